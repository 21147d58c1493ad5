"""The data of a report: plain values, wherever they come from."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.arrays import BoolArray, FloatArray
from abs_engine.dataset import Phoneme
from abs_engine.evaluate.score import Score
from abs_engine.tracking.results.run_mesh import LinearSurface

Rows = tuple[tuple[str, str], ...]
"""Names and values, for a table of two columns."""


@dataclass(frozen=True, eq=False)
class Series:
    """A number for each frame, of one system.

    Parameters
    ----------
    values : (T,) float64
        NaN where there is none.
    lower, upper : (T,) float64, optional
        Ends of its 95 % intervals.
    """

    values: FloatArray
    lower: FloatArray | None = None
    upper: FloatArray | None = None


@dataclass(frozen=True, eq=False)
class Quantity:
    """Quantity in a chart's row."""

    key: str
    label: str
    unit: str


@dataclass(frozen=True, eq=False)
class Head:
    """A head in motion.

    Parameters
    ----------
    motion : LinearSurface
        Its vertices in the head frame.
    rotations, translations : (T, 3) float64, optional
        Head to camera, radians and mm; NaN in lost frames.
    """

    motion: LinearSurface
    rotations: FloatArray | None = None
    translations: FloatArray | None = None


@dataclass(frozen=True, eq=False)
class WorstFrame:
    """A frame in which a system erred most.

    Parameters
    ----------
    picture : bytes
        WebP: the mouth with the true and the tracked contours.
    """

    frame: int
    picture: bytes
    text: str


@dataclass(frozen=True, eq=False)
class System:
    """One system's results. What it does not give is empty or None.

    Parameters
    ----------
    curves, errors, sureness : mapping of `Quantity.key` to Series
        Lip curves; errors, and how sure the system is, frame by frame.
    scores : mapping of metric to Score
        See `abs_engine.evaluate.catalogue`.
    contours : mapping of str to (T, N, 2) float64
        `outer` and `inner` contour of the lips in the picture, px, as closed loops; NaN in lost
        frames.
    error_map : (V,) float64, mm, optional
        NaN for vertices that have none.
    """

    name: str
    curves: Mapping[str, Series] = field(default_factory=dict)
    errors: Mapping[str, Series] = field(default_factory=dict)
    sureness: Mapping[str, Series] = field(default_factory=dict)
    scores: Mapping[str, Score] = field(default_factory=dict)
    contours: Mapping[str, FloatArray] = field(default_factory=dict)
    head: Head | None = None
    error_map: FloatArray | None = None
    worst: tuple[WorstFrame, ...] = ()
    facts: Rows = ()
    notes: tuple[str, ...] = ()


@dataclass(frozen=True, eq=False)
class TrueClip:
    """Ground truth of the clip; the same as in `System`, and what is said.

    Parameters
    ----------
    curves : mapping of `Quantity.key` to (T,) float64
    contours : mapping of str to (T, N, 2) float64, px
    closed : (T,) bool
    """

    curves: Mapping[str, FloatArray]
    contours: Mapping[str, FloatArray]
    head: Head
    closed: BoolArray
    said: tuple[Phoneme, ...] = ()


@dataclass(frozen=True, eq=False)
class Film:
    """The video as the page plays it.

    Parameters
    ----------
    content : bytes
        MP4, H.264.
    size : tuple of int
        Width and height of the original, the pixels of the contours.
    """

    content: bytes
    size: tuple[int, int]


@dataclass(frozen=True, eq=False)
class ReportData:
    """All that a report shows.

    Parameters
    ----------
    rate : float
        Frames per second, on average.
    times : (T,) float64
        When each frame is shown, seconds.
    faces : (F, 3) int32
        The mesh of all heads.
    colours : (V, 3) uint8 RGB
        Of the heads' vertices.
    played : int
        Frames that the player shows, the first of the clip.
    focus : tuple of float
        Middle of the mouth, mm, head frame.
    area : (N,) int, optional
        Vertices of the face, by which the scale of the error maps is chosen; by default all.
    errors, sureness : tuple of Quantity
        Rows of the charts, but for those of the lip curves, `quantities.CURVES`.
    facts : mapping of heading to Rows
        Clip, machine, seeds, commands.
    view : str
        CLIP/CAMERA of the dataset that is shown.
    caution : str
        Why its figures may not be published.
    """

    title: str
    subtitle: str
    rate: float
    times: FloatArray
    systems: tuple[System, ...]
    faces: NDArray[np.int32]
    colours: NDArray[np.uint8]
    true: TrueClip | None = None
    film: Film | None = None
    played: int = 0
    focus: tuple[float, float, float] = (0.0, 0.0, 0.0)
    area: NDArray[np.int32] | None = None
    errors: tuple[Quantity, ...] = ()
    sureness: tuple[Quantity, ...] = ()
    facts: Mapping[str, Rows] = field(default_factory=dict)
    view: str = ""
    others: tuple[str, ...] = ()
    caution: str = ""
