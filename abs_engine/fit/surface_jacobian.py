"""The motion of a drawn surface's places in the picture with each parameter."""
# mypy: disable-error-code="no-untyped-def, no-untyped-call, untyped-decorator"

from __future__ import annotations

import numba
import numpy as np
from numpy.typing import NDArray

from abs_engine.compare.borders import Borders
from abs_engine.core.camera import Camera, Window
from abs_engine.core.pose import POSE_NAMES, PoseFrame
from abs_engine.core.scene import Candidates, Scene

FloatArray = NDArray[np.float64]


def moved_along(
    scene: Scene,
    camera: Camera,
    window: Window,
    candidate: Candidates,
    frame: PoseFrame,
    borders: Borders,
) -> FloatArray:
    """Motion along each border's normal for a unit of each parameter, (K, 6 + P), drawn pixels.

    Of the surface; the lens's distortion is left out.
    """
    rows = np.empty((len(borders.facet), len(POSE_NAMES) + scene.n_modes))
    focal = window.scale * np.array([camera.matrix[0, 0], camera.matrix[1, 1]])
    _fill(
        scene.mean, scene.modes_of_vertices, scene.faces, candidate.weights[0],
        candidate.rotations[0], candidate.translations[0], frame.pivot, focal, borders.facet,
        borders.weights, borders.normal, rows,
    )  # fmt: skip
    return rows


@numba.njit(cache=True, nogil=True, error_model="numpy", fastmath={"contract"})
def _fill(mean, modes, faces, posture, rotation, shift, pivot, focal, facet, weights, normal, rows):
    """Rows of `moved_along`, border after border."""
    at, moves = np.empty(3), np.empty((modes.shape[1], 3))
    arm, seen = np.empty(3), np.empty(3)
    for k in range(len(facet)):
        at[:], moves[:] = 0.0, 0.0
        for c in range(3):
            vertex, share = faces[facet[k], c], weights[k, c]
            for axis in range(3):
                at[axis] += share * mean[vertex, axis]
                for p in range(len(moves)):
                    moves[p, axis] += share * modes[vertex, p, axis]
        for p in range(len(moves)):
            for axis in range(3):
                at[axis] += posture[p] * moves[p, axis]
        arm[:], seen[:] = 0.0, shift
        for axis in range(3):
            for other in range(3):
                arm[axis] += rotation[axis, other] * (at[other] - pivot[other])
                seen[axis] += rotation[axis, other] * at[other]
        px, py = normal[k, 0] * focal[0] / seen[2], normal[k, 1] * focal[1] / seen[2]
        pz = -(px * seen[0] + py * seen[1]) / seen[2]
        rows[k, 0] = arm[1] * pz - arm[2] * py
        rows[k, 1] = arm[2] * px - arm[0] * pz
        rows[k, 2] = arm[0] * py - arm[1] * px
        rows[k, 3], rows[k, 4], rows[k, 5] = px, py, pz
        for p in range(len(moves)):
            total = 0.0
            for axis in range(3):
                turned = rotation[0, axis] * px + rotation[1, axis] * py + rotation[2, axis] * pz
                total += moves[p, axis] * turned
            rows[k, 6 + p] = total
