"""A(a): the exponential penalty of improbable parameters (Odisio & Bailly, section 4)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from abs_engine.errors import ParameterError

FloatArray = NDArray[np.float64]
_STEEPEST = 50.0  # beyond that many softnesses it goes on in a straight line: exp would overflow


@dataclass(frozen=True, eq=False)
class ExponentialPenalty:
    """Nothing inside of the corpus' range, and growing exponentially outside of it.

    A(a) = strength * sum_i (exp(e_i) - 1 - e_i), with e_i the distance of a_i from the interval
    [lower_i, upper_i] in units of `softness`, 0 inside. The paper says only that A is
    "exponentially-fashioned"; this is smooth (its slope has no step at the interval's ends).

    Parameters
    ----------
    lower, upper : (P,) float64, sd
        What the parameters of the corpus keep to.
    softness : float, sd
        How far outside exp(e) is e.
    strength : float
        In units of the error that it is added to; e = 1 costs 0.72 of it.

    Raises
    ------
    ParameterError
        If a bound is not finite, an interval is empty, or softness or strength is not positive.
    """

    lower: FloatArray
    upper: FloatArray
    softness: float = 0.5
    strength: float = 1.0

    def __post_init__(self) -> None:
        shapes = self.lower.shape == self.upper.shape and self.lower.ndim == 1
        if not shapes or not np.isfinite([self.lower, self.upper]).all():
            raise ParameterError("the penalty's bounds are not finite or differ in number", _CHECK)
        if not (self.lower <= self.upper).all() or not min(self.softness, self.strength) > 0:
            raise ParameterError("the penalty has an empty interval or is not positive", _CHECK)

    @classmethod
    def of_corpus(
        cls, parameters: FloatArray, softness: float = 0.5, strength: float = 1.0
    ) -> ExponentialPenalty:
        """With the range of the parameters (T, P) of a corpus."""
        rows = np.atleast_2d(np.asarray(parameters, np.float64))
        return cls(rows.min(axis=0), rows.max(axis=0), softness, strength)

    def __call__(self, parameters: FloatArray) -> FloatArray:
        """A (...,) of parameters (..., P)."""
        beyond = np.maximum(self.lower - parameters, parameters - self.upper)
        e = np.maximum(beyond, 0.0) / self.softness
        curved = np.minimum(e, _STEEPEST)
        grown = np.exp(curved)
        straight = (e - curved) * (grown - 1.0)
        return np.asarray(self.strength * (grown - 1.0 - curved + straight).sum(axis=-1))


_CHECK = "take them from the corpus"
