"""Points of the surface that a picture shows: facing it, not hidden, not outside."""

from __future__ import annotations

from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import NDArray

from abs_engine.core.arrays import FloatArray
from abs_engine.core.camera import Camera, Window
from abs_engine.core.errors import ParameterError, PictureError
from abs_engine.core.geometry import Pose
from abs_engine.core.scene import Candidates, Renderer, Scene
from abs_engine.face.appearance.patches import Patches
from abs_engine.face.settings.appearance import APPEARANCE


@dataclass(frozen=True, eq=False)
class Sighting:
    """A frame whose geometry is known, to learn appearance from.

    Parameters
    ----------
    image : (H, W, 3), RGB 0 to 255
    vertices : (V, 3) float, mm, head frame
    pose : Pose
        Head to camera.
    parameters : (P,) float64
        What the appearance is to depend on; sd.

    Raises
    ------
    PictureError
        If a pixel is not finite, or the picture is not (H, W, 3).
    """

    image: NDArray[np.generic]
    vertices: NDArray[np.floating]
    pose: Pose
    parameters: FloatArray

    def __post_init__(self) -> None:
        check_picture(self.image)


def check_picture(image: NDArray[np.generic]) -> None:
    """Raise `PictureError` unless the picture is (H, W, 3) and finite."""
    if image.ndim != 3 or image.shape[2] != 3:
        raise PictureError(f"a picture has shape {image.shape}", "give (H, W, 3) RGB")
    if not np.isfinite(image).all():
        bad = int((~np.isfinite(image)).any(axis=2).sum())
        raise PictureError(f"{bad} pixels of a picture are NaN or infinite", "decode it again")


def depth_of(
    sighting: Sighting, scene: Scene, camera: Camera, renderer: Renderer
) -> NDArray[np.float32]:
    """Depth (H, W), mm, of the sighted head at the picture's size; 0 where it is not.

    Raises `PictureError` if the picture has another size than the camera's, `ParameterError` if the
    sighting has another number of vertices than the scene.
    """
    if sighting.image.shape[1::-1] != camera.size:
        raise PictureError(
            f"a picture is {sighting.image.shape[1]}x{sighting.image.shape[0]}, the camera's "
            f"{camera.size[0]}x{camera.size[1]}",
            "give the pictures that the camera was calibrated for",
        )
    if sighting.vertices.shape != scene.mean.shape:
        raise ParameterError(
            f"a sighting has vertices of shape {sighting.vertices.shape}, the scene "
            f"{scene.mean.shape}",
            "give the shape of the same mesh for each picture",
        )
    none = np.zeros((0, *scene.mean.shape), np.float32)
    at = np.asarray(sighting.vertices, np.float32)
    still = replace(scene, mean=at, modes=none, texture_modes=None)
    one = Candidates.one(np.zeros(0), sighting.pose)
    return renderer.draw(still, one, camera, camera.whole)[0].depth


def in_sight(
    points: FloatArray,
    normals: FloatArray,
    depth: NDArray[np.float32],
    camera: Camera,
    window: Window,
    margin: bool = False,
) -> FloatArray:
    """Weight (N,) of how squarely points (N, 3) of the surface, mm, camera frame, are seen.

    The cosine between normal (N, 3), of any length, and line of sight; 0 for points that are turned
    away (below `APPEARANCE.facing`), hidden, or outside of the window. `depth` (H, W), mm, is that
    of a drawing of the whole scene in the window. With a `margin`, the pixels around must show the
    surface too, so that a colour interpolated there is mixed with nothing else.
    """
    height, width = depth.shape
    z = points[:, 2]
    safe = np.where(z > camera.near, z, camera.near)
    place = window.to_drawn(camera.project(np.column_stack([points[:, :2], safe])))
    column, row = np.rint(np.clip(place, -9, [width + 9, height + 9])).astype(int).T
    edge = 1 if margin else 0
    inside = (column >= edge) & (column < width - edge) & (row >= edge) & (row < height - edge)
    lengths = np.linalg.norm(points, axis=1) * np.linalg.norm(normals, axis=1)
    cosine = -np.einsum("nk,nk->n", points, normals) / np.maximum(lengths, 1e-12)
    steepness = np.sqrt(np.maximum(1 - cosine**2, 0)) / np.maximum(cosine, APPEARANCE.facing)
    pixel = z / (camera.matrix[0, 0] * window.scale)
    slack = APPEARANCE.nearer + (0.75 + edge) * pixel * steepness
    at = row.clip(0, height - 1), column.clip(0, width - 1)
    shown = inside & (z > camera.near) & (cosine > APPEARANCE.facing)
    if margin:  # where the head ends, a depth of 0 hides everything
        around = np.ones((3, 3), np.uint8)
        shown &= np.asarray(cv2.dilate(depth, around))[at] < z + slack
        shown &= np.asarray(cv2.erode(depth, around))[at] > z - slack
    else:
        shown &= (depth[at] == 0) | (depth[at] > z - slack)
    return np.asarray(np.where(shown, cosine, 0.0))


def sighted(
    sighting: Sighting,
    patches: Patches,
    scene: Scene,
    camera: Camera,
    window: Window,
    renderer: Renderer,
) -> tuple[FloatArray, FloatArray]:
    """Visibility (N,) of points, 0 where unseen, by the drawn pixels (K, 2) of their patches."""
    depth = depth_of(sighting, scene, camera, renderer)
    moved = sighting.pose.apply(np.asarray(sighting.vertices[patches.kept], np.float64))
    points, normals = patches.surface(moved)
    weights = in_sight(points, normals, depth, camera, camera.whole)
    return weights, window.to_drawn(camera.project(moved))
