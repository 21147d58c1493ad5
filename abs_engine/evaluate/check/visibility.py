"""The check of lines of sight: what each pixel meets, by vertices and facet ids alone.

The ray through the centre of a pixel is met with the facet that the id names. Where a mirror is,
a facet is met twice, directly and reflected, and the one that the pixel lies in is kept.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.arrays import BoolArray, FloatArray, IntArray
from abs_engine.core.camera import Camera
from abs_engine.dataset import Truth


@dataclass(frozen=True, eq=False)
class Reflection:
    """The plane of a mirror, camera frame: points x with normal . x = offset.

    Parameters
    ----------
    corners : (4, 3) float64, mm
        A rectangle.
    """

    corners: FloatArray

    @property
    def normal(self) -> FloatArray:
        """Unit normal, (3,)."""
        across, up = self.corners[1] - self.corners[0], self.corners[3] - self.corners[0]
        normal = np.cross(across, up)
        return np.asarray(normal / np.linalg.norm(normal))

    def points(self, points: FloatArray) -> FloatArray:
        """Mirror images of points (..., 3)."""
        away = (points - self.corners[0]) @ self.normal
        return np.asarray(points - 2 * away[..., None] * self.normal)

    def directions(self, vectors: FloatArray) -> FloatArray:
        """Mirror images of directions (..., 3)."""
        return np.asarray(vectors - 2 * (vectors @ self.normal)[..., None] * self.normal)

    def seen_through(self, rays: FloatArray) -> BoolArray:
        """Mask of the lines of sight (N, 3) from the camera's centre that meet the rectangle."""
        across, up = self.corners[1] - self.corners[0], self.corners[3] - self.corners[0]
        with np.errstate(divide="ignore", invalid="ignore"):
            reach = (self.normal @ self.corners[0]) / (rays @ self.normal)
            hit = rays * reach[:, None] - self.corners[0]
        a, b = hit @ across / (across @ across), hit @ up / (up @ up)
        return np.asarray((reach > 0) & (a >= 0) & (a <= 1) & (b >= 0) & (b <= 1))


@dataclass(frozen=True, eq=False)
class Head:
    """Vertices of a frame before a camera.

    Parameters
    ----------
    points : (V, 3) float64, mm, camera frame
    drawn : (V, 3) float64
        The same with the lens distortion applied, so that an ideal lens sees them in place.
    """

    points: FloatArray
    drawn: FloatArray

    @classmethod
    def of(cls, truth: Truth, frame: int, mirror: Reflection | None = None) -> Head:
        """The head of a frame, or its image in a mirror."""
        points = truth.pose(frame).apply(truth.vertices(frame).astype(np.float64))
        points = points if mirror is None else mirror.points(points)
        return cls(points, truth.camera.distort(points))


@dataclass(frozen=True, eq=False)
class Sight:
    """The N pixels of a frame that have a facet id.

    Parameters
    ----------
    ids : (H, W) uint16
    x, y : (N,) int
    facet : (N,) int
    weights : (N, 3) float64
        Barycentric weights of the point that is seen, perspective-correct.
    depth : (N,) float64, mm
    slope : (N,) float64
        How fast the depth changes from pixel to pixel, mm/px.
    edges : (N, 3, 2) float64
        Outward unit normals of the facet's edges in the picture.
    outside : (N, 3) float64
        How far the pixel's centre lies outside of each edge, px; negative inside.
    mirrored : (N,) bool
    """

    frame: int
    ids: NDArray[np.uint16]
    x: IntArray
    y: IntArray
    facet: IntArray
    weights: FloatArray
    depth: FloatArray
    slope: FloatArray
    edges: FloatArray
    outside: FloatArray
    mirrored: BoolArray
    reflection: Reflection | None

    def __len__(self) -> int:
        """Return the number of pixels."""
        return len(self.x)

    def blend(self, truth: Truth, direct: FloatArray, mirrored: FloatArray | None) -> FloatArray:
        """Values (V, C) of vertices at the points that are seen, (N, C)."""
        corner = truth.faces[self.facet]
        out = np.einsum("nk,nkc->nc", self.weights, direct[corner])
        if mirrored is not None:
            other = np.einsum("nk,nkc->nc", self.weights, mirrored[corner])
            out = np.where(self.mirrored[:, None], other, out)
        return np.asarray(out)


def reflection(truth: Truth) -> Reflection | None:
    """The mirror of a view, if there is one."""
    return None if truth.mirror is None else Reflection(truth.mirror)


def in_mirror(truth: Truth, x: NDArray[np.integer], y: NDArray[np.integer]) -> BoolArray:
    """Mask (N,) of the pixels that look into the mirror."""
    mirror = reflection(truth)
    if mirror is None:
        return np.zeros(len(x), np.bool_)
    return mirror.seen_through(lines_of_sight(truth.camera, np.column_stack([x, y])))


def lines_of_sight(camera: Camera, pixels: NDArray[np.number]) -> FloatArray:
    """Directions (N, 3), z = 1, in which pixels (N, 2) look; the lens is undone step by step."""
    inverse = np.linalg.inv(camera.matrix)
    ideal = np.column_stack([pixels, np.ones(len(pixels))]) @ inverse.T
    rays = ideal.copy()
    for _ in range(40 if camera.distorted else 0):
        rays[:, :2] += (ideal - camera.distort(rays))[:, :2]
    return np.asarray(rays)


def look(truth: Truth, frame: int) -> Sight:
    """Meet every line of sight of a frame with the facet that is named there."""
    ids = truth.facet_ids(frame)
    y, x = np.nonzero(ids)
    facet = np.minimum(ids[y, x].astype(np.int64) - 1, len(truth.faces) - 1)
    mirror = reflection(truth)
    parts = _meet(truth, Head.of(truth, frame), x, y, facet)
    mirrored = np.zeros(len(x), np.bool_)
    if mirror is not None:
        other = _meet(truth, Head.of(truth, frame, mirror), x, y, facet)
        nearer = other[-1].max(axis=1) < parts[-1].max(axis=1)
        mirrored = in_mirror(truth, x, y) & nearer
        parts = tuple(
            np.where(mirrored.reshape(-1, *[1] * (a.ndim - 1)), b, a)
            for a, b in zip(parts, other, strict=True)
        )
    weights, depth, slope, edges, outside = parts
    return Sight(frame, ids, x, y, facet, weights, depth, slope, edges, outside, mirrored, mirror)


def _meet(
    truth: Truth, head: Head, x: IntArray, y: IntArray, facet: IntArray
) -> tuple[FloatArray, ...]:
    """Weights, depth, slope, edges, outside; see `Sight`."""
    inverse = np.linalg.inv(truth.camera.matrix)
    pixel = np.column_stack([x, y, np.ones(len(x))])
    rays = pixel @ inverse.T
    corners = head.drawn[truth.faces[facet]]
    a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]
    parts = [np.einsum("ni,ni->n", rays, np.cross(*pair)) for pair in ((b, c), (c, a), (a, b))]
    with np.errstate(divide="ignore", invalid="ignore"):
        weights = np.stack(parts, axis=1) / np.sum(parts, axis=0)[:, None]
        depth = np.einsum("nk,nk->n", weights, corners[..., 2])
        normal = np.cross(b - a, c - a) @ inverse
        slope = np.abs(depth) * np.hypot(normal[:, 0], normal[:, 1])
        slope /= np.abs(np.einsum("ni,ni->n", normal, pixel))
        edges, outside = _edges(corners @ truth.camera.matrix.T, pixel[:, :2])
    return weights, depth, slope, edges, outside


def _edges(image: FloatArray, pixel: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Outward normals (N, 3, 2) of the edges of facets, and how far pixels lie outside (N, 3)."""
    place = image[..., :2] / image[..., 2:]
    run = np.roll(place, -1, axis=1) - place
    turn = np.sign(run[:, 0, 0] * run[:, 1, 1] - run[:, 0, 1] * run[:, 1, 0])
    normal = np.stack([run[..., 1], -run[..., 0]], axis=-1) * turn[:, None, None]
    normal /= np.linalg.norm(normal, axis=2, keepdims=True)
    outside = np.einsum("nkc,nkc->nk", normal, pixel[:, None] - place)
    behind = (image[..., 2] <= 0).any(axis=1) | ~np.isfinite(outside).all(axis=1)
    far = np.where(behind[:, None], 1e6, outside)
    return np.nan_to_num(normal), far
