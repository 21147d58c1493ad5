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
from abs_engine.core.geometry import facet_areas
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
        Those of them that are compared; the others only give these a normal.
    area : float, mm^2
        Of all the skin that moves, at posture 0.
    """

    mean: FloatArray
    modes: FloatArray
    facets: NDArray[np.int32]
    compared: IntArray
    area: float

    @classmethod
    def of(cls, body: Body, spot: float) -> SkinPatch:
        """The skin of a face that moves by `SHADING.least_motion` or more.

        As many of its points are compared as `SHADING.together` for each `spot`, mm^2, of it. Lips
        shine and stretch: in real videos, and on drawn heads, they are better left out.
        """
        shown = np.array([name == "skin" for name in body.regions])
        facets = body.faces[shown[body.facet_class]]
        motion = np.sqrt((body.modes.astype(np.float64) ** 2).sum(axis=(0, 2)))
        moves = motion > SHADING.least_motion
        skin = facets[moves[facets].any(axis=1)]
        points = np.unique(skin[moves[skin]])
        area = float(facet_areas(body.mean.astype(np.float64), skin).sum())
        points = points[:: max(1, round(len(points) * spot / max(SHADING.together * area, spot)))]
        around = skin[np.isin(skin, points).any(axis=1)]
        used, place = np.unique(around, return_inverse=True)
        return cls(
            body.mean[used].astype(np.float64), body.modes[:, used].astype(np.float64, "C"),
            place.reshape(-1, 3).astype(np.int32), np.searchsorted(used, points),
            area,
        )  # fmt: skip

    def about(self, posture: FloatArray) -> PatchAbout:
        """The compared points about a posture (P,)."""
        moved = self.mean + np.tensordot(posture, self.modes, 1)
        across, turning = shading_loops.normals_and_slopes(
            moved, self.modes, self.facets, self.compared
        )
        along = np.ascontiguousarray(self.modes[:, self.compared].transpose(0, 2, 1))
        mean = np.ascontiguousarray(self.mean[self.compared].T)
        return PatchAbout(mean, along, posture, across, turning)


@dataclass(frozen=True, eq=False)
class PatchAbout:
    """The N compared points of a patch about a posture, from which their normals turn steadily.

    Parameters
    ----------
    mean : (3, N) float64, mm, head frame
        Posture 0.
    along : (P, 3, N) float64, mm
        Modes.
    posture : (P,) float64
    across : (3, N) float64, mm^2
        Normals in this posture, as long as twice the area of the facets around them.
    turning : (P, 3, N) float64, mm^2
        How they change with each mode.
    """

    mean: FloatArray
    along: FloatArray
    posture: FloatArray
    across: FloatArray
    turning: FloatArray

    def of(self, some: BoolArray) -> PatchAbout:
        """The same of some points (N,)."""
        where = np.flatnonzero(some)
        mean, along, across, turning = (
            np.take(part, where, axis=-1)
            for part in (self.mean, self.along, self.across, self.turning)
        )
        return PatchAbout(mean, along, self.posture, across, turning)

    def placed(self, candidates: Candidates) -> tuple[FloatArray, FloatArray]:
        """Places, mm, and normals of the points (B, N, 3), camera frame."""
        at, normals = shading_loops.turned(
            self.mean + _moved(candidates.weights, self.along),
            self.crossed(candidates.weights),
            candidates.rotations,
            candidates.translations,
        )
        return at, normals

    def crossed(self, weights: FloatArray) -> FloatArray:
        """Normals (..., 3, N), mm^2, head frame, in postures (..., P)."""
        return self.across + _moved(weights - self.posture, self.turning)


def _moved(weights: FloatArray, modes: FloatArray) -> FloatArray:
    """Motion (..., 3, N) by weights (..., P) of modes (P, 3, N); quicker than `np.tensordot`."""
    count, _, number = modes.shape
    moved = weights @ modes.reshape(count, 3 * number)
    return np.asarray(moved.reshape(*weights.shape[:-1], 3, number))


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

    def uphill(self, pixels: FloatArray) -> FloatArray:
        """Slopes of the light at pixels (N, 2), along x and y, (N, 3, 2) for a pixel."""
        return np.asarray(shading_loops.uphill(self.values, pixels - [self.left, self.top]))


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
        at, normals = patch.about(candidate.weights[0]).placed(candidate)
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
