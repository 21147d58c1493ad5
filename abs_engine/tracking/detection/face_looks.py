"""The look of the face that is followed, and of those near it, by which it is known again.

Where one person passes before another, the landmark network goes on to the nearer face, and would
be taken along by it; and a face that went may come back elsewhere.
"""

from __future__ import annotations

import cv2
import numpy as np

from abs_engine.core.arrays import FloatArray, Image
from abs_engine.tracking.detection.face_detection import Face, faces_at_a_glance
from abs_engine.tracking.detection.landmarks import Landmarks, landmarks_of
from abs_engine.tracking.settings.detection import DETECTION


class FaceLooks:
    """Remembers how the followed face, and those near it, looked when last seen apart."""

    def __init__(self) -> None:
        self._own: FloatArray | None = None
        self._rivals: list[FloatArray] = []
        self._since = 0

    def forget_others(self) -> None:
        """Forget all faces but the followed one, as after a cut of the film."""
        self._rivals = []

    def step(self, image: Image, found: Landmarks, *, look: bool) -> None:
        """The next frame (H, W, 3) RGB in which the followed face is found; asked for, a look."""
        self._since += 1
        if self._since > DETECTION.patience:
            self.forget_others()
        whole = ((found.pixels >= 0) & (found.pixels < image.shape[1::-1])).all()
        if not (look and whole):
            return
        near = _near(image, found)
        if len(near) < len(self._rivals):  # one that is missing may be hidden, or hide
            return
        seen = [landmarks_of(image, face, both=False) for face in near]
        self._rivals = [_look(image, marks) for marks in seen if marks is not None]
        self._own, self._since = _look(image, found), 0

    def of_another(self, image: Image, found: Landmarks) -> bool:
        """Whether a face looks like one nearby, and not like the one that is followed."""
        if self._own is None or not self._rivals:
            return False
        look = _look(image, found)
        nearest = min(_unlike(look, rival) for rival in self._rivals)
        return nearest < DETECTION.taken * _unlike(look, self._own)

    def same(self, image: Image, found: Landmarks) -> bool:
        """Whether a face looks so much like the followed one that it is no other, wherever."""
        return (
            self._own is not None and _unlike(_look(image, found), self._own) < DETECTION.same_look
        )


def _near(image: Image, found: Landmarks) -> list[Face]:
    """Faces beside one, at most some of its sizes away, whose heads do not overlap."""
    centre = found.pixels.mean(axis=0)

    def beside(face: Face) -> bool:
        size = DETECTION.of_box * face.size
        away = float(np.linalg.norm(face.centre - centre))
        least, most = sorted((size, found.size))
        near = DETECTION.apart * most < away < DETECTION.rival_reach * found.size
        return near and most < DETECTION.most_size_ratio * least

    side = 2 * DETECTION.rival_reach * found.size
    return [face for face in faces_at_a_glance(image, centre, side) if beside(face)]


def _look(image: Image, marks: Landmarks) -> FloatArray:
    """Logarithms of the colours (468, 3) of a face at its landmarks, less their mean.

    They are of a thumbnail, so that a face looks alike near and far, sharp and blurred.
    """
    low = np.maximum(np.floor(marks.pixels.min(axis=0)), 0).astype(int)
    high = np.maximum(np.ceil(marks.pixels.max(axis=0)).astype(int) + 1, low + 1)
    part = image[low[1] : high[1], low[0] : high[0]]
    if not part.size:
        return np.zeros((len(marks.points), 3))
    scale = DETECTION.look_side / marks.size
    size = [max(1, round(scale * n)) for n in part.shape[1::-1]]
    small = cv2.resize(part, size, interpolation=cv2.INTER_AREA).astype(np.float32)
    factor = np.array(size) / part.shape[1::-1]
    x, y = (factor * (marks.pixels - low + 0.5) - 0.5).astype(np.float32).T[..., None]
    seen = cv2.remap(small, x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)[:, 0]
    bright = np.log(seen.astype(np.float64) + DETECTION.cut_dark)
    return np.asarray(bright - bright.mean())


def _unlike(one: FloatArray, other: FloatArray) -> float:
    """Root of the mean squared difference of two looks."""
    return float(np.sqrt(((one - other) ** 2).mean()))
