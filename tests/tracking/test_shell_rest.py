"""The head that a shell of lips is cut from: at rest, whatever posture it was fitted in."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np

from abs_engine.face.shape.lip_shell import cut_lip_shell
from abs_engine.face.shape.modal import load_physics
from abs_engine.face.shape.physics_head import physics_shape
from abs_engine.io.assets import load_speaker, shipped
from abs_engine.tracking.shells import BUNDLED, head_at_rest

SPEAKER = load_speaker()


def head(mean, rest=None):
    return SimpleNamespace(body=SimpleNamespace(mean=mean, rest=rest))


def test_a_head_in_the_average_posture_of_speech_is_not_at_rest():
    rest = SPEAKER.vertices.astype(np.float32)
    assert head_at_rest(SPEAKER, head(rest + 1, rest)) is rest
    assert head_at_rest(SPEAKER, head(rest)) is rest  # it does not say


def test_a_head_in_the_mean_posture_of_learned_lips_is_at_rest_without_it():
    rest, physics = SPEAKER.vertices.astype(np.float32), load_physics(shipped(BUNDLED))
    shell = cut_lip_shell(SPEAKER)
    mean = rest + physics_shape(SPEAKER, np.zeros_like(rest), shell, physics).mean
    assert np.abs(mean - rest).max() > 0.5
    np.testing.assert_allclose(
        head_at_rest(SPEAKER, head(mean, rest + 9), physics), rest, atol=1e-4
    )
