"""Smooth displacements of a surface: a Gaussian process in place of what no shape target knows.

Lüthi, Gerig, Jud and Vetter, "Gaussian Process Morphable Models", IEEE TPAMI 40(8), 2018: a sum of
Gaussian kernels, its eigenfunctions by Nyström's method (section 4.2). Gerig, Morel-Forster,
Blumer, Egger, Lüthi, Schönborn and Vetter, "Morphable Face Models - An Open Framework", FG 2018: a
kernel that mirrors, as faces are nearly symmetric.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.arrays import FloatArray
from abs_engine.face.settings.shape import SHAPE

_AT_ONCE = 512  # rows of the kernel


def smooth_modes(
    vertices: FloatArray, scales: Sequence[tuple[float, float]] = SHAPE.smooth_scales
) -> FloatArray:
    """Displacements (K, V, 3), mm per standard deviation, of vertices (V, 3), mm.

    The same for each coordinate, so K is three times the kernel's rank.
    """
    samples = vertices[_spread(vertices, min(SHAPE.smooth_samples, len(vertices)))]
    kernel = _kernel(samples, samples, scales)
    fields = _fields(_kernel(vertices, samples, scales), kernel)
    each = np.zeros((len(fields), 3, len(vertices), 3))
    for axis in range(3):
        each[:, axis, :, axis] = fields
    return np.asarray(each.reshape(-1, len(vertices), 3))


def mirrored_modes(
    vertices: FloatArray,
    asymmetry: float,
    scales: Sequence[tuple[float, float]] = SHAPE.smooth_scales,
) -> NDArray[np.float32]:
    """Displacements (K, V, 3) float32, as `smooth_modes`, of a body nearly its own mirror image.

    x runs across, and is 0 in the plane of the mirror. The sides differ by so much less,
    `asymmetry`, than those of `smooth_modes`, which are free; what both share is as there.
    """
    half = vertices[vertices[:, 0] >= 0]
    here = half[_spread(half, min(SHAPE.smooth_samples // 2, len(half)))]
    there = here * np.array([-1.0, 1.0, 1.0])
    single = vertices.astype(np.float32)  # takes half of the time
    near, far = (_kernel(single, x.astype(np.float32), scales) for x in (here, there))
    own, across = (_kernel(here, x, scales) for x in (here, there))
    even, odd = (_fields(0.5 * (near + s * far), 0.5 * (own + s * across)) for s in (1.0, -1.0))
    across_face = _widest(np.concatenate([odd, asymmetry * even]))
    in_plane = _widest(np.concatenate([even, asymmetry * odd]))
    each = np.zeros((3, SHAPE.smooth_fields, len(vertices), 3), np.float32)
    each[0, : len(across_face), :, 0] = across_face
    each[1, : len(in_plane), :, 1] = each[2, : len(in_plane), :, 2] = in_plane
    return each.reshape(-1, len(vertices), 3)


def _widest(fields: NDArray[np.floating]) -> NDArray[np.floating]:
    """The fields (K, V) that move most, at most `SHAPE.smooth_fields`."""
    return np.asarray(fields[np.argsort(-(fields**2).sum(axis=1))[: SHAPE.smooth_fields]])


def _fields(kernel: NDArray[np.floating], samples: NDArray[np.floating]) -> NDArray[np.floating]:
    """Eigenfunctions (K, V) by the kernel (V, S) to samples, and of the samples (S, S)."""
    values, vectors = np.linalg.eigh(samples + 1e-6 * np.eye(len(samples)))
    order = np.argsort(-values)[: SHAPE.smooth_fields]
    along = (vectors[:, order] / np.sqrt(values[order])).astype(kernel.dtype)
    return np.asarray((kernel @ along).T)


def _spread(vertices: FloatArray, count: int) -> NDArray[np.int_]:
    """Vertices that lie far from each other: each the farthest from those before."""
    chosen, away = [0], np.full(len(vertices), np.inf)
    x, y, z = np.ascontiguousarray(vertices.T)
    for _ in range(count - 1):
        last = chosen[-1]
        np.minimum(away, (x - x[last]) ** 2 + (y - y[last]) ** 2 + (z - z[last]) ** 2, out=away)
        chosen.append(int(away.argmax()))
    return np.array(chosen)


def _kernel(
    one: NDArray[np.floating], other: NDArray[np.floating], scales: Sequence[tuple[float, float]]
) -> NDArray[np.floating]:
    """Covariance (N, M) of the displacements at points, mm^2."""
    out = np.zeros((len(one), len(other)), one.dtype)
    for first in range(0, len(one), _AT_ONCE):  # few enough to stay in a processor's cache
        part, sums = one[first : first + _AT_ONCE], out[first : first + _AT_ONCE]
        apart = (part**2).sum(1)[:, None] + (other**2).sum(1) - 2 * part @ other.T
        np.maximum(apart, 0, out=apart)
        apart *= -0.5
        term = np.empty_like(apart)
        for sd, reach in scales:
            np.exp(np.divide(apart, reach**2, out=term), out=term)
            term *= sd**2
            sums += term
    return out
