"""Sources of shapes that physics is learned from: dots, and lips found in pictures."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.arrays import FloatArray
from abs_engine.face.shape.modal import LearnedPhysics, learn


@dataclass(frozen=True, eq=False)
class Source:
    """Frames of one recording, in the order of time.

    Parameters
    ----------
    displacements : (T, N, 3) float64, mm
        Of the shell from the person's own rest: the means of their posteriors.
    spread : (R, N, 3) float64, mm
        The mean covariance of these posteriors, as displacements whose outer products add up to
        it; none where they are exact.
    """

    displacements: FloatArray
    spread: FloatArray = field(default_factory=lambda: np.zeros((0, 0, 3)))

    def __len__(self) -> int:
        """Return the number of frames, T."""
        return len(self.displacements)

    def without(self, frames: NDArray[np.integer]) -> Source:
        """The same with some frames left out."""
        return Source(np.delete(self.displacements, frames, axis=0), self.spread)


def learn_sources(rest: FloatArray, sources: Sequence[Source], modes: int) -> LearnedPhysics:
    """Physics of all sources, of a frame or more each, together, each of which counts the same.

    `rest` (N, 3), mm, are the points at rest.

    A recording's frames are much alike, so that how many there are of them says little about how
    much was seen; a clip of two seconds may be all that there is of a posture. Errors are those of
    `modal.learn`.
    """
    weights = np.concatenate([np.full(len(s), 1 / len(s)) for s in sources])
    spreads = [s.spread.reshape(-1, *np.shape(rest)) / np.sqrt(len(sources)) for s in sources]
    moved = np.concatenate([s.displacements for s in sources])
    return learn(rest, moved, modes, weights=weights, spread=np.concatenate(spreads))


def balanced(sources: Sequence[Source]) -> FloatArray:
    """Displacements (K, N, 3), mm, of all sources, those of short ones repeated.

    As many of each as there are of the longest, or nearly.
    """
    longest = max(len(s) for s in sources)
    return np.concatenate(
        [np.tile(s.displacements, (round(longest / len(s)), 1, 1)) for s in sources]
    )
