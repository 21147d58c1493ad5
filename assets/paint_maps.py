"""What a painter needs to know at every texel: where it lies on the head, and seeded noise there.

All patterns are functions of the place on the head (mm), so no seam of the chart shows.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from scipy import ndimage
from scipy.spatial import cKDTree

LATTICE = 32


@dataclass(frozen=True)
class Texels:
    """The texels that a facet covers, as flat lists.

    Attributes
    ----------
    size : int
        Side of the texture in pixels.
    rows, columns : (T,) int
        Where they are in the texture.
    face : (T,) int
        The facet under each.
    place : (T, 3) float64
        Its position on the average head, mm.
    kind : (T,) uint8
        Class of the facet.
    hollow : (T,) float64
        Concavity of the surface there, about -1 (ridge) to 1 (crease).
    """

    size: int
    rows: np.ndarray
    columns: np.ndarray
    face: np.ndarray
    place: np.ndarray
    kind: np.ndarray
    hollow: np.ndarray


def cover(uv: np.ndarray, faces: np.ndarray, size: int) -> np.ndarray:
    """Return the (size, size) facet number under each texel, -1 where there is none."""
    owner = np.full((size, size), -1, np.int32)
    corners = np.round((uv[faces] * size - 0.5) * 16).astype(np.int32)
    for f, polygon in enumerate(corners):
        cv2.fillConvexPoly(owner, polygon, f, shift=4)
    return owner


def cross_2d(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Return the signed area of the parallelograms of plane vectors."""
    return a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]


def barycentric(
    uv: np.ndarray, faces: np.ndarray, owner: np.ndarray, rows: np.ndarray, columns: np.ndarray
) -> np.ndarray:
    """Return (T, 3) weights of each texel in its facet, not below zero."""
    size = len(owner)
    a, b, c = (uv[faces[owner[rows, columns]]] * size - 0.5).transpose(1, 0, 2)
    p = np.stack([columns, rows], 1)
    area = cross_2d(b - a, c - a)
    area = np.where(np.abs(area) < 1e-9, 1e-9, area)
    w = np.stack([cross_2d(b - p, c - p), cross_2d(c - p, a - p), cross_2d(a - p, b - p)], 1)
    w = np.clip(w / area[:, None], 0.0, None)
    return w / w.sum(1, keepdims=True)


def hollowness(vertices: np.ndarray, faces: np.ndarray, weld: np.ndarray) -> np.ndarray:
    """Return the concavity at each vertex: how far its neighbours' mean lies outside, per edge."""
    n = weld.max() + 1
    corners = weld[faces]
    points = np.zeros((n, 3))
    points[weld] = vertices
    tri = points[corners]
    normal = np.zeros((n, 3))
    mean, count, length = np.zeros((n, 3)), np.zeros(n), np.zeros(n)
    face_normal = np.cross(tri[:, 1] - tri[:, 0], tri[:, 2] - tri[:, 0])
    for i in range(3):
        here, there = corners[:, i], corners[:, (i + 1) % 3]
        np.add.at(normal, here, face_normal)
        for a, b in ((here, there), (there, here)):
            np.add.at(mean, a, points[b])
            np.add.at(count, a, 1.0)
            np.add.at(length, a, np.linalg.norm(points[a] - points[b], axis=1))
    normal /= np.linalg.norm(normal, axis=1, keepdims=True) + 1e-12
    offset = mean / count[:, None] - points
    return np.clip(4.0 * (normal * offset).sum(1) / (length / count), -1, 1)[weld]


def texels(arrays: dict[str, np.ndarray], size: int) -> Texels:
    """Rasterise the chart and carry the head's geometry to the texels."""
    uv, faces = arrays["uv"].astype(float), arrays["faces"]
    vertices = arrays["vertices"].astype(float)
    owner = cover(uv, faces, size)
    rows, columns = np.nonzero(owner >= 0)
    face = owner[rows, columns]
    weights = barycentric(uv, faces, owner, rows, columns)
    place = np.einsum("tk,tkc->tc", weights, vertices[faces[face]])
    hollow = hollowness(vertices, faces, arrays["weld"])
    return Texels(
        size,
        rows,
        columns,
        face,
        place,
        arrays["facet_class"][face],
        (weights * hollow[faces[face]]).sum(1),
    )


def noise(place: np.ndarray, wavelength: float, seed: int) -> np.ndarray:
    """Return smooth noise of about unit spread and zero mean at places (mm)."""
    lattice = np.random.default_rng(seed).normal(size=(LATTICE,) * 3)
    turn, _ = np.linalg.qr(np.random.default_rng(seed + 1).normal(size=(3, 3)))
    at = (place @ turn) / wavelength
    value = ndimage.map_coordinates(lattice, at.T, order=1, mode="grid-wrap")
    return value / 0.6


def layered(
    place: np.ndarray, wavelengths: list[float], gains: list[float], seed: int
) -> np.ndarray:
    """Return a weighted sum of noises of several wavelengths (mm)."""
    return sum(
        g * noise(place, w, seed + 17 * i)
        for i, (w, g) in enumerate(zip(wavelengths, gains, strict=True))
    )


def step(x: np.ndarray, low: float, high: float) -> np.ndarray:
    """Rise smoothly from 0 at `low` to 1 at `high` (or fall, if low > high)."""
    t = np.clip((x - low) / (high - low), 0.0, 1.0)
    return t * t * (3.0 - 2.0 * t)


def bump(
    place: np.ndarray, centre: tuple[float, float, float], radius: float, mirrored: bool = True
) -> np.ndarray:
    """Return a Gaussian spot around a place, on both sides of the head when `mirrored`."""
    at = place * [1, 1, 1]
    if mirrored:
        at[:, 0] = np.abs(at[:, 0])
    return np.exp(-(((at - centre) ** 2).sum(1)) / radius**2)


def to_points(place: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Return the distance (mm) of each place to the nearest of some points."""
    return cKDTree(points).query(place, workers=1)[0]


def dense(loop: np.ndarray, closed: bool) -> np.ndarray:
    """Sample a polyline at twenty points an edge."""
    following = np.roll(loop, -1, 0) if closed else loop[1:]
    start = loop if closed else loop[:-1]
    t = np.linspace(0, 1, 20, endpoint=False)[:, None, None]
    return (start + t * (following - start)).reshape(-1, loop.shape[1])


def to_image(at: Texels, colour: np.ndarray) -> np.ndarray:
    """Put texel colours (T, 3), 0 to 1, into an RGB image; fill the gaps with the nearest ones."""
    image = np.zeros((at.size, at.size, 3))
    empty = np.ones((at.size, at.size), bool)
    image[at.rows, at.columns] = colour
    empty[at.rows, at.columns] = False
    near = ndimage.distance_transform_edt(empty, return_distances=False, return_indices=True)
    return np.round(np.clip(image[tuple(near)], 0, 1) * 255).astype(np.uint8)
