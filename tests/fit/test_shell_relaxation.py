"""The full-rank shell settles on a frame, and the lips learn from what it found."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from heads import SIZE, colours_of, head_of, picture_of, seen_at

from abs_engine.compare.facets import FacetLikelihood
from abs_engine.core.camera import Camera
from abs_engine.core.scene import Candidates
from abs_engine.face.shape.fem import ThinShell
from abs_engine.face.shape.lip_shell import COLUMNS
from abs_engine.fit.shell import ShellSetting, shell_problem
from abs_engine.fit.shell_relaxation import Settled, settle, softness
from abs_engine.io.assets import load_speaker
from abs_engine.papers.basu1998.experiment import TrainedLips, learn_lips
from abs_engine.papers.basu1998.incremental_training import STRAINED, further_trained
from abs_engine.papers.basu1998.motion import UNROUNDED, authored_motion
from abs_engine.papers.basu1998.single_frames import colours_of as colours_in
from abs_engine.render.cpu import CpuRenderer

CAMERA = Camera.ideal(SIZE)
SPEAKER = load_speaker()
FRONT = seen_at([0, 0, 0], [0, 0, 560])


@cache
def lips() -> TrainedLips:
    """Lips that never saw rounding."""
    motion = authored_motion(SPEAKER, "clara", frames=60, sentences=UNROUNDED)
    return learn_lips(SPEAKER, "clara", colours_of(head_of("clara"), FRONT, CAMERA), 0, motion)


def elastic() -> ThinShell:
    return lips().model.shell.elastic_at(lips().model.physics.rest)


# ---- softness ------------------------------------------------------------------------------------


def test_nodes_move_as_far_as_the_temperature_says():
    """Displacements drawn from N(0, T K^-1) by the stiffness's own Cholesky factor."""
    shell, typical = elastic(), 0.4
    temperature = softness(shell, typical)
    assert softness(shell, 3 * typical) == pytest.approx(9 * temperature)
    factor = np.linalg.cholesky(shell.stiffness.toarray() / temperature)
    rng = np.random.default_rng(0)
    drawn = np.linalg.solve(factor.T, rng.normal(size=(612, 2000))).T.reshape(-1, 204, 3)
    assert np.sqrt((drawn**2).sum(axis=2).mean()) == pytest.approx(typical, rel=0.02)
    energy = np.mean([shell.energy(u) for u in drawn[:200]])
    assert energy / temperature == pytest.approx(612 / 2, rel=0.03)  # equipartition


# ---- settling ------------------------------------------------------------------------------------

SAID = authored_motion(SPEAKER, "clara", frames=30, sentences=("_ S u: f O: w u: _",))
HEADS = SAID.vertices(SPEAKER)
ROUNDED = (5, 12, 20, 26)


def known(frame: int) -> np.ndarray:
    """Weights of the nearest modal shape."""
    model = lips().model
    nodes = model.shell.nodes(HEADS[frame])
    return model.physics.coefficients(nodes) / model.deviations


@cache
def setting() -> ShellSetting:
    return lips().setting(CAMERA, CpuRenderer())


@cache
def colours(frame: int) -> FacetLikelihood:
    """Of a picture of a whole head whose lips are rounded."""
    head = replace(head_of("clara").head, mean=HEADS[frame])
    return colours_in(shell_problem(setting(), picture_of(head, FRONT, CAMERA), FRONT))


def rms(away: np.ndarray) -> float:
    """RMS distance of the lips' nodes in the picture's plane, mm."""
    return float(np.sqrt((away[: 3 * COLUMNS, :2] ** 2).sum(axis=1).mean()))


@cache
def settled(frame: int, typical: float = STRAINED) -> Settled:
    shell = elastic()
    model = setting().model
    return settle(model, colours(frame), known(frame), FRONT, shell, softness(shell, typical))


def leaving(frame: int) -> tuple[np.ndarray, np.ndarray]:
    """What the nearest modal shape misses of the lips in the picture's plane, and what is moved.

    Started from there, so that what is left lies outside of the modes.
    """
    model = lips().model
    truth, found = model.shell.nodes(HEADS[frame]), settled(frame, 1.0)
    near = found.nodes - found.moved
    np.testing.assert_allclose(near, setting().scene.vertices(known(frame))[:204])
    return (truth - near)[: 3 * COLUMNS], found.moved[: 3 * COLUMNS]


def test_nodes_that_leave_the_modes_come_nearer_to_the_truth():
    """In a few frames together; in one of them they stay as far from it, or nearly.

    There (12) it hangs on the picture's chroma: 1.01 times as far as it is drawn here, 1.03 times
    as video would hold it.
    """
    pairs = [leaving(frame) for frame in ROUNDED]
    before, after = ([rms(m - k * v) for m, v in pairs] for k in (0.0, 1.0))
    assert np.linalg.norm(after) < 0.92 * np.linalg.norm(before)
    assert max(a / b for a, b in zip(after, before, strict=True)) < 1.05


def test_nodes_leave_the_modes_towards_the_truth():
    """Cosines of a few frames together: where little is missed, its direction is uncertain."""
    pairs = [[a[:, :2].ravel() for a in leaving(frame)] for frame in ROUNDED]
    cosines = [a @ b / np.linalg.norm(a) / np.linalg.norm(b) for a, b in pairs]
    assert np.mean(cosines) > 0.4
    assert min(cosines) > 0


@pytest.mark.parametrize("start", ["known", "mean", "wrong"])
def test_the_posterior_never_gets_worse(start):
    shell = elastic()
    for frame in ROUNDED:
        weights = {"known": known(frame), "mean": np.zeros(10), "wrong": np.ones(10)}[start]
        for typical in (0.05, STRAINED, 2.0):
            soft = softness(shell, typical)
            found = settle(setting().model, colours(frame), weights, FRONT, shell, soft)
            assert found.after <= found.before
            assert (found.after < found.before) == bool(found.moved.any())


def test_what_is_told_is_the_likelihood_and_the_strain():
    frame, shell = ROUNDED[1], elastic()
    found, like = settled(frame), colours(frame)
    base = setting().scene.vertices(known(frame))
    for u, told in ((0 * found.moved, found.before), (found.moved, found.after)):
        mean = np.float32(base + setting().model.surrounded(u))
        there = replace(like, scene=replace(like.scene, mean=mean, modes=0 * like.scene.modes))
        candidate = Candidates.one(np.zeros(10), FRONT)
        strain = shell.energy(u) / softness(shell, STRAINED)
        assert told == pytest.approx(there.negative_log(candidate)[0] + strain, rel=1e-4)


def test_a_stiff_shell_stays_and_a_soft_one_goes_far():
    moved = [
        np.linalg.norm(settled(ROUNDED[1], typical).moved, axis=1).max()
        for typical in (0.01, STRAINED, 2.0)
    ]
    assert moved[0] < 0.05 < moved[1] < moved[2]


# ---- further training ----------------------------------------------------------------------------


def test_lips_learn_a_direction_that_they_lacked():
    """Five shapes that go 3 mm each way along a smooth field that is no mode."""
    old = lips().model.physics
    x = (old.rest - old.rest.mean(axis=0)) / 15
    field = np.stack([0 * x[:, 0], np.sin(2 * x[:, 0]), np.cos(2 * x[:, 1])], axis=1)
    field -= np.tensordot(old.matrix.T @ field.ravel(), old.modes, 1)
    field /= np.linalg.norm(field)
    spread = 3.0 * np.sqrt(len(field)) * np.array([-1, -0.5, 0, 0.5, 1])
    shapes = [Settled(old.rest + old.mean + k * field, k * field, 1.0, 0.0) for k in spread]
    after = further_trained(lips(), shapes)
    new = after.model.physics

    def variance(physics) -> float:
        along = physics.matrix.T @ field.ravel()
        return float((physics.variances * along**2).sum())

    frames = len(lips().training.displacements)
    assert variance(old) < 1e-6
    assert variance(new) == pytest.approx((spread**2).sum() / (frames + 4), rel=0.1)
    assert new.total > old.total * 0.9
    assert (len(new.modes), new.noise, new.person) == (len(old.modes), old.noise, "clara")
    assert new.source.endswith("; and 5 shapes found in video")
    np.testing.assert_array_equal(new.rest, old.rest)
    assert after.model.physics is after.training.physics
    assert len(after.training.displacements) == frames + 5
    assert lips().model.physics is old  # what was given is untouched
    missed = [np.abs(p.shape(p.coefficients(shapes[0].nodes)) - shapes[0].nodes).max()
              for p in (old, new)]  # fmt: skip
    assert missed[1] < 0.2 * missed[0]


def test_what_was_settled_makes_lips_that_fit_better():
    shapes = [settled(frame, 1.0) for frame in range(4, 28, 3)]
    after = further_trained(lips(), shapes).model.physics
    old = lips().model.physics
    for_new, for_old = [], []
    for frame in ROUNDED:
        truth = lips().model.shell.nodes(HEADS[frame])
        for physics, out in ((after, for_new), (old, for_old)):
            out.append(rms(physics.shape(physics.coefficients(truth)) - truth))
    assert np.mean(for_new) < 0.97 * np.mean(for_old)
