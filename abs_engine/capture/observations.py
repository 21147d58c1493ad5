"""Points in the head frame, frame after frame: the file that models are trained on."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, fields
from pathlib import Path

import numpy as np

from abs_engine.core.arrays import BoolArray, FloatArray
from abs_engine.core.errors import ModelFormatError, ParameterError, TooFewPointsError
from abs_engine.io.arrays import Layout, plain, real, text, truth, whole
from abs_engine.io.npz import read_npz, write_npz

FORMAT, VERSION = "abs_engine.observations", 1
_LAYOUT: Layout = {
    "points": real("T", "N", 3, gaps=True),
    "names": text("N"),
    **dict.fromkeys(("found", "uncertain"), truth("T", "N")),
    **dict.fromkeys(("error", "score"), real("T", "N", gaps=True)),
    "rate": real(low=1e-9),
    **dict.fromkeys(("rotations", "translations"), real("T", 3, gaps=True)),
    "rigid_error": real("T", gaps=True),
    "pixels": real("views*", "frames*", "points*", 2, gaps=True),
    "source": text(),
    "first": whole(optional=True),
}


@dataclass(frozen=True, eq=False)
class Observations:
    """Points that were observed, T frames of N points.

    Parameters
    ----------
    points : (T, N, 3) float64, mm, head frame
        NaN where a point was not found.
    names : tuple of str, N
        Those of `dot_annotations.LIPS17` first where they were observed.
    found : (T, N) bool
    uncertain : (T, N) bool
        Found, but by a weak correlation; a person should look at it.
    error : (T, N) float64, px
        Reprojection error, root mean square over the views; NaN where not found. For marker files
        it is the residual that the file states, in mm.
    score : (T, N) float64
        Lowest normalised correlation over the views; 1 for marker files.
    rate : float
        Frames per second.
    rotations : (T, 3) float64
        Head pose: rotation vectors, head frame to world (first camera), radians; NaN where the
        head was not found.
    translations : (T, 3) float64, mm, world frame
    rigid_error : (T,) float64, mm
        See `HeadMotion.error`.
    pixels : (V, T, N, 2) float64, px
        Where each view saw the points; V is 0 for marker files.
    source : str
        What the points were made of.
    first : int
        Number of the first frame, as a marker file counts them.

    Raises
    ------
    ParameterError
        If the arrays do not fit together, or a point that was found has no place.
    """

    points: FloatArray
    names: tuple[str, ...]
    found: BoolArray
    uncertain: BoolArray
    error: FloatArray
    score: FloatArray
    rate: float
    rotations: FloatArray
    translations: FloatArray
    rigid_error: FloatArray
    pixels: FloatArray = field(default_factory=lambda: np.zeros((0, 0, 0, 2)))
    source: str = ""
    first: int = 0

    def __post_init__(self) -> None:
        frames, count = self.found.shape
        wanted = {
            "points": (frames, count, 3),
            "uncertain": (frames, count),
            "error": (frames, count),
            "score": (frames, count),
            "rotations": (frames, 3),
            "translations": (frames, 3),
            "rigid_error": (frames,),
        }
        for name, shape in wanted.items():
            if getattr(self, name).shape != shape:
                raise ParameterError(
                    f"observations have {name} of shape {getattr(self, name).shape}, not {shape}",
                    "give all of them for the same frames and points",
                )
        if len(self.names) != count or len(set(self.names)) != count:
            raise ParameterError(f"{count} points have other names", "name each point once")
        if not self.rate > 0 or not np.isfinite(self.rate):
            raise ParameterError(f"the rate is {self.rate}", "give frames per second")
        if not np.isfinite(self.points[self.found]).all():
            raise ParameterError("a point that was found has no place", "mark it as not found")

    @property
    def frames(self) -> int:
        """Number of frames, T."""
        return len(self.found)

    def of(self, names: Sequence[str]) -> FloatArray:
        """The named points (T, K, 3), mm, head frame; NaN where not found.

        Raises
        ------
        TooFewPointsError
            If one of them was not observed.
        """
        lacking = [name for name in names if name not in self.names]
        if lacking:
            raise TooFewPointsError(
                f"{len(lacking)} of {len(names)} points were not observed: {lacking[0]}, ...",
                "observe all of them, or ask for fewer",
            )
        at = [self.names.index(name) for name in names]
        return np.where(self.found[:, at, None], self.points[:, at], np.nan)

    def doubtful(self, names: Sequence[str]) -> BoolArray:
        """In which frames (T,) one of the named points was found, but is uncertain."""
        at = [self.names.index(name) for name in names]
        return np.asarray((self.uncertain & self.found)[:, at].any(axis=1))


def write_observations(path: Path, observations: Observations) -> Path:
    """Write an observation file, ``.npz``, whole or not at all.

    Raises
    ------
    OutputError
        If it exists or cannot be written.
    """
    parts = {part.name: getattr(observations, part.name) for part in fields(observations)}
    write_npz(path, FORMAT, VERSION, parts)
    return path


def read_observations(path: Path) -> Observations:
    """Read an observation file.

    Raises
    ------
    InputFileError
        If it is missing or no NPZ archive.
    ModelFormatError
        If format or version differ, an array is missing, or they do not fit together.
    """
    data = plain(read_npz(Path(path), FORMAT, VERSION, _LAYOUT, "observe again"))
    shape = data["points"].shape[:2]
    try:
        if data["pixels"].size and data["pixels"].shape[1:3] != shape:
            raise ParameterError(
                f"the pixels are of shape {data['pixels'].shape}", "give those of all points"
            )
        return Observations(**data)
    except ParameterError as error:
        raise ModelFormatError(
            f"{path} is not a whole observation file ({error})", "observe again"
        ) from error
