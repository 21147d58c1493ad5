"""From a corpus to an articulatory model, and how well it holds the corpus (section 2.2)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from abs_engine.capture.corpus import Corpus
from abs_engine.core.arrays import FloatArray
from abs_engine.core.errors import AbsEngineError, ParameterError, TooFewPointsError
from abs_engine.face.shape.articulatory import GuidedPCA, Missing
from abs_engine.face.shape.articulatory_model import ArticulatoryModel
from abs_engine.face.shape.linear import LinearShape
from abs_engine.face.shape.predictors import PAPER_PREDICTORS, Predictor
from abs_engine.learn.settings import LEARNING
from abs_engine.learn.spoken import SpokenCorpus

MOST_BUILT = LEARNING.most_built
"""Models that are built at most to measure visemes that were not learned."""


@dataclass(frozen=True, eq=False)
class Build:
    """A model and what it was built from.

    Parameters
    ----------
    corpus : Corpus
        Without the points that the model does not have.
    alpha : (V, P) float64
        Parameters of the visemes by the direct inversion, standard deviations.
    errors : (V, N) float64, mm
        Distance of each point from where the direct inversion puts it; NaN where it is missing.
    left_out : tuple of str
        Points that were dropped, as they were missing in some visemes.
    imputed : mapping of str to int
        Points that were filled in, and in how many visemes.
    unsettled : float, mm
        By how much one of them still moved in the last round; 0 where it settled.
    """

    model: ArticulatoryModel
    corpus: Corpus
    alpha: FloatArray
    errors: FloatArray
    left_out: tuple[str, ...]
    imputed: Mapping[str, int]
    unsettled: float = 0.0

    @property
    def viseme_errors(self) -> FloatArray:
        """Root mean square over the points, (V,), mm."""
        return rms(self.errors)


def build(
    corpus: Corpus, predictors: Sequence[Predictor] = PAPER_PREDICTORS, missing: Missing = "refuse"
) -> Build:
    """Build the model of a corpus and invert the corpus with it; for `missing` see `GuidedPCA`.

    Raises
    ------
    TooFewPointsError
        If points are missing and may not be, a predictor has none, or there are not more visemes
        than parameters.
    ParameterError
        If a predictor asks for an unknown group, or finds nothing left to explain, or no point
        moves.
    """
    estimator = GuidedPCA(corpus.names, corpus.groups, predictors, missing).fit(corpus.points)
    _check_moved(corpus)
    model = replace(estimator.model_, source=corpus.source)
    kept = np.isin(corpus.names, model.names)
    own = Corpus(
        corpus.points[:, kept], model.names, corpus.visemes, model.groups, corpus.frame,
        corpus.source,
    )  # fmt: skip
    alpha = np.array([_inverted(model, v, p) for v, p in zip(own.visemes, own.points, strict=True)])
    errors = np.linalg.norm(own.points - model.points(alpha), axis=2)
    filled = estimator.left_out_, estimator.imputed_, estimator.unsettled_
    return Build(model, own, alpha, errors, *filled)


def _check_moved(corpus: Corpus) -> None:
    """Refuse visemes that are one posture: a model of them would be one of errors."""
    points = corpus.points[:, np.isfinite(corpus.points).all(axis=2).any(axis=0)]
    away = np.linalg.norm(points - np.nanmean(points, axis=0), axis=2)
    most = float(np.sqrt(np.nanmean(away**2, axis=0)).max(initial=0.0))
    if most < LEARNING.least_articulated:
        raise ParameterError(
            f"no point moves by more than {most:.2f} mm over the visemes, where jaw and lips move "
            "by several",
            "check which frames the visemes are",
        )


def _inverted(model: ArticulatoryModel, viseme: str, points: FloatArray) -> FloatArray:
    """Parameters (P,) of a viseme (N, 3), which an error names."""
    try:
        return model.invert(points)
    except TooFewPointsError as error:
        raise TooFewPointsError(f"viseme '{viseme}': {error.problem}", "leave it out") from error


@dataclass(frozen=True, eq=False)
class LeftOut:
    """Errors of models on visemes that they were not built of.

    `errors` (V,), mm, of each viseme in the model of all others, RMS over the points; NaN where
    `skipped`: visemes without which no model can be built, or whose points do not determine the
    parameters, and why.
    """

    errors: FloatArray
    skipped: Mapping[str, AbsEngineError]


def leave_out_in_turn(
    corpus: Corpus, predictors: Sequence[Predictor] = PAPER_PREDICTORS, missing: Missing = "refuse"
) -> LeftOut:
    """Errors of each viseme in the model of all others; of more than `MOST_BUILT` several at once.

    Those that cannot be left out are told of, with the reason.
    """
    out = np.full(len(corpus), np.nan)
    skipped: dict[str, AbsEngineError] = {}
    rounds = min(len(corpus), MOST_BUILT)
    own = np.arange(len(corpus)) % rounds
    for k in range(rounds):
        model: ArticulatoryModel | None = None
        for viseme in np.flatnonzero(own == k):
            try:
                if model is None:
                    estimator = GuidedPCA(corpus.names, corpus.groups, predictors, missing)
                    model = estimator.fit(corpus.points[own != k]).model_
                kept = np.isin(corpus.names, model.names)
                out[viseme] = rms(model.errors(corpus.points[viseme, kept]))
            except (TooFewPointsError, ParameterError) as error:
                skipped[corpus.visemes[viseme]] = error
    return LeftOut(out, skipped)


def rms(distances: FloatArray) -> FloatArray:
    """Root mean square over the last axis, leaving out NaN."""
    return np.asarray(np.sqrt(np.nanmean(distances**2, axis=-1)), np.float64)


def dense_head(built: Build, spoken: SpokenCorpus) -> LinearShape:
    """The whole bundled head moved by the model's parameters, head frame; see `dense_units`.

    The model is built of the corpus, or of some of its visemes.
    """
    own = [spoken.corpus.visemes.index(v) for v in built.corpus.visemes]
    return dense_units(built.alpha, spoken.weights[own], spoken.neutral, spoken.speaker.units)


def dense_units(
    alpha: FloatArray, weights: FloatArray, neutral: NDArray[np.floating],
    units: NDArray[np.floating],
) -> LinearShape:  # fmt: skip
    """Full heads by regression of their face units' weights on the parameters of the same visemes.

    Raises `ParameterError` if the arrays do not fit together; `TooFewPointsError` if the visemes do
    not determine the modes. Mean (M, 3) and modes (P, M, 3) are in the head frame; generators are
    face-unit weights. Given are parameters (V, P), standard deviations; weights (V, U); a neutral
    head (M, 3), mm, head frame; and units (U, M, 3), mm at weight 1.
    """
    alpha, weights = np.asarray(alpha, np.float64), np.asarray(weights, np.float64)
    if len(alpha) != len(weights) or weights.shape[1:] != units.shape[:1]:
        raise ParameterError(
            f"parameters {alpha.shape}, weights {weights.shape} and units {units.shape} do not fit",
            "give (V, P), (V, U) and (U, M, 3)",
        )
    fitted = _solver(alpha) @ weights
    used = np.flatnonzero(weights.any(axis=0))
    deltas = units[used].astype(np.float64)
    mean = neutral + np.tensordot(fitted[0, used], deltas, 1)
    modes = np.asarray(np.tensordot(fitted[1:][:, used], deltas, 1), np.float64)
    heads = np.asarray(np.tensordot(weights[:, used], deltas, 1), np.float64)
    return LinearShape(
        mean.astype(np.float32), modes.astype(np.float32), fitted[1:], fitted[0],
        _shares(alpha, modes, heads),
    )  # fmt: skip


def _solver(alpha: FloatArray) -> FloatArray:
    """Matrix (1 + P, V) from values in the visemes to those at 0 and their slopes."""
    design = np.column_stack([np.ones(len(alpha)), alpha])
    if np.linalg.matrix_rank(design) < design.shape[1]:
        raise TooFewPointsError(
            f"{len(alpha)} visemes do not determine {alpha.shape[1]} modes", "give more visemes"
        )
    return np.asarray(np.linalg.pinv(design), np.float64)


def _shares(alpha: FloatArray, modes: FloatArray, heads: FloatArray) -> FloatArray:
    """Share (P,) of the heads' variance that each mode holds, as if the others were not."""
    centred = heads - heads.mean(axis=0)
    total = max(float((centred**2).sum()), 1e-300) / (len(heads) - 1)
    each = (modes.reshape(len(modes), -1) ** 2).sum(axis=1) * alpha.var(axis=0, ddof=1)
    return np.asarray(each / total, np.float64)
