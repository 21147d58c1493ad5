"""Differences of textures, made white by what the texture model leaves out of its own frames."""
# mypy: disable-error-code="no-untyped-def, no-untyped-call, untyped-decorator"

from __future__ import annotations

from dataclasses import dataclass

import numba
import numpy as np
from numpy.typing import NDArray

from abs_engine.core.arrays import Float32Array
from abs_engine.core.buffers import Buffers
from abs_engine.core.compiled import LOOP
from abs_engine.core.scene import Scene


@dataclass(frozen=True, eq=False)
class TextureNoise:
    """Whitening of differences of luminance-normalised RGB, in a texture's atlas.

    `layers` (h, w, 1 + 3 q) are those of `face.appearance.residual_covariance.Leftover`.
    """

    layers: Float32Array

    def scales(self, scene: Scene, drawn: Buffers, where: NDArray[np.bool_]) -> Float32Array:
        """Factors by which single differences of some drawn pixels are multiplied, (N,)."""
        return self._at(scene, drawn, where)[:, 0]

    def whitened(
        self, off: Float32Array, scene: Scene, drawn: Buffers, where: NDArray[np.bool_]
    ) -> Float32Array:
        """Differences (N, 3) of some drawn pixels (H, W), times the noise's inverse root.

        The noise is 1 in every channel of every pixel, in units of spread, and that along
        `common` beside it: I + V' V. Along the principal axes Q of V, of squared length e, its
        inverse root is 1 / sqrt(1 + e), and 1 elsewhere.
        """
        read = self._at(scene, drawn, where)
        rows = off * read[:, :1]
        count = (read.shape[1] - 1) // 3
        if count == 0 or len(off) == 0:
            return rows
        v = read[:, 1:].reshape(-1, count, 3).transpose(1, 0, 2).reshape(count, -1)
        squared, axes = np.linalg.eigh((v @ v.T).astype(np.float64))
        long = squared > 1e-6
        e = squared[long]
        along = axes[:, long].T @ (v @ rows.ravel())
        drop = axes[:, long] @ ((1 - 1 / np.sqrt(1 + e)) / e * along)
        return np.asarray(rows - (drop.astype(np.float32) @ v).reshape(-1, 3), np.float32)

    def _at(self, scene: Scene, drawn: Buffers, where: NDArray[np.bool_]) -> Float32Array:
        """The layers at some drawn pixels, (N, 1 + 3 q)."""
        facets = drawn.facet_id[where] - 1
        out = np.empty((len(facets), self.layers.shape[2]), np.float32)
        _read(self.layers, scene.uv, scene.faces, facets, drawn.barycentrics[where], out)
        return out


@numba.njit(**LOOP, error_model="numpy", fastmath={"contract", "reassoc"})
def _read(layers, uv, faces, facets, barycentrics, out):
    """Interpolate layers (h, w, C) between texels at points of facets; pixel = uv * size - 0.5."""
    height, width, count = layers.shape
    half, zero = np.float32(0.5), np.float32(0)
    for n in range(len(facets)):
        x, y = zero, zero
        for k in range(3):
            corner = faces[facets[n], k]
            x += barycentrics[n, k] * uv[corner, 0]
            y += barycentrics[n, k] * uv[corner, 1]
        x = min(max(x * np.float32(width) - half, zero), np.float32(width - 1))
        y = min(max(y * np.float32(height) - half, zero), np.float32(height - 1))
        i, j = int(x), int(y)
        i2, j2 = min(i + 1, width - 1), min(j + 1, height - 1)
        fx, fy = x - np.float32(i), y - np.float32(j)
        for c in range(count):
            upper = layers[j, i, c] + fx * (layers[j, i2, c] - layers[j, i, c])
            lower = layers[j2, i, c] + fx * (layers[j2, i2, c] - layers[j2, i, c])
            out[n, c] = upper + fy * (lower - upper)
