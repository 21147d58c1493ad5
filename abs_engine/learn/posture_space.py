"""A speaker's own postures: guided components of what was tracked, in place of anybody's.

Odisio and Bailly (2003), section 2.2, on tracked postures in place of visemes measured by beads.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from abs_engine.core.arrays import FloatArray, evenly
from abs_engine.core.errors import TooFewFramesError
from abs_engine.core.params import ParamSpec
from abs_engine.core.settings import GENERAL
from abs_engine.face.shape.articulatory import GuidedPCA
from abs_engine.face.shape.linear import LinearShape
from abs_engine.face.shape.predictors import PAPER_PREDICTORS, Predictor
from abs_engine.learn.choice import Points
from abs_engine.learn.settings import LEARNING

PREDICTORS = (
    *PAPER_PREDICTORS,
    Predictor("lips5", ("lips",), "xyz", "+y"),
    Predictor("lips6", ("lips",), "xyz", "+y"),
)
"""The paper's, and what they leave of lips: as far as a closed mouth may be off by a tenth of a
millimetre without."""

_USUAL_RATE = 25.0  # frames per second: 40 ms


@dataclass(frozen=True, eq=False)
class PostureSpace:
    """Posture space of one speaker's mouth.

    Parameters
    ----------
    expression : LinearShape
        Of the whole head; its P modes are the components, for one standard deviation.
    spec : ParamSpec
        Their names and bounds.
    steps : (P,) float64
        How far each moves in 40 ms, standard deviations; NaN where no two frames say so.
    seen : (K, P) float64
        Postures of the frames that were learned from, evenly thinned out.
    noise : dict of str to float
        Share of each component's variance that is noise, those left out among them; of anybody's
        modes none.
    centre : (M,) float64
        Posture of anybody's modes at which its parameters are 0.
    back : (M, P) float64
        What parameters are of postures less that, as nearly as can be.
    """

    expression: LinearShape
    spec: ParamSpec
    steps: FloatArray
    seen: FloatArray
    noise: dict[str, float]
    centre: FloatArray
    back: FloatArray

    @classmethod
    def of_anybody(
        cls, expression: LinearShape, spec: ParamSpec, steps: FloatArray
    ) -> PostureSpace:
        """Anybody's modes as they are, in place of a speaker's own."""
        count = len(spec)
        unseen, centre = np.zeros((0, count)), np.zeros(count)
        return cls(expression, spec, steps, unseen, {}, centre, np.eye(count))

    @property
    def own(self) -> bool:
        """Whether they are a speaker's."""
        return bool(self.noise)

    def parameters(self, postures: FloatArray) -> FloatArray:
        """Parameters (..., P) of postures (..., M) of anybody's modes."""
        return np.asarray((postures - self.centre) @ self.back, np.float64)

    @property
    def left_out(self) -> tuple[str, ...]:
        """Names of the components that are below the noise."""
        return tuple(name for name in self.noise if name not in self.spec.names)


def learn_postures(
    expression: LinearShape,
    chosen: Points,
    clips: Sequence[FloatArray],
    rates: Sequence[float] | None = None,
) -> PostureSpace:
    """Guided components of tracked postures.

    A component's noise is how far it jumps from frame to frame and back while the mouth hardly
    moves: the second difference of white noise has six times its variance.

    Parameters
    ----------
    expression : LinearShape
        M modes, of anybody.
    chosen : Points
        Which vertices guide the components.
    clips : sequence of (T, M) float64
        Postures of each recording; NaN in frames that are not to be learned from.
    rates : sequence of float, optional
        Frames per second of each recording; by default 25.

    Raises
    ------
    TooFewFramesError
        If there are fewer than `LEARNING.least_frames`.
    """
    postures, at = _well_seen(clips), chosen.vertices
    modes = expression.modes[:, at].astype(np.float64)
    points = expression.mean[at].astype(np.float64) + np.tensordot(postures, modes, 1)
    guided = GuidedPCA(chosen.names, chosen.groups, PREDICTORS).fit(points)
    names, centre, scores = guided.model_.parameters, postures.mean(axis=0), guided.scores_
    own = scores.T @ (postures - centre) / (len(scores) - 1)  # (P, M): scores are uncorrelated
    back = np.linalg.lstsq(postures - centre, scores, rcond=None)[0]
    tracked = [(clip - centre) @ back for clip in clips]
    noise = _noise(clips, tracked, modes)
    kept = np.flatnonzero(noise < LEARNING.most_noise)
    spec = ParamSpec(
        names, ("sd",) * len(names), np.full(len(names), GENERAL.mode_step),
        scores.min(axis=0) - LEARNING.beyond, scores.max(axis=0) + LEARNING.beyond,
    ).only(kept)  # fmt: skip
    steps = LEARNING.sudden * _moved(
        tracked, [_USUAL_RATE] * len(clips) if rates is None else rates
    )
    mixing = own @ expression.mixing
    moved = np.tensordot(centre, expression.modes, 1)
    shape = LinearShape(
        np.asarray(expression.mean + moved, np.float32),
        np.tensordot(own[kept], expression.modes, 1).astype(np.float32),
        mixing[kept], expression.offset + centre @ expression.mixing,
        guided.explained_variance_ratio_[kept],
    )  # fmt: skip
    shares = dict(zip(names, map(float, noise), strict=True))
    seen = scores[evenly(len(scores), LEARNING.most_seen)][:, kept]
    return PostureSpace(shape, spec, steps[kept], seen, shares, centre, back[:, kept])


def _well_seen(clips: Sequence[FloatArray]) -> FloatArray:
    """Postures (N, M) of all frames that are learned from; an error if there are too few."""
    every = np.concatenate(clips)
    postures = every[np.isfinite(every).all(axis=1)]
    if len(postures) < LEARNING.least_frames:
        raise TooFewFramesError(
            f"{len(postures)} frames show the mouth well, postures need {LEARNING.least_frames}",
            "give more recordings, or longer ones",
        )
    return postures


def _moved(tracked: Sequence[FloatArray], rates: Sequence[float]) -> FloatArray:
    """RMS movement (P,) in 40 ms of components (T, P) of clips; NaN where no two frames say so.

    Between the frames that are nearest to 40 ms apart, as speech is smooth; what is left to 40 ms
    counts as in a random walk.
    """
    squares = []
    for clip, rate in zip(tracked, rates, strict=True):
        lag = max(1, round(rate / _USUAL_RATE))
        squares.append((clip[lag:] - clip[:-lag]) ** 2 * (rate / _USUAL_RATE / lag))
    every = np.concatenate(squares)
    every = every[np.isfinite(every).all(axis=1)]
    if len(every) == 0:
        return np.full(every.shape[1], np.nan)
    return np.asarray(np.sqrt(every.mean(axis=0)), np.float64)


def _noise(
    clips: Sequence[FloatArray], tracked: Sequence[FloatArray], modes: FloatArray
) -> FloatArray:
    """Variance (P,) of the noise of components (T, P) of clips (T, M) of modes (M, N, 3).

    Measured where the mouth moves least: in fast speech, or at a low frame rate, the mouth itself
    jumps. It is too small for components that move the mouth much, as the same postures say where
    it rests; but such components are hardly ever noise.
    """
    jumps = np.concatenate([np.diff(clip, 2, axis=0) for clip in tracked])
    steps = [np.tensordot(np.diff(clip, axis=0), modes, 1) for clip in clips]
    far = [(step**2).sum(axis=-1).mean(axis=-1) for step in steps]
    moved = np.concatenate([np.maximum(one[:-1], one[1:]) for one in far])
    seen = np.isfinite(moved)
    if not seen.any():
        return np.zeros(jumps.shape[1])
    count = max(LEARNING.least_resting, round(LEARNING.resting * seen.sum()))
    still = np.argsort(np.where(seen, moved, np.inf), kind="stable")[: min(count, seen.sum())]
    return np.asarray((jumps[still] ** 2).mean(axis=0) / 6, np.float64)
