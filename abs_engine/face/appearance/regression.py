"""Many small least-squares fits at once: what each texel or point looks like, by the parameters.

For the fits, frames are added one by one and only sums are kept, so memory does not grow with their
number. `Frames`, what a texture's leftover is measured on, keeps them all.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.arrays import BoolArray, FloatArray, IntArray
from abs_engine.core.errors import NothingSeenError, ParameterError
from abs_engine.face.settings.appearance import APPEARANCE

BLOCK = 20_000  # items solved at once


@dataclass(frozen=True, eq=False)
class Fitted:
    """value = base + parameters . modes of K items with C channels each.

    Parameters
    ----------
    base : (K, C) float64
        At parameters of zero.
    modes : (P, K, C) float64, per unit of parameter
    mean : (K, C) float64
        Over the frames that show the item.
    frames : (K,) int64
        How many frames show it; 0 where all else is 0.
    total, residual : (K, C) float64
        Weighted sum of squares about the mean, and about the fit.
    """

    base: FloatArray
    modes: FloatArray
    mean: FloatArray
    frames: IntArray
    total: FloatArray
    residual: FloatArray

    @property
    def explained(self) -> float:
        """Share of the variance, over all items and channels, that the fit explains."""
        total = float(self.total.sum())
        return 1.0 - float(self.residual.sum()) / total if total > 0 else 0.0


@dataclass(frozen=True, eq=False)
class Frames:
    """Values of T frames that many fits were made of, all kept: memory grows with T times K.

    There are no weights: every frame that shows an item counts alike, unlike in `LinearFits`.

    Parameters
    ----------
    values : (T, K, C) float32
    seen : (T, K) bool
        Which frames show which items.
    parameters : (T, P) float64
    recordings : (T,) int64, optional
        Which frames were recorded together: they are left out together.
    """

    values: NDArray[np.float32]
    seen: BoolArray
    parameters: FloatArray
    recordings: IntArray | None = None

    def of(self, items: BoolArray) -> Frames:
        """The same of some items, (K,)."""
        return replace(self, values=self.values[:, items], seen=self.seen[:, items])

    def recorded(self, kept: BoolArray) -> Frames:
        """Some of the frames, (T,)."""
        names = None if self.recordings is None else self.recordings[kept]
        return Frames(self.values[kept], self.seen[kept], self.parameters[kept], names)

    @cached_property
    def ridge(self) -> float:
        """The ridge with which recordings foretell others best; the usual one without any."""
        if self.recordings is None:
            return APPEARANCE.ridge
        lost = [float((self.left_out(ridge) ** 2).sum()) for ridge in APPEARANCE.ridges]
        return APPEARANCE.ridges[int(np.argmin(lost))]

    def left_out(self, ridge: float) -> FloatArray:
        """Residual of each frame from the fit of all others, (T, K, C); 0 where it shows no item.

        Where recordings are known, of all other recordings.
        """
        if self.recordings is None:
            return self._frame_out(ridge)
        names = np.unique(self.recordings)
        held = np.diag(np.r_[1e-9, np.full(self.parameters.shape[1], ridge)])
        off, sums = np.zeros(self.values.shape), self._sums
        for name in names:
            out = self.recordings == name
            gram, cross = (part[names != name].sum(axis=0) for part in sums)
            found = np.linalg.solve(gram + held, cross)
            rows, seen = self._rows[out], self.seen[out]
            off[out] = (self.values[out] - np.einsum("ti,kic->tkc", rows, found)) * seen[..., None]
        return off

    @cached_property
    def _rows(self) -> FloatArray:
        return np.column_stack([np.ones(len(self.parameters)), self.parameters])

    @cached_property
    def _sums(self) -> tuple[FloatArray, FloatArray]:
        """Sums of each recording's squares (R, K, 1 + P, 1 + P), and with its values."""
        grams, crosses = [], []
        given = np.zeros(len(self.parameters)) if self.recordings is None else self.recordings
        for name in np.unique(given):
            own = given == name
            rows, seen = self._rows[own], self.seen[own].astype(np.float64)
            pairs = (rows[:, :, None] * rows[:, None]).reshape(len(rows), -1)
            size = rows.shape[1]
            grams.append((seen.T @ pairs).reshape(-1, size, size))
            shown = self.values[own] * seen[..., None]
            crosses.append(np.einsum("ti,tkc->kic", rows, shown, optimize=True))
        return np.array(grams), np.array(crosses)

    def _frame_out(self, ridge: float) -> FloatArray:
        """Residuals of frames that are left out one by one.

        The residuals over one minus the leverage, which for a ridge is the same as to fit again
        without the frame. A frame that alone decides about an item has a leverage of nearly 1,
        which is held below `APPEARANCE.highest`.
        """
        rows = self._rows
        seen, values = self.seen.astype(np.float64), self.values.astype(np.float64)
        held = np.diag(np.r_[1e-9, np.full(rows.shape[1] - 1, ridge)])
        gram = np.einsum("tk,ti,tj->kij", seen, rows, rows, optimize=True)
        inverse = np.linalg.inv(gram + held)
        cross = np.einsum("tk,ti,tkc->kic", seen, rows, values, optimize=True)
        fitted = np.einsum("ti,kij,kjc->tkc", rows, inverse, cross, optimize=True)
        leverage = np.einsum("ti,kij,tj->tk", rows, inverse, rows, optimize=True)
        off = (values - fitted) / (1 - np.minimum(leverage, APPEARANCE.highest))[..., None]
        return np.asarray(off * seen[..., None])


class LinearFits:
    """Sums for K weighted least-squares fits, of C channels each, on the same P parameters."""

    def __init__(self, items: int, channels: int, parameters: int) -> None:
        n = parameters + 1
        self._parameters = parameters
        self._gram = np.zeros((items, n, n))
        self._cross = np.zeros((items, n, channels))
        self._square = np.zeros((items, channels))
        self._frames = np.zeros(items, np.int64)

    def add(self, values: FloatArray, weights: FloatArray, parameters: FloatArray) -> None:
        """Add a frame's values (K, C) with weights (K,), 0 where it does not show the item.

        Raises `ParameterError` if it has other than P parameters, or one that is not finite.
        """
        if np.shape(parameters) != (self._parameters,) or not np.isfinite(parameters).all():
            raise ParameterError(
                f"a frame has parameters of shape {np.shape(parameters)}, or not finite",
                f"give {self._parameters} for every frame",
            )
        seen = np.flatnonzero(weights > 0)
        row = np.concatenate([np.ones(1), parameters])
        w, v = weights[seen, None], values[seen]
        self._gram[seen] += w[:, :, None] * np.outer(row, row)
        self._cross[seen] += row[:, None] * (w * v)[:, None]
        self._square[seen] += w * v**2
        self._frames[seen] += 1

    def solve(self, ridge: float) -> Fitted:
        """Fit.

        Parameters
        ----------
        ridge : float, frames
            Weight of the wish that an item does not depend on the parameters (in sd): it decides
            for what few frames show, and hardly counts for what many show.

        Raises
        ------
        NothingSeenError
            If no frame shows any item.
        ParameterError
            If `ridge` is not positive.
        """
        if not self._frames.any():
            raise NothingSeenError(
                "no training frame shows any part of the surface to learn",
                "check that poses, camera and pictures belong together",
            )
        if not ridge > 0:
            raise ParameterError(f"the ridge is {ridge}", "give a positive number of frames")
        items, n, channels = self._cross.shape
        found = np.zeros((items, n, channels))
        seen = np.flatnonzero(self._frames)
        held = ridge * np.diag(np.r_[0.0, np.ones(n - 1)])
        for start in range(0, len(seen), BLOCK):
            part = seen[start : start + BLOCK]
            found[part] = np.linalg.solve(self._gram[part] + held, self._cross[part])
        return self._fitted(found)

    def _fitted(self, found: FloatArray) -> Fitted:
        weight = np.maximum(self._gram[:, 0, :1], 1e-300)
        mean = self._cross[:, 0] / weight
        residual = self._square - 2 * np.einsum("knc,knc->kc", found, self._cross)
        residual += np.einsum("knc,knm,kmc->kc", found, self._gram, found)
        return Fitted(
            base=found[:, 0],
            modes=np.ascontiguousarray(found[:, 1:].transpose(1, 0, 2)),
            mean=mean,
            frames=self._frames.copy(),
            total=np.maximum(self._square - weight * mean**2, 0.0),
            residual=np.maximum(residual, 0.0),
        )
