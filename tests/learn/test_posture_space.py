"""A speaker's own postures: guided components of what was tracked."""

from __future__ import annotations

import numpy as np
import pytest

from abs_engine.core.errors import TooFewFramesError
from abs_engine.core.params import ParamSpec
from abs_engine.face.head import build_mouth_model
from abs_engine.io.assets import load_speaker
from abs_engine.learn.choice import choose_points
from abs_engine.learn.posture_space import PostureSpace, learn_postures


@pytest.fixture(scope="module")
def expression():
    speaker = load_speaker()
    texture = speaker.texture(next(iter(speaker.people)))
    return build_mouth_model(speaker, speaker.vertices, texture, free_person=False).expression


@pytest.fixture(scope="module")
def postures(expression):
    """Two clips that move slowly in two ways, with some noise in every mode."""
    rng, time = np.random.default_rng(0), np.arange(120)[:, None]
    moved = np.zeros((len(expression.modes), 2))
    moved[0, 0] = moved[1, 1] = 1.0
    smooth = np.sin(time * [0.3, 0.17] + [0, 1]) @ moved.T
    return [smooth + rng.normal(0, 0.02, smooth.shape), -smooth + rng.normal(0, 0.02, smooth.shape)]


def test_what_moves_is_kept_and_noise_is_named(expression, postures):
    space = learn_postures(expression, choose_points(load_speaker()), postures)
    assert space.spec.names[:2] == ("jaw1", "lips1")
    assert len(space.spec) < len(space.noise)
    assert {*space.spec.names, *space.left_out} == set(space.noise)
    assert all(space.noise[name] >= 0.5 for name in space.left_out)
    assert space.expression.modes.shape == (len(space.spec), *expression.mean.shape)


def test_fast_speech_is_no_noise(expression, postures):
    """A mouth that opens and shuts in two frames, and rests in between."""
    time = np.arange(120)
    fast = np.zeros((120, len(expression.modes)))
    fast[:, 0] = 3.0 * ((time % 4 == 1) & (time % 20 < 12))
    clips = [clip + fast for clip in postures]
    space = learn_postures(expression, choose_points(load_speaker()), clips)
    assert space.noise["jaw1"] < 0.1
    assert space.left_out


def test_anybodys_postures_stay_as_they_are(expression, postures):
    spec = ParamSpec(
        tuple(f"m{k}" for k in range(len(expression.modes))), ("sd",) * len(expression.modes),
        *(np.full(len(expression.modes), v) for v in (0.1, -3.0, 3.0)),
    )  # fmt: skip
    space = PostureSpace.of_anybody(expression, spec, np.ones(len(spec)))
    assert not space.own
    assert not space.left_out
    np.testing.assert_array_equal(space.parameters(postures[0]), postures[0])


def test_postures_are_those_that_were_tracked(expression, postures):
    """What the components leave of the head's movement is about the noise that was added."""
    space = learn_postures(expression, choose_points(load_speaker()), postures)
    every = np.concatenate(postures)
    count = len(space.seen)
    tracked = expression.mean + np.tensordot(every[:count], expression.modes, 1)
    own = space.expression.mean + np.tensordot(space.seen, space.expression.modes, 1)
    lips = load_speaker().points["lips"]
    error = np.sqrt(((own - tracked)[:, lips] ** 2).sum(axis=2).mean())
    spread = np.sqrt((tracked - tracked.mean(axis=0))[:, lips].var(axis=0).sum(axis=1).mean())
    assert error < 0.1 * spread


def test_generators_have_the_same_weights_by_either_modes(expression, postures):
    """Of a speaker whose mouth is more open than anybody's on average."""
    opened = [clip + np.eye(len(expression.modes))[0] for clip in postures]
    space = learn_postures(expression, choose_points(load_speaker()), opened)
    tracked = np.concatenate(opened)[: len(space.seen)]
    wanted = expression.offset + tracked @ expression.mixing
    found = space.expression.offset + space.seen @ space.expression.mixing
    spread = np.sqrt((wanted - wanted.mean(axis=0)).var(axis=0).sum())
    assert np.sqrt(((found - wanted) ** 2).sum(axis=1).mean()) < 0.2 * spread


def test_frames_that_are_not_to_be_learned_from_do_not_count(expression, postures):
    gaps = [np.where(np.arange(120)[:, None] % 10 < 9, clip, np.nan) for clip in postures]
    space = learn_postures(expression, choose_points(load_speaker()), gaps)
    assert np.isfinite(space.expression.modes).all()
    assert np.isfinite(space.steps).all()
    assert len(space.seen) == 216


def test_steps_are_of_40_ms_at_any_frame_rate(expression):
    """Of speech, which is smooth: in half the time it goes half as far."""

    def said(rate: float) -> np.ndarray:
        time = np.arange(round(8 * rate))[:, None] / rate
        moved = np.zeros((2, len(expression.modes)))
        moved[0, 0] = moved[1, 1] = 1.0
        smooth = np.sin(time * [11.0, 7.0] + [0, 1]) @ moved
        return smooth + np.random.default_rng(0).normal(0, 0.02, smooth.shape)

    def steps(*rates: float) -> np.ndarray:
        clips, points = [said(rate) for rate in rates], choose_points(load_speaker())
        return learn_postures(expression, points, clips, rates).steps[:2]

    usual = steps(25.0)
    for rates in ((50.0,), (100.0,), (25.0, 50.0), (50.0, 25.0)):
        np.testing.assert_allclose(steps(*rates), usual, rtol=0.03)
    space = learn_postures(expression, choose_points(load_speaker()), [said(25.0)])
    np.testing.assert_array_equal(space.steps[:2], usual)
    alone = np.where(np.arange(200)[:, None] % 2, np.nan, said(25.0))
    twice = [alone, alone]
    assert np.isnan(learn_postures(expression, choose_points(load_speaker()), twice).steps).all()


def test_a_frame_rate_just_above_25_is_no_longer_step(expression):
    """Of a random walk, which goes as far in the same time at any rate."""

    def steps(rate: float) -> np.ndarray:
        rng, ways = np.random.default_rng(1), np.zeros((2, len(expression.modes)))
        ways[0, 0] = ways[1, 1] = 1.0
        walk = np.cumsum(rng.normal(0, 0.3 / np.sqrt(rate), (1500, 2)), axis=0) @ ways
        walk += rng.normal(0, 0.001, walk.shape)
        found = learn_postures(expression, choose_points(load_speaker()), [walk], [rate])
        return found.steps[:1] * walk[:, 0].std()  # of the walk, not of what it comes to

    np.testing.assert_allclose(steps(30.0), steps(25.0), rtol=0.04)


def test_too_few_frames_are_refused(expression, postures):
    with pytest.raises(TooFewFramesError, match="30 frames show the mouth well"):
        learn_postures(expression, choose_points(load_speaker()), [postures[0][:30]])
