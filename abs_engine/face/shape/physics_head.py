"""Learned physics for a whole head: what the face does when the shell moves in its modes.

The shell is lips and the skin next to them. Where the whole head is tracked, chin and cheeks are to
follow: each mode of the shell is made of the face units that come nearest to it, and the head moves
by those.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from abs_engine.face.settings.shape import SHAPE
from abs_engine.face.shape.linear import LinearShape
from abs_engine.face.shape.lip_shell import LipShell
from abs_engine.face.shape.modal import LearnedPhysics
from abs_engine.face.shape.mouth import mouth_units
from abs_engine.io.assets import Speaker


def physics_shape(
    speaker: Speaker, neutral: NDArray[np.float32], shell: LipShell, physics: LearnedPhysics
) -> LinearShape:
    """The modes of a head, neutral (V, 3), mm, that go with a shell's, cut from this speaker.

    The physics is of that shell; of this person or another. Parameters are standard deviations of
    its modes, generators the units of `mouth_units`. `variance` is the share of the shell's
    variance that each mode holds.
    """
    units = speaker.unit_matrix(mouth_units()).astype(np.float64)
    weight = np.ones(len(shell))
    weight[np.unique(shell.faces[shell.lip])] = SHAPE.lip_share
    weight = np.repeat(weight / np.sqrt((weight**2).sum()), 3)
    moved = shell.nodes(units).reshape(len(units), -1) * weight  # (N, 3M)
    wanted = np.vstack([physics.mean[None], physics.deviations[:, None, None] * physics.modes])
    wanted = wanted.reshape(len(wanted), -1) * weight
    normal = moved @ moved.T + SHAPE.weight_cost**2 * np.eye(len(units))
    weights = np.asarray(np.linalg.solve(normal, moved @ wanted.T).T, np.float64)  # (1 + P, N)
    heads = np.tensordot(weights, units, 1)
    return LinearShape(
        np.asarray(neutral + heads[0], np.float32), np.asarray(heads[1:], np.float32),
        weights[1:], weights[0], np.asarray(physics.variances / physics.total),
    )  # fmt: skip
