"""The estimator of articulatory parameters: visemes checked, completed and analysed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.arrays import BoolArray, FloatArray
from abs_engine.core.errors import ParameterError, TooFewPointsError
from abs_engine.face.shape.articulatory_model import ArticulatoryModel, learned, refuse_complex
from abs_engine.face.shape.guided_components import guided, imputed
from abs_engine.face.shape.predictors import PAPER_PREDICTORS, Predictor

Missing = Literal["refuse", "drop", "impute"]


class GuidedPCA:
    """Estimates an `ArticulatoryModel`; the constructor stores, `fit` computes.

    Parameters
    ----------
    names : sequence of str, N
        Of the points.
    groups : mapping of str to sequence of str
        Names of points by group.
    predictors : sequence of Predictor
        In their order: each explains what those before leave.
    missing : {"refuse", "drop", "impute"}
        What to do with points that are NaN in some visemes. ``drop`` keeps them out of the model;
        ``impute`` fills them in from the model of the others, again and again until that settles.

    Attributes
    ----------
    model_ : ArticulatoryModel
    mean_, components_ : (N, 3) and (P, N, 3) float64, mm
        X0, and the columns of M_X.
    explained_variance_ratio_ : (P,) float64
        Shares of the variance of the fitted data; their sum is what all parameters explain.
    scores_ : (V, P) float64
        The predictors' values, of mean 0 and variance 1, uncorrelated. The direct inversion
        (`transform`) takes all points instead and comes close to them.
    left_out_ : tuple of str
        Points that were dropped.
    imputed_ : dict of str to int
        Points that were filled in, and in how many visemes.
    unsettled_ : float, mm
        By how much one of them still moved in the last round; 0 where it settled.
    n_features_in_ : int

    Notes
    -----
    The variance is that over the visemes, with V - 1 in the denominator.
    """

    def __init__(
        self,
        names: Sequence[str],
        groups: Mapping[str, Sequence[str]],
        predictors: Sequence[Predictor] = PAPER_PREDICTORS,
        missing: Missing = "refuse",
    ) -> None:
        self.names = names
        self.groups = groups
        self.predictors = predictors
        self.missing = missing

    def get_params(self, deep: bool = True) -> dict[str, Any]:
        """Arguments of the constructor, by name; `deep` is without effect."""
        return {k: getattr(self, k) for k in ("names", "groups", "predictors", "missing")}

    def set_params(self, **params: Any) -> GuidedPCA:
        """Change what the constructor was given.

        Raises
        ------
        ParameterError
            If there is no such parameter.
        """
        for name, value in params.items():
            if name not in self.get_params():
                raise ParameterError(
                    f"there is no parameter '{name}'",
                    f"choose one of {', '.join(self.get_params())}",
                )
            setattr(self, name, value)
        return self

    def fit(self, X: FloatArray, y: None = None) -> GuidedPCA:
        """Learn from visemes.

        Parameters
        ----------
        X : (V, N, 3) or (V, 3N) float64, mm
            NaN where a point is missing.
        y : None
            Of no account.

        Raises
        ------
        TooFewPointsError
            If points are missing and `missing` is ``refuse``, or one is missing everywhere; if a
            predictor has no points; if there are not more visemes than parameters.
        ParameterError
            If shapes or names do not fit, a value is infinite, two predictors have one name, or
            one asks for an unknown group, or finds nothing left to explain.
        """
        data, kept = self._prepared(X)
        names = tuple(name for name, keep in zip(self.names, kept, strict=True) if keep)
        groups = _within(self.groups, names)
        columns = [p.columns(names, groups) for p in self.predictors]
        gaps = ~np.isfinite(data)
        self.unsettled_ = 0.0
        if gaps.any():
            data, self.unsettled_ = imputed(data, self.predictors, columns)
        steps = guided(data, self.predictors, columns)
        self.left_out_ = tuple(n for n, keep in zip(self.names, kept, strict=True) if not keep)
        counts = gaps.reshape(len(gaps), -1, 3).any(axis=2).sum(axis=0)
        self.imputed_ = {n: int(c) for n, c in zip(names, counts, strict=True) if c}
        self.n_features_in_ = 3 * len(self.names)
        self._kept = kept
        self.scores_ = steps.scores
        self.model_ = ArticulatoryModel(
            names, tuple(self.predictors), steps.mean.reshape(-1, 3),
            steps.modes.reshape(-1, len(names), 3), steps.variance, groups,
        )  # fmt: skip
        return self

    @property
    def mean_(self) -> FloatArray:
        """X0, (N, 3), mm."""
        return self.model_.mean

    @property
    def components_(self) -> FloatArray:
        """Columns of M_X, (P, N, 3), mm for one standard deviation."""
        return self.model_.modes

    @property
    def explained_variance_ratio_(self) -> FloatArray:
        """Shares (P,) of the variance, 0 to 1."""
        return self.model_.variance

    def transform(self, X: FloatArray) -> FloatArray:
        """Parameters (V, P) of visemes, (V, N, 3) or (V, 3N), by the direct inversion.

        Raises
        ------
        ParameterError
            If shapes do not fit, or nothing was learned yet.
        TooFewPointsError
            If the points that are there do not determine the parameters.
        """
        points = _shaped(X, len(self.names))
        return learned(self).invert(points[:, self._kept])

    def fit_transform(self, X: FloatArray, y: None = None) -> FloatArray:
        """`fit`, then `transform` of the same."""
        return self.fit(X).transform(X)

    def inverse_transform(self, X: FloatArray) -> FloatArray:
        """Points (V, N, 3), mm, without those left out, of parameters (V, P)."""
        return learned(self).points(X)

    def get_feature_names_out(self, input_features: None = None) -> NDArray[np.object_]:
        """Names of the parameters."""
        return np.array([p.name for p in self.predictors], dtype=object)

    def _prepared(self, X: FloatArray) -> tuple[FloatArray, BoolArray]:
        """Data (V, 3K) of the points that are kept, and which (N,) they are."""
        points = _shaped(X, len(self.names))
        if np.isinf(points).any():
            raise ParameterError("a coordinate is infinite", "give NaN where a point is missing")
        if not self.predictors:
            raise ParameterError("there are no predictors", "give one at least")
        twice = [p.name for k, p in enumerate(self.predictors)
                 if p.name in [q.name for q in self.predictors[:k]]]  # fmt: skip
        if twice:
            raise ParameterError(f"two predictors are named '{twice[0]}'", "name each once")
        if len(points) <= len(self.predictors):
            raise TooFewPointsError(
                f"{len(points)} visemes for {len(self.predictors)} parameters",
                "record more visemes than parameters, or give fewer predictors",
            )
        gaps = np.asarray(~np.isfinite(points).all(axis=2), np.bool_)
        self._check_missing(gaps)
        dropped = gaps.any(axis=0) & (self.missing == "drop")
        kept = np.asarray(~dropped, np.bool_)
        points = np.where(gaps[..., None], np.nan, points)[:, kept]
        return points.reshape(len(points), -1), kept

    def _check_missing(self, gaps: BoolArray) -> None:
        if self.missing not in ("refuse", "drop", "impute"):
            raise ParameterError(f"missing is '{self.missing}'", "choose refuse, drop or impute")
        refused = np.asarray(
            gaps.any(axis=0) if self.missing == "refuse" else gaps.all(axis=0), np.bool_
        )
        if self.missing == "drop" or not refused.any():
            return
        bad = [n for n, wrong in zip(self.names, refused, strict=True) if wrong]
        few = ", ".join(bad[:5]) + (", ..." if len(bad) > 5 else "")
        if self.missing == "refuse":
            raise TooFewPointsError(
                f"{len(bad)} of {len(refused)} points are missing in some visemes: {few}",
                "keep them out with --missing drop, or fill them in with --missing impute",
            )
        raise TooFewPointsError(
            f"{len(bad)} points are missing in all visemes: {few}",
            "keep them out with --missing drop",
        )


def _shaped(X: FloatArray, count: int) -> FloatArray:
    """(V, N, 3) of either form."""
    refuse_complex(X)
    points = np.asarray(X, np.float64)
    if points.ndim == 2 and points.shape[1] == 3 * count:
        points = points.reshape(len(points), count, 3)
    if points.ndim != 3 or points.shape[1:] != (count, 3):
        raise ParameterError(
            f"visemes have shape {np.shape(X)}", f"give (V, {count}, 3), or (V, {3 * count})"
        )
    return points


def _within(
    groups: Mapping[str, Sequence[str]], names: tuple[str, ...]
) -> dict[str, tuple[str, ...]]:
    """The groups without points that are not among the names."""
    known = set(names)
    return {group: tuple(n for n in points if n in known) for group, points in groups.items()}
