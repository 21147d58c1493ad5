"""A head without a texture, painted by regions, so that the landmark network sees a face.

A strip of colours is the texture, and each vertex has its place on the strip. Neighbours on it are
neighbours on the head, so that colours run into each other where regions meet, and no vertex has to
be split.
"""

from __future__ import annotations

from collections.abc import Mapping

import cv2
import numpy as np
from numpy.typing import NDArray

from abs_engine.core.arrays import FloatArray
from abs_engine.face.schema import CLASS_NAMES
from abs_engine.learn.heads.marks import Marks
from abs_engine.learn.heads.settings import HEAD_IMPORT

_STRIP = {
    "brow": (62, 44, 36), "skin": (205, 158, 132), "lips": (168, 96, 92), "inner": (58, 24, 22),
    "tongue": (150, 80, 78), "teeth": (222, 214, 196), "pupil": (12, 10, 10),
    "iris": (84, 64, 46), "white": (222, 216, 210),
}  # fmt: skip
"""Colours, sRGB, in the order in which they run into each other."""
_STRIP_SHARE = 0.125  # of a texture's width
_STEP = 16  # pixels of the strip for each colour
_OF_CLASS = {
    "skin": "skin", "upper_lip": "lips", "lower_lip": "lips", "inner_mouth": "inner",
    "tongue": "tongue", "upper_teeth": "teeth", "lower_teeth": "teeth", "eyes": "white",
}  # fmt: skip
_PUPIL, _IRIS = 0.2, 0.5  # of an eyeball's radius
_BROW_UP, _BROW_WIDE, _BROW_HIGH = 0.52, 0.75, 0.13
"""How high above an eye's middle a brow is, and half its width and height, in widths of the eye."""


def paint(
    vertices: FloatArray,
    faces: NDArray[np.integer],
    classes: NDArray[np.uint8],
    marks: Marks,
    blinks: FloatArray,
) -> tuple[NDArray[np.float32], NDArray[np.uint8]]:
    """Places (V, 2) of vertices (V, 3), mm, on a texture, and that, (H, W, 3) uint8 RGB.

    `blinks` (V,), mm, is how far eyes that close move each vertex.
    """
    order = list(_STRIP)
    at = np.full(len(vertices), order.index("skin"), np.float64)
    for name, colour in _OF_CLASS.items():
        at[faces[classes == CLASS_NAMES.index(name)]] = order.index(colour)
    skin = np.unique(faces[classes == CLASS_NAMES.index("skin")])
    at[skin] = order.index("skin")
    lips = np.isin(classes, [CLASS_NAMES.index(n) for n in ("upper_lip", "lower_lip")])
    at[np.setdiff1d(faces[lips], skin)] = order.index("lips")
    lids = blinks > HEAD_IMPORT.lid * max(float(blinks.max()), 1e-9)
    at[skin] -= ~lids[skin] * _brows(vertices[skin], vertices[marks.eye_corners])
    eyes = np.unique(faces[classes == CLASS_NAMES.index("eyes")])
    for side in (-1, 1):
        own = eyes[side * vertices[eyes, 0] > 0]
        if len(own):
            at[own] = order.index("pupil") + _from_pupil(vertices[own])
    row = _between(np.array(list(_STRIP.values()), np.float64), _STEP * len(order))
    texture = np.repeat(row[None], 4, axis=0)
    across = (at + 0.5) / len(order)
    return np.stack([across, np.full(len(at), 0.5)], axis=1).astype(np.float32), texture


def laid(
    uv: NDArray[np.float32],
    textures: Mapping[str, NDArray[np.uint8]],
    painted_uv: NDArray[np.float32],
    strip: NDArray[np.uint8],
) -> tuple[NDArray[np.float32], dict[str, NDArray[np.uint8]]]:
    """Textures of a mesh (V, 2) with the painted strip at their right, for what was added to it.

    `painted_uv` are places (V + N, 2) on the strip alone.
    """
    share = 1 / (1 + _STRIP_SHARE)
    out = painted_uv.copy()
    out[:, 0] = share + (1 - share) * painted_uv[:, 0]
    out[: len(uv)] = uv * [share, 1.0]
    beside = {}
    for name, texture in textures.items():
        height, width = texture.shape[:2]
        size = (max(1, round(width * _STRIP_SHARE)), height)
        beside[name] = np.hstack([texture, np.asarray(cv2.resize(strip, size), np.uint8)])
    return out, beside


def _between(colours: FloatArray, width: int) -> NDArray[np.uint8]:
    """A row (W, 3) of pixels that runs from colour to colour."""
    at = (np.arange(width) + 0.5) / width * len(colours) - 0.5
    row = [np.interp(at, np.arange(len(colours)), channel) for channel in colours.T]
    return np.asarray(np.rint(np.stack(row, axis=1)), np.uint8)


def _brows(skin: FloatArray, eyes: FloatArray) -> FloatArray:
    """Share (N,) of brow in each place of the skin, 0 to 1: arcs above the eyes."""
    out = np.zeros(len(skin))
    for outer, inner in ((eyes[0], eyes[1]), (eyes[3], eyes[2])):
        wide = float(np.linalg.norm(outer - inner))
        middle = 0.5 * (outer + inner) + [0.0, _BROW_UP * wide, 0.0]
        along = (skin[:, 0] - middle[0]) / (_BROW_WIDE * wide)
        up = (skin[:, 1] - middle[1]) / wide + 0.12 * along**2
        near = (np.abs(along) < 1) & (skin[:, 2] > outer[2] - 0.6 * wide)
        out = np.maximum(out, near * np.clip(2 - np.abs(up) / _BROW_HIGH, 0, 1))
    return out


def _from_pupil(eye: FloatArray) -> FloatArray:
    """Place (N,) of an eyeball's vertices on the strip, from its pupil: 0, 1 iris, 2 white."""
    front = eye[eye[:, 2] >= eye[:, 2].max() - 0.1 * np.ptp(eye[:, 2])]
    radius = 0.5 * float(np.ptp(eye[:, :2], axis=0).max())
    away = np.hypot(*(eye[:, :2] - front[:, :2].mean(axis=0)).T) / max(radius, 1e-9)
    away = np.where(eye[:, 2] >= np.median(eye[:, 2]), away, 1.0)
    return np.asarray(np.interp(away, [_PUPIL, _PUPIL + 0.08, _IRIS, _IRIS + 0.06], [0, 1, 1, 2]))
