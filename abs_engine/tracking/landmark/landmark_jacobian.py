"""The motion of landmarks in the picture and in depth with each parameter, compiled."""
# mypy: disable-error-code="no-untyped-def, no-untyped-call, untyped-decorator"

from __future__ import annotations

import numba
import numpy as np

from abs_engine.core.compiled import INNER, LOOP


def load() -> None:
    """Load the compiled function, and what numba and NumPy load for any, which takes a while."""
    point, none = np.zeros((1, 3)), np.zeros((0, 1, 3))
    weighed_motion(
        point + 1, point[0], none, np.eye(3), np.ones(1), np.eye(2), np.zeros(1), point,
        np.empty((6, 3)),
    )  # fmt: skip


@numba.njit(**LOOP, error_model="numpy")
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


@numba.njit(**INNER, error_model="numpy")
def _place(points, modes, posture, motion):
    """Move points (N, 3) by a posture (M,) and then by `motion` (3, 4), in place."""
    line = points.reshape(-1)
    for k in range(len(posture)):
        mode = modes[k].reshape(-1)
        for n in range(len(line)):
            line[n] += posture[k] * mode[n]
    for n in range(len(points)):
        x, y, z = points[n]
        for a in range(3):
            points[n, a] = motion[a, 0] * x + motion[a, 1] * y + motion[a, 2] * z + motion[a, 3]


@numba.njit(**LOOP, error_model="numpy")
def weighed_residuals(
    mean, modes, normals, posture, motion, pivot, rays, sunk, axes, trusted, bias, deviation,
    together, stray, flat, hidden, guessed, residual, out,
):  # fmt: skip
    """Landmarks off where they are seen, and their motion, both times the root of their trust.

    Parameters
    ----------
    mean, normals : (N, 3), `modes` (M, N, 3), `posture` (M,)
    motion : (3, 4)
        Head to camera.
    pivot : (3,), camera frame
    rays, sunk, axes, trusted, bias : (N, 2), (N,), (2, 2), (N,), (N, 2)
        What is seen; see `SeenRays` and `LandmarkShape`.
    deviation : (N, 3)
    together, stray : (N,)
        How many count as one, and the deviations from where on one counts less.
    flat : (N,) bool
        Whose depths say nothing.
    hidden, guessed : float
        Cosine below which one is guessed, and what it then counts.
    residual : (N, 3), out
    out : (6 + M, 3 N), out; see `weighed_motion`

    Returns
    -------
    float
        RMS distance in the picture, standard deviations.
    """
    count = len(mean)
    there, weight, factor = mean.copy(), np.empty((count, 3)), np.empty(count)
    rotation, deep = np.ascontiguousarray(motion[:, :3]), 0.0
    _place(there, modes, posture, motion)
    for n in range(count):
        factor[n] = pivot[2] / there[n, 2]
        deep += (sunk[n] * pivot[2] - there[n, 2]) / count
    total = 0.0
    for n in range(count):
        x, y, z = there[n]
        dx, dy = (x / z - rays[n, 0]) * pivot[2], (y / z - rays[n, 1]) * pivot[2]
        for a in range(2):
            residual[n, a] = (axes[a, 0] * dx + axes[a, 1] * dy + bias[n, a]) / deviation[n, a]
        residual[n, 2] = (deep - sunk[n] * pivot[2] + z) / deviation[n, 2]
        away = residual[n, 0] ** 2 + residual[n, 1] ** 2
        total += away
        facing = 0.0
        for a in range(3):
            for b in range(3):
                facing -= rotation[a, b] * normals[n, b] * there[n, a]
        facing = (facing / np.sqrt(x * x + y * y + z * z) - hidden) / (1.0 - hidden)
        trust = trusted[n] * min(max(facing, guessed), 1.0) / (1.0 + away / stray[n] ** 2)
        root = np.sqrt(trust / together[n])
        if flat[n]:
            residual[n, 2] = 0.0
        for a in range(3):
            residual[n, a] *= root
            weight[n, a] = root / deviation[n, a]
        if flat[n]:
            weight[n, 2] = 0.0
    weighed_motion(there, pivot, modes, rotation, factor, axes, np.zeros(count), weight, out)
    return np.sqrt(total / (2 * count))
