"""Learned physics moves the whole head as it moves the shell."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from abs_engine.core.errors import ModelFormatError
from abs_engine.face.shape.physics_head import physics_shape
from abs_engine.io.assets import load_speaker
from abs_engine.learn.training import Training, train
from abs_engine.papers.basu1998.motion import authored_motion, observed_motion
from abs_engine.tracking.start.blob_start import mouth_model

SPEAKER = load_speaker()


@pytest.fixture(scope="module")
def trained() -> Training:
    dots = observed_motion(SPEAKER, authored_motion(SPEAKER, "clara"))
    return train(dots, SPEAKER, "clara")


def test_lips_go_where_the_shell_goes(trained):
    shape = physics_shape(SPEAKER, SPEAKER.named("clara"), trained.shell, trained.physics)
    moved = np.linalg.norm(shape.modes, axis=2).max()
    assert moved > 3
    lips = np.unique(trained.shell.faces[trained.shell.lip])
    modes = trained.physics.deviations[:, None, None] * trained.physics.modes
    missed = (trained.shell.nodes(shape.modes) - modes)[:, lips]
    assert np.sqrt((missed**2).sum(axis=(0, 2)).mean()) < 0.4
    at = trained.shell.nodes(shape.mean) - trained.physics.rest
    error = (at - trained.physics.mean)[lips]
    assert np.sqrt((error**2).sum(axis=1).mean()) < 0.8


def test_chin_and_cheeks_follow_and_the_skull_stays(trained):
    shape = physics_shape(SPEAKER, SPEAKER.named("clara"), trained.shell, trained.physics)
    moved = np.linalg.norm(shape.modes, axis=2).max(axis=0)
    top = SPEAKER.vertices[:, 1].argmax()
    assert moved[top] < 0.1
    assert moved[SPEAKER.landmarks["chin"]].max() > 3


def test_a_tracker_takes_it_from_a_file(trained, tmp_path):
    trained.physics.save(tmp_path / "lips.npz")
    model = mouth_model(SPEAKER, "clara", tmp_path / "lips.npz")
    assert model.n_expression == 10
    other = replace(trained.physics, speaker="0" * 16)
    other.save(tmp_path / "other.npz")
    with pytest.raises(ModelFormatError):
        mouth_model(SPEAKER, "clara", tmp_path / "other.npz")
