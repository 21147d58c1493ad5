"""Per-facet scores and forces of colour-class maps (Basu et al., eqs. 8, 9, 11, 12).

Both integrals over a facet come in two ways: the exact sum over its visible pixels, and the paper's
one sample, the value at its centre times its visible area. The centre is that of the visible part,
so that a facet which is half hidden is sampled where it is seen.

The paper moves a facet as a whole: its force says what a shift of it would gain. Facets also grow
and shrink, and what a facet gains when it grows over pixels that suit it is no gradient within it:
a model with its mouth open before a closed one feels nothing. `border_forces` has both.
"""

from __future__ import annotations

from typing import Literal, get_args

import cv2
import numpy as np
from numpy.typing import NDArray

from abs_engine.core.arrays import FloatArray
from abs_engine.core.buffers import Buffers, Outlines
from abs_engine.core.camera import Camera
from abs_engine.core.errors import ParameterError

Rule = Literal["exact", "sample"]


def check_rule(rule: str) -> None:
    """Raise `ParameterError` unless there is such a rule."""
    if rule not in get_args(Rule):
        raise ParameterError(f"nothing is known of the rule '{rule}'", "choose exact or sample")


def facet_scores(
    buffers: Buffers | Outlines,
    maps: NDArray[np.floating],
    facet_class: NDArray[np.integer],
    rule: Rule,
) -> FloatArray:
    """Contribution (F,) of each facet to the sum of eq. 9, in drawn pixels; 0 for hidden ones.

    `maps` (C, H, W) are the likelihood map of each class id, `facet_class` (F,) the facets'
    classes.
    """
    return facet_forces(buffers, maps[:, None], facet_class, rule)[:, 0]


def slopes(maps: NDArray[np.floating]) -> FloatArray:
    """Gradients (C, 2, H, W) of maps (C, H, W), to the right and downwards, per drawn pixel."""
    down, right = np.gradient(np.asarray(maps, np.float64), axis=(1, 2))
    return np.stack([right, down], axis=1)


def node_forces(forces: FloatArray, faces: NDArray[np.integer], n_nodes: int) -> FloatArray:
    """Forces (N, D) on nodes: a facet's force (F, D) goes to its three nodes in equal parts."""
    out = np.zeros((n_nodes, forces.shape[1]))
    for corner in range(3):
        np.add.at(out, faces[:, corner], forces / 3)
    return out


def border_forces(
    buffers: Buffers, maps: NDArray[np.floating], faces: NDArray[np.integer], n_nodes: int
) -> FloatArray:
    """Forces on the nodes: the derivative of eq. 7 by their places in the picture.

    (N, 2) float64, to the right and downwards, drawn pixels. `maps` (C, H, W) are what a pixel
    gives to a facet of each class; `maps[0]` to no facet.

    Notes
    -----
    The integral over all visible facets changes only where two classes meet in the picture: when
    their border moves, pixels go from one to the other. So each pair of neighbouring pixels of
    different classes pushes the border by the difference of what the two classes would get there.
    The border is the edge of whichever surface lies in front, so its facet's nodes are pushed, by
    the barycentrics of its pixel.
    """
    out, depth = np.zeros((n_nodes, 2)), np.where(buffers.depth > 0, buffers.depth, np.inf)
    for axis, one in ((0, (0, 1)), (1, (1, 0))):
        here = tuple(slice(None, -d or None) for d in one)
        there = tuple(slice(d, None) for d in one)
        first, second = buffers.class_id[here], buffers.class_id[there]
        rows, columns = np.nonzero(first != second)
        p = rows, columns
        q = rows + one[0], columns + one[1]
        a, b = first[p], second[p]
        gain = 0.5 * sum(maps[(a, *at)] - maps[(b, *at)] for at in (p, q))
        depth_p, depth_q = (depth[at] for at in (p, q))
        front = tuple(np.where(depth_p <= depth_q, x, y) for x, y in zip(p, q, strict=True))
        corners = faces[buffers.facet_id[front] - 1]
        share = buffers.barycentrics[front].astype(np.float64) * np.asarray(gain)[:, None]
        np.add.at(out[:, axis], corners, share)
    return out


def lifted(forces: FloatArray, points: FloatArray, camera: Camera, scale: float) -> FloatArray:
    """Forces (N, 3), camera frame, of forces in the drawn picture (N, 2) on points (N, 3), mm.

    By the pinhole's derivative: the work of a small displacement is the same in space and picture.
    Lens distortion is left out, which bends the direction by little.
    """
    x, y, z = points.T
    focal = scale * np.array([camera.matrix[0, 0], camera.matrix[1, 1]])
    across = forces * focal / z[:, None]
    return np.column_stack([across, -(across[:, 0] * x + across[:, 1] * y) / z])


def facet_forces(
    buffers: Buffers | Outlines,
    planes: NDArray[np.floating],
    facet_class: NDArray[np.integer],
    rule: Rule,
) -> FloatArray:
    """Integrals (F, D) of each class's planes (C, D, H, W) over the visible part of its facets.

    With the `slopes` (C, 2, H, W) of smoothed maps as planes, which say which way to go, these are
    the forces on the facets in the picture, to the right and downwards, drawn pixels (eqs. 11 and
    12, alpha left out).
    """
    check_rule(rule)
    rows, columns = np.nonzero(buffers.facet_id)
    facet = buffers.facet_id[rows, columns] - 1
    count = len(facet_class)
    if rule == "exact":
        values = planes[facet_class[facet], :, rows, columns]
        return np.stack([np.bincount(facet, v, count) for v in values.T.astype(np.float64)], axis=1)
    area = np.bincount(facet, minlength=count)
    seen = np.flatnonzero(area)
    x, y = (np.bincount(facet, v, count)[seen] / area[seen] for v in (columns, rows))
    out = np.zeros((count, planes.shape[1]))
    for number in np.unique(facet_class[seen]):
        of = facet_class[seen] == number
        for k, plane in enumerate(planes[number]):
            out[seen[of], k] = _at(plane, x[of], y[of])
    return out * area[:, None]


def _at(plane: NDArray[np.floating], x: FloatArray, y: FloatArray) -> FloatArray:
    """Values of a plane at sub-pixel places, bilinear."""
    places = np.asarray(x, np.float32), np.asarray(y, np.float32)
    found = cv2.remap(np.asarray(plane, np.float32), *places, cv2.INTER_LINEAR)
    return np.asarray(found, np.float64).ravel()
