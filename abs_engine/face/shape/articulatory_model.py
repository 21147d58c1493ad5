"""A face that articulatory parameters move: X = X0 + M alpha, and its direct inversion.

Odisio and Bailly (2003), section 2.2.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from abs_engine.core.arrays import FloatArray
from abs_engine.core.errors import ModelFormatError, ParameterError, TooFewPointsError
from abs_engine.core.kinds import to_path
from abs_engine.face.settings.shape import SHAPE
from abs_engine.face.shape.predictors import Predictor
from abs_engine.io.arrays import Layout, real, text
from abs_engine.io.inputs import parse_json
from abs_engine.io.npz import read_npz, write_npz

FORMAT, VERSION = "abs_engine.articulatory_model", 1
_LAYOUT: Layout = {
    "names": text("N"),
    "mean": real("N", 3),
    "modes": real("P", "N", 3),
    "variance": real("P"),
    "told": text(),
    "source": text(),
}


@dataclass(frozen=True, eq=False)
class ArticulatoryModel:
    """Named points as a linear function of parameters of unit variance.

    Parameters
    ----------
    names : tuple of str, N
        Of the points.
    predictors : tuple of Predictor, P
        What the parameters were made of, in their order.
    mean : (N, 3) float64, mm, the frame of the corpus
        X0, the mean of the visemes.
    modes : (P, N, 3) float64, mm for one standard deviation
        The columns of M_X; they are not orthogonal.
    variance : (P,) float64
        Share of the corpus's variance that each parameter explains, 0 to 1.
    groups : mapping of str to tuple of str
        Names of points by group.
    source : str
        What was learned from.

    Raises
    ------
    ModelFormatError
        If the arrays do not fit together.
    """

    names: tuple[str, ...]
    predictors: tuple[Predictor, ...]
    mean: FloatArray
    modes: FloatArray
    variance: FloatArray
    groups: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    source: str = ""

    def __post_init__(self) -> None:
        points, count = len(self.names), len(self.predictors)
        found = self.mean.shape, self.modes.shape, self.variance.shape
        if found != ((points, 3), (count, points, 3), (count,)):
            raise ModelFormatError(
                "the arrays of an articulatory model do not fit together", "build it again"
            )

    @property
    def parameters(self) -> tuple[str, ...]:
        """Names of the parameters, such as jaw1."""
        return tuple(p.name for p in self.predictors)

    @property
    def held(self) -> float:
        """Share of the corpus's variance that all parameters explain, 0 to 1."""
        return float(self.variance.sum())

    @property
    def noise(self) -> float:
        """By how much a coordinate of the corpus is off the model, RMS, mm."""
        left = max(0.0, 1.0 / self.held - 1.0) if self.held > 0 else 0.0
        missed = np.sqrt(float((self.modes**2).sum()) * left / self.mean.size)
        return max(float(missed), SHAPE.point_noise)

    def points(self, alpha: FloatArray) -> FloatArray:
        """Points (..., N, 3), mm, at parameters (..., P), standard deviations.

        Raises
        ------
        ParameterError
            If there are other than P parameters.
        """
        if np.shape(alpha)[-1:] != (len(self.modes),):
            raise ParameterError(
                f"parameters have shape {np.shape(alpha)}",
                f"give {len(self.modes)}: {', '.join(self.parameters)}",
            )
        return np.asarray(self.mean + np.tensordot(alpha, self.modes, 1), np.float64)

    def invert(self, points: FloatArray) -> FloatArray:
        """The direct inversion: parameters (..., P) of the least-squares nearest postures.

        Parameters
        ----------
        points : (..., N, 3) float64, mm, the frame of the corpus
            NaN where a point is missing; the others decide.

        Raises
        ------
        ParameterError
            If there are other than N points, or one is infinite or complex.
        TooFewPointsError
            If the points that are there do not determine all parameters: where some are missing,
            none may be expected to be off by more than `SHAPE.uncertain_parameter`.
        """
        refuse_complex(points)
        points = np.asarray(points, np.float64)
        if points.shape[-2:] != self.mean.shape:
            raise ParameterError(
                f"points have shape {points.shape}", f"give the model's {len(self.names)} points"
            )
        if np.isinf(points).any():
            raise ParameterError("a coordinate is infinite", "give NaN where a point is missing")
        away = (points - self.mean).reshape(-1, self.mean.size)
        matrix = self.modes.reshape(len(self.modes), -1).T
        noise = self.noise
        out = np.array([_solved(matrix, row, noise) for row in away]).reshape(-1, len(self.modes))
        return out.reshape(*points.shape[:-2], len(self.modes))

    def transform(self, X: FloatArray) -> FloatArray:
        """`invert` as scikit-learn calls it: (V, P) of postures (V, N, 3) or (V, 3N), mm."""
        refuse_complex(X)
        rows = np.asarray(X, np.float64)
        flat = rows.ndim == 2 and rows.shape[1] == self.mean.size
        return self.invert(rows.reshape(-1, *self.mean.shape) if flat else rows)

    def inverse_transform(self, X: FloatArray) -> FloatArray:
        """`points` as scikit-learn calls it: (V, N, 3), mm, of parameters (V, P)."""
        return self.points(X)

    def errors(self, points: FloatArray) -> FloatArray:
        """Residual of the direct inversion at each point, (..., N), mm; NaN where it is missing."""
        missed = np.asarray(points, np.float64) - self.points(self.invert(points))
        return np.asarray(np.linalg.norm(missed, axis=-1), np.float64)

    def arrays(self) -> dict[str, Any]:
        """All that it holds, by name, as a file has it; `from_arrays` takes it."""
        told = {
            "predictors": [asdict(p) for p in self.predictors],
            "groups": {name: list(points) for name, points in self.groups.items()},
        }
        return {
            "names": np.array(self.names),
            "mean": self.mean, "modes": self.modes, "variance": self.variance,
            "told": json.dumps(told), "source": self.source,
        }  # fmt: skip

    @classmethod
    def from_arrays(cls, data: Mapping[str, NDArray[np.generic]]) -> ArticulatoryModel:
        """The model of the arrays of a file; others among them are not read.

        Raises `KeyError` if something is missing; `TypeError`, `ValueError`, `AttributeError`,
        `ParameterError` or `ModelFormatError` if something is of another kind, or they do not make
        a model.
        """
        told = parse_json(str(data["told"]))
        predictors = tuple(
            Predictor(p["name"], tuple(p["points"]), p["coordinates"], p["positive"])
            for p in told["predictors"]
        )
        mean, modes, variance = (
            np.asarray(data[name], np.float64) for name in ("mean", "modes", "variance")
        )
        return cls(
            tuple(map(str, data["names"])), predictors, mean, modes, variance,
            {name: tuple(points) for name, points in told["groups"].items()}, str(data["source"]),
        )  # fmt: skip

    def save(self, path: Path) -> None:
        """Write an ``.npz``, whole or not at all.

        Raises
        ------
        OutputError
            If it exists or cannot be written.
        """
        write_npz(path, FORMAT, VERSION, self.arrays())


def learned(estimator: object) -> ArticulatoryModel:
    """The model of an estimator; `ParameterError` before its `fit`."""
    model = getattr(estimator, "model_", None)
    if not isinstance(model, ArticulatoryModel):
        raise ParameterError("nothing was learned yet", "call fit first")
    return model


def refuse_complex(points: ArrayLike) -> None:
    """Raise `ParameterError` for complex numbers, of which NumPy would drop the imaginary parts."""
    if np.iscomplexobj(points):
        raise ParameterError("a coordinate is complex", "give real numbers")


def _solved(matrix: FloatArray, away: FloatArray, noise: float) -> FloatArray:
    """Least squares over what is finite of one posture (3N,), off by `noise`, mm."""
    there = np.isfinite(away)
    own = matrix[there]
    alpha, _, rank, _ = np.linalg.lstsq(own, away[there], rcond=None)
    few = rank < own.shape[1]
    if not few and not there.all():
        expected = noise * np.linalg.norm(np.linalg.pinv(own, rcond=0.0), axis=1)
        few = expected.max() > SHAPE.uncertain_parameter
    if few:
        raise TooFewPointsError(
            f"{there.sum() // 3} points do not determine {own.shape[1]} parameters",
            "observe more points, those of lips and jaw above all",
        )
    return np.asarray(alpha, np.float64)


def load_articulatory(path: Path) -> ArticulatoryModel:
    """Read what `ArticulatoryModel.save` wrote.

    Raises
    ------
    InputFileError
        If it is missing or cannot be read.
    ModelFormatError
        If it has another format or version, lacks something, or holds what is not finite.
    """
    data = read_npz(to_path("path", path), FORMAT, VERSION, _LAYOUT, "build it again")
    try:
        return ArticulatoryModel.from_arrays(data)
    except (KeyError, TypeError, ValueError, AttributeError, ParameterError) as error:
        raise ModelFormatError(
            f"{path} is not a complete articulatory model ({error})", "build it again"
        ) from error
