"""Faces in pictures that lie on their side or upside down, as of a camera that was turned."""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np

from abs_engine.core.arrays import FloatArray, Image
from abs_engine.tracking.face_detection import Face, find_faces
from abs_engine.tracking.settings.detection import DETECTION


def faces_any_way_up(image: Image) -> list[Face]:
    """The faces of an image (H, W, 3), the surest first, whichever way up the picture is.

    The detector finds faces that lie on their side, but less surely, and puts the eyes and mouth of
    some, and of all that are upside down, where those of an upright face would be. Small faces are
    looked for upright alone.
    """
    upright = find_faces(image)
    if _surest(upright) >= DETECTION.upright:
        return upright
    little = _little(image)
    ways = {q: _surest(faces_turned(little, q, in_parts=False)) for q in (1, 2, 3)}
    best = max(ways, key=ways.__getitem__)
    if ways[best] < _surest(upright) + DETECTION.plainly_turned:
        return upright
    return faces_turned(image, best, in_parts=False) or upright


def faces_turned(image: Image, quarters: int, *, in_parts: bool = True) -> list[Face]:
    """The faces of an image, the surest first, seen after quarter turns against the clock.

    See `find_faces` for `in_parts`.
    """
    if quarters % 4 == 0:
        return find_faces(image, in_parts=in_parts)
    found = find_faces(np.ascontiguousarray(np.rot90(image, quarters)), in_parts=in_parts)
    return [_turned_back(face, image.shape[:2], quarters % 4) for face in found]


def _little(image: Image) -> Image:
    """The picture, not much larger than the detector sees it."""
    height, width = image.shape[:2]
    factor = min(1.0, DETECTION.little / max(height, width))
    size = max(1, round(factor * width)), max(1, round(factor * height))
    return np.asarray(cv2.resize(image, size, interpolation=cv2.INTER_AREA))


def _surest(faces: list[Face]) -> float:
    return faces[0].score if faces else 0.0


def _turned_back(face: Face, shape: tuple[int, ...], quarters: int) -> Face:
    """The face (px) in the picture (H, W) as it was before quarter turns against the clock."""

    def back(places: FloatArray) -> FloatArray:
        height, width = shape
        x, y = places[..., 0], places[..., 1]
        turned = {
            1: (width - 1 - y, x),
            2: (width - 1 - x, height - 1 - y),
            3: (y, height - 1 - x),
        }
        return np.stack(turned[quarters], axis=-1)

    return replace(face, centre=back(face.centre), points=back(face.points))
