"""The layout of a scene for indexed drawing, and the facets that are worth submitting."""
# mypy: disable-error-code="no-untyped-def, no-untyped-call, untyped-decorator"

from __future__ import annotations

from dataclasses import dataclass

import numba
import numpy as np
from numpy.typing import NDArray

from abs_engine.core.compiled import LOOP
from abs_engine.core.scene import Scene
from abs_engine.render.kernels import snapped

MARGIN = np.float32(1 / 64)
"""Pixels by which a facet must miss all pixel centres to be left out."""


@dataclass(frozen=True, eq=False)
class Layout:
    """Vertices and facets such that the last vertex of every facet carries its label.

    `gl_PrimitiveID` would name the facet too, but makes llvmpipe take every triangle apart, which
    doubles the cost of drawing. A flat attribute of the provoking vertex costs nothing; where
    facets of different labels meet, vertices are doubled.

    Parameters
    ----------
    source : (N,) int32
        Scene vertex behind each vertex; the first V are the scene's own, in order.
    label : (N,) int32
    faces : (F, 3) int32
        The scene's facets in their order, rotated or pointing to doubled vertices.
    """

    source: NDArray[np.int32]
    label: NDArray[np.int32]
    faces: NDArray[np.int32]


def class_layout(scene: Scene) -> Layout:
    """The layout that labels facets with their classes; it depends on faces and classes alone."""
    return _labelled(scene, scene.facet_class.astype(np.int32))


def facet_layout(scene: Scene) -> Layout:
    """The layout that labels facets with their numbers, from 1; it depends on faces alone."""
    return _labelled(scene, np.arange(1, len(scene.faces) + 1, dtype=np.int32))


def _labelled(scene: Scene, labels: NDArray[np.int32]) -> Layout:
    count = len(scene.mean)
    own = np.zeros(count, np.int32)
    own[scene.faces] = labels[:, None]  # the last facet to touch a vertex wins
    agrees = own[scene.faces] == labels[:, None]
    corner = np.where(agrees.any(axis=1), agrees.argmax(axis=1), 0)
    order = (corner[:, None] + np.array([1, 2, 3])) % 3  # puts `corner` last, keeps the turn
    faces = np.take_along_axis(scene.faces, order, axis=1)
    alone = ~agrees.any(axis=1)
    wanted = np.stack([faces[alone, 2], labels[alone]], axis=1)
    doubled, which = np.unique(wanted, axis=0, return_inverse=True)
    faces[alone, 2] = count + which.reshape(-1)
    return Layout(
        np.concatenate([np.arange(count), doubled[:, 0]]).astype(np.int32),
        np.concatenate([own, doubled[:, 1]]).astype(np.int32),
        np.ascontiguousarray(faces, np.int32),
    )


@numba.njit(**LOOP)
def submit(clip, source, faces, cull, size, positions, indices, near):
    """Spread vertices to the layout and keep the facets that can cover a pixel centre; how many.

    llvmpipe spends several times longer on a triangle that it then throws away than these loops.
    What is kept errs on the safe side, and OpenGL decides in the end: the margin is well over its
    snapping to 1/256 pixel.

    Parameters
    ----------
    clip : (V, 4) float32
    source, faces : as in `Layout`
    cull : bool
    size : tuple of float
        Width and height in drawn pixels.
    positions : (N, 4) float32, out
    indices : (F, 3) int32, out
    near : float
        Facets that reach below this w are kept whole, mm.
    """
    width, height = size
    n = source.size
    x, y = np.empty(n, np.float32), np.empty(n, np.float32)
    last_x, last_y = np.float32(width - 1), np.float32(height - 1)
    for i in range(n):
        j = source[i]
        for k in range(4):
            positions[i, k] = clip[j, k]
        x[i], y[i] = _on_screen(clip[j], size, near)
    kept = 0
    for f in range(faces.shape[0]):
        a, b, c = faces[f, 0], faces[f, 1], faces[f, 2]
        indices[kept, 0], indices[kept, 1], indices[kept, 2] = a, b, c
        # No branch: which facets face the camera is not to be predicted.
        kept += not _useless(x[a], y[a], x[b], y[b], x[c], y[c], cull, last_x, last_y)
    return kept


@numba.njit(**LOOP)
def worth_drawing(clip, faces, cull, size, near, kept):
    """Number of facets that can cover a pixel centre, as `submit` keeps them, in their order.

    `clip` is (V, 4) float32, `faces` (F, 3) the scene's own; `cull`, `size` and `near` are as in
    `submit`. `kept` (F,) int32 becomes their numbers.
    """
    x, y = np.empty(len(clip), np.float32), np.empty(len(clip), np.float32)
    for i in range(len(clip)):
        x[i], y[i] = _on_screen(clip[i], size, near)
    last_x, last_y = np.float32(size[0] - 1), np.float32(size[1] - 1)
    count = 0
    for f in range(faces.shape[0]):
        a, b, c = faces[f, 0], faces[f, 1], faces[f, 2]
        kept[count] = f
        count += not _useless(x[a], y[a], x[b], y[b], x[c], y[c], cull, last_x, last_y)
    return count


@numba.njit(**LOOP)
def settle(positions, size, near, far):
    """Snap clip coordinates (N, 4) float32 and spread their depth, in place.

    Where all vertices are in front of the near plane, they are moved to the 1/256 pixel to which
    the CPU rasteriser snaps them, and depth is spread between the nearest and the farthest vertex.
    OpenGL's rounding in single precision then changes neither: both renderers give the same
    classes. (One pixel in one of 800 drawings differed, enough to turn a simplex.) Not for what is
    interpolated: at grazing facets 1/512 pixel shows.
    """
    width, height = size
    nearest, farthest = np.float64(np.inf), 0.0
    for i in range(positions.shape[0]):
        w = np.float64(positions[i, 3])
        if not w > near:
            return
        nearest, farthest = min(nearest, w), max(farthest, w)
    if nearest >= far:
        return
    # z / w = a - b / w, -1 at the nearest depth and 1 at the farthest, 0.1 % beyond on each side
    high, low = 1.001 / nearest, max(0.999 / farthest, 1.0 / far)
    b = 2.0 / (high - low)
    a = b * low + 1.0
    for i in range(positions.shape[0]):
        w = np.float64(positions[i, 3])
        inverse = 1.0 / w
        positions[i, 0] = snapped(np.float64(positions[i, 0]), inverse, width) * w
        positions[i, 1] = snapped(np.float64(positions[i, 1]), inverse, height) * w
        positions[i, 2] = a * w - b


@numba.njit(**LOOP, inline="always")
def _on_screen(clip, size, near):
    """Drawn pixel of clip coordinates (4,); NaN where it is not in front of the near plane."""
    w = clip[3]
    if not w > near:
        return np.float32(np.nan), np.float32(np.nan)
    half_x, half_y = np.float32(0.5 * size[0]), np.float32(0.5 * size[1])
    inverse = np.float32(1.0) / w
    return (
        clip[0] * inverse * half_x + half_x - np.float32(0.5),
        clip[1] * inverse * half_y + half_y - np.float32(0.5),
    )


@numba.njit(**LOOP, inline="always")
def _useless(x0, y0, x1, y1, x2, y2, cull, last_x, last_y):
    """Whether a facet is seen from behind or its box holds no pixel centre of the window.

    A facet that reaches behind the near plane has NaN and is left to OpenGL.
    """
    area = (x1 - x0) * (y2 - y0) - (x2 - x0) * (y1 - y0)
    left, right = min(min(x0, x1), x2) - MARGIN, max(max(x0, x1), x2) + MARGIN
    top, bottom = min(min(y0, y1), y2) - MARGIN, max(max(y0, y1), y2) + MARGIN
    extent = (right - left) + (bottom - top)
    behind = cull & (area > MARGIN * extent)  # y is down: front facets have negative areas
    outside = (right < 0) | (bottom < 0) | (left > last_x) | (top > last_y)
    between = (np.floor(right) < left) | (np.floor(bottom) < top)
    return (area == area) & (behind | outside | between)
