"""Points by what they say of all parameters, what the other frames foretell, white noise."""

from __future__ import annotations

from dataclasses import replace

import appearances
import numpy as np
import pytest
import shapes

from abs_engine.core.errors import ParameterError
from abs_engine.core.pose import PoseFrame, mode_block, pose_and
from abs_engine.face.appearance.information import choose_informative, information
from abs_engine.face.appearance.local import LocalModel
from abs_engine.face.appearance.local_learning import learn_local, own_share
from abs_engine.face.appearance.regression import Frames, LinearFits
from abs_engine.face.penalty import ImprobablePenalty
from abs_engine.face.settings.appearance import APPEARANCE
from abs_engine.render.cpu import CpuRenderer

RENDERER = CpuRenderer()
N = appearances.N_MODES
SCALE = pose_and(mode_block(N, 3.5)).spec.scale


def test_what_is_left_out_is_what_the_other_frames_foretell():
    rng = np.random.default_rng(0)
    count, ridge = 12, 1.0
    rows = rng.normal(size=(count, 2))
    values = rng.normal(size=(count, 3, 2)).astype(np.float32)
    seen = rng.random((count, 3)) < 0.9
    found = Frames(values, seen, rows).left_out(ridge)
    for t in range(count):
        fits = LinearFits(3, 2, 2)
        for k in np.delete(np.arange(count), t):
            fits.add(values[k].astype(float), seen[k].astype(float), rows[k])
        fit = fits.solve(ridge)
        foretold = fit.base + np.tensordot(rows[t], fit.modes, 1)
        expected = np.where(seen[t][:, None], values[t] - foretold, 0)
        np.testing.assert_allclose(found[t], expected, atol=1e-6)


def test_one_frame_alone_is_no_error():
    one = Frames(np.ones((1, 2, 1), np.float32), np.ones((1, 2), np.bool_), np.zeros((1, 0)))
    np.testing.assert_allclose(one.left_out(1.0), 0, atol=1e-6)


def model_of(left_out):
    count = left_out.shape[1]
    ones = np.ones((count, 8))
    spread = np.sqrt((left_out**2).mean(axis=0))
    return LocalModel(
        np.arange(count), ones, np.zeros((2, count, 8)), ones, np.ones(count), spread,
        left_out.astype(np.float32), np.ones(count), np.ones(count), np.ones(2), 0.5,
    )  # fmt: skip


def test_noise_that_points_have_in_common_counts_once():
    rng = np.random.default_rng(1)
    common = rng.normal(size=(4000, 1, 1))
    noise = 3 * common + 0.5 * rng.normal(size=(4000, 2, 8))
    model = model_of(noise)
    rows = (noise * model.inverse).reshape(len(noise), -1)
    alike, against = np.ones(16), np.r_[np.ones(8), -np.ones(8)]
    white = np.linalg.norm(model.whitener @ np.column_stack([alike, against]), axis=0)
    assert white[0] < 0.3 * white[1]
    shares = np.var(rows @ model.whitener.T, axis=0)
    assert shares.sum() / 16 < 1.1
    assert model.only(np.array([1])).whitener.shape == (8, 8)


def hidden_noise(rng, count, hidden, parameters=2):
    """Noise of 12 points that have none in common, the first half of which some frames hide."""
    noise = rng.normal(size=(count, 12, 8))
    seen = rng.random((count, 12)) >= np.where(np.arange(12) < 6, hidden, 0.0)
    return noise, seen, rng.normal(size=(count, parameters))


def test_points_that_frames_hide_are_as_white_as_others():
    rng = np.random.default_rng(5)
    noise, seen, _ = hidden_noise(rng, 3000, 0.4)
    left_out = noise * seen[..., None]
    spread = np.sqrt((left_out**2).sum(axis=0) / seen.sum(axis=0)[:, None])
    model = replace(model_of(left_out), spread=spread, seen=seen.mean(axis=0))
    shown = rng.normal(size=(3000, 12, 8)) * model.inverse
    white = ((shown.reshape(3000, -1) @ model.whitener.T) ** 2).mean(axis=0).reshape(12, 8)
    np.testing.assert_allclose(white.mean(axis=1), 1, atol=0.1)


def test_hidden_points_do_not_look_as_if_their_noise_were_shared():
    rng = np.random.default_rng(0)
    noise, seen, rows = hidden_noise(rng, 80, 0.4)
    values = (noise * seen[..., None]).astype(np.float32)
    frames = Frames(values, seen, rows, np.arange(80) // 10)
    assert own_share(frames, 1.0) == 1.0


def test_each_frame_is_a_recording_of_its_own_where_none_are_known():
    rng = np.random.default_rng(6)
    shared = np.einsum("tf,fnc->tnc", rng.normal(size=(40, 2)), rng.normal(size=(2, 12, 8)))
    noise, seen, rows = hidden_noise(rng, 40, 0.0)
    frames = Frames((noise + shared).astype(np.float32), seen, rows)
    alone = own_share(frames, 1.0)
    assert alone == own_share(replace(frames, recordings=np.arange(40)), 1.0)
    assert APPEARANCE.alone_tried[0] < alone < 1.0


@pytest.fixture(scope="module")
def ball():
    scene, camera = appearances.varying_ball(), shapes.view(appearances.PIXELS)[0]
    front = np.flatnonzero(scene.mean[:, 2] > 0.4 * shapes.RADIUS)
    frames = appearances.sightings(scene, camera, 25)
    return scene, camera, frames, learn_local(frames, scene, front, camera, RENDERER)


def moved(sighting):
    here = np.r_[np.zeros(6), sighting.parameters]
    rows = np.vstack([here, here + np.diag(SCALE)])
    return PoseFrame(sighting.pose, np.zeros(3)).candidates(rows)


def test_points_determine_all_parameters_together(ball):
    scene, camera, frames, model = ball
    known = information(model, frames, scene, camera, RENDERER, moved)
    assert known.shape == (len(model), 6 + N, 6 + N)
    np.testing.assert_allclose(known, known.transpose(0, 2, 1), atol=1e-9 * known.max())
    about, places = np.full(6 + N, 1e-3), scene.mean[model.vertices].astype(float)
    chosen = choose_informative(model, known, about, 12, places, 6.0)
    assert len(set(chosen)) == 12
    apart = np.linalg.norm(places[chosen][:, None] - places[chosen], axis=2)
    assert apart[~np.eye(12, dtype=bool)].min() >= 6

    def volume(which):
        return np.linalg.slogdet(np.diag(about) + known[which].sum(axis=0))[1]

    rng = np.random.default_rng(2)
    others = [volume(rng.choice(len(model), 12, replace=False)) for _ in range(50)]
    assert volume(chosen) > max(others)
    with pytest.raises(ParameterError, match="no frames"):
        information(model, [], scene, camera, RENDERER, moved)


def test_the_improbable_is_a_gaussian_then_exponential():
    rng = np.random.default_rng(3)
    corpus = rng.normal(size=(400, 3)) * [1, 2, 0.5] + [0, 1, 0]
    penalty = replace(ImprobablePenalty.of_corpus(corpus), strength=0.1)
    assert penalty(corpus.mean(axis=0)) == pytest.approx(0, abs=1e-9)
    assert 0.08 < penalty(corpus).mean() < 0.14  # the distance is 1 on average
    far = corpus.mean(axis=0) + np.array([[4.0, 8, 2], [40.0, 80, 20], [1e6, 0, 0]])
    values = penalty(far)
    assert values[0] > 2 * 0.1 * 16 * 0.8
    assert np.isfinite(values).all()
    assert values[2] > values[1] > values[0] or values[1] == values[2]
    with pytest.raises(ParameterError, match="no spread"):
        ImprobablePenalty.of_corpus(corpus[:1])
    with pytest.raises(ParameterError, match="do not fit"):
        ImprobablePenalty(np.zeros(2), np.eye(3))
    with pytest.raises(ParameterError, match="not finite"):
        ImprobablePenalty(np.full(2, np.nan), np.eye(2))
    with pytest.raises(ParameterError, match="not positive"):
        ImprobablePenalty(np.zeros(2), np.eye(2), strength=0)


def test_roots_square_to_the_penalty():
    penalty = ImprobablePenalty(np.ones(3), np.eye(3))
    rows = np.random.default_rng(4).normal(0, 2, (20, 3))
    np.testing.assert_allclose((penalty.roots(rows) ** 2).sum(axis=1), penalty(rows))
    assert penalty.size == 3
