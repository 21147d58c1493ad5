"""Priors over parameters (Basu et al., eq. 10)."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from abs_engine.compare.settings import COMPARISON
from abs_engine.core.arrays import FloatArray
from abs_engine.core.errors import ParameterError
from abs_engine.face.penalty import ImprobablePenalty

_SMALL = 1e-4  # step of differences, standard deviations


class Prior(ABC):
    """Prior knowledge of the parameters: its negative logarithm, in nats."""

    bends_alike = False
    """Whether its curvature is the same everywhere."""

    @abstractmethod
    def negative_log(self, x: FloatArray) -> float:
        """The value at a parameter vector (N,)."""

    def negative_logs(self, vectors: FloatArray) -> FloatArray:
        """Values (B,) at parameter vectors (B, N)."""
        return np.array([self.negative_log(x) for x in vectors], np.float64)

    def slope(self, x: FloatArray) -> FloatArray:
        """Gradient (N,) at `x` (N,); a `ParameterError` if it is not known, as of all below."""
        raise self._without("has no slope")

    def curvature(self, x: FloatArray) -> FloatArray:
        """Second derivative (N, N) at `x` (N,), or what stands for it in a Newton step."""
        raise self._without("has no curvature")

    def bend(self, x: FloatArray) -> FloatArray:
        """The second derivative (N, N) at `x` (N,) itself, where a step takes another."""
        return self.curvature(x)

    def roots(self, vectors: FloatArray) -> FloatArray:
        """Terms (B, M) whose squares add up to the values at vectors (B, N)."""
        raise self._without("is not a sum of squares")

    def _without(self, what: str) -> ParameterError:
        return ParameterError(f"{type(self).__name__} {what}", "choose another driver")


@dataclass(frozen=True, eq=False)
class GaussianPrior(Prior):
    """-log of a Gaussian with a diagonal covariance, without its constant.

    Eq. 10 prints sum f_i^2 / lambda_i; the 1/2 of a Gaussian's exponent is put back.

    Parameters
    ----------
    mean : (N,) float64
    deviation : (N,) float64
        Standard deviations; infinite where nothing is known.
    """

    bends_alike = True

    mean: FloatArray
    deviation: FloatArray

    def negative_log(self, x: FloatArray) -> float:
        """0.5 sum ((x - mean) / deviation)^2."""
        scaled = (x - self.mean) / self.deviation
        return float(0.5 * scaled @ scaled)

    def slope(self, x: FloatArray) -> FloatArray:
        """Gradient (N,) of `negative_log` at `x` (N,)."""
        return np.asarray((x - self.mean) / self.deviation**2)

    def curvature(self, x: FloatArray) -> FloatArray:
        """The inverse of the covariance, (N, N)."""
        return self._information

    @cached_property
    def _information(self) -> FloatArray:
        return np.diag(self.deviation**-2.0)

    def roots(self, vectors: FloatArray) -> FloatArray:
        """Distances from the mean in standard deviations, times the root of a half."""
        return np.asarray(np.sqrt(0.5) * (vectors - self.mean) / self.deviation)


@dataclass(frozen=True, eq=False)
class InformationPrior(Prior):
    """-log of a Gaussian by its information matrix, without its constant.

    Parameters
    ----------
    mean : (N,) float64
    information : (N, N) float64
        Inverse of the covariance; it may say nothing of some directions.
    """

    bends_alike = True

    mean: FloatArray
    information: FloatArray

    def negative_log(self, x: FloatArray) -> float:
        """0.5 (x - mean)' information (x - mean)."""
        away = x - self.mean
        return float(0.5 * away @ self.information @ away)

    def slope(self, x: FloatArray) -> FloatArray:
        """Gradient (N,) of `negative_log` at `x` (N,)."""
        return np.asarray(self.information @ (x - self.mean))

    def curvature(self, x: FloatArray) -> FloatArray:
        """The information, (N, N)."""
        return self.information

    def roots(self, vectors: FloatArray) -> FloatArray:
        """Distances from the mean along the information's axes, times their roots."""
        size, axes = np.linalg.eigh(self.information)
        root = axes * np.sqrt(0.5 * np.maximum(size, 0.0))
        return np.asarray((vectors - self.mean) @ root)


@dataclass(frozen=True, eq=False)
class ContactPrior(Prior):
    """Lips may press, but hardly pass into each other.

    Parameters
    ----------
    gap : (G,) float64, mm
        Gaps between upper and lower lip with all parameters zero.
    slope_of_gaps : (G, N) float64, mm per unit of parameter
    softness : float
        Depth in mm that is as improbable as one standard deviation.
    """

    gap: FloatArray
    slope_of_gaps: FloatArray
    softness: float = COMPARISON.contact_softness

    def negative_log(self, x: FloatArray) -> float:
        """0.5 sum (depth / softness)^2 over the gaps that are negative."""
        depth = np.minimum(self.gap + self.slope_of_gaps @ x, 0.0) / self.softness
        return float(0.5 * depth @ depth)

    def slope(self, x: FloatArray) -> FloatArray:
        """Gradient (N,) of `negative_log` at `x` (N,)."""
        depth = np.minimum(self.gap + self.slope_of_gaps @ x, 0.0) / self.softness**2
        return np.asarray(depth @ self.slope_of_gaps)

    def curvature(self, x: FloatArray) -> FloatArray:
        """Of the gaps that are negative, or so small that a step may close them, (N, N)."""
        near = self.gap + self.slope_of_gaps @ x < COMPARISON.contact_ahead
        walls = self.slope_of_gaps[near] / self.softness
        return np.asarray(walls.T @ walls)

    def bend(self, x: FloatArray) -> FloatArray:
        """None, (N, N): a wall leaves its other side open, where lips that touch may part."""
        return np.zeros((len(x), len(x)))

    def roots(self, vectors: FloatArray) -> FloatArray:
        """Depths (B, G) of the gaps that are negative, times the root of a half."""
        depth = np.minimum(self.gap + vectors @ self.slope_of_gaps.T, 0.0) / self.softness
        return np.asarray(np.sqrt(0.5) * depth)


@dataclass(frozen=True, eq=False)
class PenaltyPrior(Prior):
    """A(a) beside an error (Odisio & Bailly, section 4).

    A = 1 costs `strength`, in units of the error; `place` is where the articulatory parameters
    stand in a parameter vector.
    """

    penalty: ImprobablePenalty
    strength: float
    place: slice

    def negative_log(self, x: FloatArray) -> float:
        """Strength times A of one parameter vector (N,)."""
        return float(self.negative_logs(x[None])[0])

    def negative_logs(self, vectors: FloatArray) -> FloatArray:
        """Strength times A of parameter vectors (B, N)."""
        return np.asarray(self.strength * self.penalty(self._own(vectors)))

    def slope(self, x: FloatArray) -> FloatArray:
        """Gradient (N,) at `x` (N,), by differences."""
        out, own = np.zeros(len(x)), np.arange(len(x))[self.place][: self.penalty.size]
        steps = _SMALL * np.eye(len(x))[own]
        out[own] = self.negative_logs(x + steps) - self.negative_logs(x - steps)
        return out / (2 * _SMALL)

    def curvature(self, x: FloatArray) -> FloatArray:
        """Gauss-Newton's, (N, N), by differences of `roots`."""
        steps = _SMALL * np.eye(len(x))
        slopes = (self.roots(x + steps) - self.roots(x - steps)) / (2 * _SMALL)
        return np.asarray(2 * slopes @ slopes.T)

    def roots(self, vectors: FloatArray) -> FloatArray:
        """Terms (B, P) whose squares add up to the values."""
        return np.asarray(np.sqrt(self.strength) * self.penalty.roots(self._own(vectors)))

    def _own(self, vectors: FloatArray) -> FloatArray:
        return vectors[:, self.place][:, : self.penalty.size]
