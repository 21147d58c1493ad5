"""Faces besides the one that is followed: a larger one, or one where it is not found.

The first frame with a face says which one is followed. Who comes later, in front of a picture on
the wall or after somebody who leaves, is noticed here.
"""

from __future__ import annotations

import numpy as np

from abs_engine.core.arrays import Image
from abs_engine.tracking.detection.face_choice import by_size
from abs_engine.tracking.detection.face_detection import Face, find_faces
from abs_engine.tracking.frame.clip_setting import ClipSetting, FrameResult
from abs_engine.tracking.results.run_warnings import larger_face, only_another
from abs_engine.tracking.settings.frames import FRAME_LOOP


class OtherFaces:
    """Looks for other faces now and then in a clip.

    Parameters
    ----------
    setting : ClipSetting
        Where a user has chosen the face, none is looked for.
    """

    def __init__(self, setting: ClipSetting) -> None:
        self._setting = setting
        self._next, self._step = 0, max(1, round(FRAME_LOOP.look_apart * setting.rate))
        self._looks = self._without = 0
        self._larger: list[tuple[int, Face, float]] = []
        self._alone: list[tuple[int, Face]] = []

    def add(self, image: Image, result: FrameResult) -> None:
        """Look at the next frame (H, W, 3) RGB, or leave it out."""
        if not self._setting.others or result.index < self._next:
            return
        self._looks += 1
        if self._looks % FRAME_LOOP.looks == 0:  # a long clip is looked at less often
            self._step *= 2
        self._next = result.index + self._step
        largest = next(iter(by_size(find_faces(image, in_parts=False))), None)
        if result.pose is None:
            self._without += 1
            if largest is not None:
                self._alone.append((result.index, largest))
            return
        border = self._setting.camera.project(result.pose.apply(self._setting.face.border))
        depth = float(result.pose.apply(self._setting.face.pivot)[2])
        size = FRAME_LOOP.face_square * float(self._setting.camera.matrix[0, 0]) / depth
        if largest is None or largest.size < FRAME_LOOP.larger_face * size:
            return
        if np.linalg.norm(largest.mouth - border.mean(axis=0)) > 0.5 * largest.size:
            self._larger.append((result.index, largest, size))

    def warnings(self) -> list[str]:
        """Those of faces that are seen in more than one look, and in enough of them."""
        return [
            *larger_face(self._larger, self._looks),
            *only_another(self._alone, self._without),
        ]
