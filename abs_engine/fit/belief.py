"""The posterior of a fit: what its curvature leaves open, and what no curvature knows of.

The inverse of the value's second derivative is the covariance of the parameters (Laplace's
approximation). It knows of the picture's noise and of the priors, and nothing of what all frames
share: another person's teeth, a model that cannot purse its lips. That part was measured on films
of unknown heads, and is added.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from statistics import NormalDist

import numpy as np

from abs_engine.core.arrays import FloatArray
from abs_engine.core.blocks import POSE, POSTURE
from abs_engine.core.pose import pose_moves
from abs_engine.face.base import RINGS, Face, lip_front, lip_gap
from abs_engine.fit.head_frame import COLOUR
from abs_engine.fit.problem import Problem
from abs_engine.fit.settings import BELIEF
from abs_engine.io.assets import CLOSED_APERTURE

_RIDGE = 1e-9  # of the largest curvature: some directions may say nothing


@dataclass(frozen=True)
class Unknown:
    """Uncertainty that is added to a fit's own.

    The standard deviation that its curvature tells is multiplied by `factor`; added to it in
    squares are, in the measure's unit, `least` and a `share` of the measure's size, at most `most`.
    """

    factor: float = 1.0
    least: float = 0.0
    share: float = 0.0
    most: float = math.inf

    def deviation(self, own: FloatArray, size: FloatArray | float = 0.0) -> FloatArray:
        """The standard deviation of a measure, of what its curvature tells and its size."""
        by_size = np.minimum(self.share * np.abs(size), self.most)
        return np.asarray(np.sqrt((self.factor * own) ** 2 + self.least**2 + by_size**2))


APERTURE, WIDTH = Unknown(*BELIEF.aperture), Unknown(*BELIEF.width)
BY_LANDMARKS = Unknown(*BELIEF.by_landmarks)
GREY_APERTURE, GREY_WIDTH = Unknown(*BELIEF.grey_aperture), Unknown(*BELIEF.grey_width)
PROTRUSION = Unknown(*BELIEF.protrusion)
POINTS = tuple(Unknown(*axis) for axis in BELIEF.points)
ROTATION = tuple(Unknown(least=least) for least in BELIEF.rotation)
TRANSLATION = tuple(Unknown(least=least) for least in BELIEF.translation)


@dataclass(frozen=True, eq=False)
class Belief:
    """Standard deviations of what was found in a frame.

    Parameters
    ----------
    aperture, width, protrusion : float, mm
    lips : (N, 3) float64, mm, head frame
    rotation : (3,) float64, radians, about the camera's axes
    translation : (3,) float64, mm
    gap : float, mm
        Between the inner lips' middles, as it was found; negative where they press.
    """

    aperture: float
    width: float
    protrusion: float
    lips: FloatArray
    rotation: FloatArray
    translation: FloatArray
    gap: float

    @property
    def closed(self) -> float:
        """Probability that the lips are closed."""
        return NormalDist(self.gap, max(self.aperture, 1e-9)).cdf(CLOSED_APERTURE)

    def seen_in(self, pixel: float) -> Belief:
        """Belief where a pixel covers so many mm at the mouth."""
        more = BELIEF.coarse * pixel**2
        return replace(
            self, aperture=math.hypot(self.aperture, more), width=math.hypot(self.width, more)
        )

    def against(self, disagreement: float) -> Belief:
        """Belief where another measure of the aperture is so many joint standard deviations off.

        NaN where there is none. Errors were found to grow with how far two measures lie apart. The
        factor is empirical: the two are not independent, since the fit weighs the landmarks, too.
        """
        factor = 1.0 if math.isnan(disagreement) else math.hypot(BELIEF.agreed, disagreement)
        return replace(self, aperture=self.aperture * factor)

    def resting_on_landmarks(self, share: float) -> Belief:
        """Belief where an aperture rests on landmarks rather than on colours.

        A share, 0 to 1, of the weight of colours is missing. How far the landmark network is off on
        a person is no noise of a frame, and no curvature knows of it; where colours do not follow
        the landmarks, one of the two is wrong.
        """
        more = share * BY_LANDMARKS.deviation(np.zeros(()), max(self.gap, 0.0)) ** 2
        return replace(self, aperture=math.sqrt(self.aperture**2 + float(more)))


def share_of_landmarks(face: Face, *, alone: bool) -> float:
    """Share of an aperture that rests on landmarks, from 0 to 1: what colours lack of their weight.

    All where nothing but landmarks, `alone`, was used. None of one by poor colours, whose
    deviations are wide as they are.
    """
    classes = face.appearance.get(COLOUR)
    if classes is not None and classes.poor:
        return 0.0
    return 1.0 if alone else 1.0 - float(classes.weight if classes is not None else 1.0)


def belief_of(problem: Problem, face: Face, x: FloatArray) -> Belief | None:
    """Uncertainty of a fit at `x` (6 + P,).

    None where the evidence has no curvature, or its value is not in nats.
    Lengths are those of the head as it is scaled: how large it is, is not in them.
    """
    curve = problem.information(problem.chosen(x))
    if curve is None or not curve.any():
        return None
    covariance = _covariance(problem, curve)
    own = problem.blocks.places
    posture, pose = covariance[own[POSTURE], own[POSTURE]], covariance[own[POSE], own[POSE]]
    modes = face.scene.exact_modes
    vertices = face.scene.vertices(problem.blocks.part(x, POSTURE))
    moves, height = modes[:, face.rings["points"]], float(lip_gap(vertices[face.rings["points"]]))
    right, left = (vertices[k] for k in face.rings["corners"])
    along = (left - right) / max(float(np.linalg.norm(left - right)), 1e-9)
    wide = (modes[:, face.rings["corners"][1]] - modes[:, face.rings["corners"][0]]) @ along
    lips = modes[:, np.concatenate([face.rings[name] for name in RINGS])]
    varied = (np.tensordot(posture, lips, 1) * lips).sum(axis=0)
    spread = np.sqrt(np.maximum(varied, 0.0))
    classes = face.appearance.get(COLOUR)
    poor = classes is not None and classes.poor
    high, broad = (GREY_APERTURE, GREY_WIDTH) if poor else (APERTURE, WIDTH)
    aperture = high.deviation(_along(lip_gap(moves), posture), max(height, 0.0))
    turn, shift = _of_pose(problem, x, pose)
    return Belief(
        aperture=float(aperture),
        width=float(broad.deviation(_along(wide, posture), float(np.linalg.norm(left - right)))),
        protrusion=float(PROTRUSION.deviation(_along(lip_front(moves), posture))),
        lips=_each(POINTS, spread),
        rotation=turn,
        translation=shift,
        gap=height,
    )


def _covariance(problem: Problem, curve: FloatArray) -> FloatArray:
    """Covariance (6 + P, 6 + P) of all parameters, 0 of those that are held."""
    held = curve + _RIDGE * float(np.diag(curve).max()) * np.eye(len(curve))
    size, axes = np.linalg.eigh(held)
    free = (axes / np.maximum(size, 1e-9 * size.max())) @ axes.T
    out = np.zeros((len(problem.blocks), len(problem.blocks)))
    places = problem.blocks.indices(problem.free)
    out[np.ix_(places, places)] = free
    return out


def _along(slope: FloatArray, covariance: FloatArray) -> FloatArray:
    """Standard deviation of a measure by its slope (P,)."""
    return np.asarray(np.sqrt(max(float(slope @ covariance @ slope), 0.0)))


def _of_pose(
    problem: Problem, x: FloatArray, covariance: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Standard deviations (3,) of rotation and translation, by the pose's covariance (6, 6)."""
    pose = problem.frame.pose(x)
    arm = -(pose.rotation @ problem.frame.pivot)
    moves = pose_moves(arm[None])[:, 0]  # of the head frame's origin, about the pivot
    shift = np.sqrt(np.maximum(np.einsum("pd,pq,qd->d", moves, covariance, moves), 0.0))
    turn = np.sqrt(np.maximum(np.diag(covariance)[:3], 0.0))
    return _each(ROTATION, turn), _each(TRANSLATION, shift)


def _each(added: tuple[Unknown, ...], own: FloatArray) -> FloatArray:
    """Standard deviations (..., K) of measures, each with what is added to it."""
    return np.stack([one.deviation(own[..., k]) for k, one in enumerate(added)], axis=-1)
