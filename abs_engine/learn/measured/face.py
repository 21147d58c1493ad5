"""A head that measured points move: face units, and a smooth field of what these leave."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import RBFInterpolator

from abs_engine.core.arrays import FloatArray
from abs_engine.face.articulated import FaceShape
from abs_engine.face.schema import Unit
from abs_engine.io.assets import Speaker
from abs_engine.learn.articulated import shape_of
from abs_engine.learn.articulatory import Build
from abs_engine.learn.measured.fit import REST, MeasuredHead, fit_head
from abs_engine.learn.measured.settings import MEASURED_FACE

_SOFT = ("skin", "upper_lip", "lower_lip", "inner_mouth")


@dataclass(frozen=True, eq=False)
class MeasuredFace:
    """A talking face's shape, made of measured points.

    `neutral` (V, 3), mm, head frame, is the person at rest; `smooth` is of what was added to
    identity and face units.
    """

    head: MeasuredHead
    shape: FaceShape
    neutral: NDArray[np.float32]
    smooth: Smoothness


def measured_face(speaker: Speaker, built: Build) -> MeasuredFace:
    """Make a face that can be drawn of a corpus and its articulatory model.

    It takes a speaker's mesh and face units. Errors are those of `fit.fit_head`.
    """
    head = fit_head(speaker, built)
    design = np.column_stack([np.ones(len(built.alpha)), built.alpha])
    solver = np.linalg.pinv(design)  # (1 + P, T): values in the visemes to the mean and slopes
    still = head.left.mean(axis=0)
    at_points = np.concatenate([still[None], np.tensordot(solver, head.left - still, 1)])
    added, smooth = _spread(head, built, at_points)
    units = np.tensordot(solver @ head.weights, speaker.units.astype(np.float64), 1)
    neutral = np.asarray(head.neutral + added[0], np.float32)
    mean = np.asarray(neutral + units[0] + added[1], np.float32)
    modes = np.asarray(units[1:] + added[2:], np.float32)
    nearest = head.places.weights.argmax(axis=1)
    vertices = head.places.corners[np.arange(len(nearest)), nearest].astype(np.int64)
    at_rest = built.alpha[built.corpus.visemes.index(REST)]
    texture = speaker.texture()
    shape = shape_of(speaker, built, mean, modes, head.frame, vertices, at_rest, texture)
    return MeasuredFace(head, shape, neutral, smooth)


def _spread(
    head: MeasuredHead, built: Build, at_points: FloatArray
) -> tuple[FloatArray, Smoothness]:
    """Fields (K, V, 3) over the head of values (K, N, 3) at the points, and how smooth they are."""
    speaker = head.speaker
    teeth = np.isin(built.model.names, built.model.groups.get("lower_teeth", ()))
    opened = head.neutral + MEASURED_FACE.unfolded * speaker.unit_matrix((Unit.JAW_OPEN,))[0]
    places = head.places.at(opened)[~teeth]
    values = at_points[:, ~teeth].transpose(1, 0, 2).reshape(len(places), -1)
    smooth = smoothness(places, values)
    out = np.zeros((len(at_points), *opened.shape))
    soft = speaker.vertices_of(*_SOFT)
    over = field(places, values, smooth.reach, smooth.noise, opened[soft])
    out[:, soft] = over.reshape(len(soft), len(at_points), 3).transpose(1, 0, 2)
    if teeth.any():  # they are moved as one
        out[:, speaker.vertices_of("lower_teeth")] = at_points[:, teeth].mean(axis=1)[:, None]
    return out, smooth


@dataclass(frozen=True)
class Smoothness:
    """Smoothness of a field.

    For `reach`, mm, and `noise` see `MEASURED_FACE.reaches` and `noises`; an infinite one leaves no
    field. `explained` is the share of the values at points that were left out which the others'
    field explains.
    """

    reach: float
    noise: float
    explained: float


def smoothness(places: FloatArray, values: FloatArray) -> Smoothness:
    """The smoothness with which points predict others best: cross-validation in tenths.

    Places are (N, 3), mm, values (N, K).
    """
    fold = np.arange(len(places)) % min(MEASURED_FACE.folds, len(places))
    whole = max(float((values**2).sum()), 1e-300)
    best = Smoothness(MEASURED_FACE.reaches[0], np.inf, 0.0)  # nothing at all explains nothing
    for reach in MEASURED_FACE.reaches:
        for noise in MEASURED_FACE.noises:
            lost = 0.0
            for kept in (fold != k for k in range(fold.max() + 1)):
                said = field(places[kept], values[kept], reach, noise, places[~kept])
                lost += float(((said - values[~kept]) ** 2).sum())
            if 1 - lost / whole > best.explained:
                best = Smoothness(reach, noise, 1 - lost / whole)
    return best


def field(
    places: FloatArray, values: FloatArray, reach: float, noise: float, wanted: FloatArray
) -> FloatArray:
    """Values (M, K) at wanted places (M, 3), mm, of values (N, K) at places (N, 3).

    Far from all places they are 0.
    """
    if not np.isfinite(noise):
        return np.zeros((len(wanted), values.shape[1]))
    made = RBFInterpolator(
        places, values, kernel="gaussian", epsilon=1 / (np.sqrt(2) * reach), degree=-1,
        smoothing=noise,
    )  # fmt: skip
    return np.asarray(made(wanted), np.float64)
