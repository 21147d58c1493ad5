"""Evidence of shaded skin: the clip's own colours under its own light, point by point.

It says how far skin slides along itself, which the borders between colour classes cannot, and by
its shade how it is turned.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from abs_engine.compare.residual_rows import Rows
from abs_engine.core.arrays import BoolArray, FloatArray, Image
from abs_engine.core.camera import Camera
from abs_engine.core.geometry import Pose
from abs_engine.core.pose import PoseFrame
from abs_engine.core.scene import Candidates
from abs_engine.face import shading_loops
from abs_engine.face.appearance.harmonics import harmonics
from abs_engine.face.base import Face
from abs_engine.face.settings.appearance import SHADING
from abs_engine.face.shading import (
    LinearPicture,
    PatchAbout,
    SkinPatch,
    SkinShading,
    learn_shading,
    seen,
)
from abs_engine.fit.terms import TermKind
from abs_engine.fit.view import View

NAME = "shading"


@dataclass(frozen=True, eq=False)
class ShadedSkin:
    """Error of shaded skin in a frame, in nats.

    A point's error counts as little as Cauchy's distribution has it: highlights, hands and hair are
    no skin. Points near each other are wrong together, so that `SHADING.spot` of skin is one
    observation; `SHADING.fitted_spot` for a person whose head was fitted, as its errors reach
    farther.

    Parameters
    ----------
    near : PatchAbout
        The M points that are seen.
    seen : (N,) bool
        Mask of the points that turn to the camera, about.
    nats : float
        Weight of half a squared standard deviation of one channel of one point.
    forgiven : (3, M, L) float64
        Orthonormal errors of the points seen that do not count, in each channel.
    """

    looks: SkinShading
    near: PatchAbout
    camera: Camera
    picture: LinearPicture
    seen: BoolArray
    nats: float
    forgiven: FloatArray

    def negative_log(self, candidates: Candidates) -> FloatArray:
        """-log of the likelihood of each candidate, (B,), up to a constant."""
        return self.rows(candidates).value

    def rows(self, candidates: Candidates) -> Rows:
        """Residuals of a batch, row by row, that are squared and summed."""
        at, normals = self.near.placed(candidates)
        rows = self._roots(self._off(self.camera.project(at), normals))
        value = np.asarray((rows**2).sum(axis=1), np.float64)
        return Rows(rows, np.ones(rows.shape, np.bool_), value)

    def slopes(self, candidate: Candidates, pivot: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Residuals (K,) of one candidate, and how they change with its parameters (6 + P, K).

        Turns from the base pose are taken to be small; the lens's distortion is left out.
        """
        at, normals = self.near.placed(candidate)
        pixels, looks = self.camera.project(at), self.looks
        (turn,), (shift,) = candidate.rotations, candidate.translations
        lengths = np.linalg.norm(self.near.crossed(candidate.weights[0]), axis=0)
        along = shading_loops.deviation_slopes(
            self.picture.uphill(pixels[0]), at[0], normals[0], lengths,
            at[0] - (turn @ pivot + shift), turn, self.near.along, self.near.turning,
            self.camera.matrix[[0, 1], [0, 1]], looks.light, self._colour, looks.noise,
        )  # fmt: skip
        off = self._off(pixels, normals)
        rising = shading_loops.root_slopes(off[:, 0], SHADING.tail, self.nats)
        shares, forgiven = along.swapaxes(0, 1) @ self.forgiven, self.forgiven.mT.copy()
        shading_loops.as_root_slopes(along, shares, forgiven, rising)
        return self._roots(off)[0], along.reshape(len(along), 3 * len(lengths))

    def _off(self, pixels: FloatArray, normals: FloatArray) -> FloatArray:
        """Deviations (3, B, M) of points at pixels (B, M, 2) with normals (B, M, 3)."""
        looks, shown = self.looks, self.picture.at(pixels)
        off = shading_loops.deviations(shown, normals, looks.light, self._colour, looks.noise)
        off -= (off @ self.forgiven) @ self.forgiven.mT
        return np.asarray(off)

    def _roots(self, off: FloatArray) -> FloatArray:
        """Residuals (B, K) of deviations (3, B, M)."""
        return np.asarray(shading_loops.cauchy_roots(off, SHADING.tail, self.nats))

    @cached_property
    def _colour(self) -> FloatArray:
        return self.looks.colour[self.seen]


def shading_term(face: Face, view: View) -> ShadedSkin:
    """The error of shaded skin about a view's start."""
    looks: SkinShading = face.learned(NAME)
    start = view.frame.candidates(view.start[None])
    near = looks.patch.about(start.weights[0])
    (at,), (normals,) = near.placed(start)
    there = seen(view.camera, view.image, at, normals)
    pixels = view.camera.project(at)
    picture = LinearPicture.about(view.image, pixels[there])
    nats = looks.patch.area / _spot(face) / len(at) / 3
    shown = picture.at(pixels[None])[0]
    looks = _in_light_of_frame(looks, normals, shown, there)
    forgiven = _by_own_light(looks, normals, there)
    return ShadedSkin(looks, near.of(there), view.camera, picture, there, nats, forgiven)


def _spot(face: Face) -> float:
    """Area of skin, mm^2, that is one observation."""
    return SHADING.fitted_spot if len(face.identity) else SHADING.spot


def _in_light_of_frame(
    looks: SkinShading, normals: FloatArray, shown: FloatArray, there: BoolArray
) -> SkinShading:
    """Looks in a frame as bright, in each channel, as most of its points are (N, 3)."""
    expected = looks.shaded(normals[None, there], there)[0]
    if not len(expected):
        return looks
    share = np.median(shown[there] / np.maximum(expected, looks.noise), axis=0)
    return replace(looks, light=looks.light * np.clip(share, *SHADING.brightness))


def _by_own_light(looks: SkinShading, normals: FloatArray, there: BoolArray) -> FloatArray:
    """Errors that a frame's own light explains, orthonormal, (3, M, L): see `SHADING.own_light`."""
    basis = harmonics(normals[there])[:, : SHADING.own_light]
    return np.stack([np.linalg.qr(basis * looks.colour[there][:, [c]])[0] for c in range(3)])


def with_shading(
    face: Face, camera: Camera, frames: Iterable[tuple[Image, Pose, FloatArray]]
) -> Face | None:
    """The face with the shading that its skin has in some frames; None if they show too little.

    Each comes with about where the head is, and a correction of that and the posture (6 + P,).
    """
    posed = [
        (image, PoseFrame(pose, face.pivot).candidates(vector[None]))
        for image, pose, vector in frames
    ]
    learned = learn_shading(SkinPatch.of(face.body, _spot(face)), camera, posed)
    return None if learned is None else face.looking(**{NAME: learned})


SHADING_KIND = TermKind(
    NAME,
    shading_term,
    ("values", "residuals"),
    beside="colour",
    remedy="use --model head, or a speaker's own face",
)
