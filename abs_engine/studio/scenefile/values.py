"""The parts of a scene file; every field is a key of that name, and nearly all have defaults.

Lengths in mm and times in seconds. Unlike everywhere else angles are in degrees, as people write
these files; their names say so. The world frame is the head's at rest: x to the subject's left, y
up, z out of the face, origin midway between the ear canals.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

from abs_engine.capture.board import Board
from abs_engine.studio.appearance.optics import Sensor

Vector = tuple[float, float, float]
Rgb = tuple[int, int, int]


@dataclass(frozen=True)
class SpeakerEntry:
    """``[[speaker]]``: a person; see `abs_engine.studio.people.Person`.

    Parameters
    ----------
    name : str
        What clips call the person.
    base : str
        One of the bundled people, whose shape and skin are started from.
    random : int, optional
        Start instead from a person that is drawn by chance with this seed.
    identity : mapping of str to float
        Weights of shape targets.
    skin, lips, hair : (3,) int or str
        sRGB, 0 to 255; a skin tone also by its name.
    stubble, freckles : float
        0 to 1.
    beads : int or str
        Number of coloured beads, or a set of ink dots by name, such as lips17.
    seed : int
    """

    name: str
    base: str | None = None
    random: int | None = None
    identity: Mapping[str, float] = field(default_factory=dict)
    skin: Rgb | str | None = None
    lips: Rgb | None = None
    hair: Rgb | None = None
    stubble: float | None = None
    freckles: float | None = None
    beads: int | str | None = None
    seed: int | None = None


@dataclass(frozen=True)
class MirrorEntry:
    """``mirror`` of a camera: a flat mirror that stands still in the camera's frame.

    Parameters
    ----------
    corners : (4,) of (3,) float
        Camera frame (x right, y down, z forward), around the rectangle. Or, instead:
    centre : (3,) float
    yaw_degrees : float
        By which it is turned about the vertical from facing the camera's plane.
    size : (2,) float
        Width and height.
    """

    corners: tuple[Vector, Vector, Vector, Vector] | None = None
    centre: Vector | None = None
    yaw_degrees: float = 0.0
    size: tuple[float, float] = (100.0, 140.0)


@dataclass(frozen=True)
class CameraEntry:
    """``[[camera]]``.

    Parameters
    ----------
    name : str
    size : (2,) int, optional
        Pixels, even; by default that of the scene.
    focal : float, optional
        Focal length in pixels. Or `focal_mm` with `sensor_width_mm`, or
        `field_of_view_degrees`, which spans the width. By default 1.7 times the larger side.
    centre : (2,) float, optional
        Principal point in pixels; by default the picture's middle.
    distortion : up to 8 floats
        k1, k2, p1, p2, k3, k4, k5, k6 as OpenCV's.
    mount : {"world", "head"}
        Whether the camera stands still or is worn, and so moves with the head.
    position : (3,) float, optional
        World, or head frame if it is worn. By default before the face, at the distance from which
        the face fills most of the picture.
    target : (3,) float, optional
        What it looks at, likewise; by default the middle of the mouth, or of the face where
        `position` is left out.
    roll_degrees : float
        About the optical axis.
    sensor : table
        blur, shot, read, bands, band_period, band_speed: see
        `abs_engine.studio.appearance.optics.Sensor`.
    exposure : float
        Factor of the light.
    crf : int
        x264's quality of the video; 0 is without loss.
    mirror : table, optional
        See `MirrorEntry`.
    """

    name: str = "camera"
    size: tuple[int, int] | None = None
    focal: float | None = None
    focal_mm: float | None = None
    sensor_width_mm: float = 36.0
    field_of_view_degrees: float | None = None
    centre: tuple[float, float] | None = None
    distortion: tuple[float, ...] = ()
    mount: Literal["world", "head"] = "world"
    position: Vector | None = None
    target: Vector | None = None
    roll_degrees: float = 0.0
    sensor: Sensor = field(default_factory=Sensor)
    exposure: float = 1.0
    crf: int = 16
    mirror: MirrorEntry | None = None


@dataclass(frozen=True)
class OccluderKey:
    """A key of an occluder's motion; what is left out is as the keys around it have it.

    Parameters
    ----------
    time : float
    offset : (3,) float, optional
        Where it is held, as in `OccluderEntry`.
    turn_degrees : (3,) float, optional
        Rotation vector against the head frame.
    """

    time: float
    offset: Vector | None = None
    turn_degrees: Vector | None = None


@dataclass(frozen=True)
class OccluderEntry:
    """``[[occluder]]``: a hand or a microphone before the mouth, or a calibration board.

    Parameters
    ----------
    kind : {"hand", "microphone", "board"}
    start, end : float
    name : str
        By default its kind.
    travel : float
        Seconds that it takes to come, and again to go.
    offset, away : (3,) float, optional
        Where it is held, and where it comes from: mm from the middle of the mouth, head frame.
    turn_degrees : (3,) float, optional
        Rotation vector against the head frame.
    colour : (3,) int, optional
        sRGB.
    follows : bool
        Whether it moves with the head.
    sway : float
        mm.
    seed : int
    board : table, optional
        kind, columns, rows, square, marker, dictionary: see `abs_engine.capture.board.Board`.
    keys : list of tables
        How it moves while it is held, see `OccluderKey`; between them a monotone cubic.
    """

    kind: Literal["hand", "microphone", "board"]
    start: float
    end: float
    name: str = ""
    travel: float = 0.4
    offset: Vector | None = None
    away: Vector | None = None
    turn_degrees: Vector | None = None
    colour: Rgb | None = None
    follows: bool = True
    sway: float = 1.0
    seed: int = 0
    board: Board | None = None
    keys: tuple[OccluderKey, ...] = ()


@dataclass(frozen=True)
class EventEntry:
    """``[[event]]``: something that goes wrong for a while.

    Parameters
    ----------
    kind : {"exposure", "blur", "leave"}
        The exposure changes; the picture is out of focus; the face leaves the picture.
    start, end : float
        Seconds. It fades in and out over `ramp` seconds inside of them.
    name : str
        By default its kind.
    amount : float, optional
        Factor of the exposure (1.8), blur in pixels (2.5), or mm that the head moves (420).
    direction : (3,) float
        In which the head leaves, world frame.
    ramp : float
    cameras : list of str, optional
        Whom exposure and blur concern; by default all.
    """

    kind: Literal["exposure", "blur", "leave"]
    start: float
    end: float
    name: str = ""
    amount: float | None = None
    direction: Vector = (1.0, 0.0, 0.0)
    ramp: float = 0.3
    cameras: tuple[str, ...] | None = None
