"""Dots of a filmed session of visemes: where they truly are."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from heads import spoken_heads

from abs_engine.learn.spoken import SpokenCorpus


def filmed_places(spoken: SpokenCorpus, vertices: Sequence[int]) -> np.ndarray:
    """True places (V, N, 3) of dots in the visemes, mm, in the frame of the upper teeth."""
    heads = spoken_heads(spoken.speaker, spoken.neutral, spoken.weights)
    return spoken.corpus.frame.apply(heads[:, np.asarray(vertices)].astype(np.float64))
