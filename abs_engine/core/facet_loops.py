"""Loops over the facets of a mesh, compiled."""
# mypy: disable-error-code="no-untyped-def, no-untyped-call, untyped-decorator"

from __future__ import annotations

import numba
import numpy as np

from abs_engine.core.compiled import LOOP


@numba.njit(**LOOP, error_model="numpy")
def unit_normals(vertices, faces):
    """Area-weighted unit vertex normals (V, 3), zero where no adjacent facet has an area."""
    across, out = np.empty((len(faces), 3)), np.zeros((len(vertices), 3))
    for f in range(len(faces)):
        a, b, c = vertices[faces[f, 0]], vertices[faces[f, 1]], vertices[faces[f, 2]]
        for i in range(3):
            j, k = (i + 1) % 3, (i + 2) % 3
            across[f, i] = (b[j] - a[j]) * (c[k] - a[k]) - (b[k] - a[k]) * (c[j] - a[j])
    for corner in range(3):
        for f in range(len(faces)):
            for i in range(3):
                out[faces[f, corner], i] += across[f, i]
    for v in range(len(out)):
        x, y, z = out[v]
        length = np.sqrt(x * x + y * y + z * z)
        if length > 0:
            out[v, 0], out[v, 1], out[v, 2] = x / length, y / length, z / length
    return out
