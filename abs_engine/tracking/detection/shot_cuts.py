"""Cuts of a film: frames that show another scene than the frame before."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache

import cv2
import numpy as np

from abs_engine.core.arrays import FloatArray, Image
from abs_engine.tracking.settings.detection import DETECTION


class ShotCuts:
    """Finds cuts in frame after frame, by how much of a coarse picture changes.

    Light that comes, goes or moves from side to side is no change, nor is a camera that is shaken:
    where much changes, frames are compared again after the best shift. Plain pictures, black
    between shots say, are left out: the frame after them is compared with the one before.
    """

    def __init__(self) -> None:
        self._last: tuple[Image, FloatArray] | None = None

    def step(self, image: Image) -> bool:
        """Whether the next frame (H, W, 3) RGB begins another shot; not the first frame."""
        picture = _thinned(image)
        pattern = _pattern(picture)
        if pattern is None:
            return False
        last, self._last = self._last, (picture, pattern)
        if last is None or _changed(last[1], pattern) <= DETECTION.most_changed:
            return False
        return not _only_shifted(last[0], picture)


ASSUMED = "one person is assumed"
"""Words of the lines about shots in a run."""


def cut_line(frames: Sequence[int]) -> str:
    """Line about the frames that begin other shots."""
    return (
        f"the film is cut before {_numbered(frames)}: {ASSUMED} in all shots; if there are several "
        "people, track each shot separately"
    )


def anew_line(frames: Sequence[int]) -> str:
    """Line about the frames from which on another face may be followed."""
    return (
        f"after more than {DETECTION.patience} frames without a face, one that may be another "
        f"person's is followed from {_numbered(frames)} on: {ASSUMED}; if there are several "
        "people, track each part separately"
    )


def shots_line(frames: Sequence[int]) -> str:
    """Warning that the shots which some frames begin are all learned as one person's."""
    return (
        f"warning: another shot begins with {_numbered(frames)}: one face is learned from all "
        "shots, even of several people; if there are several, cut the video there, and give the "
        "parts that show one of them"
    )


def _numbered(frames: Sequence[int]) -> str:
    """The first few frames' numbers."""
    shown = ", ".join(str(k) for k in frames[:5]) + (", ..." if len(frames) > 5 else "")
    return f"frame{'s' if len(frames) > 1 else ''} {shown}"


def _thinned(image: Image) -> Image:
    """Every few pixels of a frame (H, W, 3)."""
    down, across = (max(1, n // DETECTION.cut_side) for n in image.shape[:2])
    return np.ascontiguousarray(image[::down, ::across])  # the frame itself is not kept


def _pattern(picture: Image) -> FloatArray | None:
    """Logarithm of brightness on a few cells, less a plane, with deviation 1; None if plain."""
    size = (DETECTION.cut_cells,) * 2
    cells = cv2.resize(picture.astype(np.float32), size, interpolation=cv2.INTER_AREA)
    cells = cells.mean(axis=2, dtype=np.float64)
    if float(cells.std()) < DETECTION.plain:
        return None
    planes, fitted = _planes(DETECTION.cut_cells)
    bright = np.log(cells.ravel() + DETECTION.cut_dark)
    left = bright - planes @ (fitted @ bright)
    return np.asarray(left / max(float(left.std()), 1e-9))


@cache
def _planes(count: int) -> tuple[FloatArray, FloatArray]:
    """Planes (N, 3) over a square of so many cells a side, and their pseudoinverse (3, N)."""
    across = np.linspace(-1.0, 1.0, count)
    planes = np.stack(
        [np.ones(count**2), *(axis.ravel() for axis in np.meshgrid(across, across))]
    ).T
    return planes, np.asarray(np.linalg.pinv(planes), np.float64)


def _changed(before: FloatArray, now: FloatArray) -> float:
    """Share of the cells of two patterns that differ."""
    return float((np.abs(before - now) > DETECTION.change).mean())


def _only_shifted(before: Image, now: Image) -> bool:
    """Whether a picture (H, W, 3) shows the scene of the one before, by a camera that is shaken."""
    height, width = now.shape[:2]
    window = cv2.createHanningWindow((width, height), cv2.CV_32F)
    grey = [window * picture.mean(axis=2, dtype=np.float32) for picture in (before, now)]
    x, y = (round(way) for way in cv2.phaseCorrelate(*grey)[0])
    if max(abs(x) / width, abs(y) / height) > DETECTION.most_shifted:
        return False
    one, other = _pattern(_beyond(before, -x, -y)), _pattern(_beyond(now, x, y))
    if one is None or other is None:
        return False
    return _changed(one, other) <= DETECTION.most_changed_shifted


def _beyond(picture: Image, x: int, y: int) -> Image:
    """A picture (H, W, 3) without its first columns and rows, or the last, where negative."""
    height, width = picture.shape[:2]
    return picture[max(0, y) : height + min(0, y), max(0, x) : width + min(0, x)]
