"""Commands that do less than a reader's do, in tests of how they are called."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from functools import partial
from typing import Any

import distributed
import pytest
from hurried import hurried
from matplotlib.figure import Figure

from abs_engine.clips import worker
from abs_engine.evaluate import bench_clip
from abs_engine.learn import articulatory, further, posture_space
from abs_engine.learn.settings import LEARNING
from abs_engine.report.articulation import report
from abs_engine.report.drawing import smooth
from abs_engine.report.drawing.figure import figure_bytes
from abs_engine.studio import make
from abs_engine.tracking.landmark import rendered_landmarks
from abs_engine.tracking.person import identity_fit
from abs_engine.tracking.settings.landmarks import LANDMARK_EVIDENCE
from abs_engine.tracking.settings.preparation import PREPARATION
from abs_engine.tracking.speaker import speaker_learning

FEW = 4
"""Frames that a speaker's face is learned from."""
FEW_EVALUATIONS = 40
"""Of the simplex over whose mouth it is and where."""
LEARN_SPEAKER = speaker_learning.learn_speaker
FIRST_FIGURE: list[bytes] = []


class Threads(distributed.LocalCluster):
    """Workers in this process, which has loaded and compiled all that they need."""

    def __init__(self, **given: object) -> None:
        super().__init__(**given | {"processes": False})


def learn_once(recordings: Any, renderer: Any, options: Any, _rounds: int, tell: Any) -> Any:
    """A speaker's face after one round."""
    return LEARN_SPEAKER(recordings, renderer, options, 1, tell)


def first_figure(figure: Figure, kind: str = "png") -> bytes:
    """The figure that was asked for first: to draw them is half of the work of `articulate`."""
    FIRST_FIGURE[:] = FIRST_FIGURE or [figure_bytes(figure, kind)]
    return FIRST_FIGURE[0]


@contextmanager
def short() -> Iterator[None]:
    """Few frames are learned from, and what is repeated is done once."""
    learning = replace(LEARNING, least_frames=FEW)
    with hurried(frames=2, rounds=1), pytest.MonkeyPatch.context() as patch:
        for module in (posture_space, speaker_learning):
            patch.setattr(module, "LEARNING", learning)
        preparation = replace(PREPARATION, speaker_most=FEW, speaker_turned=2)
        patch.setattr(speaker_learning, "PREPARATION", preparation)
        patch.setattr(speaker_learning, "learn_speaker", learn_once)
        patch.setattr(further, "train_further", partial(further.train_further, rounds=1))
        level = replace(LANDMARK_EVIDENCE, drawn_pitches=(0.0,))
        patch.setattr(rendered_landmarks, "LANDMARK_EVIDENCE", level)
        patch.setattr(articulatory, "MOST_BUILT", 5)
        patch.setattr(report, "figure_bytes", first_figure)
        patch.setattr(smooth, "FINER", 1)
        joint = replace(identity_fit.PREPARATION, joint_limit=FEW_EVALUATIONS)
        patch.setattr(identity_fit, "PREPARATION", joint)
        patch.setattr(bench_clip, "TURNS", 1)
        patch.setattr(make, "_cores", lambda: 1)  # a second process takes longer to begin
        patch.setattr(distributed, "LocalCluster", Threads)
        patch.setattr(worker, "keep_to_one_core", lambda: None)
        yield
