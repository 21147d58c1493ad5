"""Cuts of a film: frames that show another scene than the frame before."""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np

from abs_engine.core.arrays import FloatArray, Image
from abs_engine.tracking.settings.detection import DETECTION


class ShotCuts:
    """Finds cuts in frame after frame, by how much of a coarse picture changes.

    Light that comes, goes or moves from side to side is no change, and plain pictures, black
    between shots say, are left out: the frame after them is compared with the one before.
    """

    def __init__(self) -> None:
        self._last: FloatArray | None = None

    def step(self, image: Image) -> bool:
        """Whether the next frame (H, W, 3) RGB begins another shot; not the first frame."""
        now = _pattern(image)
        if now is None:
            return False
        last, self._last = self._last, now
        if last is None:
            return False
        changed = np.abs(last - now) > DETECTION.change
        return float(changed.mean()) > DETECTION.most_changed


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
        f"warning: another shot begins with {_numbered(frames)}: one face is learned of all shots, "
        "also of several people; if there are several, cut the video there, and give one's parts"
    )


def _numbered(frames: Sequence[int]) -> str:
    """The first few frames' numbers."""
    shown = ", ".join(str(k) for k in frames[:5]) + (", ..." if len(frames) > 5 else "")
    return f"frame{'s' if len(frames) > 1 else ''} {shown}"


def _pattern(image: Image) -> FloatArray | None:
    """Logarithm of brightness on a few cells, less a plane, with deviation 1; None if plain."""
    down, across = (max(1, n // DETECTION.cut_side) for n in image.shape[:2])
    part = image[::down, ::across].astype(np.float32)
    cells = cv2.resize(part, (DETECTION.cut_cells,) * 2, interpolation=cv2.INTER_AREA)
    cells = cells.mean(axis=2, dtype=np.float64)
    if float(cells.std()) < DETECTION.plain:
        return None
    across = np.linspace(-1.0, 1.0, DETECTION.cut_cells)
    plane = np.stack([np.ones(cells.size), *(axis.ravel() for axis in np.meshgrid(across, across))])
    bright = np.log(cells.ravel() + DETECTION.cut_dark)
    left = bright - plane.T @ (np.linalg.pinv(plane.T) @ bright)
    return np.asarray(left / max(float(left.std()), 1e-9))
