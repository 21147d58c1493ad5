"""Epsilon(p) as printed, for textures and points; nothing is won by hiding; fits come home."""

from __future__ import annotations

from dataclasses import replace

import appearances
import numpy as np
import pytest
import shapes

from abs_engine.compare.descriptor import texture_error, wrong_match
from abs_engine.compare.points import local_error
from abs_engine.compare.prior import PenaltyPrior
from abs_engine.core.blocks import POSTURE
from abs_engine.core.camera import Window
from abs_engine.core.errors import MeshError, ParameterError, PictureError
from abs_engine.core.geometry import Pose
from abs_engine.core.params import ParamSpec
from abs_engine.core.pose import PoseFrame, mode_block, pose_and
from abs_engine.core.scene import Candidates, Scene
from abs_engine.face.appearance.atlas import fitting_size, lay_atlas
from abs_engine.face.appearance.local_learning import learn_local
from abs_engine.face.appearance.point_selection import choose_points
from abs_engine.face.appearance.region import part
from abs_engine.face.appearance.texture import learn_texture
from abs_engine.face.penalty import ImprobablePenalty
from abs_engine.fit.problem import Problem
from abs_engine.fit.settings import TALKING_FIT
from abs_engine.optimise.by_nlopt import Simplex
from abs_engine.render.cpu import CpuRenderer

RENDERER = CpuRenderer()
N = appearances.N_MODES
AXES = {"x": 0, "y": 1, "z": 2}


@pytest.fixture(scope="module")
def scene():
    return appearances.varying_ball()


@pytest.fixture(scope="module")
def camera():
    return shapes.view(appearances.PIXELS)[0]


@pytest.fixture(scope="module")
def frames(scene, camera):
    return appearances.sightings(scene, camera, 25)


@pytest.fixture(scope="module")
def texture(frames, scene, camera):
    size = fitting_size(scene, camera, Pose.facing(shapes.DISTANCE))
    atlas = lay_atlas(scene, size, RENDERER)
    return learn_texture(frames, scene, atlas, camera, RENDERER)


@pytest.fixture(scope="module")
def local(frames, scene, camera):
    front = np.flatnonzero(scene.mean[:, 2] > 0.5 * shapes.RADIUS)
    every = learn_local(frames, scene, front, camera, RENDERER)
    return every.only(choose_points(every, 40, scene.mean[front], 8.0))


@pytest.fixture(scope="module")
def other(scene, camera):
    """A frame that nothing was learned from."""
    return appearances.sightings(scene, camera, 1, seed=77)[0]


def about(pose: Pose, error, penalty=None) -> Problem:
    """An error over vectors of a rotation, a translation and weights about a pose."""
    blocks, priors = pose_and(mode_block(N, 3.5)), ()
    if penalty is not None:
        priors = (
            PenaltyPrior(penalty, TALKING_FIT.penalty_share * error.unit, blocks.places[POSTURE]),
        )
    frame = PoseFrame(pose, np.zeros(3))
    return Problem(frame, blocks, {"epsilon": error}, priors, unit=error.unit)


def neutral(pose: Pose) -> Candidates:
    """The mean shape at a pose."""
    return Candidates.one(np.zeros(N), pose)


@pytest.fixture(scope="module", params=["tex", "tex all", "la", "la each", "la all"])
def problem(request, texture, local, scene, camera, other):
    """Epsilon of the other frame, at its own pose, with a penalty."""
    plain = replace(scene, texture_modes=None)
    penalty = ImprobablePenalty(np.zeros(N), np.eye(N), strength=1e-4)  # hardly any pull
    given = other.image, camera, camera.whole
    if request.param.startswith("tex"):
        # A mask, as a face is: turned away it shows less, and in the end nothing.
        front, _ = part(plain, (plain.mean[:, 2] > 30)[plain.faces].any(axis=1))
        own = request.param == "tex all"
        start = neutral(other.pose)
        error = texture_error(texture, front, *given, start, RENDERER, whiten=own)
    else:
        whiten = (*request.param.split(), "no")[1]
        error = local_error(local, plain, *given, RENDERER, whiten)
    return about(other.pose, error, penalty)


@pytest.fixture(scope="module")
def truth(other):
    return np.r_[np.zeros(6), other.parameters]


def test_epsilon_of_a_texture_as_printed(texture, scene, camera, other, truth):
    plain = replace(scene, texture_modes=None)
    given = other.image, camera, camera.whole, neutral(other.pose), RENDERER
    problem = about(other.pose, texture_error(texture, plain, *given))
    for x in (truth, np.zeros(6 + N)):
        one = problem.candidates(x[None])
        drawn = RENDERER.draw(texture.dress(plain), one, camera, camera.whole)[0]
        s = drawn.covered
        ours, theirs = drawn.rgb[s].astype(float), other.image[s].astype(float)
        differ = (ours + 1) / (ours + 1).sum(1, keepdims=True)
        differ -= (theirs + 1) / (theirs + 1).sum(1, keepdims=True)
        assert problem(x).value == pytest.approx((differ**2).mean(), rel=1e-4)
        assert problem(x).terms["prior"] == 0


def test_epsilon_of_points_as_printed(local, scene, camera, other, truth):
    plain = replace(scene, texture_modes=None)
    given = other.image, camera, camera.whole, RENDERER
    error, one = local_error(local, plain, *given), Candidates.one(other.parameters, other.pose)
    assert error.differences(one)[1].all()
    points = other.pose.apply(scene.vertices(other.parameters))[local.vertices]
    found = error.maps.at(camera.project(points))
    differ = found - local.at(other.parameters)
    value = about(other.pose, error)(truth).value
    assert value == pytest.approx((differ**2).sum() / (len(local) * 8), rel=1e-4)
    white = about(other.pose, local_error(local, plain, *given, whiten="each"))
    assert white(truth).value == pytest.approx(((differ / local.spread) ** 2).mean(), rel=0.05)


@pytest.mark.parametrize("scale", [0.5, 1.6])
def test_points_at_another_scale_and_in_a_crop(frames, scene, local, camera, other, truth, scale):
    """Whatever the size of the picture, what is compared can be drawn at the model's scale."""
    plain = replace(scene, texture_modes=None)
    model = learn_local(frames, scene, local.vertices, camera, RENDERER, scale=scale)
    window = Window(10.0, 8.5, 76.0, 80.0, scale)
    error = local_error(model, plain, other.image, camera, window, RENDERER)
    values = about(other.pose, error).values(
        np.stack([truth, np.zeros(6 + N), truth + 1.2 * np.eye(6 + N)[7]])
    )
    assert values.argmin() == 0
    assert values[0] < 0.5 * values[1]


def test_a_batch_is_its_single_calls(problem, truth):
    rows = (
        truth
        + np.random.default_rng(3).normal(0, 0.5, (6, 6 + N))
        * np.r_[np.full(3, 0.03), np.full(3, 2.0), np.ones(N)]
    )
    single = [problem(x) for x in rows]
    np.testing.assert_allclose(problem.values(rows), [e.value for e in single], rtol=1e-9)
    for e in single:
        assert e.value == pytest.approx(sum(e.terms.values()))


def test_the_truth_is_better_than_anything_around(problem, truth):
    at_truth = problem(truth).value
    for k, step in enumerate([0.1, 0.1, 0.1, 6, 6, 60] + [1.2] * N):
        for sign in (-1, 1):
            assert problem(truth + sign * step * np.eye(6 + N)[k]).value > at_truth


@pytest.mark.parametrize("axis", ["x", "y"])
def test_turning_away_wins_nothing(problem, truth, axis):
    """Neither from the truth, nor from a wrong start with nothing else to win."""
    angles = np.radians(np.r_[np.arange(-180, -19, 10), np.arange(20, 181, 10)])
    for start in (truth, np.zeros(6 + N)):
        rows = np.repeat(start[None], len(angles), axis=0)
        rows[:, AXES[axis]] += angles
        assert problem.values(rows).min() > problem(start).value


def test_leaving_the_picture_wins_nothing(problem, truth):
    wrong = np.r_[np.zeros(6), np.full(N, 1.5)]
    for start in (truth, wrong):
        rows = np.repeat(start[None], 4, axis=0)
        rows[0, 3], rows[1, 4], rows[2, 5], rows[3, 5] = 900, -900, 4000, -1200
        values = problem.values(rows)
        assert np.isfinite(values).all()
        assert values.min() > problem(start).value


def test_what_hides_is_seen(local, scene, camera, other, truth):
    """A plate before the ball hides half of the points, and costs what wrong ones do."""
    corners = [[-200, -200], [0, -200], [0, 200], [-200, 200]]
    plate = np.column_stack([corners, np.full(4, 150.0)])
    many = len(scene.mean)
    plain = Scene(
        np.concatenate([scene.mean, plate]),
        np.concatenate([scene.modes, np.zeros((N, 4, 3))], axis=1),
        np.concatenate([scene.faces, [[many, many + 1, many + 2], [many, many + 2, many + 3]]]),
        np.concatenate([scene.uv, np.zeros((4, 2))]),
        np.concatenate([scene.facet_class, [1, 1]]),
        scene.texture,
    )
    error = local_error(local, plain, other.image, camera, camera.whole, RENDERER)
    seen = error.differences(Candidates.one(other.parameters, other.pose))[1][0]
    left = scene.mean[local.vertices, 0] < -8
    assert not seen[left].any()
    assert seen[scene.mean[local.vertices, 0] > 8].all()
    free = replace(error, scene=replace(scene, texture_modes=None))
    covered, uncovered = (about(other.pose, one)(truth).value for one in (error, free))
    assert covered > 2 * uncovered


@pytest.mark.parametrize("known_pose", [True, False])
def test_nelder_mead_comes_home(problem, truth, known_pose):
    scale = np.r_[np.full(3, 0.02), [1.0, 1.0, 5.0], np.full(N, 0.7)]
    reach = np.r_[np.full(3, 0.3), [10.0, 10.0, 60.0], np.full(N, 3.0)]
    names = tuple("abcdefghi"[: 6 + N])
    spec = ParamSpec(names, ("sd",) * (6 + N), scale, -reach, reach)
    start = np.zeros(6 + N) if known_pose else np.r_[0.02, -0.02, 0.02, 1, -1, 5, np.zeros(N)]
    found = Simplex(1e-5, 1500).minimise(problem, start, spec)
    assert found.value < problem(start).value
    assert np.abs(found.x - truth)[6:].max() < 0.35
    assert np.abs(found.x - truth)[6:].mean() < 0.5 * np.abs(truth[6:]).mean()


def test_the_penalty_counts(problem, truth):
    x = truth.copy()
    x[6] = 2.5
    assert problem(x).terms["prior"] > problem(truth).terms["prior"] > 0


def test_a_wrong_match_by_hand():
    theirs, ours = np.array([[0.0, 0], [2, 4]]), np.array([[1.0, 2], [3, 2]])
    direct = [np.mean([((t - o) ** 2).mean() for t in theirs]) for o in ours]
    np.testing.assert_allclose(wrong_match(theirs, ours), direct)


def test_bad_input_is_named(texture, local, scene, camera, other):
    image = other.image.astype(float)
    image[2, 2] = np.nan
    start = neutral(other.pose)
    with pytest.raises(PictureError, match="NaN"):
        texture_error(texture, scene, image, camera, camera.whole, start, RENDERER)
    with pytest.raises(PictureError, match="NaN"):
        local_error(local, scene, image, camera, camera.whole, RENDERER)
    away = neutral(Pose(other.pose.rotation, other.pose.translation + np.array([9000, 0, 0])))
    with pytest.raises(ParameterError, match="nothing is drawn"):
        texture_error(texture, scene, other.image, camera, camera.whole, away, RENDERER)


def test_a_part_of_a_scene_draws_the_same_there(scene, camera, other, local):
    front = (scene.mean[:, 2] > 0)[scene.faces].any(axis=1)
    smaller, kept = part(scene, front)
    assert len(kept) == len(smaller.mean) < len(scene.mean)
    one = Candidates.one(other.parameters, other.pose)
    whole = RENDERER.draw(scene, one, camera, camera.whole)[0]
    some = RENDERER.draw(smaller, one, camera, camera.whole)[0]
    both = some.covered
    assert both.sum() > 0.9 * whole.covered.sum()
    assert np.array_equal(some.rgb[both], whole.rgb[both])
    there = local.within(kept)
    assert np.array_equal(kept[there.vertices], local.vertices)
    with pytest.raises(ParameterError, match="outside of the part"):
        local.within(kept[kept != local.vertices[0]])
    with pytest.raises(MeshError, match="0 of"):
        part(scene, np.zeros(len(scene.faces), bool))
