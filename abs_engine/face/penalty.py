"""A(a): an exponential penalty of improbable parameters (Odisio & Bailly, section 4).

The paper says only that A is "an exponentially-fashioned function that penalizes improbable
articulatory parameters". Improbable is read as far from the corpus' mean.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from abs_engine.core.arrays import FloatArray
from abs_engine.core.errors import ParameterError
from abs_engine.face.settings.shape import SHAPE

_STEEPEST = 50.0  # of m / s^2; beyond it, A stays what it is there: exp would overflow


@dataclass(frozen=True, eq=False)
class ImprobablePenalty:
    """Grows with the distance from the corpus' mean: a Gaussian's at first, then exponentially.

    A(a) = strength * s^2 * (exp(m / s^2) - 1), with m the squared Mahalanobis distance from the
    corpus' mean for each parameter (1 on average over the corpus) and s the `softness`. Where s
    is large it is the negative logarithm of the corpus' Gaussian. It decides what pictures hardly
    show, as how far the jaw is pushed forward is for a camera in front.

    Parameters
    ----------
    mean : (P,) float64, sd
    whitener : (P, P) float64
        Makes of a difference from the mean one of unit covariance.
    softness : float
        The distance, in standard deviations, beyond which it grows much faster than a Gaussian's.
    strength : float
        In units of the error that it is added to.

    Raises
    ------
    ParameterError
        If arrays are not finite or do not fit, or softness or strength is not positive.
    """

    mean: FloatArray
    whitener: FloatArray
    softness: float = SHAPE.penalty_softness
    strength: float = SHAPE.penalty_strength

    def __post_init__(self) -> None:
        if self.mean.ndim != 1 or self.whitener.shape != (self.size, self.size):
            raise ParameterError("the penalty's mean and whitener do not fit", _CHECK)
        if not (np.isfinite(self.mean).all() and np.isfinite(self.whitener).all()):
            raise ParameterError("the penalty's mean or whitener is not finite", _CHECK)
        if not min(self.softness, self.strength) > 0:
            raise ParameterError("the penalty is not positive", _CHECK)

    @classmethod
    def of_corpus(cls, parameters: FloatArray) -> ImprobablePenalty:
        """With mean and covariance of the parameters (T, P) of a corpus.

        The covariance is drawn towards the identity, see `SHAPE.penalty_shrunk`. Raises
        `ParameterError` if there are fewer than two postures.
        """
        rows = np.atleast_2d(np.asarray(parameters, np.float64))
        if len(rows) < _FEWEST:
            raise ParameterError("one posture has no spread", _CHECK)
        spread = np.atleast_2d(np.cov(rows.T))
        share = SHAPE.penalty_shrunk
        spread = (1 - share) * spread + share * np.eye(len(spread))
        return cls(rows.mean(axis=0), np.linalg.inv(np.linalg.cholesky(spread)))

    @property
    def size(self) -> int:
        """P, the number of parameters that it reads."""
        return len(self.mean)

    def __call__(self, parameters: FloatArray) -> FloatArray:
        """A (...,) of parameters (..., P)."""
        return np.asarray((self.roots(parameters) ** 2).sum(axis=-1))

    def roots(self, parameters: FloatArray) -> FloatArray:
        """Terms (..., P) whose squares add up to A."""
        off = (parameters - self.mean) @ self.whitener.T
        squared = self.softness**2
        m = np.maximum((off**2).mean(axis=-1), 1e-12)
        grown = squared * np.expm1(np.minimum(m / squared, _STEEPEST))
        factor = np.sqrt(self.strength * grown / (self.size * m))
        return np.asarray(off * factor[..., None])


_CHECK = "take them from the corpus"
_FEWEST = 2
