"""Faces in a picture and six points of each, by BlazeFace (Bazarevsky et al. 2019).

The network is MediaPipe's for near faces, as shipped in `assets/detector`; OpenCV runs it on the
CPU. It is only used to find where to begin: what is measured comes from rendering and comparing.
Pictures may lie on their side or upside down, as of a camera that was turned.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cache

import cv2
import numpy as np
from numpy.typing import NDArray

from abs_engine.core.arrays import FloatArray, Image
from abs_engine.core.settings import GENERAL
from abs_engine.face.appearance.one_tint import untinted
from abs_engine.tracking.detection.network import Network
from abs_engine.tracking.settings.detection import DETECTION

_NETWORK = Network("face_detection_short_range.tflite", "classificators", "regressors")

MARKS = ("right_eye", "left_eye", "nose_tip", "mouth", "right_ear", "left_ear")
"""The points of a face, the subject's right and left."""

_SIDE = 128  # pixels, of the picture that the network looks at
_GRIDS = ((16, 2), (8, 6))  # cells a side, and guesses for each cell


@dataclass(frozen=True, eq=False)
class Face:
    """A face in a picture; places in pixels, whose centres are at integers.

    Parameters
    ----------
    centre : (2,) float64
        Of the square about brows to chin.
    size : float
        Side length of that square.
    points : (6, 2) float64
        Where `MARKS` are seen, or would be.
    score : float
        How probably it is a face, 0 to 1.
    """

    centre: FloatArray
    size: float
    points: FloatArray
    score: float

    @property
    def mouth(self) -> FloatArray:
        """The mouth's centre (2,)."""
        return np.asarray(self.points[MARKS.index("mouth")])


def find_face(image: NDArray[np.uint8]) -> Face | None:
    """The largest face of an image (H, W, 3) RGB, or None."""
    return max(find_faces(image), key=lambda face: face.size, default=None)


def find_faces(image: NDArray[np.uint8], *, in_parts: bool = True) -> list[Face]:
    """The faces of an image (H, W, 3) RGB, the surest first.

    They are looked for in the whole picture, and in parts of it, if asked, where that shows none,
    as small faces are lost in it. Each that is found is looked at once more from near. None are
    seen in slivers, see `DETECTION.narrowest` and `longest`.
    """
    height, width = image.shape[:2]
    least, most = sorted((height, width))
    if least < DETECTION.narrowest or most > DETECTION.longest * least:
        return []
    found = _looked_at(image, np.array([width, height]) / 2.0, most, DETECTION.sure)
    for share in DETECTION.smaller if in_parts else ():
        if found:
            break
        squares = _centres(width, height, share * least)
        found = [f for at in squares for f in _looked_at(image, at, share * least, DETECTION.surer)]
    return _in_pixels(image, _distinct(found))


def faces_beside(image: NDArray[np.uint8], faces: Sequence[Face]) -> list[Face]:
    """The small upright faces of an image (H, W, 3) RGB besides others, the surest first.

    They are looked for in all parts of it, which takes about 20 looks.
    """
    height, width = image.shape[:2]
    sides = [share * min(height, width) for share in DETECTION.smaller]
    squares = [(at, side) for side in sides for at in _centres(width, height, side)]
    seen = [f for at, side in squares for f in _looked_at(image, at, side, DETECTION.surer)]
    return [f for f in _in_pixels(image, _distinct(seen)) if all(_apart(f, one) for one in faces)]


def _apart(one: Face, other: Face) -> bool:
    """Whether neither face lies within the other."""
    return bool(np.abs(one.centre - other.centre).max() > 0.5 * max(one.size, other.size))


def faces_about(image: NDArray[np.uint8], centre: FloatArray, size: float) -> list[Face]:
    """The faces of an image (H, W, 3) RGB near a place (2,), px, the surest first.

    A face is expected there whose square is about as large as `size`, px.
    """
    return _in_pixels(
        image, _looked_at(image, np.asarray(centre) + 0.5, DETECTION.again * size, DETECTION.sure)
    )


def faces_at_a_glance(image: Image, centre: FloatArray, side: float) -> list[Face]:
    """The upright faces in a square of an image about a place (2,), px: fast, and less exact."""
    low = np.maximum(np.floor(centre - 0.5 * side), 0.0).astype(int)
    high = np.maximum(np.ceil(centre + 0.5 * side).astype(int), low + 1)
    little = _little(image[low[1] : high[1], low[0] : high[0]])
    factor = little.shape[1] / (min(high[0], image.shape[1]) - low[0])
    seen = _looked_at(little, factor * (centre + 0.5 - low), factor * side, DETECTION.sure)
    back = [(f.centre / factor + low - 0.5, f.points / factor + low - 0.5, f) for f in seen]
    return [replace(f, centre=at, size=f.size / factor, points=points) for at, points, f in back]


def _in_pixels(image: NDArray[np.uint8], faces: list[Face]) -> list[Face]:
    """Faces as they are seen from near, their places counted from pixels' centres, not edges."""
    return [
        replace(f, centre=f.centre - 0.5, points=f.points - 0.5)
        for f in _distinct([_nearer(image, face) for face in faces])
    ]


def _centres(width: int, height: int, side: float) -> Iterator[FloatArray]:
    """Middles of squares that cover a picture, overlapping by a half."""
    columns, rows = (1 + int(np.ceil(2 * (n / side - 1))) for n in (width, height))
    for y in np.linspace(side / 2, height - side / 2, rows):
        for x in np.linspace(side / 2, width - side / 2, columns):
            yield np.array([x, y])


def _nearer(image: NDArray[np.uint8], face: Face) -> Face:
    """The face by a second look at it alone; as it was where that shows none."""
    again = _looked_at(image, face.centre, DETECTION.again * face.size, DETECTION.sure)
    near = [f for f in again if np.abs(f.centre - face.centre).max() < 0.5 * face.size]
    return near[0] if near else face


def _looked_at(
    image: NDArray[np.uint8], centre: FloatArray, side: float, least: float
) -> list[Face]:
    """The faces that the network sees in a square of the image; black lies around it.

    Here and in the faces, places count from the edges of pixels, the picture's corner.
    """
    scale = _SIDE / side
    first = np.maximum(np.floor(centre - 0.5 * side), 0.0)
    last = np.ceil(centre + 0.5 * side)
    part = image[int(first[1]) : int(last[1]), int(first[0]) : int(last[0])]
    if not part.size:
        return []
    part = untinted(part)
    corner = centre - side / 2.0
    place = np.array([[scale, 0.0, 0.0], [0.0, scale, 0.0]])
    place[:, 2] = 0.5 * scale - 0.5 + scale * (first - corner)
    if scale < 1:  # else pixels would be skipped
        part = np.asarray(cv2.GaussianBlur(part, (0, 0), GENERAL.shrunk_blur / scale), np.uint8)
    small = np.asarray(cv2.warpAffine(part, place, (_SIDE, _SIDE)), np.uint8)
    faces = _guesses(small, least)
    return [
        Face(f.centre / scale + corner, f.size / scale, f.points / scale + corner, f.score)
        for f in faces
    ]


def _guesses(picture: NDArray[np.uint8], least: float) -> list[Face]:
    """The faces (pixels) in a picture of `_SIDE` pixels."""
    told, boxes = _NETWORK.seen(picture.astype(np.float32) / 127.5 - 1.0)
    score = 1 / (1 + np.exp(-np.clip(told.ravel(), -50.0, 50.0)))
    kept = np.flatnonzero(score >= least)
    if not len(kept):
        return []
    raw = boxes.reshape(-1, 8, 2).astype(np.float64)[kept]
    anchor = _anchors()[kept]
    centre, points = raw[:, 0] + anchor, raw[:, 2:] + anchor[:, None]
    size, apart = raw[:, 1].max(axis=1), np.linalg.norm(points[:, 0] - points[:, 1], axis=1)
    sound = np.flatnonzero((size > 0) & (apart > DETECTION.least_apart * size))
    return _distinct(
        [Face(centre[k], float(size[k]), points[k], float(score[kept][k])) for k in sound]
    )


def _distinct(faces: list[Face]) -> list[Face]:
    """Each face once, the surest first: the mean, by score, of guesses that overlap the surest."""
    left, distinct = sorted(faces, key=lambda f: -f.score), []
    while left:
        same = [f for f in left if _overlap(f, left[0]) > DETECTION.same]
        weight = np.array([f.score for f in same])
        weight = weight / weight.sum()
        distinct.append(
            Face(
                weight @ np.stack([f.centre for f in same]),
                float(weight @ [f.size for f in same]),
                np.tensordot(weight, np.stack([f.points for f in same]), 1),
                left[0].score,
            )
        )
        left = [f for f in left if _overlap(f, left[0]) <= DETECTION.same]
    return distinct


def _overlap(one: Face, other: Face) -> float:
    """Intersection of two faces' squares over their union."""
    reach = (one.size + other.size) / 2 - np.abs(one.centre - other.centre)
    shared = float(np.prod(np.clip(reach, 0.0, min(one.size, other.size))))
    return shared / (one.size**2 + other.size**2 - shared)


@cache
def _anchors() -> FloatArray:
    """Origin of each guess (N, 2), pixels."""
    cells = []
    for n, guesses in _GRIDS:
        at = (np.arange(n) + 0.5) * _SIDE / n
        grid = np.stack(np.meshgrid(at, at), axis=-1).reshape(-1, 2)
        cells.append(np.repeat(grid, guesses, axis=0))
    return np.concatenate(cells)


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
        turned = {1: (width - 1 - y, x), 2: (width - 1 - x, height - 1 - y), 3: (y, height - 1 - x)}
        return np.stack(turned[quarters], axis=-1)

    return replace(face, centre=back(face.centre), points=back(face.points))
