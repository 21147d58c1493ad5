"""The motion of a drawn surface's places in the picture with each parameter."""
# mypy: disable-error-code="no-untyped-def, no-untyped-call, untyped-decorator"

from __future__ import annotations

import numba
import numpy as np

from abs_engine.compare.borders import Borders
from abs_engine.core.arrays import FloatArray
from abs_engine.core.camera import Camera, Window
from abs_engine.core.compiled import LOOP
from abs_engine.core.pose import POSE_NAMES, PoseFrame
from abs_engine.core.scene import Candidates, Scene


def summed_along(
    scene: Scene,
    camera: Camera,
    window: Window,
    candidate: Candidates,
    frame: PoseFrame,
    borders: Borders,
    observations: float,
) -> tuple[FloatArray, FloatArray]:
    """Gain and curvature of a drawing for a unit of each parameter, by those of its borders.

    A parameter moves a border along its normal as it moves the surface there; the lens's distortion
    is left out. The sums over borders are (6 + P,) of motion times gain, and (6 + P, 6 + P) of
    curvature times both motions, with the gain's square over the independent observations: the
    value is a logarithm of a sum.
    """
    size = len(POSE_NAMES) + scene.n_modes
    fall, bend = np.zeros(size), np.zeros((size, size))
    focal = window.scale * np.array([camera.matrix[0, 0], camera.matrix[1, 1]])
    _sum(
        scene.mean, scene.modes_of_vertices, scene.faces, candidate.weights[0],
        candidate.rotations[0], candidate.translations[0], frame.pivot, focal, borders.facet,
        borders.weights, borders.normal, borders.gain, borders.curve, max(observations, 1.0), fall,
        bend,
    )  # fmt: skip
    return fall, bend


@numba.njit(**LOOP, error_model="numpy", fastmath={"contract"})
def _sum(mean, modes, faces, posture, rotation, shift, pivot, focal, facet, weights, normal, gain,
         curve, observations, fall, bend):  # fmt: skip
    """The sums of `summed_along`, border after border."""
    lines, many = modes.reshape((len(modes), -1)), modes.shape[1]
    at, moves = np.empty(3), np.empty(3 * many)
    arm, seen, row = np.empty(3), np.empty(3), np.empty(len(fall))
    for k in range(len(facet)):
        moves[:] = 0.0
        for axis in range(3):  # slices of arrays would take four seconds to compile
            at[axis], arm[axis], seen[axis] = 0.0, 0.0, shift[axis]
        for c in range(3):
            vertex, share = faces[facet[k], c], weights[k, c]
            for axis in range(3):
                at[axis] += share * mean[vertex, axis]
            for j in range(len(moves)):  # one number after another, several in a step
                moves[j] += share * lines[vertex, j]
        for p in range(many):
            for axis in range(3):
                at[axis] += posture[p] * moves[3 * p + axis]
        for axis in range(3):
            for other in range(3):
                arm[axis] += rotation[axis, other] * (at[other] - pivot[other])
                seen[axis] += rotation[axis, other] * at[other]
        px, py = normal[k, 0] * focal[0] / seen[2], normal[k, 1] * focal[1] / seen[2]
        pz = -(px * seen[0] + py * seen[1]) / seen[2]
        row[0] = arm[1] * pz - arm[2] * py
        row[1] = arm[2] * px - arm[0] * pz
        row[2] = arm[0] * py - arm[1] * px
        row[3], row[4], row[5] = px, py, pz
        tx = rotation[0, 0] * px + rotation[1, 0] * py + rotation[2, 0] * pz
        ty = rotation[0, 1] * px + rotation[1, 1] * py + rotation[2, 1] * pz
        tz = rotation[0, 2] * px + rotation[1, 2] * py + rotation[2, 2] * pz
        for p in range(many):
            row[6 + p] = moves[3 * p] * tx + moves[3 * p + 1] * ty + moves[3 * p + 2] * tz
        for p in range(len(row)):
            fall[p] += gain[k] * row[p]
            stiff, line = curve[k] * row[p], bend[p]
            for q in range(p + 1):
                line[q] += stiff * row[q]
    for p in range(len(fall)):
        for q in range(p + 1):
            bend[p, q] += fall[p] * fall[q] / observations
            bend[q, p] = bend[p, q]
