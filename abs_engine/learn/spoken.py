"""A corpus of visemes with everything that is known of it, and the frame that it is in."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from abs_engine.capture.corpus import Corpus, bite_plane
from abs_engine.core.arrays import FloatArray
from abs_engine.core.geometry import Pose
from abs_engine.io.assets import Speaker
from abs_engine.learn.choice import Points
from abs_engine.learn.settings import LEARNING


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


def bite_plane_of(speaker: Speaker, neutral: NDArray[np.floating]) -> Pose:
    """Head frame to bite-plane frame of a person, by `upper_teeth_of`.

    The skull of the bundled head does not move in its head frame, nor do the upper teeth, so that
    this is one rigid motion for all postures.
    """
    return bite_plane(*upper_teeth_of(speaker, neutral))


def upper_teeth_of(speaker: Speaker, neutral: NDArray[np.floating]) -> FloatArray:
    """Three points (3, 3) of a person's upper teeth, right, left and front, mm, head frame.

    The lowest vertex of the hindmost quarter of the teeth on either side, and the edge of the front
    teeth: the lowest vertex near the middle, moved into it.
    """
    own = speaker.vertices_of("upper_teeth")
    place = neutral[own].astype(np.float64)
    x, y, z = place.T
    behind = z < z.min() + (z.max() - z.min()) / 4
    right, left = (place[np.where(behind & side, y, np.inf).argmin()] for side in (x < 0, x > 0))
    ahead = (np.abs(x) < LEARNING.bite_width) & (z > (z.min() + z.max()) / 2)
    front = place[np.where(ahead, y, np.inf).argmin()] * [0.0, 1.0, 1.0]
    return np.stack([right, left, front])
