"""Further training (section 6.1): shapes found in raw video extend what the lips can do."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from abs_engine.core.arrays import FloatArray
from abs_engine.core.scene import Renderer
from abs_engine.dataset.view import Truth
from abs_engine.face.shape.modal import LearnedPhysics
from abs_engine.fit.shell import shell_colours
from abs_engine.fit.shell_relaxation import Seen
from abs_engine.learn.further import LipClip, train_further
from abs_engine.papers.basu1998.experiment import TrainedLips
from abs_engine.papers.basu1998.single_frames import typical_shapes


def lip_clip(lips: TrainedLips, views: Sequence[Truth], renderer: Renderer) -> LipClip:
    """A clip that several cameras filmed at once, the head's poses known.

    Nothing else is given: the lips start from shapes of the dots.
    """
    settings = [lips.setting(view.camera, renderer) for view in views]
    moments = []
    for frame, pictures in enumerate(zip(*(v.pictures() for v in views), strict=True)):
        seen = []
        for setting, view, picture in zip(settings, views, pictures, strict=True):
            pose = view.pose(frame)
            seen.append(Seen(replace(shell_colours(setting, picture, pose), pull=None), pose))
        moments.append(tuple(seen))
    at_rest = np.zeros((len(moments), len(lips.model.shell), 3))
    return LipClip(lips.model, tuple(moments), at_rest)


def with_sample_variances(lips: TrainedLips) -> TrainedLips:
    """The same lips with the variances of the dots' own frames, as section 4.2 has them."""
    physics = replace(lips.model.physics, motion_variances=np.zeros(0))
    return _moving_by(lips, physics, lips.training.displacements)


def _moving_by(
    lips: TrainedLips, physics: LearnedPhysics, displacements: FloatArray
) -> TrainedLips:
    """The same lips with other physics, and the displacements (K, N, 3) it was learned from."""
    return replace(
        lips,
        model=replace(lips.model, physics=physics),
        starts=typical_shapes(physics, displacements),
        training=replace(lips.training, physics=physics, displacements=displacements),
    )


def further_trained(
    lips: TrainedLips, clips: Sequence[LipClip]
) -> tuple[TrainedLips, tuple[float, ...]]:
    """The same lips, learned from the dots' frames and from clips together.

    And -log probability of a moment that was left out of the clips, before and after each round.
    """
    done = train_further(lips.training, clips)
    return _moving_by(lips, done.physics, done.displacements), done.evidence
