"""A prior about shapes that were seen."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from abs_engine.compare.prior import GaussianPrior, Prior
from abs_engine.core.arrays import FloatArray
from abs_engine.core.errors import ParameterError


@dataclass(frozen=True, eq=False)
class MixturePrior(Prior):
    """-log of a mixture of Gaussians about shapes that were seen, without its constant.

    One Gaussian (eq. 10) says of what is not seen, such as depth from the front, only what follows
    from all shapes together. Speech keeps to a few ways of moving the lips, of which many hold at
    once what one mean does not: rounded lips protrude, spread ones do not.

    Parameters
    ----------
    gaussian : GaussianPrior
        Whose mean and covariance the mixture has, if the shapes have mean 0 and variance 1.
    seen : (K, P) float64
        Shapes, in standard deviations of the last P parameters; the others stay Gaussian.
    width : float
        Of each Gaussian, in standard deviations, 0 to 1; with 1 it is `gaussian` itself.

    Notes
    -----
    The centres are drawn towards the mean by sqrt(1 - width^2), so that for shapes of mean 0 and
    variance 1 the variance about the centres and that of them add up to the variance of eq. 10
    (West 1993, smooth kernels with shrinkage). In general it is width^2 + (1 - width^2) times the
    shapes' own covariance: where these were observed, and are shrunk by what errors of observation
    make of them, it is a little below that of eq. 10.

    Raises
    ------
    ParameterError
        If the shapes are not (K, P) with something in them, hold what is not finite, or have more
        parameters than the Gaussian; if the width is not above 0 and at most 1.
    """

    bends_alike = True

    gaussian: GaussianPrior
    seen: FloatArray
    width: float

    def __post_init__(self) -> None:
        shape, most = np.shape(self.seen), len(self.gaussian.mean)
        if len(shape) != 2 or not shape[0] or not 1 <= shape[1] <= most:
            raise ParameterError(
                f"shapes that were seen have shape {shape}", f"give (K, P) with P up to {most}"
            )
        if not np.isfinite(self.seen).all():
            raise ParameterError("a shape that was seen is not finite", "leave it out")
        if not 0 < self.width <= 1:
            raise ParameterError(f"the mixture's width is {self.width}", "give 0 to 1, not 0")

    def negative_log(self, x: FloatArray) -> float:
        """-log of the mean density of the Gaussians at `x` (N,)."""
        scaled, away = self._scaled(x)
        exponent = -0.5 * (away**2).sum(axis=1) / self.width**2
        highest = exponent.max()
        held = highest + np.log(np.exp(exponent - highest).mean())
        first = len(x) - away.shape[1]
        return float(0.5 * scaled[:first] @ scaled[:first] - held)

    def slope(self, x: FloatArray) -> FloatArray:
        """Gradient (N,) of `negative_log` at `x` (N,)."""
        scaled, away = self._scaled(x)
        exponent = -0.5 * (away**2).sum(axis=1) / self.width**2
        weight = np.exp(exponent - exponent.max())
        pulled = weight @ away / weight.sum() / self.width**2
        first = len(x) - away.shape[1]
        return np.asarray(np.r_[scaled[:first], pulled] / self.gaussian.deviation)

    def curvature(self, x: FloatArray) -> FloatArray:
        """That of the Gaussian (N, N), which stands for the mixture's.

        At a centre that lies alone the mixture bends 1 / width^2 times as much, and between two it
        may bend the other way. So where many shapes were seen, intervals are wider than the mixture
        would make them, by 1 / width at most; between two they may be too narrow.
        """
        return self.gaussian.curvature(x)

    def roots(self, vectors: FloatArray) -> FloatArray:
        """Those of the Gaussian parameters, and one root (B, 1) of what the shapes cost."""
        first = vectors.shape[-1] - self.seen.shape[1]
        apart = self.gaussian.roots(vectors)[:, :first]
        rest = self.negative_logs(vectors) - (apart**2).sum(axis=1)
        return np.column_stack([apart, np.sqrt(np.maximum(rest, 0.0))])

    def _scaled(self, x: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Standard deviations (N,) from the mean, and the last ones (K, P) from each centre."""
        scaled = (x - self.gaussian.mean) / self.gaussian.deviation
        first = len(scaled) - self.seen.shape[1]
        return scaled, scaled[first:] - np.sqrt(1 - self.width**2) * self.seen
