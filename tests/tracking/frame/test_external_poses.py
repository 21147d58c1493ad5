"""Head poses that are given to the tracker: read, refused, and used in place of its own."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest
from hurried import hurried
from runs import write_noise

import abs_engine
from abs_engine.cli import main
from abs_engine.core.camera import Camera
from abs_engine.core.errors import InputFileError, ModelFormatError, ParameterError
from abs_engine.core.geometry import FACING, Pose
from abs_engine.tracking.frame import head_tracking
from abs_engine.tracking.frame.clip_setting import NO_POSE
from abs_engine.tracking.frame.external_poses import GivenMotion
from abs_engine.tracking.runs.poses_file import COLUMNS, read_poses
from abs_engine.tracking.runs.record import load_run

CAMERA = Camera.ideal((96, 80))
MOUTH = np.array([0.0, -40.0, 90.0])
T = 4
LOST = 2
TURNS = Pose(FACING, np.zeros(3)).rotation_vector - np.outer(np.arange(T), [0.1, 0, 0])
SHIFTS = np.array([[1.0 + k, 2.0, 700.0] for k in range(T)])


def lost(*arrays: np.ndarray, frame: int = LOST) -> list[np.ndarray]:
    out = [a.copy() for a in arrays]
    for array in out:
        array[frame] = np.nan
    return out


def write_csv(path: Path, turns=TURNS, shifts=SHIFTS, names=COLUMNS, first=None) -> Path:
    with path.open("w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow([*(["index"] if first is not None else []), *names])
        for k, row in enumerate(np.hstack([turns, shifts])):
            cells = ["" if np.isnan(n) else repr(float(n)) for n in row]
            writer.writerow([*([first + k] if first is not None else []), *cells])
    return path


def write_npz(path: Path, turns=TURNS, shifts=SHIFTS, **more) -> Path:
    np.savez(path, rotation=turns, translation=shifts, **more)
    return path


def matrices(turns=TURNS) -> np.ndarray:
    return np.array([Pose.from_vectors(t, np.zeros(3)).rotation for t in turns])


@pytest.mark.parametrize("kind", ["csv", "csv of frames from 1", "vectors", "matrices"])
def test_all_kinds_of_files_say_the_same(tmp_path, kind):
    turns, shifts = lost(TURNS, SHIFTS)
    path = {
        "csv": lambda: write_csv(tmp_path / "a.csv", turns, shifts),
        "csv of frames from 1": lambda: write_csv(tmp_path / "a.csv", turns, shifts, first=1),
        "vectors": lambda: write_npz(tmp_path / "a.npz", turns, shifts),
        "matrices": lambda: write_npz(tmp_path / "a.npz", lost(matrices())[0], shifts),
    }[kind]()
    given = read_poses(path)
    given.check(T, CAMERA, MOUTH)
    assert [k for k, pose in enumerate(given.poses) if pose is None] == [LOST]
    for k in set(range(T)) - {LOST}:
        np.testing.assert_allclose(given.poses[k].rotation, matrices()[k], atol=1e-9)
        np.testing.assert_allclose(given.poses[k].translation, SHIFTS[k])


def changed(array: np.ndarray, value: object, *at: int) -> np.ndarray:
    out = array.copy()
    out[at] = value
    return out


BAD_NPZ = {
    "infinite": ({"shifts": changed(SHIFTS, np.inf, 1, 0)}, "frame 1 .* not finite"),
    "half a pose": ({"turns": changed(TURNS, np.nan, 3)}, "frame 3 .* not complete"),
    "found": (
        dict(zip(("turns", "shifts"), lost(TURNS, SHIFTS), strict=True))
        | {"found": np.ones(T, bool)},
        "frame 2, which is marked as found",
    ),
    "degrees": ({"turns": np.rad2deg(TURNS)}, "frame 0 by 180 rad; give .* radians"),
    "stretched": ({"turns": 1.01 * matrices()}, "frame 0 .* is not a rotation"),
    "mirrored": ({"turns": matrices() * [1, 1, -1]}, "frame 0 .* is not a rotation"),
}


@pytest.mark.parametrize("what", BAD_NPZ)
def test_what_is_no_pose_is_refused(tmp_path, what):
    arrays, said = BAD_NPZ[what]
    with pytest.raises(ParameterError, match=said):
        read_poses(write_npz(tmp_path / "bad.npz", **arrays))


def test_what_is_no_file_of_poses_is_refused(tmp_path):
    wrong = (*COLUMNS[:3], "head_x", "head_ty", "head_tz")
    with pytest.raises(InputFileError, match=r"lacks the columns head_tx .*track --help"):
        read_poses(write_csv(tmp_path / "names.csv", names=wrong))
    (tmp_path / "words.csv").write_text(",".join(COLUMNS) + "\n1,2,x,4,5,6\n")
    with pytest.raises(InputFileError, match="'x' in column head_rz is not a number"):
        read_poses(tmp_path / "words.csv")
    with pytest.raises(InputFileError, match="does not count the frames"):
        read_poses(write_csv(tmp_path / "order.csv", first=5))
    np.savez(tmp_path / "one.npz", rotation=TURNS)
    with pytest.raises(ModelFormatError, match="lacks the array translation"):
        read_poses(tmp_path / "one.npz")
    with pytest.raises(ModelFormatError, match=r"shape \(4, 3\) and translations of \(3, 3\)"):
        read_poses(write_npz(tmp_path / "lengths.npz", shifts=SHIFTS[:3]))
    np.save(tmp_path / "array.npy", TURNS)
    (tmp_path / "array.npy").rename(tmp_path / "array.npz")
    with pytest.raises(InputFileError, match="is not an NPZ file"):
        read_poses(tmp_path / "array.npz")
    with pytest.raises(InputFileError):
        read_poses(tmp_path / "missing.csv")
    with pytest.raises(InputFileError):
        read_poses(tmp_path)


NO_ARRAYS = {
    "a single number": ({"shifts": np.array(700.0)}, r"shape \(4, 3\) and translations of \(\)"),
    "one frame": ({"shifts": SHIFTS[0]}, r"translations of \(3,\)"),
    "single numbers": ({"turns": np.array(0.0), "shifts": np.array(0.0)}, r"translations of \(\)"),
    "text": ({"shifts": SHIFTS.astype(str)}, "not real numbers"),
    "words": ({"turns": np.full((T, 3), "x")}, "not real numbers"),
    "complex": ({"shifts": SHIFTS + 0j}, "not real numbers"),
    "complex turns": ({"turns": matrices() + 0j}, "not real numbers"),
    "truth values": ({"shifts": SHIFTS > 2}, "not real numbers"),
    "marks of other frames": ({"found": np.ones(T + 1, bool)}, "found of .* of each of 4 frames"),
    "marks that are numbers": ({"found": np.full(T, np.nan)}, "found of .* does not say yes or no"),
    "a mark": ({"found": True}, "found of .* does not say yes or no"),
}


@pytest.mark.parametrize("what", NO_ARRAYS)
def test_arrays_that_are_no_poses_are_refused_by_name(tmp_path, what):
    arrays, said = NO_ARRAYS[what]
    with pytest.raises(ModelFormatError, match=said) as caught:
        read_poses(write_npz(tmp_path / "bad.npz", **arrays))
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("shape", [(0, 3), (0, 3, 3)])
def test_no_frames_are_refused_by_name(tmp_path, shape):
    with pytest.raises(InputFileError, match="has no frames; give a pose for each"):
        read_poses(write_npz(tmp_path / "none.npz", np.zeros(shape), np.zeros((0, 3))))


def test_whole_numbers_of_any_kind_are_numbers(tmp_path):
    shifts = SHIFTS.astype(np.uint16)
    given = read_poses(write_npz(tmp_path / "whole.npz", shifts=shifts))
    np.testing.assert_array_equal([pose.translation for pose in given.poses], SHIFTS)


def gaps(path: Path) -> list[int]:
    return [k for k, pose in enumerate(read_poses(path).poses) if pose is None]


@pytest.mark.parametrize("numbers", [0.0, np.inf, np.nan, 1e6])
def test_what_is_not_found_is_no_pose_whatever_its_numbers(tmp_path, numbers):
    turns, shifts = (changed(a, numbers, LOST) for a in (TURNS, SHIFTS))
    found = np.arange(T) != LOST
    for kind in (bool, np.uint8):
        path = write_npz(tmp_path / "a.npz", turns, shifts, found=found.astype(kind))
        assert gaps(path) == [LOST]
    all_covered = np.ones(T, bool)  # which means something of a run only
    assert gaps(write_npz(tmp_path / "b.npz", found=found, covered=all_covered)) == [LOST]


def test_frames_of_a_run_that_are_not_found_have_a_pose_where_they_are_covered(tmp_path):
    run = {"format": "abs_engine.run", "version": 1}
    found = np.array([True, False, False, True])
    covered = np.array([False, True, False, False])
    assert gaps(write_npz(tmp_path / "a.npz", **run, found=found, covered=covered)) == [2]
    assert gaps(write_npz(tmp_path / "b.npz", **run, found=found)) == [1, 2]
    shifts = changed(SHIFTS, np.nan, 1)
    turns = changed(TURNS, np.nan, 1)
    path = write_npz(tmp_path / "c.npz", turns, shifts, **run, found=found, covered=covered)
    assert gaps(path) == [1, 2]
    with pytest.raises(ModelFormatError, match=r"covered of .* does not say yes or no"):
        read_poses(write_npz(tmp_path / "d.npz", **run, found=found, covered=covered[:2]))


def test_truth_that_knows_no_camera_is_refused_by_name(tmp_path):
    path = write_npz(tmp_path / "truth.npz", format="abs_engine.dataset", version=2)
    with pytest.raises(ModelFormatError, match="DATASET/CLIP/CAMERA"):
        read_poses(path)


NOTHING = {"turns": np.nan * TURNS, "shifts": np.nan * SHIFTS}
MISFITS = {
    "too many": ({}, 3, "4 poses for the video's 3 frames"),
    "too few": ({}, 5, "4 poses for the video's 5 frames"),
    "metres": ({"shifts": SHIFTS / 1000}, T, "behind the camera; give translations in mm"),
    "other axes": ({"turns": TURNS - TURNS[0]}, T, "no frame in which the face looks towards"),
    "none": (NOTHING, T, "no frame of .* has a pose"),
}


@pytest.mark.parametrize("what", MISFITS)
def test_poses_that_do_not_fit_the_video_are_refused(tmp_path, what):
    arrays, frames, said = MISFITS[what]
    given = read_poses(write_npz(tmp_path / "given.npz", **arrays))
    with pytest.raises(ParameterError, match=said):
        given.check(frames, CAMERA, MOUTH)


def test_poses_of_a_run_by_another_camera_are_refused(tmp_path):
    run = {
        "format": "abs_engine.run", "version": 1, "camera_matrix": CAMERA.matrix,
        "camera_distortion": CAMERA.distortion, "camera_size": CAMERA.size,
    }  # fmt: skip
    given = read_poses(write_npz(tmp_path / "results.npz", **run))
    given.check(T, CAMERA, MOUTH)
    assert len(read_poses(tmp_path).poses) == T  # the folder of a run
    for other in (Camera.ideal((96, 80), 300.0), Camera.ideal((80, 96))):
        with pytest.raises(ParameterError, match=r"another camera .*--camera"):
            given.check(T, other, MOUTH)
    for version, said in ((9, "9"), ("x", "unknown"), ([1, 2], "unknown")):
        with pytest.raises(ModelFormatError, match=f"version {said}"):
            read_poses(write_npz(tmp_path / "new.npz", **run | {"version": version}))
    several = write_npz(tmp_path / "several.npz", **run | {"format": ["abs_engine.run"] * 2})
    assert read_poses(several).camera is None  # not known to be a run
    for name, wrong in (
        ("camera_size", np.array([96.0, np.inf])),
        ("camera_size", np.array(96)),
        ("camera_matrix", CAMERA.matrix[:2]),
        ("camera_matrix", CAMERA.matrix.astype(str)),
        ("camera_distortion", CAMERA.distortion + 0j),
    ):
        with pytest.raises(ModelFormatError, match="holds no camera"):
            read_poses(write_npz(tmp_path / "wrong.npz", **run | {name: wrong}))


def test_poses_of_an_average_head_are_not_held(tmp_path):
    run = {"format": "abs_engine.run", "version": 1}
    average = read_poses(write_npz(tmp_path / "a.npz", **run, person_weights=np.zeros(8)))
    average.check(T, CAMERA, MOUTH)
    with pytest.raises(ParameterError, match=r"average head.*leave out --person, or give poses"):
        average.check(T, CAMERA, MOUTH, held=True)
    for more in ({}, {"person_weights": np.zeros(0)}):
        read_poses(write_npz(tmp_path / "b.npz", **run, **more)).check(T, CAMERA, MOUTH, held=True)
    other = read_poses(write_npz(tmp_path / "c.npz", person_weights=np.zeros(8)))
    other.check(T, CAMERA, MOUTH, held=True)  # no run


def test_given_motion_looks_at_nothing_but_counts():
    poses = tuple(Pose.from_vectors(*p) for p in zip(TURNS, SHIFTS, strict=True))
    images = [np.full((2, 2, 3), k, np.uint8) for k in range(T + 1)]
    motion = GivenMotion(poses)
    assert [pose for _, pose in head_tracking.followed(motion, images[:T])] == list(poses)
    for wrong in (images, images[:-2]):
        with pytest.raises(ParameterError, match="4 poses for"):
            list(head_tracking.followed(motion, wrong))


def test_frames_are_learned_from_whose_mouth_is_in_the_picture():
    beside = Pose(FACING, np.array([900.0, 0, 700.0]))
    behind = Pose(FACING, np.array([0.0, 0, -700.0]))
    there = Pose(FACING, np.array([0.0, -40.0, 700.0]))
    through = Pose(FACING, np.array([0.0, -40.0, 60.0]))  # the mouth, not the head, is behind
    off = (88 - CAMERA.matrix[0, 2]) * (700 - MOUTH[2]) / CAMERA.matrix[0, 0]
    aside = Pose(FACING, np.array([off, -40.0, 700.0]))  # column 88 of 96, in 80 rows
    given = GivenMotion((beside, None, there, behind, through, aside))
    seen = given.in_picture(CAMERA, MOUTH, Path("a.mpg"))
    assert seen.given == (None, None, there, None, None, aside)


@pytest.mark.parametrize(
    ("rows", "more", "said"),
    [
        (3, [], "3 poses for the video's 4 frames; give one for each frame"),
        (4, ["--mouth", 10, 10, 30, 20], "leave out --mouth, or --poses"),
        (0, [], "has no line below its column names"),
    ],
)
def test_bad_poses_end_the_command_in_one_line(tmp_path, capsys, rows, more, said):
    video = write_noise(tmp_path / "noise.mp4", T)
    poses = write_csv(tmp_path / "poses.csv", TURNS[:rows], SHIFTS[:rows])
    before = sorted(tmp_path.rglob("*"))
    words = ["track", video, "-o", tmp_path / "run", "--renderer", "cpu", "--poses", poses, *more]
    assert main([str(w) for w in words]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert said in line
    assert sorted(tmp_path.rglob("*")) == before


def test_an_average_heads_run_with_a_person_ends_the_command_in_one_line(tmp_path, capsys):
    video = write_noise(tmp_path / "noise.mp4", T)
    (tmp_path / "average").mkdir()
    run = {"format": "abs_engine.run", "version": 1, "person_weights": np.zeros(8)}
    write_npz(tmp_path / "average" / "results.npz", **run)
    words = ["track", video, "-o", tmp_path / "run", "--renderer", "cpu", "--person", "clara"]
    assert main([str(w) for w in [*words, "--poses", tmp_path / "average"]]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert "leave out --person, or give poses of a run with --person" in line
    assert not (tmp_path / "run").exists()


def test_poses_that_never_show_the_mouth_end_the_command(tmp_path, capsys):
    video = write_noise(tmp_path / "noise.mp4", T)
    poses = write_csv(tmp_path / "poses.csv", TURNS, SHIFTS + np.array([5000.0, 0, 0]))
    words = ["track", video, "-o", tmp_path / "run", "--renderer", "cpu", "--poses", poses]
    assert main([str(w) for w in words]) == 2
    assert "the mouth is outside the picture in all frames" in capsys.readouterr().err
    assert not (tmp_path / "run").exists()


# ---- end to end ----------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def truth(filmed):
    """A clip of half a second, filmed by the studio."""
    return filmed


def tracked(truth, folder: Path, poses: Path, *more: object):
    camera = truth.folder / "camera.json"
    words = ["track", truth.video, "-o", folder, "--renderer", "cpu", "--camera", camera]
    assert main([str(w) for w in [*words, "--poses", poses, *more]]) == 0
    return load_run(folder)


@pytest.fixture(scope="module")
def run(truth, tmp_path_factory):
    """Clara by her own head and the true poses; whoever looks for her face fails."""
    folder = tmp_path_factory.mktemp("known") / "run"
    with pytest.MonkeyPatch.context() as patch:
        for name in ("find_face", "faces_about", "follow", "rigid_reference"):
            patch.setattr(head_tracking, name, None)
        return tracked(truth, folder, truth.folder, "--person", "clara"), folder


def lip_error(arrays, truth) -> float:
    """RMS error of the lip points of the frames found, mm, head coordinates."""
    away = (arrays["lip_points"] - truth.points(arrays["lip_vertex"]))[arrays["found"]]
    return float(np.sqrt((away**2).sum(axis=-1).mean()))


def test_true_poses_are_taken_as_they_are_and_the_lips_are_found(run, truth):
    arrays, _ = run
    assert arrays["found"].all()
    np.testing.assert_allclose(matrices(arrays["rotation"]), matrices(truth.rotations), atol=1e-9)
    np.testing.assert_allclose(arrays["translation"], truth.translations)
    assert not arrays["parameters"][:, :6].any()
    # 1.6 mm measured, most of it depth, which a frontal view hardly shows
    assert lip_error(arrays, truth) < 1.8


def test_the_table_of_a_run_feeds_another_and_gaps_stay_gaps(run, truth, tmp_path):
    arrays, folder = run
    with (folder / "results.csv").open(newline="") as file:
        rows = list(csv.reader(file))
    for name in COLUMNS:
        rows[1 + LOST][rows[0].index(name)] = ""
    with (tmp_path / "edited.csv").open("w", newline="") as file:
        csv.writer(file).writerows(rows)
    again = abs_engine.track(
        truth.video, renderer="cpu", camera=truth.folder / "camera.json", person="clara",
        poses=tmp_path / "edited.csv", colours=folder / "colours.npz",
    )  # fmt: skip
    assert np.flatnonzero(~again["found"]).tolist() == [LOST]
    assert again["status"][LOST] == NO_POSE
    assert np.isnan(again["translation"][LOST]).all()
    others = again["found"]
    np.testing.assert_allclose(
        again["translation"][others], arrays["translation"][others], atol=1e-2
    )
    assert (
        lip_error(again.arrays, truth) < lip_error(arrays, truth) + 0.3
    )  # after the gap it starts anew


def test_to_the_average_head_they_are_a_first_guess(run, truth, tmp_path):
    _, folder = run
    with hurried(frames=2, rounds=1):
        arrays = tracked(truth, tmp_path / "run", folder, "--colours", folder / "colours.npz")
    assert [read_poses(f).average_head for f in (folder, tmp_path / "run")] == [False, True]
    assert arrays["found"].all()
    assert arrays["parameters"][:, :6].any()
    assert np.corrcoef(arrays["aperture"], truth.aperture)[0, 1] > 0.9
