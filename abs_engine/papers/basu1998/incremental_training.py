"""Further training (section 6.1): shapes found in raw video extend what the lips can do."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.errors import InputFileError
from abs_engine.core.scene import Renderer
from abs_engine.dataset.view import Truth
from abs_engine.face.shape.modal import learn
from abs_engine.fit.shell import shell_problem
from abs_engine.fit.shell_relaxation import Settled, settle, softness
from abs_engine.io.assets import Speaker
from abs_engine.papers.basu1998.experiment import TrainedLips, poses_of
from abs_engine.papers.basu1998.motion import (
    UNROUNDED,
    Motion,
    authored_motion,
    recorded_motion,
    recording_path,
)
from abs_engine.papers.basu1998.single_frames import colours_of, fit_frames, typical_shapes
from abs_engine.tracking.external_poses import GivenMotion

FloatArray = NDArray[np.float64]
STRAINED = 0.4
"""mm by which nodes typically leave the modal shape: about what least strain misses of it."""


def further_motion(speaker: Speaker, person: str) -> Motion:
    """Five seconds that leave much to be learned: the recording, or speech without rounding."""
    try:
        return recorded_motion(speaker, person, recording_path())
    except InputFileError:
        return authored_motion(speaker, person, sentences=UNROUNDED)


def settled_shapes(
    lips: TrainedLips, view: Truth, renderer: Renderer, driver: str = "simplex"
) -> Iterator[Settled]:
    """Modal fits of a clip's frames, each then relaxed to the full-rank shell; pose known.

    Frames in which no mouth is found are left out.
    """
    setting = lips.setting(view.camera, renderer)
    elastic = lips.model.shell.elastic_at(lips.model.physics.rest)
    soft = softness(elastic, STRAINED)
    pictures, motion = list(view.pictures()), GivenMotion(poses_of(view))
    for fit in fit_frames(setting, pictures, motion, lips.starts, driver):
        pose = view.pose(fit.frame)
        colours = colours_of(shell_problem(setting, pictures[fit.frame], pose))
        yield settle(setting.model, colours, fit.weights, pose, elastic, soft)


def further_trained(lips: TrainedLips, shapes: list[Settled]) -> TrainedLips:
    """The same lips, learned from the dots' frames and from settled shapes together."""
    old = lips.model.physics
    seen = np.stack([s.nodes for s in shapes]) - old.rest
    displacements = np.concatenate([lips.training.displacements, seen])
    new = learn(old.rest, displacements, len(old.modes))
    # How much of each old mode is in a new one tells its share of the errors of observation
    shared = (new.matrix.T @ old.matrix) ** 2
    noise = shared @ old.noise_variances if len(old.noise_variances) else old.noise_variances
    told = f"{old.source}; and {len(shapes)} shapes found in video"
    physics = replace(
        new, noise=old.noise, person=old.person, speaker=old.speaker, source=told,
        noise_variances=noise,
    )  # fmt: skip
    return replace(
        lips,
        model=replace(lips.model, physics=physics),
        starts=typical_shapes(physics, displacements),
        training=replace(lips.training, physics=physics, displacements=displacements),
    )
