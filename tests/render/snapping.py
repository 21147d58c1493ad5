"""Allowance for drivers that round vertices, where OpenGL is compared with the CPU rasteriser.

OpenGL moves vertices to a grid of 2^-GL_SUBPIXEL_BITS pixel. llvmpipe interpolates from where
they were, NVIDIA's driver from where they are then: a value inside a facet is that of a place at
most half a step away in each direction. Where a surface is steep, that shows.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.buffers import Buffers
from abs_engine.core.camera import Camera, Window
from abs_engine.core.scene import Candidates, Scene
from abs_engine.render.context import GLContext
from abs_engine.render.cpu import CpuRenderer


@dataclass(frozen=True)
class Allowed:
    """Largest distance of values from the exact ones; infinite where the facet may be another."""

    rgb: NDArray[np.float32]
    depth: NDArray[np.float32]
    barycentrics: NDArray[np.float32]


def half_step(gl: GLContext) -> float:
    """The most by which values are moved, in drawn pixels in each direction; none by llvmpipe."""
    return 0.5 / 2 ** int(gl.ctx.info["GL_SUBPIXEL_BITS"]) if gl.hardware else 0.0


def allowed(
    gl: GLContext, scene: Scene, candidates: Candidates, camera: Camera, window: Window
) -> list[Allowed]:
    """Change of the CPU rasteriser's values when the picture moves by half a step."""
    oracle, step = CpuRenderer(), half_step(gl) / window.scale
    exact = oracle.draw(scene, candidates, camera, window)
    moved = [
        oracle.draw(scene, candidates, _moved(camera, step * np.array(way)), window)
        for way in itertools.product((-1, 1), repeat=2)
    ]
    return [_between(one, others) for one, *others in zip(exact, *moved, strict=True)]


def _moved(camera: Camera, by: NDArray[np.float64]) -> Camera:
    matrix = camera.matrix.copy()
    matrix[:2, 2] += by
    return Camera(matrix, camera.size, camera.distortion, camera.near, camera.far)


def _between(exact: Buffers, moved: list[Buffers]) -> Allowed:
    parts = {}
    for name in ("rgb", "depth", "barycentrics"):
        known = getattr(exact, name)
        most = np.zeros_like(known)
        for other in moved:
            same = other.facet_id == exact.facet_id
            away = np.abs(getattr(other, name) - known)
            away[~same] = np.inf
            most = np.maximum(most, away)
        parts[name] = most
    return Allowed(**parts)
