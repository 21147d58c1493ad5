"""The variances of modes in motion that was not seen: cross-validated over blocks of time.

A sample covariance says how far the frames went that it was made of. Its weak modes are the few
directions that were left after the strong ones had taken what they could, so that other motion of
the same face goes several times as far along them. Here each block of time is left out in turn,
modes are learned from the others, and the spectrum is flattened until the left-out frames are as
likely as they can be.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.arrays import FloatArray
from abs_engine.core.errors import ParameterError
from abs_engine.face.shape.modal import LearnedPhysics
from abs_engine.learn.settings import LEARNING
from abs_engine.learn.sources import Source, learn_sources

_ROUNDS, _SETTLED = 50, 1e-10
_STEP = 2.0  # largest change of a logarithm in a step


def held_out_variances(
    rest: FloatArray, sources: Sequence[Source], variances: FloatArray
) -> FloatArray:
    """Variances (P,), mm^2, of as many modes in frames that are not among those learned from.

    `rest` (N, 3), mm, are the points at rest. No variance is below that in the frames themselves,
    `variances`. Where the others are too few
    to learn so many modes from, or move in fewer ways, they are `variances` as they are.

    Notes
    -----
    Modes of one block's others differ from block to block, so what is compared is the k-th of each:
    s_k is the mean square along it of the frames left out, about the others' mean. A law
    v_k = A l_k^g of the learned variances l_k has two numbers for all modes; they make the
    left-out frames likeliest, under independent Gaussians (the sum over k of log v_k + s_k / v_k is
    convex in log A and g). That many numbers can be found from a few blocks, a variance for each
    mode could not.
    """
    learned, squares = _left_out(rest, sources, len(variances))
    if len(squares) == 0:
        return variances
    offset, power = _likeliest(np.log(learned), squares)
    return np.asarray(np.maximum(np.exp(offset) * variances**power, variances))


def _left_out(
    rest: FloatArray, sources: Sequence[Source], modes: int
) -> tuple[FloatArray, FloatArray]:
    """Learned variances and mean squares in the frames left out, (B, P) each, mm^2."""
    learned, squares = [], []
    blocks = [np.array_split(np.arange(len(s)), LEARNING.blocks) for s in sources]
    for left_out in zip(*blocks, strict=True):
        others = [s.without(b) for s, b in zip(sources, left_out, strict=True)]
        others = [s for s in others if len(s)]
        if sum(map(len, others)) < 2 * modes:
            return np.zeros((0, modes)), np.zeros((0, modes))
        try:
            physics = learn_sources(rest, others, modes)
        except ParameterError:  # the block had a movement that the others lack
            return np.zeros((0, modes)), np.zeros((0, modes))
        along = [_squares(physics, s, b) for s, b in zip(sources, left_out, strict=True) if len(b)]
        if along:
            learned.append(physics.variances)
            squares.append(np.mean(along, axis=0))
    return np.array(learned), np.array(squares)


def _squares(physics: LearnedPhysics, source: Source, frames: NDArray[np.intp]) -> FloatArray:
    """Mean squares (P,), mm^2, along the modes of some frames of a source, spread included."""
    along = physics.coefficients(physics.rest + source.displacements[frames])
    own = source.spread.reshape(-1, len(physics.matrix)) @ physics.matrix
    return np.asarray((along**2).mean(axis=0) + (own**2).sum(axis=0))


def _likeliest(learned: FloatArray, squares: FloatArray) -> FloatArray:
    """Log A and g of v = A l^g, by Newton's method, of (B, P) logarithms of l and squares."""
    columns = np.stack([np.ones(learned.size), learned.ravel()], axis=1)
    seen, law = squares.ravel(), np.array([0.0, 1.0])
    for _ in range(_ROUNDS):
        ratio = seen * np.exp(-columns @ law)
        slope = columns.T @ (1 - ratio)
        # 1 beside the ratio: half of the expected curvature keeps steps short far from the minimum
        curvature = (columns * np.maximum(ratio, 0.5)[:, None]).T @ columns
        step = np.linalg.solve(curvature, slope)
        step *= min(1.0, _STEP / np.abs(step).max(initial=1e-12))
        law = law - step
        if np.abs(step).max() < _SETTLED:
            break
    return law
