"""Moments of postures, recorded or authored: how people move their mouths."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from abs_engine.core.arrays import FloatArray
from abs_engine.core.errors import InputFileError, ModelFormatError
from abs_engine.io.arrays import check_arrays, of_json, places_of, real, text
from abs_engine.io.assets import shipped
from abs_engine.io.inputs import read_json

FORMAT, VERSION = "abs_engine.postures", 1
RECORDED = "postures/recorded.json"
_AGAIN = "make it again with assets/make_postures.py"


@dataclass(frozen=True, eq=False)
class Postures:
    """Mean (N,) and covariance (N, N) of the weights of generators, such as face units."""

    mean: FloatArray
    covariance: FloatArray

    @classmethod
    def of(cls, samples: FloatArray) -> Postures:
        """Moments of postures (S, N)."""
        return cls(samples.mean(axis=0), np.cov(samples, rowvar=False))

    def pooled(self, other: Postures, share: float) -> Postures:
        """Moments of postures of which a share, 0 to 1, are these and all else the others."""
        apart, rest = self.mean - other.mean, 1.0 - share
        within = share * self.covariance + rest * other.covariance
        return Postures(
            share * self.mean + rest * other.mean, within + share * rest * np.outer(apart, apart)
        )

    def scaled(self, factors: FloatArray) -> Postures:
        """Moments of the same postures, each generator's weight times its factor (N,)."""
        return Postures(self.mean * factors, self.covariance * np.outer(factors, factors))

    def partly_again(self, share: float) -> Postures:
        """Moments of 2 N generators: these, and as many that only some postures have.

        In a share of the postures, 0 to 1, drawn independently of their weights, the second half
        has the weights of the first; in the others it has none.
        """
        c, apart = self.covariance, np.outer(self.mean, self.mean)
        again = share * c + share * (1.0 - share) * apart
        whole = np.block([[c, share * c], [share * c, again]])
        return Postures(np.r_[self.mean, share * self.mean], whole)


def recorded_postures(names: Sequence[str], path: Path | None = None) -> Postures:
    """Moments of a real person's postures, by the names of the face units, in their order.

    By default of the file that is shipped, see ``assets/postures/PROVENANCE.md``. Raises
    `InputFileError` if it cannot be read, `ModelFormatError` if it has another format or version,
    or lacks a unit.
    """
    path = shipped(RECORDED) if path is None else path
    try:
        read = read_json(path)
        kind = (read["format"], read["version"])
        given = {k: of_json(read[k]) for k in ("unit_names", "mean", "covariance")}
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise InputFileError(f"{path} holds no moments of postures", _AGAIN) from error
    if kind != (FORMAT, VERSION):
        raise ModelFormatError(f"{path} has another format or version", _AGAIN)
    layout = {"unit_names": text("N"), "mean": real("N"), "covariance": real("N", "N")}
    data = check_arrays(path, given, layout, _AGAIN)
    order = places_of(path, data["unit_names"], names, _AGAIN)
    return Postures(data["mean"][order], data["covariance"][np.ix_(order, order)])
