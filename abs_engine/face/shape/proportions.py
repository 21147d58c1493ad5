"""Variation of the skull's proportions: it alone holds where no landmark lies.

The targets of a head and smooth fields let crown and ears differ by up to twice as much as people's
do, and tie them to a forehead of which a picture shows half. Each proportion is therefore taken as
measured to be average, with as much noise as leaves it the spread of people, and the modes are
those of the Gaussian that this leaves (Bishop, Pattern Recognition and Machine Learning, 2006, eq.
2.117). So is the turn of the face: what a head is turned by is its pose, not its shape.
"""

from __future__ import annotations

import numpy as np

from abs_engine.core.arrays import FloatArray
from abs_engine.face.settings.shape import SHAPE
from abs_engine.io.assets import Speaker

_TURN = 1e-3  # rad: none, but for the numerics
_INNER = np.r_[8, 17:68]
"""The chin and all but the jaw line of the 68 usual landmarks, by which a face is turned."""


def proportioned(speaker: Speaker, modes: FloatArray) -> FloatArray:
    """Matrix (K, K) that makes of modes (K, 3 V), mm, those of skulls as alike as people's are."""
    moves = modes.reshape(len(modes), -1, 3)
    rows = [*_turns(speaker, moves), *_proportions(speaker, moves)]
    if not rows:
        return np.eye(len(modes))
    changes, spread = np.stack([r for r, _ in rows], axis=1), np.array([s for _, s in rows])
    free = (changes**2).sum(axis=0)
    tied = spread**2 < free  # what differs by less already is left alone
    slopes, told, wanted = changes[:, tied], free[tied], spread[tied] ** 2
    noise = wanted * told / (told - wanted)
    gain = np.linalg.solve(slopes.T @ slopes + np.diag(noise), slopes.T)
    left = np.eye(len(modes)) - slopes @ gain
    values, axes = np.linalg.eigh(0.5 * (left + left.T))
    root = axes * np.sqrt(np.maximum(values, 0.0))
    return np.asarray(root.T)


_Rows = list[tuple[FloatArray, float]]


def _turns(speaker: Speaker, modes: FloatArray) -> _Rows:
    """By how much each mode (K,) turns the face about each axis, rad, and the spread of it.

    The rotation that lays a face's landmarks on those of the average head, to first order (Horn,
    JOSA A 4(4), 1987). None where the head names no landmarks.
    """
    if "landmark_68" not in speaker.points:
        return []
    marks = speaker.points["landmark_68"][_INNER]
    arms = speaker.vertices[marks].astype(np.float64)
    arms -= arms.mean(axis=0)
    inertia = (arms**2).sum() * np.eye(3) - arms.T @ arms
    turns = np.linalg.solve(inertia, np.cross(arms, modes[:, marks]).sum(axis=1).T)
    return [(turn, _TURN) for turn in turns]


def _proportions(speaker: Speaker, modes: FloatArray) -> _Rows:
    """By how much each mode (K,) changes a proportion, and the spread of it, mm, for each.

    None of a mask, which ends at the nose's root.
    """
    v = speaker.vertices.astype(np.float64)
    root = _root(speaker)
    crown = int(v[:, 1].argmax())
    skull = v[:, 1] > v[root, 1] + SHAPE.above_ears * (v[crown, 1] - v[root, 1])
    if not skull.any():
        return []
    back = int(np.where(skull, v[:, 2], np.inf).argmin())
    head = v[:, 1] > v[speaker.lip_ring, 1].mean()
    sides, ears = (
        [int(np.where(part, s * v[:, 0], -np.inf).argmax()) for s in (1, -1)]
        for part in (skull, head)
    )
    return [
        (modes[:, sides[0], 0] - modes[:, sides[1], 0], SHAPE.head_breadth),
        (modes[:, root, 2] - modes[:, back, 2], SHAPE.head_length),
        (modes[:, crown, 1] - modes[:, root, 1], SHAPE.head_height),
        (modes[:, crown, 0] - modes[:, root, 0], SHAPE.crown_sideways),
        *((modes[:, e, 0] - modes[:, t, 0], SHAPE.ears) for e, t in zip(ears, sides, strict=True)),
    ]


def _root(speaker: Speaker) -> int:
    """The nose's root, about: between the eyes."""
    v = speaker.vertices.astype(np.float64)
    eyes = v[speaker.landmarks["eye_corners"]]
    beside = np.linalg.norm(v[:, :2] - eyes[:, :2].mean(axis=0), axis=1)
    near = beside < beside.min() + SHAPE.between_eyes * np.ptp(eyes[:, 0])
    return int(np.where(near, v[:, 2], -np.inf).argmax())
