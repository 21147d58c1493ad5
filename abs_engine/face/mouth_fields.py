"""Modes of people's mouths for a head that has no shape targets of mouths: smooth ones."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from abs_engine.face.schema import PERSON_TARGETS
from abs_engine.face.settings.shape import SHAPE
from abs_engine.face.shape.smooth import smooth_modes
from abs_engine.io.assets import Speaker


def mouth_fields(speaker: Speaker) -> NDArray[np.float32]:
    """As many modes as `PERSON_TARGETS`, (Q, V, 3), mm at weight 1, over the whole head.

    The widest principal directions, over the lips, of smooth displacements about the mouth; each is
    so long that the spread of the target in its place is one standard deviation.
    """
    vertices = speaker.vertices.astype(np.float64)
    ring = vertices[speaker.lip_ring]
    middle = ring.mean(axis=0)
    away = np.maximum(np.linalg.norm(vertices - middle, axis=1) - 0.5 * np.ptp(ring[:, 0]), 0)
    near = np.flatnonzero(away < SHAPE.mouth_far * SHAPE.mouth_reach)
    fields = smooth_modes(vertices[near], SHAPE.smooth_scales[1:])
    fields *= np.exp(-0.5 * (away[near] / SHAPE.mouth_reach) ** 2)[:, None]
    lips = np.isin(near, speaker.vertices_of("upper_lip", "lower_lip"))
    flat = fields[:, lips].reshape(len(fields), -1)
    values, vectors = np.linalg.eigh(flat @ flat.T)
    kept = vectors[:, np.argsort(-values)[: len(PERSON_TARGETS)]].T
    spread = np.array([spread for *_, spread in PERSON_TARGETS.values()])
    out = np.zeros((len(kept), *vertices.shape), np.float32)
    out[:, near] = np.tensordot(kept, fields, 1) / spread[:, None, None]
    return out
