"""How places on a drawn surface move in the picture with each parameter."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from abs_engine.compare.borders import Borders
from abs_engine.core.camera import Camera, Window
from abs_engine.core.pose import PoseFrame
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
    rotation, translation = candidate.rotations[0], candidate.translations[0]
    corners = scene.faces[borders.facet]
    vertices = scene.vertices(candidate.weights[0])
    at = np.einsum("kc,kcd->kd", borders.weights, vertices[corners])
    seen = at @ rotation.T + translation
    focal = window.scale * np.array([camera.matrix[0, 0], camera.matrix[1, 1]])
    across = borders.normal * focal / seen[:, 2:]
    away = -(across * seen[:, :2]).sum(axis=1) / seen[:, 2]
    pull = np.column_stack([across, away])
    arms = (at - frame.pivot) @ rotation.T
    modes = scene.modes[:, corners].astype(np.float64)
    moves = np.einsum("pkcd,kc,kd->kp", modes, borders.weights, pull @ rotation, optimize=True)
    return np.hstack([np.cross(arms, pull), pull, moves])
