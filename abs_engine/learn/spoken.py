"""A corpus of visemes with everything that is known of it."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from abs_engine.capture.corpus import Corpus
from abs_engine.core.arrays import FloatArray
from abs_engine.io.assets import Speaker
from abs_engine.learn.choice import Points


@dataclass(frozen=True, eq=False)
class SpokenCorpus:
    """A corpus of a bundled speaker, with everything that is known of it.

    Parameters
    ----------
    corpus : Corpus
        As measured, with noise.
    exact : (V, N, 3) float64, mm, bite-plane frame
        Where the points are.
    weights : (V, 52) float64
        Face-unit weights of the visemes.
    neutral : (M, 3) float32, mm, head frame
        All vertices of the person at rest.
    chosen : Points
        Which vertices the points are.
    """

    corpus: Corpus
    exact: FloatArray
    weights: FloatArray
    neutral: NDArray[np.float32]
    chosen: Points
    speaker: Speaker

    @property
    def noiseless(self) -> Corpus:
        """The corpus as an exact measurement would give it."""
        return replace(self.corpus, points=self.exact)
