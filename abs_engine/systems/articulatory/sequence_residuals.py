"""Epsilon(p) as a sum of squares, whose terms a Gauss-Newton step needs one by one."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from abs_engine.appearance.local import N_D
from abs_engine.appearance.sight import in_sight
from abs_engine.camera import Window
from abs_engine.compare.descriptor import TextureError, penalty_roots
from abs_engine.compare.points import DEPTH_SCALE, LocalError
from abs_engine.scene import Candidates

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
    """

    rows: NDArray[np.floating]
    there: Flags
    value: FloatArray
    penalty: FloatArray


def parts(error: TextureError | LocalError, vectors: FloatArray) -> Parts:
    """Epsilon of parameter vectors (B, n), taken apart; its value is that of the objective."""
    many = error.candidates(vectors)
    rows: NDArray[np.floating]
    if isinstance(error, TextureError):
        rows, there, data = _texture(error, many)
        wrong = error.wrong
    else:
        rows, there, data = _local(error, many)
        wrong = float(error.wrong.mean())
    terms = penalty_roots(many.weights, error.penalty, wrong)
    return Parts(rows, there, data + (terms**2).sum(axis=1), terms)


def _texture(
    error: TextureError, many: Candidates
) -> tuple[NDArray[np.floating], Flags, FloatArray]:
    drawn = error.renderer.draw(error.scene, many, error.camera, error.window)
    frame = error.term.normalised
    rows = np.zeros((len(many), frame.size), np.float32)
    there = np.zeros(rows.shape, np.bool_)
    data = np.empty(len(many))
    for i, buffers in enumerate(drawn):
        covered = buffers.covered
        ours = buffers.rgb[covered].astype(np.float32)
        ours = (ours + 1) / (ours.sum(axis=1, keepdims=True) + 3)
        differ = frame[covered] - ours
        count = len(differ)
        lost = max(error.drawn - count, 0)
        data[i] = (float((differ**2).sum()) / 3 + error.wrong * lost) / (count + lost)
        rows[i].reshape(frame.shape)[covered] = differ / np.sqrt(3 * (count + lost))
        there[i].reshape(frame.shape)[covered] = True
    return rows, there, data


def _local(error: LocalError, many: Candidates) -> tuple[NDArray[np.floating], Flags, FloatArray]:
    w = error.window
    coarse = Window(w.x, w.y, w.width, w.height, w.scale * DEPTH_SCALE)
    drawn = error.renderer.draw(error.scene, many, error.camera, coarse)
    count = len(error.model)
    rows, shown = np.empty((len(many), count, N_D)), np.empty((len(many), count), np.bool_)
    for i, buffers in enumerate(drawn):
        moved = error.windows.patches.placed(many, i)
        points, normals = error.windows.patches.surface(moved)
        rows[i] = error.windows.read(error.maps, w.to_drawn(error.camera.project(moved)))
        shown[i] = in_sight(points, normals, buffers.depth, error.camera, coarse) > 0
    rows = (rows - error.model.at(many.weights)) * error.inverse
    costs = np.where(shown, (rows**2).sum(axis=2) / N_D, error.wrong)
    there = np.repeat(shown, N_D, axis=1)
    flat = np.where(there, rows.reshape(len(many), -1), 0.0) / np.sqrt(N_D * count)
    return flat, there, costs.mean(axis=1)
