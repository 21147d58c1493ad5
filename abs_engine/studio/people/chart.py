"""The speaker's texture chart: which facet lies under each texel, and where that is on the head."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from abs_engine.core.arrays import Float32Array
from abs_engine.io.assets import Speaker

_SUBPIXEL_BITS = 4


@dataclass(frozen=True, eq=False)
class Chart:
    """The texels (T) that facets cover, as flat lists.

    Parameters
    ----------
    size : int
        Side of the texture in pixels.
    rows, columns : (T,) int64
        Where they are in the texture.
    face : (T,) int32
        Facet under each.
    weights : (T, 3) float32
        Barycentric place in the facet.
    place : (T, 3) float32
        mm, head frame, on the average head.
    kind : (T,) uint8
        Facet class.
    area : (T,) float32
        mm^2 of the average head that the texel shows.
    nearest : (size, size) int32
        Index of the covered texel that is nearest to each pixel of the texture.
    """

    size: int
    rows: NDArray[np.int64]
    columns: NDArray[np.int64]
    face: NDArray[np.int32]
    weights: Float32Array
    place: Float32Array
    kind: NDArray[np.uint8]
    area: Float32Array
    nearest: NDArray[np.int32]

    def lift(self, image: NDArray[np.uint8]) -> Float32Array:
        """Colours (T, 3) float32, 0 to 255, of the texels of a texture."""
        return np.asarray(image[self.rows, self.columns], np.float32)

    def lay(self, colour: Float32Array) -> NDArray[np.uint8]:
        """Texture (size, size, 3) uint8 of texel colours; gaps take the nearest one."""
        whole = np.clip(np.rint(colour), 0, 255).astype(np.uint8)
        return whole[self.nearest]


@lru_cache(maxsize=1)
def chart_of(speaker: Speaker, size: int) -> Chart:
    """The chart of a speaker in textures of size x size pixels."""
    corners = speaker.uv.astype(np.float64)[speaker.faces] * size - 0.5
    owner = np.full((size, size), -1, np.int32)
    fixed = np.round(corners * 2**_SUBPIXEL_BITS).astype(np.int32)
    for facet, polygon in enumerate(fixed):
        cv2.fillConvexPoly(owner, polygon, [facet], shift=_SUBPIXEL_BITS)
    rows, columns = np.nonzero(owner >= 0)
    face = owner[rows, columns]
    weights = _barycentric(corners[face], np.column_stack([columns, rows]))
    on_head = speaker.vertices[speaker.faces]
    place = np.einsum("tk,tkc->tc", weights, on_head[face])
    millimetres = np.linalg.norm(
        np.cross(on_head[:, 1] - on_head[:, 0], on_head[:, 2] - on_head[:, 0]), axis=1
    )
    texels = np.maximum(np.abs(_cross(corners)), 1e-6)
    return Chart(
        size, rows, columns, face, weights, place.astype(np.float32),
        speaker.facet_class[face], (millimetres / texels)[face].astype(np.float32),
        _nearest(owner, rows, columns),
    )  # fmt: skip


def _nearest(
    owner: NDArray[np.int32], rows: NDArray[np.int64], columns: NDArray[np.int64]
) -> NDArray[np.int32]:
    number = np.zeros(owner.shape, np.int32)
    number[rows, columns] = np.arange(len(rows))
    near = ndimage.distance_transform_edt(owner < 0, return_distances=False, return_indices=True)
    return np.asarray(number[tuple(near)], np.int32)


def _cross(corners: NDArray[np.float64]) -> NDArray[np.float64]:
    """Twice the signed area of triangles (..., 3, 2)."""
    ab, ac = corners[..., 1, :] - corners[..., 0, :], corners[..., 2, :] - corners[..., 0, :]
    return np.asarray(ab[..., 0] * ac[..., 1] - ab[..., 1] * ac[..., 0])


def _barycentric(corners: NDArray[np.float64], points: NDArray[np.int64]) -> Float32Array:
    """Weights (T, 3) of points (T, 2) in triangles (T, 3, 2); those just outside are moved in."""
    area = _cross(corners)
    safe = np.where(np.abs(area) < 1e-9, 1e-9, area)
    out = np.empty((len(points), 3))
    for k in range(3):
        part = corners.copy()
        part[:, k] = points
        out[:, k] = np.clip(_cross(part) / safe, 0, None)
    total = out.sum(axis=1, keepdims=True)
    return np.asarray(np.where(total > 0, out / np.maximum(total, 1e-12), 1 / 3), np.float32)
