"""Means over frames, and how sure they are: confidence intervals by bootstrap."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from abs_engine.core.arrays import FloatArray
from abs_engine.core.errors import ParameterError

RESAMPLES, LEVEL = 1000, 0.95
BLOCK_SECONDS = 0.5
"""Blocks last at least so long; neighbouring frames of speech are alike for about a syllable."""


@dataclass(frozen=True, eq=False)
class Mean:
    """A mean over the frames of a clip, kept frame by frame so that it can be resampled.

    Its value is sum(part) / sum(weight). Shares such as precision are of this form too: a weight
    of 1 in each frame that was found, a part of 1 in those that are true.

    Parameters
    ----------
    part, weight : (T,) float64
        Both 0 in frames that do not count.
    root : bool
        Take the square root at the end, as for a root mean square.
    """

    part: FloatArray
    weight: FloatArray
    root: bool = False

    @classmethod
    def of(cls, values: ArrayLike, *, root: bool = False) -> Mean:
        """The mean of values (T,), leaving out those that are not finite."""
        given = np.asarray(values, np.float64)
        known = np.isfinite(given)
        return cls(np.where(known, given, 0.0), known.astype(np.float64), root)

    @classmethod
    def share(cls, part: ArrayLike, whole: ArrayLike) -> Mean:
        """The share of the frames `whole` (T,) bool that are also in `part` (T,) bool."""
        both = np.asarray(part, bool) & np.asarray(whole, bool)
        return cls(both.astype(np.float64), np.asarray(whole, np.float64))

    def __len__(self) -> int:
        """Return the number of frames, T."""
        return len(self.part)


def value(means: Sequence[Mean]) -> float:
    """The mean over one clip or several; every frame counts the same. NaN where none counts."""
    part = sum(float(m.part.sum()) for m in means)
    weight = sum(float(m.weight.sum()) for m in means)
    return float(_finish(np.array(part), np.array(weight), means[0].root))


def block_length(frames: int, rate: float) -> int:
    """Length of a block in frames.

    The cube root of the number of frames (the order of magnitude that Hall, Horowitz & Jing,
    Biometrika 82 (1995), find best for variances), but half a second at least; and a quarter of
    the clip at most.
    """
    wanted = max(round(float(frames) ** (1 / 3)), round(BLOCK_SECONDS * rate), 1)
    return int(max(1, min(wanted, frames // 4)))


def confidence(
    means: Sequence[Mean], rate: ArrayLike, *, seed: int = 0, resamples: int = RESAMPLES
) -> tuple[float, float]:
    """Both ends of a percentile confidence interval of `value`, at `LEVEL`; NaN where none counts.

    Blocks of consecutive frames are drawn with replacement, since neighbouring frames are not
    independent (the moving-block bootstrap: Kuensch, Annals of Statistics 17 (1989)). Of several
    clips, whole clips are drawn first and then blocks in each (Davison & Hinkley, Bootstrap
    Methods and their Application (1997), section 3.8).

    Parameters
    ----------
    means : sequence of Mean, one for each clip
    rate : float, or sequence of float, one for each clip
        Frames per second, for the length of the blocks.

    Raises
    ------
    ParameterError
        If the seed is below 0, or rates do not fit.
    """
    if seed < 0:
        raise ParameterError(f"the seed is {seed}", "give 0 or more")
    rates = np.asarray(rate, np.float64).ravel()
    if rates.size not in (1, len(means)):
        raise ParameterError(
            f"there are {rates.size} rates for {len(means)} clips", "give each one"
        )
    rates = np.broadcast_to(rates, len(means))
    rng = np.random.default_rng(seed)
    part, weight = np.zeros(resamples), np.zeros(resamples)
    for _ in means:
        drawn = rng.integers(len(means), size=resamples)
        for number in np.unique(drawn):
            chosen = np.flatnonzero(drawn == number)
            sums = _resampled(means[number], float(rates[number]), len(chosen), rng)
            part[chosen] += sums[0]
            weight[chosen] += sums[1]
    values = _finish(part, weight, means[0].root)
    values = values[np.isfinite(values)]
    if values.size == 0:
        return float("nan"), float("nan")
    tail = (1 - LEVEL) / 2
    low, high = np.quantile(values, [tail, 1 - tail])
    return float(low), float(high)


def _resampled(
    mean: Mean, rate: float, count: int, rng: np.random.Generator
) -> tuple[FloatArray, FloatArray]:
    """Sums of part and weight of `count` clips of T frames put together from blocks."""
    frames = len(mean)
    length = block_length(frames, rate)
    blocks = -(-frames // length)
    starts = rng.integers(frames - length + 1, size=(count, blocks))
    ends = starts + length
    ends[:, -1] -= blocks * length - frames  # the last block is cut, so that T frames are drawn
    part, weight = (np.concatenate([[0.0], np.cumsum(a)]) for a in (mean.part, mean.weight))
    return (part[ends] - part[starts]).sum(axis=1), (weight[ends] - weight[starts]).sum(axis=1)


def _finish(part: FloatArray, weight: FloatArray, root: bool) -> FloatArray:
    """Part / weight, or its square root; NaN where the weight is 0."""
    ratio = np.full(np.shape(part), np.nan)
    np.divide(part, weight, out=ratio, where=weight > 0)
    # differences of cumulated squares can fall below 0 by a rounding error
    return np.asarray(np.sqrt(np.maximum(ratio, 0.0)) if root else ratio)


def compared(
    estimated: ArrayLike, truth: ArrayLike, what: str, shape: tuple[int | None, ...], remedy: str
) -> tuple[FloatArray, FloatArray]:
    """Both as float64; `ParameterError` unless they are of one shape, `None` for any length."""
    found, true = np.asarray(estimated, np.float64), np.asarray(truth, np.float64)
    fits = len(shape) == found.ndim and all(
        wanted in (None, own) for wanted, own in zip(shape, found.shape, strict=True)
    )
    if found.shape != true.shape or not fits:
        raise ParameterError(
            f"{what} of shapes {found.shape} and {true.shape} cannot be compared", remedy
        )
    return found, true


def mean_of_given(values: FloatArray) -> FloatArray:
    """Mean (T,) over what is finite in (T, N); NaN where nothing is."""
    given = np.isfinite(values)
    count = given.sum(axis=1)
    total = np.where(given, values, 0.0).sum(axis=1)
    return np.where(count > 0, total / np.maximum(count, 1), np.nan)
