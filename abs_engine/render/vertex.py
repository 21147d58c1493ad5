"""The thin vertex path: one matrix product on the CPU, then clip coordinates.

On a software rasteriser this beats deforming in the vertex shader, and the CPU rasteriser needs
it anyway. `core.geometry.Pose` and `core.camera.Camera` hold the same mathematics to read and to
test by.
"""
# mypy: disable-error-code="no-untyped-def, no-untyped-call, untyped-decorator"

from __future__ import annotations

import numba
import numpy as np
from numpy.typing import NDArray

from abs_engine.core.camera import Camera
from abs_engine.core.compiled import INNER, LOOP
from abs_engine.core.errors import ParameterError
from abs_engine.core.scene import Candidates, Scene

ClipArray = NDArray[np.float32]


def clip_positions(
    scene: Scene, candidates: Candidates, index: int, camera: Camera, clip: NDArray[np.float64]
) -> ClipArray:
    """Clip coordinates x, y, z, w (V, 4) float32, for OpenGL, of one candidate's vertices.

    w is z in the camera frame, mm; `clip` is `camera.clip_matrix(window)`. Every candidate is
    deformed by its own vector-matrix product, so that a batch gives the same bits as single calls
    (a matrix-matrix product would round differently). Plain loops beat BLAS at this size, whose
    threads cost more than they save. Raises as `check_weights`.
    """
    vertices = deform(scene.mean, scene.modes, weights_of(scene, candidates, index))
    out = np.empty((len(vertices), 4), np.float32)
    limit = camera.radius_limit if camera.distorted else 0.0
    to_clip(vertices, motion_of(candidates, index), camera.distortion, limit, clip, out)
    return out


def weights_of(scene: Scene, candidates: Candidates, index: int) -> NDArray[np.float64]:
    """The weights (P,) of one candidate; raises as `check_weights`."""
    check_weights(scene, candidates)
    return np.ascontiguousarray(candidates.weights[index])  # for loops compiled once


def check_weights(scene: Scene, candidates: Candidates) -> None:
    """Raise `ParameterError` unless candidates have as many weights as a scene has modes."""
    if candidates.weights.shape[1] != scene.n_modes:
        raise ParameterError(
            f"a candidate has {candidates.weights.shape[1]} weights, "
            f"the scene {scene.n_modes} modes",
            "build both from one shape model",
        )


def motion_of(candidates: Candidates, index: int) -> NDArray[np.float64]:
    """Rotation and translation (3, 4) of one candidate."""
    motion = np.empty((3, 4))
    motion[:, :3], motion[:, 3] = candidates.rotations[index], candidates.translations[index]
    return motion


@numba.njit(**LOOP)
def deform(mean, modes, weights):
    """X = mean + weights . modes, (V, 3) float32."""
    out = mean.copy()
    flat = out.reshape(-1)
    for k in range(modes.shape[0]):
        weight, mode = np.float32(weights[k]), modes[k].reshape(-1)
        if weight != 0:
            for i in range(flat.size):
                flat[i] += weight * mode[i]
    return out


@numba.njit(**LOOP)
def to_clip(vertices, motion, k, limit, clip, out):
    """Head frame to clip coordinates; `limit` 0 means no distortion (see `Camera.distort`)."""
    r00, r01, r02, t0 = motion[0]
    r10, r11, r12, t1 = motion[1]
    r20, r21, r22, t2 = motion[2]
    m00, m01, m02 = clip[0, 0], clip[0, 1], clip[0, 2]
    m11, m12, m22, m23 = clip[1, 1], clip[1, 2], clip[2, 2], clip[2, 3]
    for i in range(vertices.shape[0]):
        a, b, c = np.float64(vertices[i, 0]), np.float64(vertices[i, 1]), np.float64(vertices[i, 2])
        x = r00 * a + r01 * b + r02 * c + t0
        y = r10 * a + r11 * b + r12 * c + t1
        z = r20 * a + r21 * b + r22 * c + t2
        if limit > 0.0:
            x, y = _distort(x, y, z, k, limit)
        out[i, 0] = m00 * x + m01 * y + m02 * z
        out[i, 1] = m11 * y + m12 * z
        out[i, 2] = m22 * z + m23
        out[i, 3] = z


@numba.njit(**INNER)
def _distort(x, y, z, k, limit):
    """The scalar form of `Camera.distort`."""
    safe = z if abs(z) >= 1e-9 else 1e-9
    u, v = x / safe, y / safe
    rr = u * u + v * v
    dx = dy = 0.0
    if rr <= limit:
        dx = 2 * k[2] * u * v + k[3] * (rr + 2 * u * u)
        dy = k[2] * (rr + 2 * v * v) + 2 * k[3] * u * v
    rr = min(rr, limit)
    radial = (1 + rr * (k[0] + rr * (k[1] + rr * k[4]))) / (
        1 + rr * (k[5] + rr * (k[6] + rr * k[7]))
    )
    return (u * radial + dx) * z, (v * radial + dy) * z
