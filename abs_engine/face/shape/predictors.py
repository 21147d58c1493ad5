"""Predictors of articulatory parameters: the points and coordinates whose component each is.

Odisio and Bailly (2003), section 2.2.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.errors import ParameterError, TooFewPointsError
from abs_engine.io.inputs import name_problem

AXES = "xyz"
TAKEN = ("frame", "rms_mm", "points", "total")
"""No parameter's name: columns of the parameters of frames, and the sum in a table of shares."""


@dataclass(frozen=True)
class Predictor:
    """The first principal component of selected coordinates of what is not yet explained.

    Parameters
    ----------
    name : str
        Of the parameter: printable, without a comma, and none of `TAKEN`.
    points : tuple of str
        Groups of points, or single points, by name.
    coordinates : str
        Of ``x`` (to the left), ``y`` (up), ``z`` (forward).
    positive : str
        A sign and an axis, such as ``-y``: where the selected points move on the whole as the
        parameter grows. A component has no sign of its own.

    Raises
    ------
    ParameterError
        If name, points, coordinates or sign are not of this form.
    """

    name: str
    points: tuple[str, ...]
    coordinates: str = "xyz"
    positive: str = "+y"

    def __post_init__(self) -> None:
        problem = name_problem("predictor", self.name)
        if problem is None and ("," in self.name or self.name in TAKEN):
            problem = f"no predictor can be named '{self.name}'"
        if problem is not None:
            raise ParameterError(problem, f"give a name without commas, not {', '.join(TAKEN)}")
        if not self.points:
            raise ParameterError(f"predictor '{self.name}' has no points", "name groups or points")
        if not self.coordinates or not set(self.coordinates) <= set(AXES):
            raise ParameterError(
                f"predictor '{self.name}' takes coordinates '{self.coordinates}'",
                "give some of x, y and z, such as xyz",
            )
        sign, axis = self.positive[:1], self.positive[1:]
        if sign not in ("+", "-") or axis not in tuple(self.coordinates):
            raise ParameterError(
                f"predictor '{self.name}' grows towards '{self.positive}'",
                f"give + or - and one of its coordinates, such as +{self.coordinates[0]}",
            )

    def columns(
        self, names: Sequence[str], groups: Mapping[str, Sequence[str]]
    ) -> NDArray[np.int64]:
        """Indices into the coordinates x1 y1 z1 x2 ... of N points, in their order.

        Raises
        ------
        ParameterError
            If a name is neither a group nor a point.
        TooFewPointsError
            If none of the points is among `names`.
        """
        wanted: set[str] = set()
        for name in self.points:
            if name not in groups and name not in names:
                raise ParameterError(
                    f"predictor '{self.name}' asks for '{name}', no group and no point",
                    "name such a group in the table of points, or give other predictors; "
                    f"the groups are {', '.join(groups) or 'none'}",
                )
            wanted |= set(groups.get(name, (name,)))
        at = [k for k, name in enumerate(names) if name in wanted]
        if not at:
            raise TooFewPointsError(
                f"predictor '{self.name}' has no points: {', '.join(self.points)} is empty",
                "name points that every viseme has, impute those that are missing, or leave the "
                "predictor out",
            )
        own = [AXES.index(axis) for axis in AXES if axis in self.coordinates]
        return np.array([3 * k + axis for k in at for axis in own])

    def orientation(self, loadings: NDArray[np.float64], columns: NDArray[np.int64]) -> float:
        """1 or -1: what brings loadings (K,) of the columns into line with `positive`."""
        sign = 1.0 if self.positive[0] == "+" else -1.0
        moved = float(loadings[columns % 3 == AXES.index(self.positive[1])].sum())
        return sign if moved >= 0 else -sign


_JAW = ("jaw_line", "lower_teeth")
PAPER_PREDICTORS: tuple[Predictor, ...] = (
    Predictor("jaw1", _JAW, "y", "-y"),
    Predictor("lips1", ("lips",), "xyz", "+z"),
    Predictor("lips2", ("lower_lip",), "y", "-y"),
    Predictor("lips3", ("upper_lip",), "y", "+y"),
    Predictor("lips4", ("lips",), "y", "+y"),
    Predictor("jaw2", _JAW, "z", "+z"),
    Predictor("lar1", ("face",), "xyz", "-y"),
)
"""The seven of section 2.2 in their order; the signs are ours.

``lips``, ``upper_lip`` and ``lower_lip`` hold the points of the lips' contour and the beads around
it; ``face`` is everything but the points on the lips and the teeth.
"""
