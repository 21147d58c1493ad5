"""The motion of landmarks in the picture and in depth with each parameter, compiled."""
# mypy: disable-error-code="no-untyped-def, no-untyped-call, untyped-decorator"

from __future__ import annotations

import numba
import numpy as np


def load() -> None:
    """Load the compiled function, and most of numba with it, which takes a while."""
    point, none = np.zeros((1, 3)), np.zeros((0, 1, 3))
    seen_motion(point + 1, point[0], none, np.eye(3), np.ones(1), np.eye(2))


@numba.njit(cache=True, nogil=True, error_model="numpy")
def seen_motion(there, pivot, modes, rotation, factor, axes):
    """Motion of points for a unit of each of pose (6) and modes (D), (6 + D, N, 3), mm.

    Along the face's `axes` (2, 2) in the picture, times `factor` (N,), and in depth as it is.
    `there` (N, 3) and `pivot` (3,) are in the camera's frame, `modes` (D, N, 3) in the head's.
    """
    count, extra = len(there), len(modes)
    out = np.empty((6 + extra, count, 3))
    move = np.empty(3)
    for d in range(6 + extra):
        for n in range(count):
            x, y, z = there[n, 0], there[n, 1], there[n, 2]
            ax, ay, az = x - pivot[0], y - pivot[1], z - pivot[2]
            move[:] = 0.0
            if d == 0:
                move[1], move[2] = -az, ay
            elif d == 1:
                move[0], move[2] = az, -ax
            elif d == 2:
                move[0], move[1] = -ay, ax
            elif d < 6:
                move[d - 3] = 1.0
            else:
                for k in range(3):
                    for axis in range(3):
                        move[k] += rotation[k, axis] * modes[d - 6, n, axis]
            u, v = move[0] - x / z * move[2], move[1] - y / z * move[2]
            out[d, n, 0] = factor[n] * (axes[0, 0] * u + axes[0, 1] * v)
            out[d, n, 1] = factor[n] * (axes[1, 0] * u + axes[1, 1] * v)
            out[d, n, 2] = move[2]
    return out
