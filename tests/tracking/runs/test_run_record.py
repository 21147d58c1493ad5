"""A run on disk: what is written is what was found, and comes back."""

from __future__ import annotations

import csv
import gc
import json
import tracemalloc
import weakref
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from runs import lost_result, toy_model, toy_result, toy_setting

from abs_engine.core.errors import InputFileError, ModelFormatError
from abs_engine.core.geometry import Pose
from abs_engine.face.appearance.exposure import USUAL
from abs_engine.io.assets import CLOSED_APERTURE
from abs_engine.io.video import VideoInfo
from abs_engine.optimise.base import Solution
from abs_engine.render.cpu import CpuRenderer
from abs_engine.tracking.options import Clip, ClipTracker, TrackOptions
from abs_engine.tracking.results.measures import Closure
from abs_engine.tracking.results.run_mesh import load_mesh
from abs_engine.tracking.results.run_table import POINT_NAMES, closure_table, written
from abs_engine.tracking.results.run_warnings import (
    FACE_COLOURS,
    GIVEN_COLOURS,
    OTHER_COLOURS,
)
from abs_engine.tracking.run import prepare_clip
from abs_engine.tracking.runs.record import RESULTS, SUMMARY, TABLE, load_run, run_settings
from abs_engine.tracking.runs.recorder import Recorder
from abs_engine.tracking.settings.detection import DETECTION

RESULTS_OF_CLIP = [toy_result(0), toy_result(1, prototype=4), lost_result(2), toy_result(3, 3)]


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    recorder = Recorder(toy_setting())
    for result in RESULTS_OF_CLIP:
        recorder.add(result)
    made = tmp_path_factory.mktemp("run")
    recorder.record().write(made, {"settings": {"video": "v"}, "summary": {"more": 0.1}})
    return made


def test_what_is_copied_of_a_record_may_be_written_to():
    recorder = Recorder(setting := toy_setting())
    recorder.add(toy_result(0))
    record, head = recorder.record(), setting.face.body
    copied = record.copied()
    for name in ("mean", "modes", "weights", "faces"):
        mine, shared = getattr(copied.mesh, name), getattr(record.mesh, name)
        np.testing.assert_array_equal(mine, shared)
        assert not np.shares_memory(mine, shared), name
    assert np.shares_memory(record.mesh.faces, head.faces)  # that of every run with this head
    assert not np.shares_memory(copied.arrays["lip_vertex"], head.lips)


def test_the_end_of_a_search_takes_no_memory_once_its_frame_is_recorded():
    end = Solution(np.zeros(26), "converged", 12.5, {}, 321, information=np.zeros((26, 26)))
    recorder, found = Recorder(toy_setting()), weakref.ref(end)
    recorder.add(replace(toy_result(0), highest=end))
    del end
    gc.collect()
    assert found() is None
    assert len(recorder) == 1


def test_frames_stay_in_a_file_until_they_are_written(tmp_path):
    recorder, result = Recorder(toy_setting(), tmp_path), toy_result(0)
    recorder.add(result)  # what the face keeps for itself
    tracemalloc.start()
    for index in range(500):
        recorder.add(replace(result, index=index, lips=result.lips + index, terms={"a": 1.0}))
    gc.collect()
    grown = tracemalloc.get_traced_memory()[0]
    tracemalloc.stop()
    assert grown < 500 * 200  # bytes; a row takes 8 kB
    assert list(tmp_path.iterdir()) == []  # the file has no name, and goes with its process
    np.testing.assert_array_equal(recorder.record().arrays["lip_points"][500], result.lips + 499)


def test_terms_are_columns_from_their_first_frame_on():
    recorder = Recorder(toy_setting())
    for terms in ({}, {"colour": 1.5}, {"prior": 2.0, "colour": 3.0}):
        recorder.add(replace(toy_result(0), terms=terms))
    arrays, nan = recorder.record().arrays, np.nan
    assert arrays["term_names"].tolist() == ["colour", "prior"]
    np.testing.assert_array_equal(arrays["term_values"], [[nan, nan], [1.5, nan], [3.0, 2.0]])


def test_a_run_without_frames_has_empty_columns():
    recorder = Recorder(toy_setting())
    record = recorder.record()
    assert record.arrays["lip_points"].shape == (0, len(toy_setting().face.body.lips), 3)
    assert len(list(record.table())) == 1
    assert record.summary["frames"] == 0


@pytest.fixture(scope="module")
def run(folder):
    return load_run(folder)


@pytest.fixture(scope="module")
def table(folder):
    with (folder / TABLE).open(newline="") as file:
        return list(csv.DictReader(file))


def test_a_number_that_is_not_known_hides_no_settings(tmp_path):
    """A summary's mean may be NaN, where there is nothing that it could be of."""
    told = {"settings": {"video": "talk.mp4"}, "summary": {"aperture_difference_mm": float("nan")}}
    (tmp_path / "run.json").write_text(json.dumps(told), encoding="utf-8")
    assert run_settings(tmp_path) == {"video": "talk.mp4"}
    (tmp_path / "run.json").write_text("{", encoding="utf-8")
    assert run_settings(tmp_path) == {}


def test_arrays_come_back(run):
    np.testing.assert_array_equal(run["found"], [True, True, False, True])
    np.testing.assert_allclose(run["time"], [0, 0.04, 0.08, 0.12])
    for index, result in enumerate(RESULTS_OF_CLIP):
        np.testing.assert_array_equal(run["lip_points"][index], result.lips)
        np.testing.assert_array_equal(run["parameters"][index], result.vector)
    assert len(run["parameter_names"]) == run["parameters"].shape[1]
    assert np.isnan(run["rotation"][2]).all()
    pose = Pose.from_vectors(run["rotation"][1], run["translation"][1])
    np.testing.assert_allclose(pose.rotation, RESULTS_OF_CLIP[1].pose.rotation, atol=1e-12)
    assert run["status"].tolist() == ["converged", "converged", "face not found", "converged"]
    assert str(run["renderer"]).startswith("cpu")
    assert run["camera_size"].tolist() == [320, 240]


def test_lip_vertices_are_those_of_the_bundled_head(run):
    whole = toy_model().expression
    weights = RESULTS_OF_CLIP[1].vector[6:]
    vertices = whole.mean + np.tensordot(weights, whole.modes, 1)
    np.testing.assert_allclose(vertices[run["lip_vertex"]], run["lip_points"][1], atol=1e-3)


def test_closed_frames_have_a_small_aperture(run):
    assert run["closed"].tolist() == [
        result.found and result.aperture < CLOSED_APERTURE for result in RESULTS_OF_CLIP
    ]
    assert run["closed"][0]
    assert not run["closed"][1:].any()


def test_the_table_has_a_row_for_each_frame(table):
    assert [row["index"] for row in table] == ["0", "1", "2", "3"]
    assert table[2]["found"] == "0"
    assert table[2]["aperture"] == table[2]["lip48_x"] == table[2]["closed"] == ""
    assert [row["closed"] for row in table[:2]] == ["1", "0"]
    wide = table[1]
    assert float(wide["aperture"]) == pytest.approx(RESULTS_OF_CLIP[1].aperture, rel=1e-5)
    height = float(wide["lip62_y"]) - float(wide["lip66_y"])  # points 62 and 66 of the 68
    assert height == pytest.approx(float(wide["aperture"]), abs=1e-3)
    corners = [[float(wide[f"{name}_{axis}"]) for axis in "xyz"] for name in ("lip48", "lip54")]
    assert np.linalg.norm(np.subtract(*corners)) == pytest.approx(float(wide["width"]), abs=0.01)
    assert (
        len([name for name in wide if name[:3] == "lip" and name[3].isdigit()])
        == 3 * len(POINT_NAMES)
        == 60
    )


def test_the_summary(folder):
    told = json.loads((folder / SUMMARY).read_text())
    assert told["settings"] == {"video": "v"}
    assert told["summary"] == {
        "frames": 4,
        "lost_frames": 1,
        "lost_reasons": {"face not found": 1},
        "covered_frames": 0,
        "less_explained_frames": 0,
        "closed_frames": 1,
        "mean_evaluations": 321.0,
        "cuts": [],
        "warnings": [],
        "mean_score": pytest.approx(0.9),
        "more": 0.1,
    }


def test_a_face_that_comes_after_a_while_without_any_is_no_cut():
    """It may be another person's: a line of its own says so."""
    recorder, long = Recorder(toy_setting()), DETECTION.patience + 1
    gone = [lost_result(k) for k in range(3, 3 + long)]
    shown = [toy_result(0), replace(toy_result(1), cut=True), toy_result(2)]
    for result in [*shown, *gone, replace(toy_result(3 + long), cut=True), toy_result(4 + long)]:
        recorder.add(result)
    told = recorder.record().summary
    assert told["cuts"] == [1, 3 + long]
    assert told["warnings"][0].startswith("the film is cut before frame 1: ")
    assert f"is followed from frame {3 + long} on" in told["warnings"][1]
    before = Recorder(toy_setting())
    for result in [*gone, replace(toy_result(3 + long), cut=True)]:  # nobody came before
        before.add(result)
    told = before.record().summary
    assert told["warnings"][0].startswith(f"the film is cut before frame {3 + long}: ")


def test_a_run_that_explains_little_holds_its_warning():
    recorder = Recorder(toy_setting())
    for result in RESULTS_OF_CLIP:
        recorder.add(replace(result, score=0.6))
    (line,) = recorder.record().summary["warnings"]
    assert line.startswith("the drawn mouth explains only 60%")


@pytest.mark.parametrize(
    ("times", "begin", "end"),
    [(1.0, None, None), (20.0, "the mouth is only 1.7 pixels", ""), (0.3, "", "use --worn")],
    ids=["usual", "tiny mouth", "part of a face"],
)
def test_a_run_at_another_distance_holds_its_warning(times, begin, end):
    recorder = Recorder(toy_setting())
    for result in RESULTS_OF_CLIP:
        pose = result.pose and Pose(result.pose.rotation, times * result.pose.translation)
        recorder.add(replace(result, pose=pose))
    warnings = recorder.record().summary["warnings"]
    assert len(warnings) == (begin is not None)
    assert all(line.startswith(begin) and line.endswith(end) for line in warnings)


@pytest.mark.parametrize(("frames", "lines"), [(70, 1), (60, 0)])
def test_a_run_whose_lips_never_open_holds_its_warning(frames, lines):
    recorder = Recorder(toy_setting())
    for index in range(frames):
        recorder.add(replace(RESULTS_OF_CLIP[0], index=index))
    warnings = recorder.record().summary["warnings"]
    assert len(warnings) == lines
    assert all("closed in all 70 frames" in line for line in warnings)


@pytest.mark.parametrize(("score", "lines"), [(0.6, 2), (0.9, 0)])
def test_given_colours_may_be_the_reason(score, lines):
    recorder = Recorder(replace(toy_setting(), hint=GIVEN_COLOURS))
    for result in RESULTS_OF_CLIP:
        recorder.add(replace(result, score=score))
    warnings = recorder.record().summary["warnings"]
    assert len(warnings) == lines
    assert all("another run's" in line for line in warnings[1:])


@pytest.mark.parametrize(
    ("terms", "lines"), [(("colour",), 2), (("texture",), 0), (("colour", "texture"), 2), ((), 2)]
)
def test_colours_are_doubted_only_where_they_may_count(terms, lines):
    """A run by a speaker's texture alone had warned of the face's colours."""
    poor = {"upper_lip": 0.65, "lower_lip": 0.7}
    classes = SimpleNamespace(
        separability=poor, agreement=0.1, weight=0.1, chromatic=True, exposure=USUAL, blue=False
    )
    setting = toy_setting()
    recorder = Recorder(replace(setting, face=setting.face.looking(colour=classes)))
    values = dict.fromkeys((*terms, "prior"), 1.0)
    for index in range(4):
        recorder.add(replace(toy_result(index), terms=values, landmark_aperture=0.0))
    assert len(recorder.record().summary["warnings"]) == lines


def test_a_run_in_which_nothing_was_tracked_says_so_and_has_no_score():
    recorder = Recorder(replace(toy_setting(), hint=FACE_COLOURS))
    for index in range(4):
        status = "mouth covered" if index else "face not found"
        recorder.add(replace(lost_result(index), status=status, covered=index > 0))
    told = recorder.record().summary
    assert told["mean_score"] is None
    assert told["warnings"] == [
        "no frame was tracked (mouth covered in 3, face not found in 1): look at the overlay",
        FACE_COLOURS,
    ]


@pytest.mark.parametrize(
    ("given", "clips", "used", "said"),
    [(True, True, True, ""), (False, True, False, OTHER_COLOURS.format("without")),
     (True, False, False, OTHER_COLOURS.format("with")), (None, True, False, ""),
     (True, None, False, "")],
)  # fmt: skip
def test_colours_are_given_where_they_are_used(monkeypatch, given, clips, used, said):
    """Classes of colours are not used for a video without colour, nor the other way round."""
    given, clips = (
        one if one is None else SimpleNamespace(chromatic=one) for one in (given, clips)
    )
    face = toy_setting().face.looking(**({} if clips is None else {"colour": clips}))
    info = VideoInfo((320, 240), 25.0, 4)
    clip = Clip(Path("a.mp4"), info, toy_setting().camera, given)
    made = ClipTracker(clip.video, info, replace(toy_setting(), face=face), None, "")
    monkeypatch.setattr("abs_engine.tracking.run.made_ready", lambda *_: made)
    tracker = prepare_clip(clip, CpuRenderer(), TrackOptions(), print)
    assert (tracker.setting.hint == GIVEN_COLOURS) == used
    assert tracker.remarks == said
    assert tracker.facts.get("colours", "as asked") == ("learned" if said else "as asked")


def test_what_is_no_run_is_refused(tmp_path, run):
    with pytest.raises(InputFileError, match=r"is not a run.*that 'track -o' made"):
        load_run(tmp_path)
    (tmp_path / "one").mkdir()
    np.savez(tmp_path / "one" / RESULTS)
    with pytest.raises(InputFileError, match=f"give one of the runs in it.*{tmp_path / 'one'}"):
        load_run(tmp_path)
    np.savez(tmp_path / RESULTS, **(dict(run) | {"version": 2}))
    with pytest.raises(ModelFormatError, match="version 2"):
        load_run(tmp_path)
    np.savez(tmp_path / RESULTS, **{k: v for k, v in run.items() if k != "aperture"})
    with pytest.raises(ModelFormatError, match="lacks aperture"):
        load_run(tmp_path)
    np.savez(tmp_path / RESULTS, **(dict(run) | {"width": run["width"][:2]}))
    with pytest.raises(ModelFormatError, match="has shape"):
        load_run(tmp_path)
    (tmp_path / RESULTS).write_bytes(b"PK")
    with pytest.raises(InputFileError):
        load_run(tmp_path)


def test_the_mesh_holds_the_lips_of_the_results(folder, run):
    mesh = load_mesh(folder)
    assert len(mesh) == len(RESULTS_OF_CLIP)
    np.testing.assert_allclose(mesh.points(run["lip_vertex"]), run["lip_points"], atol=1e-4)
    np.testing.assert_allclose(mesh.vertices(1)[run["lip_vertex"]], run["lip_points"][1], atol=1e-4)
    assert np.isnan(mesh.vertices(2)).all()
    assert mesh.faces.max() == len(mesh.mean) - 1


def test_the_mesh_holds_the_person_without_expression(folder, tmp_path):
    mesh, model = load_mesh(folder), toy_model()
    np.testing.assert_array_equal(mesh.rest, model.at_rest(np.zeros(model.n_person)))
    np.testing.assert_array_equal(mesh.rest, model.head.mean)
    replace(mesh, rest=None).save(tmp_path)  # as earlier versions wrote it
    assert load_mesh(tmp_path).rest is None
    np.testing.assert_array_equal(load_mesh(tmp_path).mean, mesh.mean)


def test_a_person_moves_the_whole_mesh_as_the_drawn_part():
    model = toy_model()
    person = np.linspace(-1, 1, model.n_person)
    np.testing.assert_allclose(model.whole(person)[model.kept], model.held(person).mean, atol=1e-4)


def test_a_missing_mesh_is_named(tmp_path):
    with pytest.raises(InputFileError, match="no mesh"):
        load_mesh(tmp_path)


def test_times_are_the_videos_where_it_says_them():
    uneven = (0.0, 0.03, 0.1)
    for times, expected in ((uneven, uneven), ((0.0, 0.5), (0.0, 0.04, 0.08))):
        recorder = Recorder(replace(toy_setting(), times=times))
        for index in range(3):
            recorder.add(toy_result(index))
        np.testing.assert_allclose(recorder.record().arrays["time"], expected)
        rows = list(written(recorder.record().table()))
        column = rows[0].index("time")
        assert [float(row[column]) for row in rows[1:]] == pytest.approx(list(expected))


def test_times_of_long_clips_have_as_many_decimals():
    times = 12000 + np.arange(3) / 240
    _, *rows = written([["time", "width"], *((time, 12345.678) for time in times)])
    np.testing.assert_allclose([float(time) for time, _ in rows], times, rtol=0, atol=1e-6)
    assert rows[0][1] == "12345.7"
    _, row = written(closure_table([Closure(1, 2, times[0], times[1], 0.5)]))
    assert row[:2] == ["12000.000000", "12000.004167"]
    assert float(row[2]) == pytest.approx(1 / 240, rel=1e-4)  # how long the lips were closed


def test_a_shot_that_is_all_covered_is_in_the_summary():
    recorder = Recorder(toy_setting())
    for k in range(40):
        hidden = replace(lost_result(k), status="mouth covered", covered=True, cut=k == 15)
        recorder.add(hidden if 15 <= k < 30 else replace(toy_result(k), cut=k == 30))
    said = recorder.record().summary["warnings"]
    assert sum("no frame of the shot from frame 15 to 29 is tracked" in w for w in said) == 1
