"""Faces in pictures that lie on their side or upside down, as of a camera that was turned."""

from __future__ import annotations

from dataclasses import replace

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
    least = _surest(upright) + DETECTION.plainly_turned
    if _surest(upright) >= DETECTION.upright:
        return upright
    ways = [faces_turned(image, quarters, small=False) for quarters in (1, 2, 3)]
    best = max(ways, key=_surest)
    return best if _surest(best) >= least else upright


def faces_turned(image: Image, quarters: int, small: bool = True) -> list[Face]:
    """The faces of an image, the surest first, seen after quarter turns against the clock.

    See `find_faces` for `small`.
    """
    if quarters % 4 == 0:
        return find_faces(image, small)
    found = find_faces(np.ascontiguousarray(np.rot90(image, quarters)), small)
    return [_turned_back(face, image.shape[:2], quarters % 4) for face in found]


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
