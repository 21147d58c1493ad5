"""Toy scenes with known parts: a textured, deforming ball. Also what `bench` measures on."""

from __future__ import annotations

import numpy as np
import trimesh
from numpy.typing import ArrayLike, NDArray

from abs_engine.core.buffers import Buffers
from abs_engine.core.camera import Camera, Window
from abs_engine.core.geometry import Pose
from abs_engine.core.scene import Candidates, Renderer, Scene

SMALL, LARGE = 3, 4
"""Subdivisions of the icosphere: 1,280 and 5,120 facets."""

RADIUS = 90.0
DISTANCE = 600.0


def ball(subdivisions: int = SMALL, n_modes: int = 8, seed: int = 0) -> Scene:
    """A ball of 90 mm with smooth modes (about 1 mm per unit), four classes and a texture."""
    sphere = trimesh.creation.icosphere(subdivisions=subdivisions, radius=RADIUS)
    x, y, z = np.asarray(sphere.vertices).T / RADIUS
    uv = np.stack([0.5 + 0.45 * x, 0.5 - 0.45 * y], axis=1)
    corners = np.asarray(sphere.triangles_center) / RADIUS
    classes = 1 + (corners[:, 0] > 0.2).astype(int) + 2 * (corners[:, 1] > -0.1)
    return Scene(
        mean=np.asarray(sphere.vertices),
        modes=smooth_modes(np.stack([x, y, z], axis=1), n_modes, seed),
        faces=np.asarray(sphere.faces),
        uv=uv,
        facet_class=classes,
        texture=noise_texture(96, 64, seed),
    )


def smooth_modes(unit: NDArray[np.float64], n_modes: int, seed: int) -> NDArray[np.float64]:
    """Low-frequency displacement fields (P, V, 3), about 1 mm."""
    rng = np.random.default_rng(seed)
    waves = rng.normal(0, 2.0, (n_modes, 3, 3))
    phase = rng.uniform(0, 2 * np.pi, (n_modes, 1, 3))
    return np.asarray(np.sin(unit @ waves + phase))


def noise_texture(width: int, height: int, seed: int = 0) -> NDArray[np.uint8]:
    """Coloured blobs, (H, W, 3) uint8, not symmetric in any direction."""
    rng = np.random.default_rng(seed)
    coarse = rng.uniform(30, 225, (8, 12, 3))
    rows = np.linspace(0, 7, height)[:, None]
    columns = np.linspace(0, 11, width)[None]
    top, left = np.floor(rows).astype(int), np.floor(columns).astype(int)
    down, right = np.minimum(top + 1, 7), np.minimum(left + 1, 11)
    fy, fx = (rows - top)[..., None], (columns - left)[..., None]
    upper = coarse[top, left] * (1 - fx) + coarse[top, right] * fx
    lower = coarse[down, left] * (1 - fx) + coarse[down, right] * fx
    return np.asarray(np.rint(upper * (1 - fy) + lower * fy), np.uint8)


def view(pixels: int = 64) -> tuple[Camera, Window]:
    """A camera and window of `pixels` squared that the ball nearly fills."""
    camera = Camera.ideal((pixels, pixels), focal=2.9 * pixels)
    return camera, camera.whole


def states(scene: Scene, count: int, seed: int = 1) -> Candidates:
    """`count` random states of a scene near the camera's axis."""
    rng = np.random.default_rng(seed)
    facing = Pose.facing(DISTANCE).rotation_vector
    return Candidates.from_vectors(
        rng.normal(0, 1, (count, scene.n_modes)),
        facing + rng.normal(0, 0.05, (count, 3)),
        np.array([0, 0, DISTANCE]) + rng.normal(0, 4.0, (count, 3)),
    )


STILL = Candidates.one(np.zeros(0), Pose(np.eye(3), np.zeros(3)))
"""No modes, and vertices that are camera coordinates already."""

FISHY = np.array([-0.25, 0.08, 0.004, -0.003, 0.01, 0.02, -0.01, 0.003])


def triangles(
    corners: ArrayLike,
    classes: ArrayLike | None = None,
    texture: ArrayLike | None = None,
    cull: bool = False,
) -> Scene:
    """A scene of separate triangles, corners (F, 3, 3) in the camera frame."""
    corners = np.asarray(corners, np.float64)
    count = len(corners)
    return Scene(
        mean=corners.reshape(-1, 3),
        modes=np.zeros((0, 3 * count, 3)),
        faces=np.arange(3 * count).reshape(count, 3),
        uv=np.tile([[0, 0], [1, 0], [0, 1]], (count, 1)),
        facet_class=np.arange(1, count + 1) if classes is None else classes,
        texture=np.full((2, 2, 3), 200) if texture is None else texture,
        cull=cull,
    )


def draw_one(
    renderer: Renderer, scene: Scene, camera: Camera, window: Window | None = None
) -> Buffers:
    """Draw a scene as it stands."""
    return renderer.draw(scene, STILL, camera, window or camera.whole)[0]
