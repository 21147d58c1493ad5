"""Physics learned from several sources, with variances that hold for frames that were left out."""

from __future__ import annotations

import json
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from lip_clips import FRONT, HEADS, LEFT, RIGHT, SPEAKER, clip, lips, write_lip_run
from runs import rewrite
from scipy.optimize import minimize

from abs_engine.capture.observations import write_observations
from abs_engine.cli import main
from abs_engine.core.errors import InputFileError
from abs_engine.dataset.sums import digest
from abs_engine.face.shape.modal import LearnedPhysics, learn, load_physics
from abs_engine.face.shape.physics_head import physics_shape
from abs_engine.io.assets import shipped
from abs_engine.learn.further import Further, LipClip, train_further
from abs_engine.learn.held_out import _left_out, _likeliest, held_out_variances
from abs_engine.learn.sources import Source, balanced, learn_sources
from abs_engine.papers.basu1998.experiment import OBSERVED
from abs_engine.papers.basu1998.motion import UNROUNDED, authored_motion, observed_motion
from abs_engine.tracking.models.shells import BUNDLED
from abs_engine.tracking.results.run_mesh import RunMesh
from abs_engine.tracking.speaker.lip_clips import load_lip_run

N, RNG = 12, np.random.default_rng(5)
REST = RNG.normal(size=(N, 3))
BASIS = np.linalg.qr(RNG.normal(size=(3 * N, 8)))[0].T.reshape(8, N, 3)
TRUE = np.array([40.0, 10.0, 4.0, 1.0])


def moved(coefficients: np.ndarray) -> np.ndarray:
    return np.tensordot(coefficients, BASIS[: coefficients.shape[1]], 1)


class TestSources:
    def test_each_source_counts_the_same_however_long_it_is(self):
        one, other = moved(RNG.normal(size=(40, 2))), 3 + moved(2 * RNG.normal(size=(10, 4)))
        once = learn_sources(REST, [Source(one), Source(other)], 4)
        repeated = learn(REST, np.concatenate([one, *[other] * 4]), 4)
        np.testing.assert_allclose(once.mean, repeated.mean, atol=1e-12)
        np.testing.assert_allclose(once.variances / once.total, repeated.variances / repeated.total)
        np.testing.assert_allclose(once.modes, repeated.modes, atol=1e-8)
        np.testing.assert_array_equal(
            balanced([Source(one), Source(other)]), np.concatenate([one, *[other] * 4])
        )

    def test_a_lone_source_is_learned_from_as_it_is(self):
        data = moved(RNG.normal(size=(30, 4)) * np.sqrt(TRUE))
        found, plain = learn_sources(REST, [Source(data)], 3), learn(REST, data, 3)
        np.testing.assert_allclose(found.variances, plain.variances)
        covariance = np.cov(data.reshape(30, -1).T)
        wanted = np.linalg.eigvalsh(covariance)[::-1]
        np.testing.assert_allclose(plain.variances, wanted[:3])
        assert plain.total == pytest.approx(wanted.sum())

    def test_what_a_posterior_leaves_open_stays_in_the_variance(self):
        """Half of a mode's variance seen, half of it in the posterior: all of it is learned."""
        drawn = RNG.normal(size=(4000, 4)) * np.sqrt(TRUE)
        drawn[:, 1] *= np.sqrt(0.5)
        spread = np.sqrt(0.5 * TRUE[1]) * BASIS[1:2]
        found = learn_sources(REST, [Source(moved(drawn), spread)], 4)
        np.testing.assert_allclose(found.variances, TRUE, rtol=0.1)
        without = learn_sources(REST, [Source(moved(drawn))], 4)
        np.testing.assert_allclose(without.variances, TRUE * [1, 0.5, 1, 1], rtol=0.1)


class TestHeldOut:
    def test_variances_of_plenty_of_independent_frames_stay(self):
        data = Source(moved(RNG.normal(size=(3000, 4)) * np.sqrt(TRUE)))
        physics = learn_sources(REST, [data], 4)
        found = held_out_variances(REST, [data], physics.variances)
        np.testing.assert_allclose(found, physics.variances, rtol=0.03)
        assert (found >= physics.variances).all()

    def test_motion_that_goes_on_elsewhere_is_expected_to_go_farther(self):
        """A random walk, which each block takes farther: in its weak directions above all."""
        rng = np.random.default_rng(0)
        walk = rng.normal(size=(140, 8)).cumsum(axis=0) * 0.6 ** np.arange(8)
        data = Source(moved(walk))
        physics = learn_sources(REST, [data], 5)
        ratio = held_out_variances(REST, [data], physics.variances) / physics.variances
        assert (ratio > 1.1).all()
        assert ratio[4] > 1.5 * ratio[0]

    def test_the_law_makes_what_was_left_out_likeliest(self):
        learned, squares = np.log(RNG.uniform(1, 90, (7, 5))), RNG.uniform(0.1, 60, (7, 5))

        def unlikely(law: np.ndarray) -> float:
            log_v = law[0] + law[1] * learned
            return float((log_v + squares * np.exp(-log_v)).sum())

        found = _likeliest(learned, squares)
        best = minimize(unlikely, [0.0, 1.0], method="BFGS", options={"gtol": 1e-9})
        np.testing.assert_allclose(found, best.x, atol=1e-4)

    def test_nothing_of_a_block_is_in_what_it_is_compared_with(self):
        data = moved(RNG.normal(size=(70, 4)) * np.sqrt(TRUE))
        plain = _left_out(REST, [Source(data)], 3)
        data[:10] += 50 * BASIS[7]
        changed = _left_out(REST, [Source(data)], 3)
        np.testing.assert_array_equal(changed[0][0], plain[0][0])
        assert (changed[0][1:, 0] != plain[0][1:, 0]).all()

    def test_too_few_frames_change_nothing(self):
        data = Source(moved(RNG.normal(size=(8, 4))))
        variances = learn_sources(REST, [data], 4).variances
        np.testing.assert_array_equal(held_out_variances(REST, [data], variances), variances)


@cache
def further() -> Further:
    """After twenty rounded moments that two cameras saw."""
    return train_further(lips().training, [clip(range(5, 25), (FRONT, LEFT))], rounds=1)


def error(physics: LearnedPhysics) -> float:
    """RMS distance, mm, of the lips of rounded heads from their nearest shape."""
    truth = lips().model.shell.nodes(HEADS[6:26:4])
    away = physics.shape(physics.coefficients(truth)) - truth
    return float(np.sqrt((away[:, :102] ** 2).sum(axis=2).mean()))


class TestFurther:
    def test_what_was_left_out_is_explained_better_and_the_lips_come_nearer(self):
        done, before = further(), lips().model.physics
        assert done.kept == 1
        assert done.evidence[1] < done.evidence[0] - 1
        assert error(done.physics) < 0.95 * error(before)
        assert done.physics.source.endswith("; and 16 shapes found in video")
        assert (done.physics.noise, done.physics.person) == (before.noise, "clara")
        assert (done.physics.noise_variances < done.physics.motion_variances).all()
        assert len(done.displacements) == 60 + 16 * round(60 / 16)

    def test_the_added_shapes_go_where_the_truth_is(self):
        truth = lips().model.shell.nodes(HEADS[5:21]) - lips().model.physics.rest
        away = (further().sources[1].displacements - truth)[:, :102]
        far = (lips().model.physics.mean - truth)[:, :102]
        assert np.sqrt((away**2).mean()) < 0.5 * np.sqrt((far**2).mean())

    def test_what_explains_nothing_better_is_not_kept(self):
        class Worse(LipClip):
            def evidence(self, physics: LearnedPhysics, shapes: np.ndarray) -> np.ndarray:
                return np.array([1.0 if physics is lips().training.physics else 2.0])

        given = clip(range(5, 11), (FRONT,))
        done = train_further(
            lips().training, [Worse(given.model, given.moments, given.tracked)], rounds=2
        )
        assert done.physics is lips().training.physics
        assert (done.kept, done.evidence, len(done.sources)) == (0, (1.0, 2.0, 2.0), 1)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Dots, and runs of two cameras."""
    folder = tmp_path_factory.mktemp("add")
    motion = authored_motion(SPEAKER, "clara", frames=60, sentences=UNROUNDED)
    write_observations(
        folder / "dots.npz", observed_motion(SPEAKER, motion, noise=OBSERVED, seed=0)
    )
    write_lip_run(folder / "front", range(5, 15), FRONT)
    write_lip_run(folder / "left", range(5, 15), LEFT)
    return folder


class TestAdd:
    def run(self, folder: Path, *more: str) -> int:
        words = ["train", str(folder / "dots.npz"), "-o", str(folder / "lips.npz")]
        return main(
            [*words, "--person", "clara", "--train", "60", "--renderer", "cpu", "--add", *more]
        )

    def test_runs_of_two_cameras_teach_the_lips(self, folder: Path, capsys):
        assert self.run(folder, f"{folder / 'front'},{folder / 'left'}") == 0
        said = capsys.readouterr().out
        assert "left out, before and by round" in said
        assert "shapes that were added, by clip: 8" in said
        physics = load_physics(folder / "lips.npz")
        assert physics.source.endswith("; and 8 shapes found in video")
        assert error(physics) < error(lips().model.physics)
        (folder / "lips.npz").unlink()

    def test_bad_runs_are_one_line_and_leave_nothing(self, folder: Path, capsys):
        write_lip_run(folder / "short", range(5, 12), LEFT)
        write_lip_run(folder / "moved", range(5, 12), LEFT)
        (folder / "moved.mp4").unlink()
        worn = write_lip_run(folder / "worn", range(5, 10), LEFT)
        (worn / "colours.npz").unlink()
        write_lip_run(folder / "few", range(5, 8), LEFT)
        rewrite(write_lip_run(folder / "early", range(5, 13), LEFT), without="contradicted")
        rewrite(write_lip_run(folder / "fast", range(5, 15), RIGHT), rate=np.array(50.0))
        cases = {
            f"{folder / 'front'},{folder / 'short'}": "begin and end at the same time",
            str(folder / "moved"): "is not there",
            str(folder / "few"): "in 3 frames",
            str(folder / "none"): "none",
            str(folder / "worn"): "tracked without colours, as with --worn",
            str(folder / "early"): "lacks contradicted; track it again",
            f"{folder / 'front'},{folder / 'fast'}": "front has 25 frames/s, ",
            f"{folder / 'front'},{folder / 'front'}": "come from the same video",
            ",": "names no run",
        }
        for runs, told in cases.items():
            assert self.run(folder, runs) == 2
            said = capsys.readouterr().err.strip().splitlines()
            assert told in said[-1]
            assert "in place of" not in said[-1]  # a video is no run, and 'train' takes none
            assert not (folder / "lips.npz").exists()


def test_lips_move_away_from_the_persons_rest_not_from_the_average_of_speech(folder: Path):
    shell = lips().model.shell
    run, neutral = load_lip_run(folder / "front", SPEAKER, shell), SPEAKER.named("clara")
    np.testing.assert_array_equal(run.rest, neutral)
    truth = shell.nodes(HEADS[5:15]) - shell.nodes(neutral)
    np.testing.assert_allclose(run.tracked, truth, atol=1e-3)


def test_the_physics_of_a_run_that_states_its_rest_is_not_asked_for(tmp_path: Path):
    run = write_lip_run(tmp_path / "run", range(5, 7), FRONT)
    told = json.loads((run / "run.json").read_text())
    told["settings"] |= {"physics": "lost.npz"}
    (run / "run.json").write_text(json.dumps(told))
    found = load_lip_run(run, SPEAKER, lips().model.shell)
    np.testing.assert_array_equal(found.rest, SPEAKER.named("clara"))


def test_the_rest_of_an_early_run_tracked_with_physics_is_without_its_mean(tmp_path: Path):
    """There the head of the mesh is in the mean posture of the lips that it was tracked with."""
    folder, physics = write_lip_run(tmp_path / "run", range(5, 7), FRONT), lips().model.physics
    neutral, shell = SPEAKER.named("clara"), lips().model.shell
    summary = folder / "run.json"
    told = json.loads(summary.read_text())
    for name, moves_by in (("lips.npz", physics), (None, load_physics(shipped(BUNDLED)))):
        moved = physics_shape(SPEAKER, neutral, shell, moves_by)
        (folder / "mesh.npz").unlink()
        weights = np.zeros((2, len(moved.modes)))
        RunMesh(moved.mean, moved.modes, weights, SPEAKER.faces).save(folder)
        told["settings"] |= {"model": "shell", "physics": name}
        summary.write_text(json.dumps(told))
        if name is not None:
            with pytest.raises(InputFileError, match=r"lips\.npz, the lips that"):
                load_lip_run(folder, SPEAKER, shell)
            physics.save(tmp_path / name)
        run = load_lip_run(folder, SPEAKER, shell)
        np.testing.assert_allclose(run.rest, neutral, atol=1e-4)
        near = physics_shape(SPEAKER, np.zeros_like(neutral), shell, moves_by).mean
        np.testing.assert_allclose(run.tracked[0], shell.nodes(near), atol=1e-3)
        assert np.abs(run.tracked[0]).max() > 0.5
    named = {"physics": "lips.npz", "physics_sha256": digest(tmp_path / "lips.npz")}
    told["settings"] |= named
    summary.write_text(json.dumps(told))
    load_lip_run(folder, SPEAKER, shell)
    replace(physics, source="others").save(tmp_path / "others.npz")
    (tmp_path / "others.npz").rename(tmp_path / "lips.npz")
    with pytest.raises(InputFileError, match=r"lips\.npz, the lips that .* have changed since"):
        load_lip_run(folder, SPEAKER, shell)


def test_a_physics_with_and_without_cross_validated_variances_is_read_back(tmp_path: Path):
    physics = lips().model.physics
    bare = replace(physics, motion_variances=np.zeros(0))
    for name, one in (("with", physics), ("without", bare)):
        one.save(tmp_path / f"{name}.npz")
        back = load_physics(tmp_path / f"{name}.npz")
        np.testing.assert_array_equal(back.deviations, one.deviations)
    assert (physics.deviations >= bare.deviations - 1e-12).all()
    assert (physics.deviations > 1.02 * bare.deviations).any()
