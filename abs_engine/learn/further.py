"""Further training (section 6.1): lips found in pictures without dots extend what lips can do.

The shell is relaxed on each moment of the clips, physics is learned again from the dots and what
was found, and that once more with the new physics, which reaches what the first did not. This is
expectation and maximisation for the modal covariance: a shape counts with its posterior covariance,
so that what a camera cannot see keeps the variance that it had. What was learned is kept only if it
explains moments better that were left out.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from abs_engine.core.arrays import FloatArray, evenly
from abs_engine.face.shape.lip_model import LipModel
from abs_engine.face.shape.modal import LearnedPhysics
from abs_engine.fit.shell_relaxation import Seen, Settled, relaxed, settle, softness
from abs_engine.learn.held_out import held_out_variances
from abs_engine.learn.settings import LEARNING
from abs_engine.learn.sources import Source, balanced, learn_sources
from abs_engine.learn.training import Training


@dataclass(frozen=True, eq=False)
class LipClip:
    """Lips of a person filmed without dots.

    Parameters
    ----------
    model : LipModel
        Of the person, at rest where the person's lips are at rest.
    moments : tuple of tuple of Seen
        In the order of time; each is what one camera or more saw at once.
    tracked : (T, N, 3) float64, mm
        Displacements that were found before, of each moment; 0 where there are none.
    """

    model: LipModel
    moments: tuple[tuple[Seen, ...], ...]
    tracked: FloatArray

    @property
    def learned(self) -> int:
        """Number of moments that are learned from; the others are left out, one at least."""
        return min(len(self.moments) - 1, round((1 - LEARNING.left_out) * len(self.moments)))

    def relaxed(self, physics: LearnedPhysics, shapes: FloatArray) -> Source:
        """Shapes of the moments learned from, the shell relaxed from shapes (K, N, 3), mm."""
        elastic = self.model.shell.elastic_at(self.model.physics.rest)
        free = relaxed(
            self._own(physics), elastic, softness(elastic, LEARNING.strained), LEARNING.free_modes
        )
        found = self._settled(free, shapes, range(self.learned))
        size, axes = np.linalg.eigh(np.mean([f.covariance for f in found], axis=0))
        scaled = free.modes * free.deviations[:, None, None]
        spread = np.tensordot((axes * np.sqrt(np.maximum(size, 0.0))).T, scaled, 1)
        return Source(np.array([f.moved for f in found]), spread)

    def evidence(self, physics: LearnedPhysics, shapes: FloatArray) -> FloatArray:
        """-log probability of the pictures of each moment left out, nats, by a physics' modes."""
        left_out = range(self.learned, len(self.moments))
        own = self._settled(self._own(physics), shapes, left_out)
        return np.array([one.evidence for one in own])

    def _own(self, physics: LearnedPhysics) -> LearnedPhysics:
        return replace(physics, rest=self.model.physics.rest)

    def _settled(
        self, physics: LearnedPhysics, shapes: FloatArray, moments: range
    ) -> list[Settled]:
        """Fits of some moments, each also from where the one before ended."""
        model, found = replace(self.model, physics=physics), list[Settled]()
        common = self._weights(physics, shapes)
        for k in moments:
            own = self._weights(physics, self.tracked[k : k + 1])
            last = [one.weights[None] for one in found[-1:]]
            starts = np.concatenate([np.zeros_like(common[:1]), common, own, *last])
            found.append(settle(model, self.moments[k], starts))
        return found

    def _weights(self, physics: LearnedPhysics, moved: FloatArray) -> FloatArray:
        """Weights (K, P), in standard deviations, of displacements (K, N, 3), mm."""
        return np.asarray(physics.coefficients(physics.rest + moved) / physics.deviations)


@dataclass(frozen=True, eq=False)
class Further:
    """Physics after further training.

    Parameters
    ----------
    physics : LearnedPhysics
        The kept one.
    sources : tuple of Source
        What it was learned from, the dots first.
    evidence : tuple of float
        -log probability of a moment that was left out, nats, before and after each round.
    """

    physics: LearnedPhysics
    sources: tuple[Source, ...]
    evidence: tuple[float, ...]

    @property
    def kept(self) -> int:
        """The round whose physics is kept; 0 for what the dots alone gave."""
        return int(np.argmin(self.evidence))

    @property
    def displacements(self) -> FloatArray:
        """Those that were learned from, (K, N, 3), mm, as many of each source."""
        return balanced(self.sources)


def train_further(
    training: Training,
    clips: Sequence[LipClip],
    rounds: int = LEARNING.further_rounds,
    tell: Callable[[str], None] = lambda _: None,
) -> Further:
    """Learn from clips without dots, too; `tell` is called with what is begun, in a few words.

    The clips, of two moments or more each, are of the same person as the training or of others:
    what is pooled are displacements from each one's rest.
    """
    dots = Source(training.displacements)
    physics, sources = training.physics, tuple[Source, ...]((dots,))
    made = [(physics, sources)]
    evidence = [_explained(physics, sources, clips)]
    for number in range(1, rounds + 1):
        tell(f"relaxing the lips of {sum(c.learned for c in clips)} moments, round {number}")
        shapes = _some_of(sources)
        sources = (dots, *(clip.relaxed(physics, shapes) for clip in clips))
        physics = _learned(training.physics, sources)
        evidence.append(_explained(physics, sources, clips))
        made.append((physics, sources))
    return Further(*made[int(np.argmin(evidence))], tuple(evidence))


def _explained(
    physics: LearnedPhysics, sources: Sequence[Source], clips: Sequence[LipClip]
) -> float:
    """-log probability of a moment that was left out, nats, mean over all clips' moments."""
    shapes = _some_of(sources)
    return float(np.mean(np.concatenate([clip.evidence(physics, shapes) for clip in clips])))


def _some_of(sources: Sequence[Source]) -> FloatArray:
    """A few of the sources' displacements, evenly spread over time."""
    every = balanced(sources)
    return np.asarray(every[evenly(len(every), LEARNING.starts)])


def _learned(old: LearnedPhysics, sources: Sequence[Source]) -> LearnedPhysics:
    """Physics of all sources, the dots' first; `old` is what the dots alone gave."""
    new = learn_sources(old.rest, sources, len(old.modes))
    # How much of each old mode is in a new one is its share of the errors of observation
    shared = (new.matrix.T @ old.matrix) ** 2 / len(sources)
    count = sum(len(s) for s in sources[1:])
    return replace(
        new, noise=old.noise, person=old.person, speaker=old.speaker,
        source=f"{old.source}; and {count} shapes found in video",
        noise_variances=shared @ old.noise_variances,
        motion_variances=held_out_variances(old.rest, sources, new.variances),
    )  # fmt: skip
