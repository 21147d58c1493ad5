"""Labels as COCO keypoints: the 68 landmarks and the box of the head in each picture.

The layout is that of the COCO keypoint task (Lin et al. 2014). As everywhere here, pixel centres
are at integers: a keypoint at (0, 0) is the middle of the first pixel. Boxes count whole pixels.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

_PARTS = (
    ("jaw", 17, False), ("right_brow", 5, False), ("left_brow", 5, False), ("bridge", 4, False),
    ("nose", 5, False), ("right_eye", 6, True), ("left_eye", 6, True), ("outer_lip", 12, True),
    ("inner_lip", 8, True),
)  # fmt: skip
"""Name, number of points, and whether they make a ring, in the order of the 68."""

OUTSIDE, HIDDEN, VISIBLE = 0, 1, 2


def keypoint_names() -> list[str]:
    """Names of the 68 landmarks."""
    return [f"{part}_{i + 1}" for part, count, _ in _PARTS for i in range(count)]


def skeleton() -> list[list[int]]:
    """Pairs of keypoints, counted from 1, that are joined."""
    edges, first = [], 1
    for _, count, ring in _PARTS:
        edges += [[i, i + 1] for i in range(first, first + count - 1)]
        edges += [[first + count - 1, first]] if ring else []
        first += count
    return edges


def keypoints(
    pixels: NDArray[np.float64], visible: NDArray[np.bool_], size: tuple[int, int]
) -> list[float]:
    """x, y, v of each landmark of a frame, one after the other, rounded to 1/1000 px.

    v is 0, and so are x and y, outside of the picture; 1 hidden; 2 visible.
    """
    out: list[float] = []
    inside = ((pixels >= -0.5) & (pixels < np.array(size) - 0.5)).tolist()
    for (x, y), within, seen in zip(pixels.tolist(), map(all, inside), visible, strict=True):
        if within:
            out += [round(x, 3), round(y, 3), VISIBLE if seen else HIDDEN]
        else:
            out += [0, 0, OUTSIDE]
    return out


def box_and_area(seen: NDArray[np.bool_]) -> tuple[list[int], int]:
    """Box (x, y, width, height) around the pixels where `seen` (H, W), and their number."""
    rows, columns = np.flatnonzero(seen.any(axis=1)), np.flatnonzero(seen.any(axis=0))
    if not len(rows):
        return [0, 0, 0, 0], 0
    (top, bottom), (left, right) = rows[[0, -1]].tolist(), columns[[0, -1]].tolist()
    return [left, top, right - left + 1, bottom - top + 1], int(seen.sum())


def coco(
    names: list[str],
    size: tuple[int, int],
    pixels: NDArray[np.float64],
    visible: NDArray[np.bool_],
    boxes: NDArray[np.integer],
    areas: NDArray[np.integer],
) -> dict[str, Any]:
    """Content of a ``coco.json``.

    Parameters
    ----------
    names : list of str
        File name of each frame's picture.
    size : tuple of int
        Width and height, pixels.
    pixels : (T, 68, 2) float64
    visible : (T, 68) bool
    boxes : (T, 4) int
        See `box_and_area`.
    areas : (T,) int
        Frames whose area is 0 get a picture without an annotation.
    """
    width, height = size
    images = [
        {"id": i, "file_name": name, "width": width, "height": height}
        for i, name in enumerate(names)
    ]
    annotations: list[dict[str, Any]] = []
    for i in np.flatnonzero(np.asarray(areas) > 0).tolist():
        points = keypoints(pixels[i], visible[i], size)
        annotations.append(
            {
                "id": i + 1, "image_id": i, "category_id": 1, "iscrowd": 0,
                "bbox": np.asarray(boxes[i]).tolist(), "area": int(areas[i]),
                "num_keypoints": sum(v > 0 for v in points[2::3]), "keypoints": points,
            }
        )  # fmt: skip
    head = {
        "id": 1,
        "name": "head",
        "supercategory": "person",
        "keypoints": keypoint_names(),
        "skeleton": skeleton(),
    }
    info = {"description": "68 landmarks of a rendered head; pixel centres are at integers"}
    return {"info": info, "images": images, "annotations": annotations, "categories": [head]}
