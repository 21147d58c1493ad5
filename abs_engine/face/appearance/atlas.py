"""The normalised-shape referential of textures (Odisio & Bailly, 3.1), and warping frames into it.

The paper warps to a given posture p0. Here the referential is the mesh's own texture atlas: it
depends on nothing but the mesh, each facet has a place of its own, and what is hidden in any one
posture (the inside of the lips, the teeth) is in it too.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import cv2
import numpy as np
from numpy.typing import NDArray

from abs_engine.core.arrays import BoolArray, FloatArray
from abs_engine.core.camera import Camera
from abs_engine.core.errors import MeshError
from abs_engine.core.geometry import Pose
from abs_engine.core.scene import Candidates, Renderer, Scene
from abs_engine.face.appearance.visibility import Sighting, depth_of, in_sight
from abs_engine.face.settings.appearance import APPEARANCE


@dataclass(frozen=True, eq=False)
class Atlas:
    """Place of each texel on the mesh.

    Parameters
    ----------
    facet_id : (H, W) int32
        Facet index + 1; 0 where the atlas is empty.
    barycentrics : (H, W, 3) float32
        Weights of the facet's vertices.
    faces : (F, 3) int32
    facet_class : (F,) int32
    """

    facet_id: NDArray[np.int32]
    barycentrics: NDArray[np.float32]
    faces: NDArray[np.int32]
    facet_class: NDArray[np.int32]

    @cached_property
    def texels(self) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
        """Rows and columns (K,) of the texels that lie on the mesh."""
        rows, columns = np.nonzero(self.facet_id)
        return rows, columns

    def surface(self, vertices: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Points and normals (K, 3) of the texels on a mesh with vertices (V, 3)."""
        facet = self.facet_id[self.texels] - 1
        corners = vertices[self.faces[facet]]
        points = np.einsum("kc,kcx->kx", self.barycentrics[self.texels], corners)
        a, b, c = (vertices[self.faces[:, k]] for k in range(3))
        return points, np.cross(b - a, c - a)[facet]

    def on(self, facets: BoolArray) -> Atlas:
        """The atlas of some facets (F,) of the mesh alone."""
        covered = (self.facet_id > 0) & facets[self.facet_id - 1]
        return replace(self, facet_id=np.where(covered, self.facet_id, 0).astype(np.int32))

    def picture(self, values: FloatArray, known: BoolArray) -> NDArray[np.float32]:
        """Values of texels (K, C) as an image (H, W, C), where some (K,), one at least, are known.

        Texels that are not known get the value of the nearest known one of their facet's class, or
        of any class if none of theirs is known; so do those that lie on no facet.
        """
        out = np.zeros((*self.facet_id.shape, values.shape[1]), np.float32)
        out[self.texels] = values
        filled = self._sources(known)
        return np.asarray(out.reshape(-1, values.shape[1])[filled])

    def _sources(self, known: BoolArray) -> NDArray[np.intp]:
        """Flat index (H, W) of the texel whose value each texel shows."""
        on = self.facet_id > 0
        shown = np.zeros(on.shape, bool)
        shown[self.texels] = known
        kinds = np.where(on, self.facet_class[self.facet_id - 1], 0)
        source = _nearest(shown)
        for kind in np.unique(kinds[shown]):
            of = kinds == kind
            source[of] = _nearest(shown & of)[of]
        return np.where(on, source, source.ravel()[_nearest(on)])


def _nearest(mask: BoolArray) -> NDArray[np.intp]:
    """Flat index of the nearest true pixel to each pixel."""
    kind = cv2.DIST_LABEL_PIXEL
    empty = (~mask).astype(np.uint8)
    _, label = cv2.distanceTransformWithLabels(empty, cv2.DIST_L2, 5, labelType=kind)
    index = np.zeros(label.max() + 1, np.intp)
    index[label[mask]] = np.flatnonzero(mask)
    return np.asarray(index[label])


def lay_atlas(scene: Scene, size: tuple[int, int], renderer: Renderer) -> Atlas:
    """Draw the mesh into its own texture coordinates, as many texels wide and high as `size` says.

    Raises `MeshError` if no texel lies on the mesh.
    """
    flat = np.column_stack([scene.uv * size - 0.5, np.full(len(scene.uv), _AWAY)])
    one = Scene(
        flat.astype(np.float32),
        np.zeros((0, *flat.shape), np.float32),
        scene.faces,
        scene.uv,
        scene.facet_class,
        scene.texture,
        cull=False,
    )
    camera = Camera(np.diag([_AWAY, _AWAY, 1.0]), size)  # pixel = x, y
    still = Candidates.one(np.zeros(0), Pose(np.eye(3), np.zeros(3)))
    drawn = renderer.draw(one, still, camera, camera.whole)[0]
    if not drawn.covered.any():
        raise MeshError(
            f"no texel of {size[0]}x{size[1]} lies on the mesh", "check its texture coordinates"
        )
    return Atlas(drawn.facet_id, drawn.barycentrics, scene.faces, scene.facet_class)


_AWAY = 500.0


def fitting_size(scene: Scene, camera: Camera, pose: Pose) -> tuple[int, int]:
    """Size of a square atlas whose texels are about as large as the camera's pixels.

    The pose, head to camera, is of a usual frame.
    """
    flat = camera.project(pose.apply(scene.mean.astype(np.float64)))
    inside = scene.faces[_areas(flat, scene.faces) < 0]
    if len(inside) == 0:
        raise MeshError("no facet of the mesh faces the camera", "check the pose")
    pixels = np.abs(_areas(flat, inside))
    texels = np.abs(_areas(scene.uv.astype(np.float64), inside))
    drawn = texels > 0
    side = np.median(np.sqrt(pixels[drawn] / texels[drawn]))
    rounded = int(np.clip(16 * np.ceil(side / 16), *APPEARANCE.texture_sizes))
    return rounded, rounded


def _areas(flat: FloatArray, faces: NDArray[np.int32]) -> FloatArray:
    """Signed areas of facets in the plane; negative where they face a viewer (y down)."""
    a, b, c = (flat[faces[:, k]] for k in range(3))
    first, second = b - a, c - a
    return np.asarray(0.5 * (first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0]))


def warp(
    sighting: Sighting, atlas: Atlas, scene: Scene, camera: Camera, renderer: Renderer
) -> tuple[FloatArray, FloatArray]:
    """Colours of the texels in a frame, and how squarely it shows them, as `Atlas.texels` has them.

    (K, 3) float64, RGB 0 to 255, and (K,) float64, 0 where the texel is not seen. The scene's faces
    and classes are those of the sighting; the renderer decides what is hidden.
    """
    depth = depth_of(sighting, scene, camera, renderer)
    points, normals = atlas.surface(sighting.pose.apply(np.asarray(sighting.vertices, np.float64)))
    weights = in_sight(points, normals, depth, camera, camera.whole, margin=True)
    place = camera.project(points).astype(np.float32)
    image = np.asarray(sighting.image, np.float32)
    colours = sampled(image, np.where(weights[:, None] > 0, place, 0))
    return colours, weights


def sampled(image: NDArray[np.float32], place: NDArray[np.floating]) -> FloatArray:
    """Colours (K, C) of an image at pixel places (K, 2), bilinear, its border repeated."""
    x, y = (np.ascontiguousarray(axis, np.float32) for axis in np.asarray(place).T)
    rows = 32_000  # cv2.remap's images have fewer rows and columns than 2^15
    out = [
        cv2.remap(image, x[i : i + rows, None], y[i : i + rows, None], cv2.INTER_LINEAR,
                  borderMode=cv2.BORDER_REPLICATE)[:, 0]
        for i in range(0, len(x), rows)
    ]  # fmt: skip
    return np.concatenate(out).astype(np.float64)
