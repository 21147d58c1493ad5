"""Mixtures of Gaussians by expectation maximisation, with a weight for every sample.

Sample weights are what the libraries' mixtures lack: here they carry how probable it is, by
place, that a pixel belongs to the class that is learned.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.arrays import Float32Array, FloatArray
from abs_engine.face.appearance import mixture_loops
from abs_engine.face.settings.colour import COLOURS

_Real = TypeVar("_Real", np.float32, np.float64)
_FLOOR = 1e-5  # variance floor: 8-bit chromaticity is not finer than this


@dataclass(frozen=True, eq=False)
class Mixture:
    """A Gaussian mixture of K components in D dimensions.

    Parameters
    ----------
    weights : (K,) float64, sum 1
    means : (K, D) float64
    covariances : (K, D, D) float64
    """

    weights: FloatArray
    means: FloatArray
    covariances: FloatArray

    def densities(self, samples: FloatArray) -> FloatArray:
        """Weighted density of each component, (N, K), at samples (N, D)."""
        return _components(np.asarray(samples, np.float64), self.means, *self._white).T

    @cached_property
    def _white(self) -> tuple[FloatArray, FloatArray]:
        """Roots (K, D, D) of half the inverse covariances, and densities (K,) at the means."""
        roots = np.linalg.cholesky(0.5 * np.linalg.inv(self.covariances), upper=True)
        volumes = np.sqrt(np.linalg.det(2 * np.pi * self.covariances))
        return np.ascontiguousarray(roots), self.weights / volumes

    def density(self, samples: FloatArray) -> FloatArray:
        """Probability density (N,) at samples (N, D)."""
        return np.asarray(self.densities(samples).sum(axis=1))

    @property
    def peak(self) -> float:
        """The highest density at a component's mean."""
        return float(self.density(self.means).max())

    @property
    def sound(self) -> bool:
        """Whether weights sum to 1 and covariances are symmetric and positive."""
        alike = np.allclose(self.covariances, self.covariances.transpose(0, 2, 1))
        positive = alike and (np.linalg.eigvalsh(self.covariances) > 0).all()
        return bool(abs(self.weights.sum() - 1) < 1e-6 and positive)

    def part(self, some: slice | NDArray[np.intp]) -> Mixture:
        """Some of the components, their weights brought to a sum of 1."""
        weights = self.weights[some]
        return Mixture(weights / weights.sum(), self.means[some], self.covariances[some])

    def as_one(self) -> Mixture:
        """One Gaussian with the mixture's mean and covariance."""
        mean = self.weights @ self.means
        away = self.means - mean
        within = np.tensordot(self.weights, self.covariances, 1)
        return Mixture(np.ones(1), mean[None], (within + (self.weights * away.T) @ away)[None])

    def anchored(
        self, samples: FloatArray, weight: FloatArray, anchor: Mixture, strength: float
    ) -> Mixture:
        """One maximum a-posteriori step: as `updated`, with `strength` samples like `anchor`.

        `anchor` has the same components; none of them can die out or wander far.
        """
        samples, weight = _counted(samples, weight)
        parts = self.densities(samples)
        share = weight[:, None] * parts / np.maximum(parts.sum(axis=1, keepdims=True), 1e-300)
        pseudo = strength * anchor.weights
        mass = share.sum(axis=0) + pseudo
        means = (share.T @ samples + pseudo[:, None] * anchor.means) / mass[:, None]
        pull = anchor.means - means
        drawn = anchor.covariances + pull[:, :, None] * pull[:, None]
        prior = pseudo[:, None, None] * drawn
        spread = (_scatters(samples, share, means) + prior) / mass[:, None, None]
        return Mixture(mass / mass.sum(), means, spread + _FLOOR * np.eye(means.shape[1]))

    def updated(self, samples: FloatArray, weight: FloatArray) -> Mixture:
        """One step of expectation maximisation on samples (N, D) with weights (N,)."""
        samples, weight = _counted(samples, weight)
        parts = self.densities(samples)
        share = weight[:, None] * parts / np.maximum(parts.sum(axis=1, keepdims=True), 1e-300)
        mass = share.sum(axis=0)
        alive = mass > COLOURS.least_component * mass.sum()
        share, mass = share[:, alive], mass[alive]
        means = share.T @ samples / mass[:, None]
        scatter = _scatters(samples, share, means) / mass[:, None, None]
        return Mixture(mass / mass.sum(), means, scatter + _FLOOR * np.eye(means.shape[1]))


@dataclass(frozen=True, eq=False)
class Mixtures:
    """Several mixtures over the same D dimensions, all evaluated at once, in single precision."""

    mixtures: tuple[Mixture, ...]

    def densities(self, samples: Float32Array) -> Float32Array:
        """Probability density of each mixture, (M, N), at samples (N, D)."""
        parts = _components(samples, *self._white)
        return np.stack([parts[some].sum(axis=0) for some in self._places])

    @cached_property
    def _places(self) -> list[slice]:
        """The components of each mixture among all."""
        ends = np.cumsum([len(one.weights) for one in self.mixtures]).tolist()
        return [slice(*pair) for pair in pairwise([0, *ends])]

    @cached_property
    def _white(self) -> tuple[Float32Array, Float32Array, Float32Array]:
        """Means (K, D), roots (K, D, D) and densities at the means (K,)."""
        each = [(one.means, *one._white) for one in self.mixtures]
        means, roots, scales = (
            np.concatenate(part).astype(np.float32) for part in zip(*each, strict=True)
        )
        return means, roots, scales


def _components(
    samples: NDArray[_Real], means: NDArray[_Real], roots: NDArray[_Real], scales: NDArray[_Real]
) -> NDArray[_Real]:
    """Weighted density of each component, (K, N), at samples (N, D); see `Mixture._white`."""
    turned = np.ascontiguousarray(samples.T)
    out, part = np.empty((len(means), len(samples)), turned.dtype), np.empty_like(turned[0])
    mixture_loops.exponents(turned, means, roots, part, out)
    np.exp(out, out=out)
    out *= scales[:, None]
    return out


def _counted(samples: FloatArray, weight: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Those of samples (N, D) that have a weight (N,), and their weights.

    Most have none where weights come from places.
    """
    some = np.flatnonzero(weight)
    return (samples, weight) if len(some) == len(weight) else (samples[some], weight[some])


def _scatters(samples: FloatArray, share: FloatArray, means: FloatArray) -> FloatArray:
    """Weighted sums (K, D, D) of the offsets of samples (N, D) from each mean, by shares (N, K)."""
    turned = np.ascontiguousarray(samples.T), np.ascontiguousarray(share.T)
    return np.asarray(mixture_loops.scatters(*turned, means))


def single(samples: FloatArray, weight: FloatArray) -> Mixture:
    """One Gaussian with the weighted mean and covariance of samples (N, D)."""
    mean = weight @ samples / weight.sum()
    spread = _scatters(samples, weight[:, None], mean[None]) / float(weight.sum())
    return Mixture(np.ones(1), mean[None], spread + _FLOOR * np.eye(len(mean)))


def fit_mixture(samples: FloatArray, weight: FloatArray, most: int) -> Mixture:
    """A mixture with as many components as the Bayesian information criterion asks for, of `most`.

    Samples are (N, D), their weights (N,) the probability, 0 to 1, that they belong to the class.

    Notes
    -----
    Neighbouring pixels are not independent; the criterion counts a share of the weight
    as samples, see `COLOURS.independent`.
    """
    samples, weight = _counted(samples, weight)
    mixture = single(samples, weight)
    best, best_score = mixture, _bic(mixture, samples, weight)
    for _ in range(1, most):
        mixture = _split(mixture)
        for _ in range(COLOURS.mixture_steps):
            mixture = mixture.updated(samples, weight)
        score = _bic(mixture, samples, weight)
        if score < best_score:
            best, best_score = mixture, score
    return best


def _split(mixture: Mixture) -> Mixture:
    """Split the component with the most spread along its longest axis."""
    longest = np.linalg.eigvalsh(mixture.covariances)[:, -1]
    k = int(np.argmax(mixture.weights * longest))
    values, vectors = np.linalg.eigh(mixture.covariances[k])
    step = np.sqrt(values[-1]) * vectors[:, -1]
    halves, means = mixture.weights.copy(), mixture.means.copy()
    halves[k] /= 2
    means[k] -= step
    return Mixture(
        np.append(halves, halves[k]),
        np.vstack([means, mixture.means[k] + step]),
        np.concatenate([mixture.covariances, mixture.covariances[k : k + 1]]),
    )


def _bic(mixture: Mixture, samples: FloatArray, weight: FloatArray) -> float:
    k, d = mixture.means.shape
    free = k - 1 + k * d + k * d * (d + 1) / 2
    count = COLOURS.independent * weight.sum()
    likelihood = COLOURS.independent * weight @ np.log(np.maximum(mixture.density(samples), 1e-300))
    return float(free * np.log(max(count, 2.0)) - 2 * likelihood)
