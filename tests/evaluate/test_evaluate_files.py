"""Results in files, ours and other systems', and the command that scores them."""

from __future__ import annotations

import csv
import json
import os
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from results import (
    FRAMES,
    RATE,
    areas,
    arkit_rows,
    clip,
    reference_of,
    run_arrays,
    speaker,
    true_landmarks,
    wide_rows,
    write_csv,
    write_dataset,
    write_run,
)
from scipy.spatial.transform import Rotation

from abs_engine.cli import main
from abs_engine.core.errors import InputFileError, ModelFormatError, ParameterError
from abs_engine.core.geometry import FACING, rotations
from abs_engine.dataset.timecode import BASES, seconds_since_first
from abs_engine.evaluate.arkit_csv import read_arkit
from abs_engine.evaluate.landmark_csv import read_landmarks
from abs_engine.evaluate.score import measure, summary
from abs_engine.io.csv_table import read_table
from abs_engine.report.inspect.runs import load_run_head
from abs_engine.report.scoring import default_folder, evaluate
from abs_engine.studio.speech import read_livelink
from abs_engine.tracking.results.run_mesh import load_mesh

MARKS = slice(48, 68)


@pytest.fixture(scope="module")
def truth():
    return clip()


@pytest.fixture(scope="module")
def reference(truth):
    return reference_of(truth)


@pytest.fixture(scope="module")
def dataset(truth, tmp_path_factory):
    return write_dataset(tmp_path_factory.mktemp("data") / "set", truth)


def scored(estimate, truth):
    scores = summary([measure(estimate, truth, truth.landmarks["landmark_68"])])
    return {key: score.value for key, score in scores.items()}


def landmarks_of(path, truth, reference):
    return scored(read_landmarks(path, reference), truth)


def arkit(path, reference):
    return read_arkit(path, reference, speaker().unit_names, speaker().units, areas())


def long_rows(truth, unit):
    pixels, points = true_landmarks(truth)
    source = pixels if unit == "px" else points
    return ["frame", "time", "point", "x", "y", "z", "unit"], [
        [t, t / RATE, k, *source[t, k], *([""] if unit == "px" else []), unit]
        for t in range(len(truth))
        for k in range(68)
    ]


def test_a_wide_file_of_the_truth_scores_nothing(truth, reference, tmp_path):
    path = write_csv(tmp_path / "a.csv", *wide_rows(truth, *true_landmarks(truth)))
    scores = landmarks_of(path, truth, reference)
    for key in ("landmarks_rms_px", "lips_nme", "landmarks_rms_camera_mm"):
        assert scores[key] == pytest.approx(0, abs=1e-9)
    assert scores["failure_share"] == 0
    assert "landmarks_rms_head_mm" not in scores


def test_the_pose_of_a_wide_file(truth, reference, tmp_path):
    heading, rows = wide_rows(truth, *true_landmarks(truth))
    heading += ["pose_Rx", "pose_Ry", "pose_Rz", "pose_Tx", "pose_Ty", "pose_Tz"]
    turned = Rotation.from_matrix(rotations(truth.rotations) @ FACING.T).as_euler("XYZ")
    rows = [[*row, *turned[t], *truth.translations[t]] for t, row in enumerate(rows)]
    scores = landmarks_of(write_csv(tmp_path / "a.csv", heading, rows), truth, reference)
    assert scores["head_angle_rms_deg"] == pytest.approx(0, abs=1e-5)
    assert scores["head_position_rms_mm"] == pytest.approx(0, abs=1e-9)
    for key in ("landmarks_rms_head_mm", "aperture_rms_mm", "width_rms_mm", "protrusion_rms_mm"):
        assert scores[key] == pytest.approx(0, abs=1e-6)


@pytest.mark.parametrize("unit", ["px", "mm"])
def test_a_long_file_of_the_truth_scores_nothing(truth, reference, tmp_path, unit):
    path = write_csv(tmp_path / "a.csv", *long_rows(truth, unit))
    scores = landmarks_of(path, truth, reference)
    key = {"px": "landmarks_rms_px", "mm": "landmarks_rms_camera_mm"}[unit]
    assert scores[key] == pytest.approx(0, abs=1e-9)
    assert scores["landmarks_rms_px"] == pytest.approx(0, abs=1e-9)  # mm: by the true camera
    assert ("landmarks_rms_camera_mm" in scores) == (unit == "mm")
    assert ("lip_landmarks_rms_camera_mm" in scores) == (unit == "mm")


def test_a_long_file_with_the_columns_of_two_dimensions_alone(truth, reference, tmp_path):
    pixels, _ = true_landmarks(truth)
    rows = [[t, k, *pixels[t, k], "px"] for t in range(FRAMES) for k in range(68)]
    path = write_csv(tmp_path / "a.csv", ["frame", "point", "x", "y", "unit"], rows)
    scores = landmarks_of(path, truth, reference)
    assert scores["landmarks_rms_px"] == pytest.approx(0, abs=1e-9)
    assert scores["failure_share"] == 0


@pytest.mark.parametrize("unit", ["px", "mm"])
def test_points_that_one_frame_lacks_count_in_the_others(truth, reference, tmp_path, unit):
    heading, rows = long_rows(truth, unit)
    rows = [row for row in rows if not (row[0] == 0 and row[2] >= 48)]
    for row in rows:
        row[heading.index("x")] += 30.0 * (row[2] >= 48)
    estimate = read_landmarks(write_csv(tmp_path / "a.csv", heading, rows), reference)
    clip_scores = measure(estimate, truth, truth.landmarks["landmark_68"])
    scores = {key: score.value for key, score in summary([clip_scores]).items()}
    key = {"px": "landmarks_rms_px", "mm": "landmarks_rms_camera_mm"}[unit]
    wanted = 30 * np.sqrt(20 / 68 * (FRAMES - 1) / FRAMES)
    assert scores[key] == pytest.approx(wanted, abs=1e-6)
    assert scores["failure_share"] == 1
    assert scores["landmarks_given"] == pytest.approx(1 - 20 / 68 / FRAMES)
    assert scores["lips_given"] == pytest.approx(1 - 1 / FRAMES)
    assert "1 of 60 tracked frames lack points" in clip_scores.notes[0]
    assert "(48, 49, 50, 51, 52, 53, 54, 55 and 12 more)" in clip_scores.notes[0]


@pytest.mark.parametrize("unit", ["px", "mm"])
def test_a_frame_without_lips_or_most_points_failed(truth, reference, tmp_path, unit):
    heading, rows = long_rows(truth, unit)
    lacks = {3: [50], 5: range(35), 7: range(34)}  # one of the lips; most; half
    rows = [row for row in rows if row[2] not in lacks.get(row[0], ())]
    scores = landmarks_of(write_csv(tmp_path / "a.csv", heading, rows), truth, reference)
    assert scores["failure_share"] == pytest.approx(2 / FRAMES)
    assert scores["landmarks_rms_px"] == pytest.approx(0, abs=1e-9)


def test_most_points_are_most_of_those_that_a_system_gives(truth, reference, tmp_path):
    """Without the 17 of the jaw there are 51, of which one frame lacks 26 and another 25."""
    heading, rows = long_rows(truth, "px")
    lacks = {5: range(17, 43), 7: range(17, 42)}
    rows = [row for row in rows if row[2] >= 17 and row[2] not in lacks.get(row[0], ())]
    scores = landmarks_of(write_csv(tmp_path / "a.csv", heading, rows), truth, reference)
    assert scores["failure_share"] == pytest.approx(1 / FRAMES)


def test_points_that_are_never_given_say_nothing_of_failure(truth, reference, tmp_path):
    heading, rows = long_rows(truth, "mm")
    rows = [row for row in rows if row[2] < 60]
    estimate = read_landmarks(write_csv(tmp_path / "a.csv", heading, rows), reference)
    clip_scores = measure(estimate, truth, truth.landmarks["landmark_68"])
    scores = {key: score.value for key, score in summary([clip_scores]).items()}
    assert (scores["failure_share"], scores["landmarks_given"]) == (0, 1)
    assert clip_scores.notes == ()


def test_a_long_file_in_head_coordinates(truth, reference, tmp_path):
    points = truth.points(truth.landmarks["landmark_68"])
    rows = [
        [t, k, *points[t, k], "mm", "head"] for t in range(FRAMES) for k in range(48, 68)
    ]  # the lips alone
    heading = ["frame", "point", "x", "y", "z", "unit", "space"]
    scores = landmarks_of(write_csv(tmp_path / "a.csv", heading, rows), truth, reference)
    assert scores["landmarks_rms_head_mm"] == pytest.approx(0, abs=1e-9)
    assert scores["protrusion_rms_mm"] == pytest.approx(0, abs=1e-9)


def test_noise_in_a_file_scores_itself(truth, reference, tmp_path):
    rng = np.random.default_rng(1)
    pixels, points = (a + rng.normal(size=a.shape) * 0.8 for a in true_landmarks(truth))
    path = write_csv(tmp_path / "a.csv", *wide_rows(truth, pixels, points))
    scores = landmarks_of(path, truth, reference)
    assert scores["landmarks_rms_px"] == pytest.approx(0.8 * np.sqrt(2), rel=0.05)
    assert scores["landmarks_rms_camera_mm"] == pytest.approx(0.8 * np.sqrt(3), rel=0.05)


@pytest.mark.parametrize("unit", ["px", "mm"])
def test_closures_seen_by_landmarks(truth, reference, tmp_path, unit):
    path = write_csv(tmp_path / "a.csv", *long_rows(truth, unit))
    found = read_landmarks(path, reference).closed
    wide_open, shut = truth.aperture > 2.5, truth.aperture == 0
    assert wide_open.sum() > 20
    assert not found[wide_open].any()
    assert shut.sum() > 10
    assert found[shut].all()


def test_lost_frames_are_empty_or_without_success(truth, reference, tmp_path):
    heading, rows = wide_rows(truth, *true_landmarks(truth))
    rows[4][3:] = [""] * len(rows[4][3:])
    rows[7][2], rows[7][3:] = 0, [0.0] * len(rows[7][3:])
    estimate = read_landmarks(write_csv(tmp_path / "a.csv", heading, rows), reference)
    assert measure(estimate, truth, truth.landmarks["landmark_68"]).notes == ()
    scores = scored(estimate, truth)
    assert scores["frames_lost"] == 2
    assert scores["failure_share"] == pytest.approx(2 / FRAMES)
    assert scores["landmarks_rms_px"] == pytest.approx(0, abs=1e-9)


def test_a_face_unit_file_of_the_truth_scores_nothing(truth, reference, tmp_path):
    path = write_csv(tmp_path / "a.csv", *arkit_rows(truth))
    scores = scored(arkit(path, reference), truth)
    for area in areas():
        assert scores[f"{area}_rms_head_mm"] == pytest.approx(0, abs=1e-6)
        assert f"{area}_rms_camera_mm" not in scores  # the file does not say where the head is
    assert scores["head_angle_offset_removed_rms_deg"] == pytest.approx(0, abs=1e-5)
    assert "head_angle_rms_deg" not in scores
    assert scores["aperture_rms_mm"] == pytest.approx(0, abs=1e-6)
    for key in ("precision_frames", "recall_frames", "precision_events", "recall_events"):
        assert scores[f"closure_{key}"] == 1  # the same definition as the studio's


def test_timecodes_of_another_duration_are_refused(truth, reference, tmp_path):
    heading, rows = arkit_rows(truth)
    slow = [[f"00:00:{k // 20:02d}:{5 * k % 100 // 5:02d}", *row[1:]] for k, row in enumerate(rows)]
    with pytest.raises(ParameterError, match=r"lasts 2\.79 s by its timecodes, the truth 2\.36 s"):
        arkit(write_csv(tmp_path / "a.csv", heading, slow), reference)  # 2 s + 19 / 24 s
    night = [["", *row[1:]] for row in rows]
    assert arkit(write_csv(tmp_path / "b.csv", heading, night), reference).found.all()
    codes = [
        f"23:59:59:{k:02d}" if k < 25 else f"00:00:0{k // 25 - 1}:{k % 25:02d}"
        for k in range(FRAMES)
    ]
    night = [[code, *row[1:]] for code, row in zip(codes, rows, strict=True)]
    assert arkit(write_csv(tmp_path / "c.csv", heading, night), reference).found.all()


def test_a_wrong_weight_scores_what_it_moves(truth, reference, tmp_path):
    heading, rows = arkit_rows(truth)
    at = heading.index("MouthSmileLeft")
    for row in rows:
        row[at] = 0.5
    scores = scored(arkit(write_csv(tmp_path / "a.csv", heading, rows), reference), truth)
    moved = 0.5 * np.linalg.norm(speaker().unit_matrix(("mouthSmileLeft",))[0], axis=1)
    expected = np.sqrt((moved[areas()["lips"]] ** 2).mean())
    assert scores["lips_rms_head_mm"] == pytest.approx(expected, rel=1e-5)


def test_another_frame_rate_is_brought_to_the_frames(truth, reference, tmp_path):
    heading, _ = arkit_rows(truth)
    at = heading.index("JawOpen")
    dense = []  # jawOpen rises by 0.5 in a second, at 50 rows a second
    for k in range(2 * FRAMES - 1):
        row = [f"00:00:{k // 50:02d}:{k % 50:02d}.000", 61, *[0.0] * (len(heading) - 2)]
        row[at] = 0.01 * k
        dense.append(row)
    found = arkit(write_csv(tmp_path / "a.csv", heading, dense), reference)
    unit = speaker().unit_names.index("jawOpen")
    np.testing.assert_allclose(found.surface.weights[:, unit], 0.02 * np.arange(FRAMES), atol=1e-12)


def test_both_readers_of_face_units_have_one_clock(truth, reference, tmp_path):
    """The same file is scored and played at the same times, whatever its timecodes count."""
    heading, rows = arkit_rows(truth)
    for base in BASES:
        codes = [f"23:59:{58 + k // base:02d}:{k % base:02d}.000" for k in range(2 * base)]
        codes += [f"00:00:{k // base:02d}:{k % base:02d}.000" for k in range(2 * base)]
        lines = [[code, *rows[k % len(rows)][1:]] for k, code in enumerate(codes)]
        path = write_csv(tmp_path / f"{base}.csv", heading, lines)
        times = read_livelink(path).times
        np.testing.assert_allclose(times, np.arange(4 * base) / base, atol=1e-9)
        np.testing.assert_array_equal(seconds_since_first(codes, path), times)
        with pytest.raises(ParameterError, match=f"lasts {times[-1]:.2f} s"):
            arkit(path, reference)


def _without(heading, rows, *names):
    keep = [k for k, name in enumerate(heading) if name not in names]
    return [heading[k] for k in keep], [[row[k] for k in keep] for row in rows]


def test_wide_files_that_are_wrong(truth, reference, tmp_path):
    good = wide_rows(truth, *true_landmarks(truth))

    def fails(error, match, heading, rows):
        path = tmp_path / f"{len(list(tmp_path.iterdir()))}.csv"
        with pytest.raises(error, match=match):
            read_landmarks(write_csv(path, heading, rows), reference)

    heading, rows = good
    fails(
        InputFileError,
        r"lacks the columns x_5 .*; for a run, give its folder",
        *_without(*good, "x_5"),
    )
    fails(InputFileError, "there is 'Frame'", ["Frame", *heading[1:]], rows)
    fails(ParameterError, "59 frames from 1 to 59, the truth 60", heading, rows[:-1])
    late = [[row[0] + 4, *row[1:]] for row in rows]
    fails(ParameterError, "60 frames from 5 to 64", heading, late)
    slow = [[row[0], row[1] * 25 / 30, *row[2:]] for row in rows]
    fails(ParameterError, r"frame 4 at 0\.133333 s, the truth at 0\.16 s", heading, slow)
    nan = [list(row) for row in rows]
    nan[2][5] = float("nan")
    fails(InputFileError, "line 4: 'nan' in column x_2", heading, nan)
    fails(InputFileError, "twice", heading, [*rows, rows[0]])
    pixels, points = true_landmarks(truth)
    fails(InputFileError, "between 0 and", *wide_rows(truth, pixels / 640, points))
    fails(InputFileError, "give points in mm", *wide_rows(truth, pixels, points / 1000))
    fails(InputFileError, r"line 2: 4 cells", heading, [rows[0][:4], *rows[1:]])


def test_blank_lines_count_where_a_line_is_named(tmp_path):
    path = tmp_path / "gaps.csv"
    path.write_text("\na,b\n\n1,2\n,\n\n3,x\n")
    with pytest.raises(InputFileError, match="line 7: 'x' in column b"):
        read_table(path).numbers(("a", "b"))
    path.write_text("a,b\n\n\n1,2,3\n")
    with pytest.raises(InputFileError, match="line 4: 3 cells under 2 names"):
        read_table(path)


def test_long_files_that_are_wrong(truth, reference, tmp_path):
    heading, rows = long_rows(truth, "px")

    def fails(error, match, heading, rows):
        path = tmp_path / f"{len(list(tmp_path.iterdir()))}.csv"
        with pytest.raises(error, match=match):
            read_landmarks(write_csv(path, heading, rows), reference)

    fails(InputFileError, "lacks the columns unit", *_without(heading, rows, "unit"))
    fails(InputFileError, "the unit 'cm'", heading, [[*row[:-1], "cm"] for row in rows])
    fails(InputFileError, "other than 0 to 67", heading, [[*rows[0][:2], 68, *rows[0][3:]], *rows])
    fails(InputFileError, "a point twice", heading, [*rows, rows[0]])
    fails(ParameterError, "59 frames", heading, rows[:-68])
    solid = long_rows(truth, "mm")
    fails(InputFileError, "lacks the column z", *_without(*solid, "z"))
    spaces = [[*row, "moon"] for row in solid[1]]
    fails(InputFileError, "spaces moon", [*solid[0], "space"], spaces)
    fails(InputFileError, "has no line below its column names", heading, [])


def test_face_unit_files_that_are_wrong(truth, reference, tmp_path):
    heading, rows = arkit_rows(truth)

    def fails(error, match, heading, rows):
        path = tmp_path / f"{len(list(tmp_path.iterdir()))}.csv"
        with pytest.raises(error, match=match):
            arkit(write_csv(path, heading, rows), reference)

    fails(InputFileError, "lacks the columns mouthpucker", *_without(heading, rows, "MouthPucker"))
    fails(ParameterError, "lasts 1.56 s", heading, rows[:40])
    fails(ParameterError, "40 rows", *_without(heading, rows[:40], "Timecode"))
    wrong = [[*row[:2], 100.0, *row[3:]] for row in rows]
    fails(InputFileError, "weights from 0 to 1", heading, wrong)
    below = [[*row[:2], -0.5, *row[3:]] for row in rows]
    fails(InputFileError, "a weight of .* is -0.5; give weights from 0 to 1", heading, below)
    degrees = [[*row[:-1], 20.0] for row in rows]
    fails(InputFileError, "a head angle of .* is 20; give radians", heading, degrees)
    for count in (FRAMES, 20):  # as long as the clip, and otherwise
        turned = rows[:count][::-1]
        fails(InputFileError, "line 3 of .* has a timecode before the one above", heading, turned)


def test_the_command_scores_systems_side_by_side(truth, dataset, tmp_path, capsys):
    run = write_run(tmp_path / "run", truth)
    pixels, points = true_landmarks(truth)
    landmarks = write_csv(tmp_path / "other.csv", *wide_rows(truth, pixels + 1.0, points))
    units = write_csv(tmp_path / "phone.csv", *arkit_rows(truth))
    out = tmp_path / "scores"
    words = ["evaluate", run, landmarks, units, "--truth", dataset, "-o", out]
    assert main([str(word) for word in words]) == 0
    printed = capsys.readouterr().out
    assert printed.splitlines()[0].split() == ["run", "other", "phone"]
    told = json.loads((out / "scores.json").read_text())
    assert (told["format"], told["version"]) == ("abs_engine.scores", 1)
    run_scores, other, phone = (told["systems"][n] for n in ("run", "other", "phone"))
    # what is filmed is rounded to half precision: under 0.01 mm
    assert run_scores["lips_rms_head_mm"]["value"] < 0.01
    assert phone["lips_rms_head_mm"]["value"] < 0.01
    assert other["landmarks_rms_px"]["value"] == pytest.approx(np.sqrt(2), abs=0.02)
    points = {f"{n}_jitter_mm" for n in ("landmarks", "lip_landmarks")} | {"failure_share"}
    picture = {"landmarks_rms_px", "landmarks_nme", "lips_rms_px", "lips_nme"}
    placed = {f"{n}_rms_camera_mm" for n in ("landmarks", "lip_landmarks")}
    in_head = {f"{n}_rms_head_mm" for n in ("landmarks", "lip_landmarks")}
    assert set(run_scores) >= points | picture | placed | in_head
    assert set(other) >= points | picture | placed
    assert set(phone) >= points | in_head
    assert run_scores["landmarks_rms_px"]["value"] < 0.05
    assert set(told["metrics"]) >= set(run_scores) | set(other) | set(phone)
    with (out / "scores.csv").open() as file:
        lines = list(csv.DictReader(file))
    row = next(r for r in lines if r["system"] == "other" and r["metric"] == "landmarks_rms_px")
    assert float(row["value"]) == pytest.approx(other["landmarks_rms_px"]["value"], rel=1e-5)
    with np.load(out / "error_map_run.npz") as saved:
        assert str(saved["format"]) == "abs_engine.error_map"
        assert saved["vertex_rms_mm"].shape == (len(truth.neutral),)
        assert saved["vertex_rms_mm"].max() < 0.05
    assert not (out / "error_map_other.npz").exists()


def test_the_command_scores_one_run_where_it_lies(truth, dataset, tmp_path, capsys):
    run = write_run(tmp_path / "run", truth, width=truth.width + 2.0)
    assert main(["evaluate", str(run), "--truth", str(dataset / "clip" / "camera")]) == 0
    assert "lip points, head coordinates, RMS" in capsys.readouterr().out
    told = json.loads((run / "evaluation" / "scores.json").read_text())["systems"]["run"]
    assert told["width_bias_mm"]["value"] == pytest.approx(2, abs=0.01)
    assert not (run / "evaluation" / "truth_scores.json").exists()
    assert (run / "evaluation" / "truth_curves.png").stat().st_size > 1000
    assert main(["evaluate", str(run), "--truth", str(dataset)]) == 2
    assert capsys.readouterr().err.endswith("remove it (-o gives another place)\n")


def test_a_result_whose_name_is_no_utf_8_is_scored(truth, dataset, tmp_path, capsys):
    path = write_csv(tmp_path / "lat\udce4n.csv", *wide_rows(truth, *true_landmarks(truth)))
    out = tmp_path / "out"
    words = [str(path), "--truth", str(dataset), "-o", str(out), "--json"]
    assert main(["evaluate", *words]) == 0
    assert list(json.loads(capsys.readouterr().out)["systems"]) == [r"lat\udce4n"]
    assert r"lat\udce4n" in (out / "scores.csv").read_text()


def test_the_command_says_how_to_choose_a_place_whatever_is_wrong_with_the_usual_one(
    truth, dataset, tmp_path, monkeypatch, capsys
):
    run = write_run(tmp_path / "run", truth)
    monkeypatch.setattr(os, "access", lambda path, mode: path != run)
    words = ["evaluate", str(run), "--truth", str(dataset)]
    assert main(words) == 2
    said = capsys.readouterr().err
    assert "evaluation cannot be written (Permission denied)" in said
    assert said.endswith("(-o gives another place)\n")
    assert main([*words, "-o", str(run / "scores")]) == 2
    assert "(-o" not in capsys.readouterr().err


@pytest.mark.parametrize(
    ("moved", "said"), [(9.0, "every frame failed: is this"), (300.0, "is this the clip and cam")]
)
def test_the_command_warns_of_what_another_view_scores(
    truth, dataset, tmp_path, caplog, moved, said
):
    pixels, points = true_landmarks(truth)
    heading, rows = wide_rows(truth, pixels + 100.0, points + moved)
    path = write_csv(tmp_path / "a.csv", heading, rows)
    out = tmp_path / "out"
    assert main(["evaluate", str(path), "--truth", str(dataset), "-o", str(out)]) == 0
    assert said in caplog.text
    told = json.loads((out / "scores.json").read_text())
    assert said in told["notes"]["a"][0]
    assert told["views"] == ["clip/camera"]


def test_what_lies_well_in_the_picture_is_of_this_view(truth, dataset, tmp_path, caplog):
    pixels, points = true_landmarks(truth)
    path = write_csv(tmp_path / "a.csv", *wide_rows(truth, pixels, points + 9.0))
    done = evaluate([path], [dataset], tmp_path / "out")
    assert done.systems["a"]["failure_share"].value == 1
    (line,) = (line for line in done.lines() if line.startswith("frames that failed"))
    assert line.split() == ["frames", "that", "failed", "(%)", "100", "[100,", "100]"]
    assert not caplog.records


def test_a_run_far_from_the_truth_is_asked_about_as_a_file_is(truth, dataset, tmp_path, caplog):
    run = write_run(tmp_path / "run", truth, translation=truth.translations + 90.0)
    evaluate([run], [dataset], tmp_path / "out")
    assert "mm (RMS) from the truth: is this the clip" in caplog.text


def test_a_constant_offset_is_named_where_it_makes_frames_fail(truth, dataset, tmp_path, caplog):
    for name, moved, said in (("near", 4.0, False), ("off", 9.0, True)):
        run = write_run(tmp_path / name, truth)
        mesh = load_mesh(run)
        replace(mesh, mean=mesh.mean + np.float32(moved) * np.eye(3, dtype=np.float32)[1]).save(run)
        caplog.clear()
        evaluate([run], [dataset], tmp_path / f"out-{name}")
        line = "points are 9.0 mm off in head coordinates, 0.0 mm once it is removed"
        assert (line in caplog.text) == said


def test_the_command_pools_clips(truth, dataset, tmp_path):
    runs = [write_run(tmp_path / n, truth, width=truth.width + k) for k, n in ((1, "a"), (3, "b"))]
    out = tmp_path / "out"
    words = ["evaluate", *runs, "--truth", dataset, dataset, "-o", out]
    assert main([str(word) for word in words]) == 0
    systems = json.loads((out / "scores.json").read_text())["systems"]
    assert list(systems) == ["a", "b", "all clips"]
    assert systems["all clips"]["width_bias_mm"]["value"] == pytest.approx(2, abs=0.01)
    assert systems["all clips"]["frames"]["value"] == 2 * FRAMES


def test_the_command_refuses_on_one_line(truth, dataset, tmp_path, capsys):
    def fails(*words):
        assert main(["evaluate", *map(str, words)]) == 2
        err = capsys.readouterr().err
        assert len(err.splitlines()) == 1
        return err

    out = tmp_path / "out"
    short = write_run(tmp_path / "short", clip(20))
    assert "has 20 frames, the truth 60" in fails(short, "--truth", dataset, "-o", out)
    assert "does not exist" in fails(tmp_path / "no.csv", "--truth", dataset, "-o", out)
    run = write_run(tmp_path / "run", truth)
    assert "1 results and 2 truths" in fails(run, "--truth", dataset, dataset, "-o", out)
    assert "not ground truth" in fails(run, "--truth", tmp_path, "-o", out)
    junk = tmp_path / "junk.csv"
    junk.write_bytes(b"\xff\xfe\x00,\x81\n1,2\n")
    assert "not text in UTF-8; save it as UTF-8" in fails(junk, "--truth", dataset, "-o", out)
    assert not out.exists()
    assert not list(tmp_path.glob(".out-*"))


def test_a_run_of_another_camera(truth, dataset, tmp_path, capsys, caplog):
    matrix, size = truth.camera.matrix, np.array(truth.camera.size)
    other = write_run(tmp_path / "a", truth, camera_size=size[::-1], camera_matrix=matrix)
    words = ["--truth", str(dataset), "-o"]
    assert main(["evaluate", str(other), *words, str(tmp_path / "x")]) == 2
    assert "480x640 pixels, the truth 640x480" in capsys.readouterr().err
    for name, factor, warnings in (("b", 1.19, 0), ("c", 1.21, 1), ("d", 0.79, 2)):
        run = write_run(tmp_path / name, truth, camera_size=size, camera_matrix=matrix * factor)
        assert main(["evaluate", str(run), *words, str(tmp_path / f"{name}-out")]) == 0
        assert caplog.text.count("focal length") == warnings


def test_a_run_without_its_camera_is_no_model(truth, tmp_path):
    run = write_run(tmp_path / "run", truth)
    with pytest.raises(ModelFormatError, match="lacks camera_matrix, camera_size"):
        load_run_head(run, speaker())


def test_the_help_names_every_default_folder(tmp_path, capsys):
    (tmp_path / "a.csv").touch()
    assert default_folder([tmp_path]) == tmp_path / "evaluation"
    assert default_folder([tmp_path / "a.csv"]) == tmp_path / "a-evaluation"
    assert default_folder([tmp_path, tmp_path]) == Path("evaluation")
    assert main(["evaluate", "--help"]) == 0
    said = " ".join(capsys.readouterr().out.split())
    for name in ("RUN/evaluation", "FILE-evaluation beside", "./evaluation for several"):
        assert name in said


def test_error_maps_of_names_that_are_alike_once_they_are_plain(truth, dataset, tmp_path):
    names = ("q a", "q(a", "Q_A")
    runs = [
        write_run(tmp_path / n, truth, aperture=truth.aperture + k) for k, n in enumerate(names)
    ]
    evaluate(runs, [dataset], tmp_path / "out")
    maps = sorted(path.name for path in (tmp_path / "out").glob("*.npz"))
    assert maps == ["error_map_Q_A_3.npz", "error_map_q_a.npz", "error_map_q_a_2.npz"]


def test_results_named_alike_are_told_apart(truth, dataset, tmp_path):
    (tmp_path / "x").mkdir()
    (tmp_path / "y").mkdir()
    runs = [write_run(tmp_path / place / "run", truth) for place in "xy"]
    out = tmp_path / "out"
    words = ["evaluate", *runs, "--truth", dataset, "-o", out]
    assert main([str(word) for word in words]) == 0
    assert list(json.loads((out / "scores.json").read_text())["systems"]) == ["run", "y/run"]
    assert (out / "error_map_y_run.npz").is_file()
    assert run_arrays(truth)["lip_points"].shape[0] == FRAMES
