"""Epsilon(p) as a sum of squares, whose terms a Gauss-Newton step needs one by one."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from abs_engine.compare.descriptor import TextureError, penalty_roots
from abs_engine.compare.points import LocalError
from abs_engine.core.scene import Candidates
from abs_engine.face.appearance.local import N_D

FloatArray = NDArray[np.float64]
Flags = NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class Parts:
    """Epsilon of a batch, taken apart.

    Parameters
    ----------
    rows : (B, K) float32 or float64
        Differences of descriptors, 0 where there is none.
    there : (B, K) bool
        Where there is one.
    value : (B,) float64
        Epsilon.
    penalty : (B, P) float64
        Square roots of A(a)'s terms, in units of epsilon.
    mixer : (K, K) float64 or None
        What the rows are multiplied by before they are squared.
    """

    rows: NDArray[np.floating]
    there: Flags
    value: FloatArray
    penalty: FloatArray
    mixer: FloatArray | None = None

    def mixed(self, rows: NDArray[np.floating]) -> FloatArray:
        """Rows, or differences of rows, as they are squared."""
        return np.asarray(rows if self.mixer is None else rows @ self.mixer.T)


def parts(error: TextureError | LocalError, vectors: FloatArray) -> Parts:
    """Epsilon of parameter vectors (B, n), taken apart; its value is that of the objective."""
    if isinstance(error, TextureError):
        many = error.candidates(vectors)
        rows, there, data = _texture(error, many)
        terms = penalty_roots(many.weights, error.penalty, error.wrong)
        return Parts(rows, there, data + (terms**2).sum(axis=1), terms)
    differ, shown, weights = error.differences(vectors)
    wide = differ.reshape(len(differ), -1)
    data = (error.mixed(differ) ** 2).mean(axis=1) + np.where(shown, 0, error.wrong).mean(axis=1)
    terms = penalty_roots(weights, error.penalty, float(error.wrong.mean()))
    return Parts(
        wide / np.sqrt(wide.shape[1]), np.repeat(shown, N_D, axis=1),
        data + (terms**2).sum(axis=1), terms, error.mixer,
    )  # fmt: skip


def _texture(
    error: TextureError, many: Candidates
) -> tuple[NDArray[np.floating], Flags, FloatArray]:
    drawn = error.renderer.draw(error.scene, many, error.camera, error.window)
    frame = error.term.normalised
    rows = np.zeros((len(many), frame.size), np.float32)
    there = np.zeros(rows.shape, np.bool_)
    data = np.empty(len(many))
    for i, buffers in enumerate(drawn):
        covered, differ = error.differences(buffers)
        count = len(differ)
        lost = max(error.drawn - count, 0)
        data[i] = (float((differ**2).sum()) / 3 + error.wrong * lost) / (count + lost)
        rows[i].reshape(frame.shape)[covered] = differ / np.sqrt(3 * (count + lost))
        there[i].reshape(frame.shape)[covered] = True
    return rows, there, data
