"""Shaded skin: a clip's own colour of each point of the face, and the light that falls on it.

Skin is taken for matt: what a pixel shows is the colour of a point times the light that its normal
receives, which has nine numbers for each channel wherever the lamps are (see
`appearance.harmonics`). A point that slides is seen by its colour, one that turns by its shade.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from abs_engine.core.arrays import BoolArray, FloatArray, Image, IntArray
from abs_engine.core.camera import Camera
from abs_engine.core.scene import Candidates
from abs_engine.face import shading_loops
from abs_engine.face.appearance.harmonics import HARMONICS, harmonics
from abs_engine.face.base import Body
from abs_engine.face.settings.appearance import SHADING

_BYTES = np.arange(256) / 255.0
_LINEAR = np.where(
    _BYTES <= 0.04045, _BYTES / 12.92, ((_BYTES + 0.055) / 1.055) ** 2.4
).astype(np.float32)  # fmt: skip
"""Light of each value of an sRGB picture (IEC 61966-2-1)."""
_DARKEST = float(_LINEAR[1])


@dataclass(frozen=True, eq=False)
class SkinPatch:
    """Skin that moves with the mouth, as points that are compared and the facets around them.

    Parameters
    ----------
    mean : (S, 3) float64, mm, head frame
        Posture 0.
    modes : (P, S, 3) float64, mm
    facets : (G, 3) int32
        Into the S vertices.
    compared : (N,) int
        Those of them that are compared; the patch's edge only gives others a normal.
    """

    mean: FloatArray
    modes: FloatArray
    facets: NDArray[np.int32]
    compared: IntArray

    @classmethod
    def of(cls, body: Body) -> SkinPatch:
        """The skin of a face that moves by `SHADING.least_motion` or more.

        Lips shine and stretch: in real videos, and on drawn heads, they are better left out.
        """
        shown = np.array([name == "skin" for name in body.regions])
        facets = body.faces[shown[body.facet_class]]
        motion = np.sqrt((body.modes.astype(np.float64) ** 2).sum(axis=(0, 2)))
        moves = motion > SHADING.least_motion
        near = facets[moves[facets].any(axis=1)]
        used = np.unique(near)
        place = np.full(len(body.mean), -1)
        place[used] = np.arange(len(used))
        return cls(
            body.mean[used].astype(np.float64), body.modes[:, used].astype(np.float64),
            place[near].astype(np.int32), np.flatnonzero(moves[used]),
        )  # fmt: skip

    @property
    def area(self) -> float:
        """Area at posture 0, mm^2."""
        a, b, c = (self.mean[self.facets[:, k]] for k in range(3))
        return float(0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1).sum())

    def placed(self, candidates: Candidates) -> tuple[FloatArray, FloatArray]:
        """Places, mm, and normals of the compared points (B, N, 3), camera frame."""
        moved = candidates.weights @ self.modes.reshape(len(self.modes), -1)
        at, normals = shading_loops.places_and_normals(
            self.mean + moved.reshape(-1, *self.mean.shape), self.facets, self.compared,
            candidates.rotations, candidates.translations,
        )  # fmt: skip
        return at, normals


@dataclass(frozen=True, eq=False)
class SkinShading:
    """Colours of a patch's N points and the light on them, learned from a clip.

    Parameters
    ----------
    colour : (N, 3) float64
        Of each point, about 1.
    light : (9, 3) float64, linear
        Of each harmonic, camera frame, in each channel.
    noise : (3,) float64, linear
        Deviation of what the points show from what is expected.
    """

    patch: SkinPatch
    colour: FloatArray
    light: FloatArray
    noise: FloatArray

    def shaded(self, normals: FloatArray, seen: BoolArray) -> FloatArray:
        """Expected light of the M points `seen` (N,), (B, M, 3) linear, by normals (B, M, 3)."""
        return np.asarray((harmonics(normals) @ self.light) * self.colour[seen])


@dataclass(frozen=True, eq=False)
class LinearPicture:
    """A part of a frame in linear light, (h, w, 3), with its first pixel's place in the frame."""

    values: NDArray[np.float32]
    left: int
    top: int

    @classmethod
    def about(cls, image: Image, pixels: FloatArray) -> LinearPicture:
        """The part of a frame about some pixels (N, 2), its noise smoothed."""
        height, width = image.shape[:2]
        margin = SHADING.margin
        if not len(pixels):  # then nothing is compared
            pixels = np.zeros((1, 2))
        low = np.floor(pixels.min(axis=0)).astype(int) - margin
        high = np.ceil(pixels.max(axis=0)).astype(int) + margin + 1
        left, top = np.clip(low, 0, [width - 2, height - 2])
        right, bottom = np.clip(high, [left + 2, top + 2], [width, height])
        values = _LINEAR[image[top:bottom, left:right]]
        smooth = cv2.GaussianBlur(values, (0, 0), SHADING.smoothing)
        return cls(np.asarray(smooth, np.float32), int(left), int(top))

    def at(self, pixels: FloatArray) -> FloatArray:
        """Light at pixels (B, N, 2) of the frame, (B, N, 3)."""
        return np.asarray(shading_loops.sampled(self.values, pixels - [self.left, self.top]))


def seen(camera: Camera, image: Image, at: FloatArray, normals: FloatArray) -> BoolArray:
    """Mask of the points (N, 3), camera frame, that turn to the camera and lie in the picture.

    Whatever is in front of them.
    """
    away = -(at * normals).sum(axis=-1) / np.linalg.norm(at, axis=-1)
    pixels, size = camera.project(at), np.array(image.shape[1::-1])
    within = ((pixels > -0.5) & (pixels < size - 0.5)).all(axis=-1)
    return np.asarray((away > SHADING.facing) & (at[:, 2] > 0) & within)


def learn_shading(
    patch: SkinPatch, camera: Camera, frames: Sequence[tuple[Image, Candidates]]
) -> SkinShading | None:
    """Learn a clip's colours and light from frames whose pose and posture are known, about.

    A frame is an image (H, W, 3) uint8 RGB and a candidate. None where fewer points are seen than
    say anything.
    """
    if not frames or not len(patch.compared):
        return None
    each = list(_views(patch, camera, frames))
    there, shown, turned = (np.stack(part) for part in zip(*each, strict=True))
    if there.sum() < SHADING.fewest * HARMONICS:
        return None
    colour, light = np.ones((len(patch.compared), 3)), np.zeros((HARMONICS, 3))
    for k in range(3):
        one = shown[..., k]
        for _ in range(SHADING.rounds):
            light[:, k] = _light(turned[there], one[there], colour[:, k], there, light[:, k])
            colour[:, k] = _colour(turned @ light[:, k], one, there, colour[:, k])
    left = np.abs(shown - (turned @ light) * colour)[there]
    least = np.maximum(SHADING.least_noise * np.median(shown[there], axis=0), _DARKEST)
    return SkinShading(patch, colour, light, np.hypot(1.4826 * np.median(left, axis=0), least))


def _views(
    patch: SkinPatch, camera: Camera, frames: Sequence[tuple[Image, Candidates]]
) -> Iterator[tuple[BoolArray, FloatArray, FloatArray]]:
    """Of each frame, a mask of the points seen (N,), their light (N, 3), and their harmonics."""
    for image, candidate in frames:
        at, normals = patch.placed(candidate)
        pixels = camera.project(at)
        there = seen(camera, image, at[0], normals[0])
        shown = LinearPicture.about(image, pixels[0, there]).at(pixels)
        yield there, shown[0], harmonics(normals[0])


def _light(
    turned: FloatArray, shown: FloatArray, colour: FloatArray, there: BoolArray, last: FloatArray
) -> FloatArray:
    """The light (9,) in one channel by what is seen (M,), its harmonics (M, 9), and the colours.

    What lies far from the light found `last` counts less.
    """
    rows = turned * np.broadcast_to(colour, there.shape)[there][:, None]
    weight = np.ones(len(rows))
    if last.any():
        off = np.abs(rows @ last - shown)
        weight = 1 / (1 + (off / max(SHADING.wrong * float(np.median(off)), 1e-9)) ** 2)
    held = SHADING.least_light * len(rows) * np.eye(HARMONICS)
    heavy = rows * weight[:, None]
    return np.asarray(np.linalg.solve(heavy.T @ rows + held, heavy.T @ shown))


def _colour(lit: FloatArray, shown: FloatArray, there: BoolArray, before: FloatArray) -> FloatArray:
    """The points' colours (N,) in one channel, by what was seen in T frames (T, N).

    A point has, as of `SHADING.alike` frames, the colour of most.
    """
    held = SHADING.alike * float(np.median(lit[there] ** 2))
    own, sure = (lit * shown * there).sum(axis=0), (lit**2 * there).sum(axis=0)
    return np.asarray((own + held * np.median(before)) / np.maximum(sure + held, 1e-12))
