"""Labels of a frame, worked out from the ids that were drawn and the geometry that was given.

Only ids and what covers the head come from the drawing. Depth, normals, albedo and optical flow
follow from the facet under each pixel's centre and the exact place of the centre in it.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from abs_engine.core.arrays import BoolArray, Float32Array, FloatArray
from abs_engine.core.camera import Camera
from abs_engine.io.assets import Speaker
from abs_engine.studio import surface
from abs_engine.studio.plane_cut import cut_off
from abs_engine.studio.seam import DEPTH, beside, lip_strips

CLEARANCE = 1.0
"""A landmark is hidden by what is nearer to the camera than it by more than this, mm.

Lips that are pressed together overlap by up to 0.8 mm, and the seam between them is seen.
"""

_NEARER = 1.001
"""Meshes are cut this many times as far away as the camera's `near`, beyond which `flat` sees."""


@dataclass(frozen=True, eq=False)
class Geometry:
    """The head in one frame, as one camera has it.

    Parameters
    ----------
    points : (V, 3) float64, mm, camera frame
        Where the vertices are.
    drawn : (V, 3) float64
        Where an ideal lens must have them to see them where the camera does.
    pixels : (V, 2) float64
        Where they appear.
    normals : (V, 3) float32, camera frame
    """

    points: FloatArray
    drawn: FloatArray
    pixels: FloatArray
    normals: Float32Array

    @classmethod
    def of(cls, camera: Camera, points: FloatArray, normals: Float32Array) -> Geometry:
        """From vertices and normals (V, 3) in the camera frame."""
        drawn = camera.distort(points)
        return cls(points, drawn, flat(camera, drawn), normals)


def flat(camera: Camera, drawn: FloatArray) -> FloatArray:
    """Ideal projection (..., 2) of points (..., 3); what is not in front of the lens, far away."""
    depth = drawn[..., 2:]
    seen = np.where(depth > camera.near, depth, np.nan)
    image = drawn @ camera.matrix.T
    return np.nan_to_num(image[..., :2] / seen, nan=-1e6)


class Surface:
    """Surface that is seen at each pixel of the head.

    Parameters
    ----------
    ids : (H, W) uint16, facet + 1
    faces : (F, 3) int32
    """

    def __init__(
        self, ids: NDArray[np.uint16], geometry: Geometry, faces: NDArray[np.int32], camera: Camera
    ) -> None:
        self.ids, self._faces, self._camera = ids, faces, camera
        self._geometry = geometry
        self._weights = np.zeros((*ids.shape, 3), np.float32)
        self.depth = np.zeros(ids.shape)
        inverse = np.linalg.inv(camera.matrix)
        surface.trace(ids, geometry.drawn, faces, inverse, self._weights, self.depth)

    def normals(self) -> Float32Array:
        """Unit normals (H, W, 3), camera frame, 0 where the head is not seen."""
        out = self._blend(self._geometry.normals)
        length = np.sqrt((out**2).sum(axis=2, keepdims=True))
        return np.asarray(out / np.maximum(length, 1e-12), np.float32)

    def albedo(self, skin: Skin) -> NDArray[np.uint8]:
        """Colour (H, W, 3) of the texture, without light, 0 where the head is not seen."""
        levels = np.concatenate([[0], skin.levels(self._geometry.pixels)]).astype(np.uint8)
        out = np.zeros((*self.ids.shape, 3), np.uint8)
        where = self._blend(skin.uv)
        surface.sample(self.ids, where, levels[self.ids], skin.texels, skin.starts, skin.sides, out)
        return out

    def flow(self, following: Geometry) -> tuple[Float32Array, BoolArray]:
        """Motion of the visible points to the next frame, and whether it is known.

        Returns
        -------
        flow : (H, W, 2) float32, pixels
        valid : (H, W) bool
        """
        place = flat(self._camera, self._blend(following.drawn).astype(np.float64))
        height, width = self.ids.shape
        here = np.stack(np.meshgrid(np.arange(width), np.arange(height)), axis=-1)
        valid = (self.ids > 0) & (place[..., 0] > -1e5)
        return np.where(valid[..., None], place - here, 0).astype(np.float32), valid

    def _blend(self, values: NDArray[np.floating]) -> FloatArray:
        """Values (V, C) of the vertices at each pixel, (H, W, C)."""
        out = np.empty((*self.ids.shape, values.shape[1]))
        surface.blend(self.ids, self._weights, self._faces, np.asarray(values, np.float64), out)
        return out


class Skin:
    """A square texture and its halvings, so that what is far away is not sampled too thinly.

    Parameters
    ----------
    texture : (S, S, 3) uint8
    """

    def __init__(self, speaker: Speaker, texture: NDArray[np.uint8]) -> None:
        self.uv, self._faces = speaker.uv, speaker.faces
        steps = [texture.astype(np.float32)]
        while len(steps[-1]) > 8 and len(steps) < 8:
            half = len(steps[-1]) // 2
            less = cv2.resize(steps[-1], (half, half), interpolation=cv2.INTER_AREA)
            steps.append(np.asarray(less, np.float32))
        self.sides = np.array([len(step) for step in steps], np.int64)
        self.starts = np.concatenate([[0], np.cumsum(self.sides**2)[:-1]]).astype(np.int64)
        self.texels = np.concatenate([step.reshape(-1, 3) for step in steps])
        self._texels_of_facet = _areas(speaker.uv.astype(np.float64) * len(texture), self._faces)

    def levels(self, pixels: FloatArray) -> NDArray[np.uint8]:
        """Mipmap level that each facet (F,) needs, for vertices at pixels (V, 2)."""
        share = self._texels_of_facet / np.maximum(_areas(pixels, self._faces), 1e-6)
        level = 0.5 * np.log2(np.maximum(share, 1.0))
        return np.clip(np.rint(level), 0, len(self.sides) - 1).astype(np.uint8)


def _areas(points: FloatArray, faces: NDArray[np.int32]) -> FloatArray:
    a, b, c = (points[faces[:, k]] for k in range(3))
    doubled = (b - a)[:, 0] * (c - a)[:, 1] - (c - a)[:, 0] * (b - a)[:, 1]
    return np.asarray(0.5 * np.abs(doubled), np.float64)


@dataclass(frozen=True, eq=False)
class Cover:
    """Object that may stand before the head: a mesh as an ideal lens must have it.

    Parameters
    ----------
    drawn : (N, 3) float64, mm, camera frame
    faces : (M, 3) int32
    """

    drawn: FloatArray
    faces: NDArray[np.int32]


def visible(
    vertex: NDArray[np.integer],
    geometry: Geometry,
    speaker: Speaker,
    camera: Camera,
    covers: tuple[Cover, ...] = (),
    *,
    mirrored: bool = False,
) -> BoolArray:
    """Mask (N,) of the vertices that are seen: in the picture, with nothing solid before them.

    The facets that meet in a vertex do not hide it; what turns its back hides nothing, as it is
    not drawn; props hide from both sides. Landmarks of the lips are also seen in a fold, where
    their own lip is seen within `seam.SLACK` of them.

    Parameters
    ----------
    vertex : (N,) int
    mirrored : bool
        Whether facets count the other way round.
    """

    def clear(points: NDArray[np.integer], clearance: float = CLEARANCE) -> BoolArray:
        near = _hidden(points, geometry, speaker, camera, covers, clearance, mirrored)
        return inside(geometry.pixels[points], camera) & ~near

    seen = clear(vertex) & (geometry.drawn[vertex, 2] > camera.near)
    strips = lip_strips(speaker)
    folded = [i for i in np.flatnonzero(~seen).tolist() if int(vertex[i]) in strips]
    if not folded:
        return np.asarray(seen)
    shallow = clear(vertex[folded], DEPTH)
    for i in np.asarray(folded)[shallow].tolist():
        mark = int(vertex[i])
        seen[i] = clear(beside(geometry.points, mark, strips[mark])).any()
    return np.asarray(seen)


def _hidden(
    vertex: NDArray[np.integer],
    geometry: Geometry,
    speaker: Speaker,
    camera: Camera,
    covers: tuple[Cover, ...],
    clearance: float,
    mirrored: bool,
) -> BoolArray:
    """Whether something is nearer than vertices (N,) on their rays, by more than `clearance`."""
    points = np.column_stack([geometry.pixels[vertex], geometry.drawn[vertex, 2]])
    faces = speaker.faces[:, ::-1] if mirrored else speaker.faces
    owner, weld = speaker.weld[vertex].astype(np.int64), speaker.weld
    drawn, pixels = geometry.drawn, geometry.pixels
    if drawn[:, 2].min() <= camera.near:
        drawn, faces = before_lens(camera, drawn, faces)
        weld = np.append(weld, np.full(len(drawn) - len(weld), -2, weld.dtype))
        pixels = flat(camera, drawn)
    hidden = surface.hidden(points, drawn, pixels, faces, weld, owner, clearance)
    for cover in covers:
        drawn, faces = before_lens(camera, cover.drawn, cover.faces)
        nobody, own = np.full(len(vertex), -1), np.arange(len(drawn), dtype=np.int32)
        place = flat(camera, drawn)
        for side in (faces, faces[:, ::-1]):
            hidden |= surface.hidden(points, drawn, place, side, own, nobody, clearance)
    return np.asarray(hidden)


def before_lens(
    camera: Camera, drawn: FloatArray, faces: NDArray[np.int32]
) -> tuple[FloatArray, NDArray[np.int32]]:
    """Vertices (N, 3) and facets of a mesh, cut off where the camera sees nothing yet.

    Facets keep the numbers of their vertices; those on the cut come after the mesh's own.
    """
    height = drawn[:, 2] - _NEARER * camera.near
    if height.min() >= 0:
        return drawn, faces
    part = cut_off(faces, height)
    return part.of(drawn), part.faces


def inside(pixels: FloatArray, camera: Camera) -> BoolArray:
    """Whether pixel coordinates (N, 2) lie in the picture, whose edges are half a pixel out."""
    return np.asarray(((pixels >= -0.5) & (pixels < np.array(camera.size) - 0.5)).all(axis=1))
