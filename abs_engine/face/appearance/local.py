"""Local appearance of points of the surface, linear in the parameters (Odisio & Bailly, 3.2)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from abs_engine.core.arrays import BoolArray, FloatArray, IntArray
from abs_engine.core.errors import ParameterError
from abs_engine.face.appearance.descriptors import COMPONENTS
from abs_engine.face.settings.appearance import APPEARANCE
from abs_engine.io.arrays import Layout, real, whole

N_D = len(COMPONENTS)


@dataclass(frozen=True, eq=False)
class LocalModel:
    """d^i = d_0^i + M_D^i a for N points of the surface (eqs. 2 and 3).

    Parameters
    ----------
    vertices : (N,) int64
        Vertices of the scene.
    base : (N, 8) float64
        d_0, in the order of `descriptors.COMPONENTS`.
    modes : (P, N, 8) float64, per unit of parameter
        M_D; P is 0 for constant appearance (`la_cst`).
    mean : (N, 8) float64
        Over the frames that show the point.
    sigma : (N,) float64, drawn pixels
        Scale of each point's filters; all alike in the paper.
    spread : (N, 8) float64
        Standard deviation of what is left out, over the frames that show the point.
    left_out : (T, N, 8) float32
        By how much each training frame's descriptor is off what the other frames foretell; 0
        where the point is hidden.
    seen : (N,) float64
        Share of the training frames that show the point, 0 to 1.
    facing : (N,) float64
        Mean cosine between normal and line of sight in these frames.
    reach : (P,) float64
        Root mean square of each parameter over the training frames.
    explained : float
        Share of the descriptors' variance that the model explains, 0 to 1.
    unit : float, drawn pixels per mm
        0 where the filters' windows are rigid in the picture, as in the paper; else see
        `windows.Windows`.
    """

    vertices: IntArray
    base: FloatArray
    modes: FloatArray
    mean: FloatArray
    sigma: FloatArray
    spread: FloatArray
    left_out: NDArray[np.float32]
    seen: FloatArray
    facing: FloatArray
    reach: FloatArray
    explained: float
    unit: float = 0.0

    def __post_init__(self) -> None:
        n, p = len(self.vertices), len(self.modes)
        fits = all(a.shape == (n,) for a in (self.vertices, self.sigma, self.seen, self.facing))
        fits = fits and all(a.shape == (n, N_D) for a in (self.base, self.mean, self.spread))
        fits = fits and len(self.left_out) > 0 and self.left_out.shape[1:] == (n, N_D)
        if n == 0 or not fits or self.modes.shape != (p, n, N_D) or self.reach.shape != (p,):
            raise ParameterError("local appearance arrays do not fit", "learn them again")
        if not (np.isfinite(self.base).all() and np.isfinite(self.modes).all()):
            raise ParameterError("a local appearance model holds NaN", "learn it again")

    def __len__(self) -> int:
        """Return the number of points, N."""
        return len(self.vertices)

    @property
    def inverse(self) -> FloatArray:
        """One over `spread` (N, 8), which counts as a tenth of its median where it is smaller."""
        return inverse_spread(self.spread)

    @cached_property
    def whitener(self) -> FloatArray:
        """Makes noise of all descriptors together, in units of `spread`, white: (8 N, 8 N).

        What a linear model misses is missed by many points at once: where lips roll in, or light
        falls otherwise, all around them are off alike. The inverse root of the correlation of
        what was left out, drawn by `APPEARANCE.alone` to the identity.
        """
        return self.whitened_by(APPEARANCE.alone)

    def whitened_by(self, alone: float) -> FloatArray:
        """The same with another share, 0 to 1, for `AppearanceSettings.alone`."""
        together = in_common(self.left_out * self.inverse, (self.left_out != 0).any(axis=2))
        values, axes = np.linalg.eigh((1 - alone) * together + alone * np.eye(len(together)))
        return np.asarray((axes / np.sqrt(np.maximum(values, alone))) @ axes.T)

    def at(self, parameters: ArrayLike) -> FloatArray:
        """Descriptors (..., N, 8) at parameters (..., P); those beyond the model's are not read."""
        given = np.asarray(parameters, np.float64)
        if given.shape[-1] < len(self.modes):
            raise ParameterError(
                f"{given.shape[-1]} parameters for a model of {len(self.modes)}", "give one each"
            )
        return np.asarray(self.base + np.tensordot(given[..., : len(self.modes)], self.modes, 1))

    def constant(self) -> LocalModel:
        """The model with M_D = 0 (`la_cst`): the mean; what differences are measured by stays."""
        return replace(
            self, base=self.mean, modes=self.modes[:0], reach=self.reach[:0], explained=0.0
        )

    def only(self, chosen: NDArray[np.integer]) -> LocalModel:
        """The model of some of its points, indices (M,)."""
        kept = {f.name: getattr(self, f.name)[chosen] for f in fields(self) if f.name in _BY_POINT}
        modes, left_out = self.modes[:, chosen], self.left_out[:, chosen]
        return replace(self, modes=modes, left_out=left_out, **kept)

    def within(self, kept: NDArray[np.integer]) -> LocalModel:
        """The model on a part of its scene that has the vertices `kept` (V',), ascending.

        Raises `ParameterError` if a point is not in the part.
        """
        place = np.searchsorted(kept, self.vertices).clip(0, len(kept) - 1)
        if not np.array_equal(kept[place], self.vertices):
            raise ParameterError("points lie outside of the part", "choose them inside of it")
        return replace(self, vertices=place.astype(np.int64))

    def arrays(self) -> dict[str, Any]:
        """All that it holds, by name, as a file has it; `from_arrays` takes it."""
        return {f.name: getattr(self, f.name) for f in fields(self)}

    @classmethod
    def from_arrays(cls, data: Mapping[str, NDArray[np.generic]]) -> LocalModel:
        """The model of the arrays of a file; others among them are not read.

        Raises `KeyError` if one is missing; `TypeError`, `ValueError` or `ParameterError` if one is
        of another kind, or they do not make a model.
        """
        names = [f.name for f in fields(cls) if f.name not in ("vertices", "left_out", *_NUMBERS)]
        arrays = {name: np.asarray(data[name], np.float64) for name in names}
        left_out = np.asarray(data["left_out"], np.float32)
        vertices = np.asarray(data["vertices"], np.int64)
        explained, unit = (float(data[name]) for name in _NUMBERS)
        return cls(vertices=vertices, left_out=left_out, explained=explained, unit=unit, **arrays)


LAYOUT: Layout = {
    "vertices": whole("N", low=0),
    **dict.fromkeys(("base", "mean"), real("N", N_D)),
    "modes": real("P*", "N", N_D),
    "sigma": real("N", low=1e-9),
    "spread": real("N", N_D, low=0.0),
    "left_out": real("Q", "N", N_D, dtype=np.float32),
    **dict.fromkeys(("seen", "facing"), real("N", low=0.0)),
    "reach": real("P*"),
    **dict.fromkeys(("explained", "unit"), real()),
}
"""Its arrays in a file."""
_BY_POINT = ("vertices", "base", "mean", "sigma", "spread", "seen", "facing")
_NUMBERS = ("explained", "unit")


def inverse_spread(spread: FloatArray) -> FloatArray:
    """One over spreads (N, 8), none of which counts as less than a share of their median."""
    floor = APPEARANCE.least_spread * np.median(spread, axis=0) + 1e-6
    return np.asarray(1 / np.maximum(spread, floor))


def in_common(noise: FloatArray, seen: BoolArray) -> FloatArray:
    """Mean products (8 N, 8 N) of noise (T, N, 8), over the frames that show both points, (T, N).

    The noise is 0 where the point is hidden. Not every one of its eigenvalues is positive where
    frames hide points, since each pair is averaged over frames of its own.
    """
    rows, shown = noise.reshape(len(noise), -1), seen.astype(np.float64)
    both = np.maximum(shown.T @ shown, 1.0)
    return np.asarray(rows.T @ rows / both.repeat(N_D, axis=0).repeat(N_D, axis=1))
