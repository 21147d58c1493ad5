"""Scene files as a whole, and their clips; see `values` for units and the other parts."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

from abs_engine.studio.appearance.look import Light
from abs_engine.studio.appearance.optics import Background
from abs_engine.studio.scenefile.values import (
    CameraEntry,
    EventEntry,
    OccluderEntry,
    SpeakerEntry,
    Vector,
)

FORMAT, VERSION = "abs_engine.scene", 1
Label = Literal["normals", "albedo", "flow"]


@dataclass(frozen=True)
class HeadKey:
    """A key of the head's motion.

    Parameters
    ----------
    time : float
    turn_degrees : (3,) float
        Rotation vector: nodding (down is positive), turning to its left, tilting to its right.
    shift : (3,) float
        World frame.
    """

    time: float
    turn_degrees: Vector = (0.0, 0.0, 0.0)
    shift: Vector = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class MotionEntry:
    """``motion`` of a clip: small smooth head motion of chance, and keys that are added to it.

    Parameters
    ----------
    amount : float
        0 is none; at 1 nodding, turning and tilting stay within 5, 8 and 4 degrees.
    seed : int, optional
        By default from the scene's seed and the clip's number.
    keys : list of tables
        See `HeadKey`; between them a monotone cubic.
    """

    amount: float = 1.0
    seed: int | None = None
    keys: tuple[HeadKey, ...] = ()


@dataclass(frozen=True)
class ClipEntry:
    """``[[clip]]``: a person says something.

    Exactly one of `sentence`, `say`, `textgrid`, `arkit` tells what; by default the sentence
    'demo'. Files are looked for beside the scene file.

    Parameters
    ----------
    name : str
        Folder of the clip; by default clip-1, clip-2, ...
    speaker : str
        A ``[[speaker]]``, or one of the bundled people.
    sentence : str
        A built-in sentence, or viseme symbols.
    say : str
        Phonemes in the alphabet that `alphabet` names.
    alphabet : {"x-sampa", "ipa"}
    textgrid : str
        A Praat TextGrid, whose tier `tier` holds the phonemes; by default it is guessed.
    tier : str, optional
    arkit : str
        A Live Link Face CSV, which drives face and head as it is.
    frames : int, optional
        Length; by default as long as what is said takes. Built-in sentences are stretched to it,
        anything else is cut, or held at its end.
    repeat : int
        How often what is said is said, one time after the other.
    blinks : bool
        Blinks and moving brows of chance; a recording has its own.
    motion : table
        See `MotionEntry`.
    cameras, lights, occluders, events : list of str, optional
        Names; by default all of the scene's.
    """

    name: str = ""
    speaker: str = "clara"
    sentence: str | None = None
    say: str | None = None
    alphabet: Literal["x-sampa", "ipa"] = "x-sampa"
    textgrid: str | None = None
    tier: str | None = None
    arkit: str | None = None
    frames: int | None = None
    repeat: int = 1
    blinks: bool = True
    motion: MotionEntry = field(default_factory=MotionEntry)
    cameras: tuple[str, ...] | None = None
    lights: tuple[str, ...] | None = None
    occluders: tuple[str, ...] | None = None
    events: tuple[str, ...] | None = None


@dataclass(frozen=True)
class SceneFile:
    """A scene file.

    Parameters
    ----------
    format, version : str, int
        `FORMAT` and `VERSION`.
    seed : int
    rate : float
        Frames per second.
    size : (2,) int
        Pixels of all cameras that have no size of their own.
    labels : list of {"normals", "albedo", "flow"}
        Which pictures are written besides ids and depth; by default all.
    frames : bool
        Whether to keep every picture as it was before compression, as PNG.
    ambient, roughness : float
        Share of the albedo that is seen without a lamp; roughness of the skin, 0 to 1.
    shirt : (3,) float or false
        Linear RGB.
    background : table
        top, bottom, clutter, picture: see `abs_engine.studio.appearance.optics.Background`.
    speaker, camera, light, occluder, event, clip : lists of tables
        By default one camera, a key and a fill light, and one clip.
    """

    format: str = FORMAT
    version: int = VERSION
    seed: int = 0
    rate: float = 25.0
    size: tuple[int, int] = (320, 240)
    labels: tuple[Label, ...] = ("normals", "albedo", "flow")
    frames: bool = False
    ambient: float = 0.12
    roughness: float = 0.55
    shirt: Vector | bool = (0.06, 0.09, 0.15)
    background: Background = field(default_factory=Background)
    speaker: tuple[SpeakerEntry, ...] = ()
    camera: tuple[CameraEntry, ...] = ()
    light: tuple[Light, ...] = ()
    occluder: tuple[OccluderEntry, ...] = ()
    event: tuple[EventEntry, ...] = ()
    clip: tuple[ClipEntry, ...] = ()
