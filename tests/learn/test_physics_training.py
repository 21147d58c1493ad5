"""Lips learned from dots: whose head, which frames, how near the whole shell is to the truth."""

from __future__ import annotations

import os
import subprocess
import sys
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from clara_lips import MOTION, SEEN, SHELL, SPEAKER, TRAINED
from scipy.spatial.transform import Rotation

from abs_engine.capture.dot_annotations import LIPS16
from abs_engine.capture.observations import Observations, write_observations
from abs_engine.cli import main
from abs_engine.cli.commands.train import report_lines
from abs_engine.core.errors import (
    InputFileError,
    ModelFormatError,
    ParameterError,
    TooFewPointsError,
)
from abs_engine.face.shape.lip_dots import lips17
from abs_engine.face.shape.lip_shell import COLUMNS
from abs_engine.face.shape.modal import load_physics
from abs_engine.learn.believed_dots import believe
from abs_engine.learn.correspondence import correspond, similarity
from abs_engine.learn.settings import LEARNING
from abs_engine.learn.training import Training, check_speaker, train
from abs_engine.papers.basu1998.motion import (
    HARVARD,
    RATE,
    RECORDED_FROM,
    RECORDING,
    SLOWLY,
    Motion,
    authored_motion,
    observed_motion,
    recorded_motion,
    recording_path,
    spoken_motion,
)
from abs_engine.studio.speech import play_recording, read_livelink

LIPS = slice(0, 3 * COLUMNS)


def rms(away: np.ndarray) -> float:
    return float(np.sqrt((away**2).sum(axis=-1).mean()))


def most_varied(path: Path) -> int:
    """First frame of the stretch in which ten directions have the greatest product of variances."""
    weights = play_recording(read_livelink(path), SPEAKER.unit_names, RATE).weights
    units = SPEAKER.unit_matrix(SPEAKER.unit_names)[:, lips17(SPEAKER)[: len(LIPS16)]]
    dots = weights @ units.reshape(len(units), -1).astype(np.float64)

    def spread(start: int) -> float:
        part = dots[start : start + LEARNING.trained]
        values = np.linalg.svd(part - part.mean(axis=0), compute_uv=False)[: LEARNING.modes]
        return float(np.log(np.maximum(values, 1e-9)).sum())

    return max(range(0, len(dots) - LEARNING.trained + 1, 10), key=spread)


def dots_of(done: Training, moved: np.ndarray) -> np.ndarray:
    """Where the dots of a shell so moved are, as they were observed."""
    return done.correspondence.home + done.correspondence.points.at(moved)


def lost(
    observations: Observations, frames: list[int], dots: slice | int = slice(3, 12)
) -> Observations:
    """The same with more than half of the dots, or others, lost in some frames."""
    points, found = observations.points.copy(), observations.found.copy()
    points[frames, dots], found[frames, dots] = np.nan, False
    return replace(observations, points=points, found=found)


def of(seen: Observations, frames: list[int]) -> Observations:
    """Some of the frames."""
    return replace(
        seen, points=seen.points[frames], found=seen.found[frames],
        uncertain=seen.uncertain[frames], error=seen.error[frames], score=seen.score[frames],
        rotations=seen.rotations[frames], translations=seen.translations[frames],
        rigid_error=seen.rigid_error[frames],
    )  # fmt: skip


def hidden(observations: Observations, most: int, seed: int) -> Observations:
    """The same with one dot or more, drawn by chance, lost in each frame."""
    rng = np.random.default_rng(seed)
    for frame in range(observations.frames):
        chosen = rng.choice(16, rng.integers(1, most + 1), replace=False)
        observations = lost(observations, [frame], chosen)
    return observations


def test_ten_modes_of_a_hundred_and_forty_frames_hold_what_the_paper_says():
    assert len(TRAINED.used) == 140
    assert TRAINED.tested.tolist() == list(range(140, 150))
    assert TRAINED.physics.held > 0.992
    assert TRAINED.physics.modes.shape == (10, 204, 3)


def test_the_dots_are_reached_and_the_rest_is_near_the_truth():
    moved = np.concatenate([TRAINED.displacements, TRAINED.test])
    seen = dots_of(TRAINED, moved)
    np.testing.assert_allclose(seen, SEEN.of(LIPS16), atol=1e-8)
    truth = SHELL.nodes(MOTION.vertices(SPEAKER))
    assert rms((TRAINED.physics.rest + moved - truth)[:, LIPS]) < 0.75
    assert rms((truth - TRAINED.physics.rest - TRAINED.physics.mean)[:, LIPS]) > 3


def test_the_noise_of_the_dots_is_found():
    assert TRAINED.physics.noise == pytest.approx(0.1, rel=0.15)
    assert train(observed_motion(SPEAKER, MOTION), SPEAKER, "clara").physics.noise < 0.02


def test_the_help_says_which_frames_are_learned_from(capsys):
    assert main(["train", "--help"]) == 0
    words = " ".join(capsys.readouterr().out.split())
    assert f"those with {LEARNING.fewest_dots} or more of the {len(LIPS16)} dots" in words
    assert f"later ones with all {len(LIPS16)} are for testing" in words


def test_test_frames_are_not_learned_from():
    points = SEEN.points.copy()
    points[140:] += 2.0
    again = train(replace(SEEN, points=points), SPEAKER, "clara", shell=SHELL)
    np.testing.assert_array_equal(again.physics.modes, TRAINED.physics.modes)
    np.testing.assert_array_equal(again.physics.mean, TRAINED.physics.mean)
    assert again.physics.noise == TRAINED.physics.noise


def test_lost_dots_are_put_back_without_test_frames():
    seen = lost(hidden(SEEN, 3, 1), [150 - k for k in range(1, 11)], 2)
    plain = train(seen, SPEAKER, "clara", n_train=130, shell=SHELL)
    points = seen.points.copy()
    points[130:] = SEEN.points[:20] + 0.5 * (points[130:] - SEEN.points[:20])
    again = train(replace(seen, points=points), SPEAKER, "clara", n_train=130, shell=SHELL)
    assert len(plain.incomplete) == 130
    np.testing.assert_array_equal(again.displacements, plain.displacements)
    np.testing.assert_array_equal(again.physics.variances, plain.physics.variances)


def test_a_new_movement_of_test_frames_is_no_jump():
    done = train(SEEN, SPEAKER, "clara", n_modes=8, n_train=24, shell=SHELL)
    assert done.tested.tolist() == list(range(24, 150))


def test_a_movement_that_one_block_alone_has_is_learned():
    """Of its variance in other frames nothing is known, so that the variances stay as they are."""
    weights, time = np.zeros((150, 52)), np.arange(150)
    units = [SPEAKER.unit_names.index(u) for u in ("jawOpen", "mouthFunnel", "mouthPressLeft")]
    weights[:, units[:2]] = 0.3 + 0.3 * np.sin(time[:, None] * [0.1, 0.17])
    weights[62:78, units[2]] = 0.5 * np.sin(np.linspace(0, np.pi, 16))
    seen = observed_motion(SPEAKER, Motion("clara", weights, ""))
    physics = train(seen, SPEAKER, "clara", n_modes=3, shell=SHELL).physics
    np.testing.assert_array_equal(physics.motion_variances, physics.variances)


def test_a_place_that_was_not_found_is_not_learned_from():
    points, found = SEEN.points.copy(), SEEN.found.copy()
    points[7, 3], found[7, 3] = 0.0, False
    done = train(replace(SEEN, points=points, found=found), SPEAKER, "clara", shell=SHELL)
    assert done.incomplete.tolist() == [7]
    assert len(done.left_out) == len(done.jumped) == 0
    place = dots_of(done, done.displacements[7])[3]
    assert np.linalg.norm(place - SEEN.points[7, 3]) < 1.0


def test_dots_that_jump_are_left_out_and_their_frames_named():
    points = SEEN.points.copy()
    points[[20, 21], 3, 0] += 60.0
    points[145, 9] += 6.0
    done = train(replace(SEEN, points=points), SPEAKER, "clara", shell=SHELL)
    assert done.jumped.tolist() == [20, 21, 145]
    assert done.incomplete.tolist() == [20, 21]
    assert len(done.left_out) == len(TRAINED.jumped) == len(TRAINED.incomplete) == 0
    assert 145 not in done.tested
    assert done.physics.noise == pytest.approx(0.1, rel=0.15)
    for frame in (20, 21):
        there = dots_of(done, done.displacements[frame])
        assert np.linalg.norm(there - SEEN.points[frame, :16], axis=1).max() < 1.0


def test_dots_that_have_each_others_names_are_refused():
    """Far apart, and beside each other on one lip; the file's frames count from 100."""
    for a, b in ((2, 5), (8, 9)):
        points = SEEN.points.copy()
        points[40:43, [a, b]] = points[40:43, [b, a]]
        with pytest.raises(
            ParameterError, match="have each other's places in frames 140, 141, 142"
        ):
            train(replace(SEEN, points=points, first=100), SPEAKER, "clara", shell=SHELL)


def test_incomplete_frames_teach_nearly_as_much_as_whole_ones():
    """Up to six of sixteen dots hidden in every frame, so that none is whole."""
    truth = SHELL.nodes(MOTION.vertices(SPEAKER))

    def missed(done: Training) -> float:
        physics = done.physics
        return rms((physics.shape(physics.coefficients(truth)) - truth)[:, LIPS])

    done = train(hidden(SEEN, 6, 0), SPEAKER, "clara", shell=SHELL)
    assert len(done.used) == len(done.incomplete) == 140
    assert len(done.tested) == 0
    assert missed(done) < 1.15 * missed(TRAINED)
    away = done.physics.rest + done.displacements - truth[done.used]
    assert rms(away[:, LIPS]) < 1.0


def test_frames_with_uncertain_dots_are_named():
    uncertain = SEEN.uncertain.copy()
    uncertain[[5, 144], 2] = True
    uncertain[9, 16] = True  # the nose, which is not learned from
    done = train(replace(SEEN, uncertain=uncertain), SPEAKER, "clara", shell=SHELL)
    assert done.uncertain.tolist() == [5, 144]
    assert len(done.used) == 140


def test_frames_with_too_few_dots_are_left_out_and_named():
    done = train(lost(SEEN, [7, 30, 31]), SPEAKER, "clara", shell=SHELL)
    assert done.left_out.tolist() == [7, 30, 31]
    assert len(done.used) == 140
    assert not set(done.used) & {7, 30, 31}
    assert done.tested.tolist() == list(range(143, 150))


class TestWhoseHead:
    def test_a_known_head_is_used_as_it_is(self):
        np.testing.assert_array_equal(TRAINED.physics.rest, SHELL.nodes(SPEAKER.named("clara")))
        assert TRAINED.physics.person == "clara"
        assert "head of clara" in TRAINED.physics.source

    def test_dots_are_scaled_turned_and_shifted_onto_the_average_head(self):
        """Of somebody who is the average one, larger, tilted and elsewhere, nothing is left."""
        turn = Rotation.from_rotvec([0.1, -0.2, 0.05]).as_matrix()
        shift = np.array([3.0, -8, 5])
        still = observed_motion(SPEAKER, Motion("clara", np.zeros((2, 52)), "")).of(LIPS16)
        average = still - SPEAKER.named("clara")[None, _dots()] + SPEAKER.vertices[_dots()]
        seen = 1.2 * average @ turn.T + shift
        laid = correspond(SPEAKER, SHELL, seen)
        assert laid.scale == pytest.approx(1.2, abs=1e-4)
        assert laid.misfit < 1e-3
        assert laid.person == ""
        np.testing.assert_array_equal(laid.rest, SHELL.nodes(SPEAKER.vertices))
        np.testing.assert_allclose(laid.brought(seen), average, atol=0.01)
        assert np.abs(laid.goals(seen)).max() < 0.01

    def test_modes_are_in_the_heads_axes_and_size_however_the_dots_were(self):
        turn = Rotation.from_rotvec([0.1, -0.2, 0.05]).as_matrix()
        turned = replace(SEEN, points=1.1 * SEEN.points @ turn.T + [100.0, 0, 0])
        plain, other = (train(s, SPEAKER, shell=SHELL).physics for s in (SEEN, turned))
        np.testing.assert_allclose(other.modes, plain.modes, atol=1e-6)
        np.testing.assert_allclose(other.mean, plain.mean, atol=1e-6)
        np.testing.assert_allclose(other.variances, plain.variances, rtol=1e-6)

    def test_dots_of_another_head_frame_or_unit_are_refused(self):
        def moved(points: np.ndarray) -> Observations:
            return replace(SEEN, points=points)

        side = Rotation.from_rotvec([0, 0.7, 0]).as_matrix()
        astray = SEEN.points.copy()
        astray[:, 2, 2] += 60.0
        astray[:, 6, 2] += 60.0
        cases = [
            (SEEN, "kofi", "25 mm RMS from those on the head of kofi"),
            (moved(SEEN.points + np.array([100.0, 0, 0])), "clara", "100 mm RMS"),
            (moved(SEEN.points @ side.T), "clara", "turned by 4"),
            (moved(SEEN.points @ side.T), None, "x left, y up, z out of the face"),
            (moved(SEEN.points / 1000), "clara", "are they in mm"),
            (moved(SEEN.points / 1000), None, "are they in mm"),
            (moved(astray), None, "check their names"),
        ]
        for seen, person, told in cases:
            with pytest.raises(ParameterError, match=told):
                train(seen, SPEAKER, person, shell=SHELL)

    @pytest.mark.parametrize("person", ["clara", None])
    def test_dots_with_each_others_names_in_all_frames_are_named(self, person):
        order = [k if k not in (1, 3) else 4 - k for k in range(len(SEEN.names))]
        told = "upper_outer_1 and upper_outer_3 have each other's place: .* if these two are"
        with pytest.raises(ParameterError, match=told) as error:
            train(replace(SEEN, points=SEEN.points[:, order]), SPEAKER, person, shell=SHELL)
        assert "in the file of points or markers" in error.value.remedy

    @pytest.mark.parametrize("person", ["clara", None])
    @pytest.mark.parametrize("axes", [[-1, 1, 1], [1, 1, -1]])
    def test_left_and_right_exchanged_throughout_are_named(self, person, axes):
        dots = replace(SEEN, points=SEEN.points * axes)
        with pytest.raises(ParameterError, match="left and right seem exchanged") as error:
            train(dots, SPEAKER, person, shell=SHELL)
        assert error.value.remedy.endswith("and that the axes are right-handed")

    def test_what_is_left_of_somebody_else_goes_into_the_mean(self):
        done = train(SEEN, SPEAKER, shell=SHELL)
        assert "average head" in done.physics.source
        truth = SHELL.nodes(MOTION.vertices(SPEAKER))
        moved = np.concatenate([done.displacements, done.test])
        near = done.correspondence.brought(truth)
        assert rms((done.physics.rest + moved - near)[:, LIPS]) < 2.0
        np.testing.assert_array_equal(done.physics.rest, SHELL.nodes(SPEAKER.vertices))

    def test_similarity_of_a_mirrored_cloud_does_not_mirror(self):
        points = np.random.default_rng(0).normal(size=(16, 3))
        _, turn, _ = similarity(points, points * [-1, 1, 1])
        assert np.linalg.det(turn) == pytest.approx(1)

    def test_a_stranger_is_refused(self):
        with pytest.raises(ParameterError, match="no person 'nobody'"):
            train(SEEN, SPEAKER, "nobody", shell=SHELL)


def _dots() -> np.ndarray:
    return lips17(SPEAKER)[: len(LIPS16)]


class TestTooLittle:
    def test_too_few_frames(self):
        with pytest.raises(TooFewPointsError, match="found in 130 of 150 frames, 140 are to be"):
            train(lost(SEEN, list(range(20))), SPEAKER, "clara", shell=SHELL)
        assert len(train(lost(SEEN, [0]), SPEAKER, "clara", n_train=149, shell=SHELL).tested) == 0

    def test_a_dot_that_was_lost_in_one_of_three_frames(self):
        few = lost(SEEN, [21], 3)
        with pytest.raises(TooFewPointsError, match="dots were lost in 1 of 3 frames to learn"):
            train(of(few, [20, 21, 40]), SPEAKER, "clara", n_modes=1, n_train=3, shell=SHELL)
        alone = of(SEEN, [20, 40, 60])
        assert len(train(alone, SPEAKER, "clara", n_modes=1, n_train=3, shell=SHELL).used) == 3

    def test_a_dot_that_only_test_frames_have(self):
        with pytest.raises(TooFewPointsError, match="upper_outer_3 was found in none of the fr"):
            train(lost(SEEN, list(range(141)), 3), SPEAKER, "clara", shell=SHELL)

    def test_a_dot_that_was_never_marked(self):
        keep = [k for k, name in enumerate(SEEN.names) if name != "corner_left"]
        without = Observations(
            SEEN.points[:, keep], tuple(SEEN.names[k] for k in keep), SEEN.found[:, keep],
            SEEN.uncertain[:, keep], SEEN.error[:, keep], SEEN.score[:, keep], SEEN.rate,
            SEEN.rotations, SEEN.translations, SEEN.rigid_error,
        )  # fmt: skip
        with pytest.raises(TooFewPointsError, match="corner_left"):
            train(without, SPEAKER, "clara", shell=SHELL)

    def test_a_face_that_does_not_move(self):
        still = observed_motion(SPEAKER, Motion("clara", np.zeros((150, 52)), ""))
        assert not np.ptp(still.of(LIPS16), axis=0).any()
        for noise in (0.0, 0.05, 0.3):
            away = np.random.default_rng(0).normal(0, noise, still.points.shape)
            said = f"the dots move by {noise * 3**0.5:.2f} mm in the 140 frames"
            with pytest.raises(ParameterError, match=said):
                train(replace(still, points=still.points + away), SPEAKER, "clara", shell=SHELL)

    @pytest.mark.parametrize(("modes", "frames"), [(0, 140), (10, 10)])
    def test_modes_and_frames_that_make_no_sense(self, modes, frames):
        with pytest.raises(ParameterError, match="cannot be learned"):
            train(SEEN, SPEAKER, "clara", n_modes=modes, n_train=frames, shell=SHELL)


def test_lips_of_another_head_are_refused():
    check_speaker(TRAINED.physics, SPEAKER)
    other = replace(SPEAKER, vertices=SPEAKER.vertices * np.float32(1.1))
    with pytest.raises(ModelFormatError, match="another speaker"):
        check_speaker(TRAINED.physics, other)
    with pytest.raises(ModelFormatError) as caught:
        check_speaker(TRAINED.physics, other)
    assert caught.value.remedy == "give that head with --speaker"


def test_lips_of_another_head_than_an_imported_one_have_a_remedy_that_works():
    other = replace(SPEAKER, vertices=SPEAKER.vertices * np.float32(1.1), own_texture=np.zeros(1))
    assert other.imported
    with pytest.raises(ModelFormatError) as caught:
        check_speaker(TRAINED.physics, other)
    assert "leave out this head (--model, --speaker)" in caught.value.remedy
    assert "train --speaker" in caught.value.remedy


class TestMotion:
    def test_speech_takes_the_frames_asked_for_and_parts_the_lips(self):
        assert len(MOTION) == 150
        assert MOTION.weights.shape == (150, 52)
        gap = SHELL.nodes(MOTION.vertices(SPEAKER))[:, [8, 25], 1]
        assert np.ptp(gap[:, 0] - gap[:, 1]) > 8

    def test_dots_are_where_the_head_is(self):
        exact = observed_motion(SPEAKER, MOTION)
        head = MOTION.vertices(SPEAKER)
        np.testing.assert_allclose(exact.of(LIPS16), head[:, _dots()], atol=1e-3)
        assert np.std(SEEN.points - exact.points) == pytest.approx(0.1, rel=0.05)

    def test_the_recording_begins_where_it_is_most_varied(
        self, data_dir: Path, monkeypatch: pytest.MonkeyPatch
    ):
        path = data_dir / RECORDING
        assert most_varied(path) == RECORDED_FROM
        motion = recorded_motion(SPEAKER, "mei", path)
        assert len(motion) == 150
        seen = observed_motion(SPEAKER, motion, noise=0.1)
        assert train(seen, SPEAKER, "mei", shell=SHELL).physics.held > 0.992
        monkeypatch.setattr("abs_engine.papers.basu1998.motion.RECORDED_FROM", 10_000)
        with pytest.raises(ParameterError, match="not in the recording"):
            recorded_motion(SPEAKER, "mei", path)

    def test_a_recording_that_is_not_there(self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
        monkeypatch.setenv("ABS_ENGINE_DATA", str(tmp_path))
        with pytest.raises(InputFileError, match="ABS_ENGINE_DATA"):
            recording_path()


class TestCommand:
    def test_all_frames_are_accounted_for(self):
        done = train(lost(SEEN, [141, 145], 3), SPEAKER, "clara", shell=SHELL)
        assert done.untested.tolist() == [141, 145]
        said = "8 left for testing, 2 more not tested, as a dot is missing, 0 left out"
        assert said in report_lines(done)[1]

    def test_it_writes_a_model_and_says_what_it_learned(self, tmp_path: Path, capsys):
        write_observations(tmp_path / "dots.npz", lost(SEEN, [7, 30]))
        out = tmp_path / "lips.npz"
        command = ["train", str(tmp_path / "dots.npz"), "-o", str(out), "--person", "clara"]
        assert main(command) == 0
        said = capsys.readouterr().out
        assert "the head of clara" in said
        assert "140 frames learned from, 8 left for testing, 2 left out" in said
        assert "too few dots were found: 7, 30" in said
        assert "10: 99." in said
        assert "yz (16 points)" in said
        model = load_physics(out)
        assert model.person == "clara"
        assert model.held > 0.992
        assert main(command) == 2  # it is there already

    def test_it_names_dots_that_jump_or_are_uncertain(self, tmp_path: Path, capsys):
        points, uncertain = SEEN.points.copy(), SEEN.uncertain.copy()
        points[20, 3, 0] += 60.0
        uncertain[5, 2] = True
        seen = replace(SEEN, points=points, uncertain=uncertain, first=100)
        write_observations(tmp_path / "dots.npz", seen)
        out = tmp_path / "lips.npz"
        assert main(["train", str(tmp_path / "dots.npz"), "-o", str(out)]) == 0
        said = capsys.readouterr().out
        assert "in 1 frames dots jump, which were left out: 120" in said
        assert "1 of these frames are learned from without some dots: 120" in said
        assert "1 of these frames have uncertain dots; a person should look at them: 105" in said

    @pytest.mark.parametrize("unbuffered", ["", "1"])
    def test_who_stops_reading_gets_no_traceback_and_the_model(
        self, tmp_path: Path, unbuffered: str
    ):
        write_observations(tmp_path / "dots.npz", SEEN)
        reader, writer = os.pipe()
        os.close(reader)
        words = ["train", str(tmp_path / "dots.npz"), "-o", str(tmp_path / "lips.npz")]
        code = "import sys; from abs_engine.cli import main; sys.exit(main(sys.argv[1:]))"
        done = subprocess.run(
            [sys.executable, "-c", code, *words], stdout=writer, stderr=subprocess.PIPE,
            text=True, check=False, env={**os.environ, "PYTHONUNBUFFERED": unbuffered},
        )  # fmt: skip
        os.close(writer)
        assert done.stderr == ""
        assert done.returncode == 141
        assert (tmp_path / "lips.npz").exists()

    def test_bad_input_is_one_line_and_leaves_nothing(self, tmp_path: Path, capsys):
        write_observations(tmp_path / "dots.npz", lost(SEEN, list(range(20))))
        out = tmp_path / "lips.npz"
        for more in ([], ["--train", "120", "--person", "nobody"], ["--modes", "500"]):
            assert main(["train", str(tmp_path / "dots.npz"), "-o", str(out), *more]) == 2
            assert len(capsys.readouterr().err.strip().splitlines()) == 1
        assert not out.exists()
        assert main(["train", str(tmp_path / "none.npz"), "-o", str(out)]) == 2


def test_hardly_more_frames_than_modes_are_refused():
    """They would hold every frame exactly, and its errors with it."""
    dots = observed_motion(SPEAKER, MOTION, noise=0.1)
    with pytest.raises(ParameterError, match="10 modes cannot be learned from 19 frames"):
        train(dots, SPEAKER, "clara", n_train=19)
    assert train(dots, SPEAKER, "clara", n_train=20).physics.noise > 0.01
    with pytest.raises(ParameterError, match="48 modes of 48 observed coordinates"):
        train(dots, SPEAKER, "clara", n_modes=48, n_train=140)


@pytest.mark.parametrize("person", ["clara", None])
def test_dots_in_a_plane_are_refused(person):
    dots = observed_motion(SPEAKER, MOTION)
    points = dots.points.copy()
    points[:, :16, 2] = points[:, :16, 2].mean() + 0.01 * points[:, :16, 1]
    with pytest.raises(ParameterError, match="lie in a plane to"):
        train(replace(dots, points=points), SPEAKER, person)


def test_what_tracked_lips_are_learned_from_is_speech_at_its_pace_then_slowly(
    monkeypatch: pytest.MonkeyPatch,
):
    authored = cache(authored_motion)  # the same words by the same mouth are the same motion
    monkeypatch.setattr("abs_engine.papers.basu1998.motion.authored_motion", authored)
    motion = spoken_motion(SPEAKER, "mei")
    fast = authored(SPEAKER, "mei", frames=None, sentences=HARVARD)
    assert len(fast) == pytest.approx(26 * RATE, abs=2 * RATE)
    assert len(motion) == len(fast) + SLOWLY * RATE
    np.testing.assert_array_equal(motion.weights[: len(fast)], fast.weights)
    slow = authored(SPEAKER, "mei", frames=int(SLOWLY * RATE))
    np.testing.assert_array_equal(motion.weights[len(fast) :], slow.weights)
    dots = observed_motion(SPEAKER, motion, noise=0.1)
    assert not believe(dots.points[:, : len(LIPS16)], dots.frames).jumped.any()
