"""The head of a clip, frame by frame: offsets, smooth normals, and the gap between the lips."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from scipy import sparse

from abs_engine.core.arrays import Float32Array
from abs_engine.io.assets import Speaker


def inner_shade(speaker: Speaker) -> Float32Array:
    """Factor (V,) by which vertices inside the mouth are darkened, as the lights cast no shadow."""
    chosen = speaker.vertices_of("inner_mouth", "upper_teeth", "lower_teeth", "tongue")
    front = speaker.vertices[speaker.landmarks["inner_lip_8"], 2].max()
    depth = np.clip(front - speaker.vertices[chosen, 2], 0, None)
    out = np.ones(len(speaker.vertices), np.float32)
    out[chosen] = 0.12 + 0.88 * np.exp(-depth / 18.0)
    return out


def smooth_normals(speaker: Speaker, vertices: Float32Array) -> Float32Array:
    """Unit normals (V, 3) of a head's vertices (V, 3), smooth across texture seams."""
    a, b, c = (vertices[speaker.faces[:, k]] for k in range(3))
    sums = _sums_of_facets(speaker) @ np.cross(b - a, c - a)
    length = np.linalg.norm(sums, axis=1, keepdims=True)
    return np.asarray((sums / np.maximum(length, 1e-12))[speaker.weld], np.float32)


@lru_cache(maxsize=2)
def _sums_of_facets(speaker: Speaker) -> sparse.csr_matrix:
    """Matrix of sums, at each welded vertex, over the facets that meet there."""
    rows = speaker.weld[speaker.faces].ravel()
    columns = np.repeat(np.arange(len(speaker.faces)), 3)
    return sparse.csr_matrix((np.ones(len(rows), np.float32), (rows, columns)))
