"""Looks of glTF materials: a picture or a colour, and how the picture lies on the mesh."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import cv2
import numpy as np
import pygltflib as gl
from numpy.typing import NDArray

from abs_engine.core.arrays import FloatArray
from abs_engine.core.errors import InputFileError
from abs_engine.io.morphs.gltf_arrays import GltfArrays
from abs_engine.io.pictures import decoded

_TILE = 512  # pixels a side of each material's share of the texture
_FLAT = 3  # numbers of a look of one colour
_MOVED, _GLOSSY = "KHR_texture_transform", "KHR_materials_pbrSpecularGlossiness"


@dataclass(frozen=True, eq=False)
class Look:
    """Appearance of a material.

    Parameters
    ----------
    picture : (H, W, 3) uint8 RGB or None
        One colour where the material has no picture, None without either.
    uses : int
        Which of the mesh's sets of texture coordinates.
    matrix : (2, 3) float64
        From these to the picture.
    """

    picture: NDArray[np.uint8] | None = None
    uses: int = 0
    matrix: FloatArray = field(default_factory=lambda: np.eye(2, 3))

    def places(self, uv: FloatArray) -> FloatArray:
        """Places (F, 3, 2) on the picture, 0 to 1, of facets by their corners' coordinates.

        Pictures repeat beyond their edges: each facet is moved to the picture as a whole, and
        ends at its edge where it crosses one.
        """
        at = uv @ self.matrix[:, :2].T + self.matrix[:, 2]
        outside = ((at < 0) | (at > 1)).any(axis=1, keepdims=True)
        return np.clip(np.where(outside, at - np.floor(at.mean(axis=1, keepdims=True)), at), 0, 1)


def look_of(arrays: GltfArrays, material: gl.Material | None) -> Look:
    """Look of a material.

    Raises
    ------
    InputFileError
        If its picture is no PNG or JPEG.
    """
    if material is None:
        return Look()
    surface = material.pbrMetallicRoughness
    glossy = (material.extensions or {}).get(_GLOSSY) or {}
    texture = None if surface is None else surface.baseColorTexture
    if texture is None and glossy.get("diffuseTexture"):
        texture = gl.TextureInfo.from_dict(glossy["diffuseTexture"])
    if texture is not None:
        return _pictured(arrays, texture)
    if surface is None and not glossy:
        return Look()
    factor = glossy.get("diffuseFactor") or (surface and surface.baseColorFactor) or (1, 1, 1)
    linear = np.array(factor, np.float64)[:3]
    return Look(np.asarray(255 * linear ** (1 / 2.2), np.uint8).reshape(1, 1, 3))


def _pictured(arrays: GltfArrays, texture: gl.TextureInfo) -> Look:
    document = arrays.file.document
    source, moved = document.textures[texture.index], (texture.extensions or {}).get(_MOVED) or {}
    if source.source is None:
        raise InputFileError(
            f"a picture of {arrays.path} is kept by {', '.join(source.extensions or ['nothing'])}",
            "export it with PNG or JPEG pictures",
        )
    turn, (across, down) = float(moved.get("rotation", 0.0)), moved.get("scale", (1.0, 1.0))
    turned = np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]])
    matrix = np.c_[turned * [across, down], moved.get("offset", (0.0, 0.0))]
    uses = moved.get("texCoord", texture.texCoord or 0)
    return Look(_image(arrays, document.images[source.source]), int(uses), matrix)


def _image(arrays: GltfArrays, image: gl.Image) -> NDArray[np.uint8]:
    """A picture, no larger than its share of the texture."""
    if image.bufferView is not None:
        raw = bytes(arrays.view(image.bufferView))
    else:
        raw = arrays.file.bytes_at(image.uri)
    found = decoded(raw)
    if found is None:
        raise ValueError("a texture is no picture, or too large")
    if max(found.shape) <= _TILE:
        return found
    return np.asarray(cv2.resize(found, (_TILE, _TILE), interpolation=cv2.INTER_AREA), np.uint8)


def side_by_side(looks: Sequence[Look]) -> NDArray[np.uint8] | None:
    """All materials' pictures in one, a tile for each; None if none has a picture."""
    pictures = [look.picture for look in looks]
    if all(picture is None or picture.size == _FLAT for picture in pictures):
        return None
    plain = np.full((1, 1, 3), 200, np.uint8)
    tiles: list[Any] = [
        cv2.resize(plain if p is None else p, (_TILE, _TILE), interpolation=cv2.INTER_AREA)
        for p in pictures
    ]
    return np.hstack(tiles)
