"""The motion of landmarks in the picture and in depth with each parameter, compiled."""
# mypy: disable-error-code="no-untyped-def, no-untyped-call, untyped-decorator"

from __future__ import annotations

import importlib

import numba
import numpy as np
from numba.np import linalg


def load() -> None:
    """Load the compiled function, and most of numba with it, which takes a while.

    Numba would import `scipy.linalg` for products of matrices, which no compiled function of ours
    has: it does so for those that need it, too.
    """
    checked = linalg.ensure_blas
    linalg.ensure_blas = lambda: None
    try:
        importlib.import_module("numba.np.arraymath").ensure_blas = checked  # type: ignore[attr-defined]
    finally:
        linalg.ensure_blas = checked
    point, none = np.zeros((1, 3)), np.zeros((0, 1, 3))
    weighed_motion(
        point + 1, point[0], none, np.eye(3), np.ones(1), np.eye(2), np.zeros(1), point,
        np.empty((6, 3)),
    )  # fmt: skip


@numba.njit(cache=True, nogil=True, error_model="numpy")
def weighed_motion(there, pivot, modes, rotation, factor, axes, sunk, weight, out):
    """Motion of points for a unit of each of pose (6) and modes (D), mm, times a `weight`.

    Along the face's `axes` (2, 2) in the picture, times `factor` (N,), and in depth: less `sunk`
    (N,) times the points' mean depth, then less the mean of that. `there` (N, 3) and `pivot` (3,)
    are in the camera's frame, `modes` (D, N, 3) in the head's; `weight` is (N, 3), `out`
    (6 + D, 3 N), of all of them one after another.
    """
    count = len(there)
    seen, step = np.empty((count, 3, 3)), np.empty((count, 3, 3))
    for n in range(count):
        x, y, z = there[n, 0], there[n, 1], there[n, 2]
        for a in range(2):
            seen[n, a, 0], seen[n, a, 1] = factor[n] * axes[a, 0], factor[n] * axes[a, 1]
            seen[n, a, 2] = -(x * seen[n, a, 0] + y * seen[n, a, 1]) / z
        seen[n, 2, 0], seen[n, 2, 1], seen[n, 2, 2] = 0.0, 0.0, 1.0
        for a in range(3):
            for b in range(3):
                step[n, a, b] = 0.0
                for k in range(3):
                    step[n, a, b] += seen[n, a, k] * rotation[k, b]
    for d in range(len(out)):
        mean, of_sunk = 0.0, 0.0
        for n in range(count):
            for a in range(3):
                if d >= 6:
                    here, of = step[n, a], modes[d - 6, n]
                    moved = here[0] * of[0] + here[1] * of[1] + here[2] * of[2]
                elif d >= 3:
                    moved = seen[n, a, d - 3]
                else:  # a turn about the axis d
                    i, j = (d + 1) % 3, (d + 2) % 3
                    moved = seen[n, a, j] * (there[n, i] - pivot[i])
                    moved -= seen[n, a, i] * (there[n, j] - pivot[j])
                out[d, 3 * n + a] = moved
            mean += out[d, 3 * n + 2] / count
            of_sunk += sunk[n] / count
        for n in range(count):
            out[d, 3 * n] *= weight[n, 0]
            out[d, 3 * n + 1] *= weight[n, 1]
            deep = out[d, 3 * n + 2] - sunk[n] * mean - (1.0 - of_sunk) * mean
            out[d, 3 * n + 2] = deep * weight[n, 2]
