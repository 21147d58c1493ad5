"""The drawn rings of the lips as they follow the shell's three: on the whole, as on the head.

A ring that keeps its distance from the shell's facets moves too far: what lies within a lip is held
back by what it is joined to, so that a mouth which opens is drawn 0.6 mm too wide open. How far a
ring is held back is told by the head's own face units.
"""

from __future__ import annotations

import numpy as np

from abs_engine.core.arrays import FloatArray
from abs_engine.face.shape.dots import ShellPoints
from abs_engine.face.shape.lip_shell import COLUMNS, LipShell
from abs_engine.io.assets import Speaker

_FACING = (-np.arange(COLUMNS)) % COLUMNS  # the column of the other lip that each one meets


def leaders(nodes: FloatArray) -> FloatArray:
    """Leading points of the rings: (..., 4, 34, 3) of shell nodes (..., N, 3).

    The shell's rings of the lips from the inner to the outer one, and the inner one of the lip
    that faces them.
    """
    rings = nodes[..., : 3 * COLUMNS, :].reshape(*nodes.shape[:-2], 3, COLUMNS, 3)
    return np.concatenate([rings, rings[..., :1, _FACING, :]], axis=-3)


def followed(
    speaker: Speaker, shell: LipShell, rings: ShellPoints, chords: FloatArray
) -> FloatArray:
    """Share that each ring has in the motion of each of its `leaders`.

    Parameters
    ----------
    speaker : Speaker
    shell : LipPoints
        N nodes, the lips' three rings first.
    rings : LipPoints
        R rings of 34 points.
    chords : (R, 4) float64
        The shares that keep a ring at its place on the shell's facets: where the units do not tell
        otherwise, these are kept.

    Returns
    -------
    (R, 4) float64
        Each row sums to 1, so that lips which move as a whole take all their rings along. Least
        squares over all points of a ring and all face units.
    """
    units = speaker.unit_matrix(speaker.unit_names).astype(np.float64)
    lead = leaders(shell.nodes(units))
    moved = rings.at(units).reshape(len(units), -1, COLUMNS, 3)
    stretched = np.stack([(lead[:, k] - lead[:, 0]).ravel() for k in range(1, 4)], axis=1)
    kept = np.einsum("rk,ukcd->rucd", chords, lead)
    missing = (np.moveaxis(moved, 1, 0) - kept).reshape(len(chords), -1)
    shares = np.linalg.lstsq(stretched, missing.T, rcond=None)[0].T
    return np.asarray(chords + np.column_stack([-shares.sum(axis=1), shares]))
