"""A ball whose colours depend on its parameters, filmed by the CPU rasteriser, as sightings."""

from __future__ import annotations

import numpy as np
import shapes

from abs_engine.core.camera import Camera
from abs_engine.core.geometry import Pose
from abs_engine.core.scene import Candidates, Scene
from abs_engine.face.appearance.visibility import Sighting
from abs_engine.render.cpu import CpuRenderer

N_MODES = 3
PIXELS = 96


def varying_ball(n_modes: int = N_MODES) -> Scene:
    """A ball with a texture mode for each shape mode; no colour is ever clipped."""
    ball = shapes.ball(shapes.LARGE, n_modes)
    height, width, _ = ball.texture.shape
    blobs = [shapes.noise_texture(width, height, 10 + k).astype(float) for k in range(n_modes)]
    base = 90 + 0.3 * ball.texture.astype(float)
    layers = 0.12 * (np.stack(blobs) - 127)
    changed = {"texture": base.astype(np.uint8), "texture_modes": layers}
    return Scene(**{**vars(ball), **changed})


def pose(rng: np.random.Generator) -> Pose:
    """A head that moves about a little."""
    facing = Pose.facing(shapes.DISTANCE).rotation_vector
    shift = np.array([0, 0, shapes.DISTANCE]) + rng.normal(0, 2.0, 3)
    return Pose.from_vectors(facing + rng.normal(0, 0.05, 3), shift)


def sightings(
    scene: Scene, camera: Camera, count: int, seed: int = 0, noise: float = 1.0
) -> list[Sighting]:
    """Frames of the scene with random parameters, and noise as a camera's."""
    rng = np.random.default_rng(seed)
    out = []
    for _ in range(count):
        weights, where = rng.uniform(-1.5, 1.5, scene.n_modes), pose(rng)
        one = Candidates.one(weights, where)
        rgb = CpuRenderer().draw(scene, one, camera, camera.whole)[0].rgb
        image = np.clip(np.rint(rgb + rng.normal(0, noise, rgb.shape)), 0, 255).astype(np.uint8)
        out.append(Sighting(image, scene.vertices(weights), where, weights))
    return out
