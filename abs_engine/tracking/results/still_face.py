"""A face in which nothing ever moves: a poster, a photo or a frozen picture that is followed."""

from __future__ import annotations

import cv2
import numpy as np

from abs_engine.core.arrays import Image
from abs_engine.core.geometry import Pose
from abs_engine.tracking.frame.clip_setting import ClipSetting, FrameResult
from abs_engine.tracking.results.other_faces import face_at
from abs_engine.tracking.settings.doubts import DOUBTS

STILL = (
    "nothing moves in the face that is followed, neither its mouth nor its eyes: if it is a "
    "picture of a face, choose another with --face N, or with --mouth and a box around its mouth"
)


class StillFace:
    """Follows how much a coarse picture of the face changes, at its place in the first frame."""

    def __init__(self, setting: ClipSetting) -> None:
        self._setting = setting
        self._part: tuple[slice, slice] | None = None
        self._least = self._most = np.full((DOUBTS.still_cells,) * 2, np.nan)
        self._frames = 0

    def add(self, image: Image, result: FrameResult) -> None:
        """Look at the next frame (H, W, 3) RGB."""
        if self._part is None and result.pose is not None:
            self._part = self._square(result.pose)
        part = image[self._part] if self._part is not None else image[:0]
        if not part.size:
            return
        size = (DOUBTS.still_cells,) * 2
        cells = cv2.resize(part, size, interpolation=cv2.INTER_AREA).mean(axis=2, dtype=np.float64)
        cells = cells / max(float(cells.mean()), 1.0)  # light that comes is no change
        self._least, self._most = np.fmin(self._least, cells), np.fmax(self._most, cells)
        self._frames += 1

    def _square(self, pose: Pose) -> tuple[slice, slice]:
        """Rows and columns of a face at a pose, as the detector would see it."""
        (x, y), side = face_at(self._setting, pose)
        top, left = y - DOUBTS.mouth_down * side, x - 0.5 * side
        rows, columns = ((max(0, round(at)), max(0, round(at + side))) for at in (top, left))
        return slice(*rows), slice(*columns)

    def warnings(self) -> list[str]:
        """That of a face which never changes, if it was seen for long enough to move."""
        least = max(DOUBTS.still_frames, DOUBTS.still_seconds * self._setting.rate)
        if self._frames < least:
            return []
        changes = np.sort(self._most - self._least, axis=None)
        most = float(changes[-DOUBTS.still_changed :].mean())
        return [STILL] if most < DOUBTS.still_change else []
