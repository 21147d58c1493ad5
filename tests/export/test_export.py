"""Exports of a run, read back by programs that others wrote and by the engine's own readers."""

from __future__ import annotations

import gc
import re
import shutil
import weakref
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pandas as pd
import parselmouth
import pygltflib
import pytest
import trimesh
from runs import lost_result, toy_result, toy_setting, written_run

from abs_engine.cli import main
from abs_engine.core.errors import (
    InputFileError,
    ModelFormatError,
    OutputError,
    ParameterError,
    PluginError,
)
from abs_engine.core.geometry import FACING, Pose
from abs_engine.core.registry import EXPORTERS
from abs_engine.evaluate.arkit_csv import read_arkit
from abs_engine.evaluate.landmark_csv import Reference, read_landmarks
from abs_engine.export import gltf
from abs_engine.export.exporter import Exporter, Loss, read_run, rms
from abs_engine.export.face_units import unit_loss, unit_weights
from abs_engine.export.fap import LIPS, fapu, neutral, parameters
from abs_engine.export.praat import closures, duration
from abs_engine.export.writing import export_run, smoothed
from abs_engine.face.head import PROTOTYPES
from abs_engine.face.schema import ICT_68, reading
from abs_engine.io.morphs import read_morphs
from abs_engine.tracking.results.smoothing import Smoothing
from abs_engine.tracking.run_in_memory import Run
from abs_engine.tracking.runs.recorder import Recorder

POSTURES = (0, 1, 2, 3, None, 1, 0)
LOST = 4
FOUND = [k for k in range(len(POSTURES)) if k != LOST]


@pytest.fixture(scope="module")
def folder(tmp_path_factory) -> Path:
    return written_run(tmp_path_factory.mktemp("run") / "run", POSTURES)


@pytest.fixture(scope="module")
def run(folder):
    return read_run(folder)


@pytest.fixture(scope="module")
def clip(run):
    lists = run.speaker.points["landmark_68"]
    return Reference(len(run), run.rate, run.neutral, lists)


def exported(folder: Path, name: str, at: Path) -> Path:
    out = at / f"out{EXPORTERS.get(name).suffix}"
    losses = export_run(folder, name, out)
    assert losses
    assert all(np.isfinite(loss.value) for loss in losses)
    return out


def test_a_run_in_memory_is_exported_as_the_one_it_is_saved_as(folder, tmp_path):
    kept, made = (tmp_path / f"{name}.parquet" for name in ("kept", "made"))
    assert export_run(Run.load(folder), "parquet", made) == export_run(folder, "parquet", kept)
    pd.testing.assert_frame_equal(pd.read_parquet(made), pd.read_parquet(kept))


def test_a_run_is_smoothed_only_where_that_is_asked_for(tmp_path, capsys):
    run = written_run(tmp_path / "run", (0, 1, 2, 3, 2, 0, 1, 3, 0, 2, None, 1))
    before = {p.name: p.read_bytes() for p in run.iterdir()}
    words = ["export", str(run), "--to", "praat", "-o"]
    assert main([*words, str(tmp_path / "raw")]) == 0
    assert "smoothed," not in capsys.readouterr().out
    assert main([*words, str(tmp_path / "smooth"), "--smooth", "savitzky-golay:5"]) == 0
    said = capsys.readouterr().out.splitlines()
    assert said[0].startswith("smoothed, lips, by savitzky-golay:5: ")
    assert said[1].startswith("read back, ")
    assert {p.name: p.read_bytes() for p in run.iterdir()} == before
    raw = read_run(run)
    soft, _ = smoothed(raw, Smoothing.named("savitzky-golay:5"))
    assert soft.frames == raw.frames
    turned = [raw.pose(k).rotation.T @ soft.pose(k).rotation for k in raw.frames]  # a still head
    np.testing.assert_allclose(turned, np.tile(np.eye(3), (len(turned), 1, 1)), atol=1e-6)
    for hard, easy in (
        (raw.mesh.weights, soft.mesh.weights),
        (raw.arrays["parameters"], soft.arrays["parameters"]),
    ):
        steps = [np.abs(np.diff(one[:10], axis=0)).sum() for one in (hard, easy)]
        assert steps[1] < 0.8 * steps[0]
    tables = [(tmp_path / name / "measures.tsv").read_text() for name in ("raw", "smooth")]
    assert tables[0] != tables[1]
    assert len(tables[0].splitlines()) == len(tables[1].splitlines())


def test_the_last_frame_after_a_long_pause_is_shown_as_long_as_most(tmp_path):
    run = read_run(written_run(tmp_path / "run", (2, 2, 2, 2, 0, 0)))
    time = np.array([0.0, 0.04, 0.08, 3.0, 3.04, 3.08])
    uneven = replace(run, arrays={**run.arrays, "time": time, "rate": 6 / 3.12})
    assert duration(uneven) == pytest.approx(3.12)
    assert closures(uneven)[-1, 1] == pytest.approx(3.12)


def test_closures_of_a_smoothed_run_are_those_of_its_smoothed_aperture(tmp_path):
    raw = read_run(written_run(tmp_path / "run", (2, 2, 2, 0, 0, 0, 0, 2, 2, 0, 2, 2, 2)))
    soft, _ = smoothed(raw, Smoothing.named("savitzky-golay:5"))
    for run in (raw, soft):
        frames = [np.arange(a, b + 1) for a, b in run.arrays["closure_frames"].tolist()]
        np.testing.assert_array_equal(np.concatenate(frames), np.flatnonzero(run.arrays["closed"]))
    assert len(raw.arrays["closure_times"]) > len(soft.arrays["closure_times"]) > 0


def test_a_covered_mouth_has_its_whole_pose_when_smoothed(tmp_path):
    recorder = Recorder(toy_setting())
    for k in range(12):
        seen = toy_result(k) if k != 6 else replace(lost_result(k), covered=True)
        recorder.add(replace(seen, pose=toy_result(k).pose))
    recorder.record().write(tmp_path, {})
    soft, _ = smoothed(read_run(tmp_path), Smoothing.named("savitzky-golay:5"))
    for name in ("rotation", "translation"):
        assert np.isfinite(soft.arrays[name]).all()


def test_a_head_that_is_upside_down_stays_so_when_smoothed(tmp_path):
    recorder = Recorder(toy_setting())
    for k in range(12):
        seen = toy_result(k)
        roll = Pose.from_vectors([0.0, 0.0, np.pi + 0.05 * (-1) ** k], np.zeros(3)).rotation
        recorder.add(replace(seen, pose=Pose(roll @ FACING, seen.pose.translation)))
    recorder.record().write(tmp_path, {})
    raw = read_run(tmp_path)
    soft, _ = smoothed(raw, Smoothing.named("savitzky-golay:5"))
    away = [raw.pose(k).angle_to(soft.pose(k)) for k in range(12)]
    assert max(away) < 0.1


def test_arkit_is_read_as_the_same_face(folder, run, clip, tmp_path):
    path = exported(folder, "arkit", tmp_path)
    areas = run.speaker.points
    read = read_arkit(path, clip, run.speaker.unit_names, run.speaker.units, areas)
    assert read.found.tolist() == [k != LOST for k in range(len(run))]
    lips = areas["lips"]
    assert rms(read.surface.points(lips)[FOUND] - run.mesh.points(lips)[FOUND]) < 0.3
    assert np.abs(read.rotations[FOUND]).max() < 1e-5  # it looks into the camera
    weights = unit_weights(run)[FOUND]
    assert weights.min() >= 0
    assert weights.max() <= 1


def test_weights_are_those_that_made_the_posture(run):
    """Those of its postures are known; before the units were on the mean's parted lips."""
    names = run.speaker.unit_names
    for frame, posture in enumerate(POSTURES):
        if posture is None:
            continue
        found = dict(zip(names, unit_weights(run)[frame], strict=True))
        made = PROTOTYPES[posture]
        assert found["jawOpen"] == pytest.approx(made.get("jawOpen", 0.0), abs=0.03), posture
        for name in ("mouthRollLower", "mouthRollUpper", "mouthShrugLower", "mouthShrugUpper"):
            assert found[name] < 0.1, (posture, name)
    assert unit_weights(run)[0].max() < 0.1  # the face at rest


def test_a_run_whose_weights_were_found_is_not_kept(folder):
    run = read_run(folder)
    gone = weakref.ref(run)
    unit_weights(run)
    del run
    gc.collect()
    assert gone() is None


def test_another_head_closes_and_opens_its_mouth_as_the_speaker_did(run, data_dir):
    """ICT's head, whose neutral lips are closed, driven by the weights alone."""
    mesh = read_morphs(data_dir / "ict")
    upper, lower = ICT_68[62], ICT_68[66]
    size = 10.0  # mm of the model's unit
    units = {reading(name)[0]: moved for name, moved in mesh.targets.items()}
    slopes = [
        size * float(np.subtract(*units[n][[upper, lower], 1])) if n in units else 0.0
        for n in run.speaker.unit_names
    ]
    opened = (unit_weights(run) @ slopes)[FOUND]
    tracked = run.arrays["aperture"][FOUND]
    np.testing.assert_allclose(opened, tracked, atol=2.0)
    assert np.abs(opened[tracked < 1]).max() < 1.0
    assert np.corrcoef(opened, tracked)[0, 1] > 0.97


def test_runs_of_earlier_versions_are_closed_from_the_mean(run):
    early = replace(run, mesh=replace(run.mesh, rest=None))
    marks = run.speaker.points["landmark_68"]
    gaps = early.neutral[marks[[61, 62, 63]], 1] - early.neutral[marks[[67, 66, 65]], 1]
    np.testing.assert_allclose(gaps, 0, atol=1e-3)
    names, weights = run.speaker.unit_names, unit_weights(early)
    assert weights[0, names.index("jawOpen")] < 0.05
    assert weights[3, names.index("jawOpen")] > 0.1
    lost = unit_loss(early, weights)  # beside the tracked mesh as it is, from another base
    assert all(0.1 < one.value < 1.5 for one in lost)


def test_arkit_s_columns_are_those_of_the_app_s_files(folder, run, tmp_path):
    table = pd.read_csv(exported(folder, "arkit", tmp_path))
    names = list(table.columns)
    assert names[:3] == ["Timecode", "BlendShapeCount", "EyeBlinkLeft"]
    assert names[17:20] == ["JawRight", "JawLeft", "JawOpen"]
    assert names[23:25] == ["MouthRight", "MouthLeft"]
    assert names[53:57] == ["TongueOut", "HeadYaw", "HeadPitch", "HeadRoll"]
    for unit, weights in zip(run.speaker.unit_names, unit_weights(run).T, strict=True):
        np.testing.assert_allclose(table[unit[:1].upper() + unit[1:]], weights, atol=1e-6)


@pytest.mark.parametrize("name", ["openface", "landmarks"])
def test_landmarks_are_read_in_the_same_places(name, folder, run, clip, tmp_path):
    read = read_landmarks(exported(folder, name, tmp_path), clip)
    assert read.found.tolist() == [k != LOST for k in range(len(run))]
    assert np.abs(read.pixels - run.landmarks_in_picture)[FOUND].max() < 0.01
    if name == "openface":
        assert np.abs(read.translations[FOUND] - run.arrays["translation"][FOUND]).max() < 0.01


def test_openface_counts_frames_from_1_and_trusts_none_that_is_lost(folder, run, tmp_path):
    table = pd.read_csv(exported(folder, "openface", tmp_path))
    assert table["frame"].tolist() == [k + 1 for k in range(len(run))]
    assert table["success"].tolist() == [int(k != LOST) for k in range(len(run))]
    assert (table["confidence"] > 0).tolist() == [k != LOST for k in range(len(run))]
    old = replace(run, arrays={k: v for k, v in run.arrays.items() if k != "score"})
    EXPORTERS.get("openface").write(old, tmp_path / "old.csv")
    trusted = pd.read_csv(tmp_path / "old.csv")["confidence"]
    assert trusted.tolist() == [float(k != LOST) for k in range(len(run))]


@pytest.mark.parametrize("name", ["gltf", "gltf-modes"])
def test_gltf_moves_as_the_run(name, folder, run, tmp_path):
    path = exported(folder, name, tmp_path)
    made = pygltflib.GLTF2().load(str(path))
    names = made.meshes[0].extras["targetNames"]
    blob = made.binary_blob()

    def values(number: int) -> np.ndarray:
        accessor = made.accessors[number]
        at = made.bufferViews[accessor.bufferView].byteOffset
        size = {"SCALAR": 1, "VEC3": 3, "VEC4": 4}[accessor.type]
        return np.frombuffer(blob, np.float32, accessor.count * size, at).reshape(-1, size)

    primitive = made.meshes[0].primitives[0]
    targets = np.array([values(one["POSITION"]) for one in primitive.targets])
    assert len(targets) == len(names)
    tracks = {c.target.path: made.animations[0].samplers[c.sampler]
              for c in made.animations[0].channels}  # fmt: skip
    times = values(tracks["weights"].input)[:, 0]
    assert np.allclose(times, run.arrays["time"][FOUND])
    weights = values(tracks["weights"].output).reshape(len(times), -1)
    face = run.speaker.points["face"]
    at = values(primitive.attributes.POSITION)[face] + np.tensordot(weights, targets[:, face], 1)
    reported = {loss.of: loss.value for loss in export_run(folder, name, tmp_path / "again.glb")}
    off = rms(1000 * at - run.mesh.points(face)[FOUND])
    assert off == pytest.approx(reported["face"], abs=1e-4)
    assert off < (0.3 if name == "gltf" else 1e-4)
    base = 1000 * values(primitive.attributes.POSITION)
    np.testing.assert_allclose(base, run.neutral if name == "gltf" else run.mesh.mean, atol=1e-3)
    ahead = values(tracks["translation"].output)[0]
    assert np.allclose(ahead, [0.0, -0.04, -0.7])  # before a camera that looks along -z, y up
    scene = trimesh.load(path)
    assert [len(one.faces) for one in scene.geometry.values()] == [len(run.mesh.faces)]


def test_gltf_is_shaded_smoothly_across_seams_of_the_texture(folder, run, tmp_path):
    made = trimesh.load(exported(folder, "gltf", tmp_path), process=False)
    (head,) = made.geometry.values()
    normals, weld = head.vertex_normals, run.speaker.weld
    first = np.unique(weld, return_index=True)[1]
    copies = np.setdiff1d(np.arange(len(weld)), first)
    assert len(copies) > 100
    assert np.allclose(normals[copies], normals[first[weld[copies]]], atol=1e-5)


def test_obj_files_are_the_heads(folder, run, tmp_path):
    path = exported(folder, "obj", tmp_path)
    assert sorted(one.name for one in path.iterdir()) == [f"{k:06d}.obj" for k in FOUND]
    read = trimesh.load(path / "000003.obj", process=False, maintain_order=True)
    assert np.allclose(np.sort(read.vertices, 0), np.sort(run.mesh.vertices(3), 0), atol=1e-4)


def test_parquet_is_the_table(folder, run, tmp_path):
    table = pd.read_parquet(exported(folder, "parquet", tmp_path))
    written = pd.read_csv(folder / "results.csv")
    assert list(table.columns) == list(written.columns)
    assert table["closed"].isna().tolist() == (~run.arrays["found"]).tolist()
    numbers = [one.drop(columns="status").astype(float) for one in (table, written)]
    np.testing.assert_allclose(*numbers, rtol=1e-5, atol=1e-5)
    assert np.array_equal(table["aperture"], run.arrays["aperture"], equal_nan=True)
    assert table["status"][LOST] == "face not found"
    assert export_run(folder, "parquet", tmp_path / "lat\udce4n.parquet")


def test_praat_itself_reads_the_closures(folder, run, tmp_path):
    path = exported(folder, "praat", tmp_path)
    grid = parselmouth.Data.read(str(path / "closures.TextGrid"))
    count = parselmouth.praat.call(grid, "Count intervals where", 1, "is equal to", "closed")
    assert count == len(run.arrays["closure_frames"]) > 0
    at = parselmouth.praat.call(grid, "Get interval at time", 1, run.arrays["time"][LOST])
    begin, end = (
        parselmouth.praat.call(grid, f"Get {what} of interval", 1, at)
        for what in ("start time", "end time")
    )
    assert parselmouth.praat.call(grid, "Get label of interval", 1, at) == "lost"
    np.testing.assert_allclose([begin, end], (np.array([LOST, LOST + 1]) - 0.5) / run.rate)
    table = parselmouth.praat.call("Read Table from tab-separated file", str(path / "measures.tsv"))
    rows = parselmouth.praat.call(table, "Get number of rows")
    assert rows == len(run)
    found = parselmouth.praat.call(table, "Get value", 4, "aperture")
    assert float(found) == pytest.approx(run.arrays["aperture"][3], abs=1e-4)
    assert parselmouth.praat.call(table, "Get value", LOST + 1, "aperture") == "--undefined--"


def test_the_measures_for_praat_have_their_deviations(folder, tmp_path):
    sure = tmp_path / "sure"
    shutil.copytree(folder, sure)
    arrays = dict(np.load(folder / "results.npz"))
    deviations = {"aperture_sd": np.arange(len(POSTURES)) / 4}
    np.savez(sure / "results.npz", **arrays | deviations)
    table = pd.read_csv(exported(sure, "praat", tmp_path) / "measures.tsv", sep="\t")
    np.testing.assert_allclose(table["aperture_sd"], deviations["aperture_sd"])
    assert "width_sd" in table


def test_older_runs_are_exported_or_refused_in_a_line(folder, tmp_path):
    old = tmp_path / "old"
    shutil.copytree(folder, old)
    lacking = "closure_frames", "closure_times", "parameter_names"
    arrays = dict(np.load(folder / "results.npz"))
    np.savez(old / "results.npz", **{k: v for k, v in arrays.items() if k not in lacking})
    made = exported(folder, "praat", tmp_path), exported(old, "praat", old)
    grids = [one / "closures.TextGrid" for one in made]
    assert grids[0].read_text() == grids[1].read_text()
    for name, suffix in (("parquet", ".parquet"), ("gltf-modes", ".glb")):
        with pytest.raises(ModelFormatError, match="lacks parameter_names"):
            export_run(old, name, tmp_path / f"out{suffix}")


def test_fap_holds_what_the_format_has(folder, run, tmp_path):
    lines = exported(folder, "fap", tmp_path).read_text().splitlines()
    assert lines[0].split() == ["2.1", "abs_engine", "25", str(len(run))]
    masks = [np.array(line.split(), int) for line in lines[1::2]]
    rows = [np.array(line.split(), int) for line in lines[2::2]]
    assert all(len(mask) == 68 for mask in masks)
    assert [len(row) - 1 for row in rows] == [mask.sum() for mask in masks]
    assert masks[LOST].sum() == 0
    wide, rest = run.landmarks[3], neutral(run)
    numbers = dict(zip((np.flatnonzero(masks[3]) + 1).tolist(), rows[3][1:], strict=True))
    unit = fapu(run)["MNS"]
    assert numbers[5] * unit == pytest.approx(wide[66, 1] - rest[66, 1], abs=unit)
    assert numbers[51] * unit == pytest.approx(rest[51, 1] - wide[51, 1], abs=unit)
    assert parameters(run)[5][3] < 0  # the lower lip of an open mouth lies lower
    assert parameters(run)[3][3] > parameters(run)[3][0]  # and so do the lower teeth
    assert set(numbers) == {3, 48, 49, 50, *LIPS}


def test_fap_s_parameters_grow_in_the_sense_that_the_standard_gives_them(run):
    """Down for lower_t, up for raise, outwards for stretch, forwards for push, up for the chin."""
    way = np.zeros((68, 3))
    way[[*range(49, 54), 61, 62, 63], 1] = -1.0
    way[[*range(55, 60), 65, 66, 67, 48, 54, 60, 64, 8], 1] = 1.0
    way[[54, 64], 0], way[[48, 60], 0] = 1.0, -1.0  # the subject's left is at the greater x
    way[[62, 66], 2] = 1.0
    moved = replace(run)
    vars(moved)["landmarks"] = neutral(run) + np.tile(way, (len(run), 1, 1))  # 1 mm
    given, units = parameters(moved), fapu(run)
    across = {6, 7, 53, 54}  # in mouth widths; all others in mouth-nose separations
    for number in LIPS:
        unit = units["MW" if number in across else "MNS"]
        assert given[number][FOUND] == pytest.approx(1 / unit), number


@pytest.mark.parametrize("axis", range(3))
def test_a_head_turns_about_its_own_axes(run, axis):
    """To its left, up or aside; of one that looks along the camera's axis all angles are 0."""
    turn = Pose.from_vectors(0.3 * np.eye(3)[axis], np.zeros(3)).rotation
    vector = Pose(FACING @ turn, np.zeros(3)).rotation_vector
    turned = replace(run, arrays=run.arrays | {"rotation": np.tile(vector, (len(run), 1))})
    angles = np.stack([parameters(turned)[k][FOUND] for k in (48, 49, 50)], axis=1)
    np.testing.assert_allclose(1e-5 * angles, np.tile(0.3 * np.eye(3)[axis], (len(FOUND), 1)),
                               atol=1e-9)  # fmt: skip


def test_a_line_says_what_a_format_cannot_hold(folder, run, tmp_path, capsys):
    heard = tmp_path / "heard"
    shutil.copytree(folder, heard)
    (heard / "run.json").write_text('{"settings": {"sound": 0.136}}')
    assert main(["export", str(heard), "--to", "praat", "-o", str(tmp_path / "praat")]) == 0
    assert "subtract 0.136 s for times in the sound alone" in capsys.readouterr().out
    arrays = {"time": run.arrays["time"] ** 2, "camera_matrix": run.arrays["camera_matrix"].copy()}
    arrays["camera_matrix"][0, 2] += 30
    other = replace(run, arrays=run.arrays | arrays)
    times, *_ = EXPORTERS.get("fap").write(other, tmp_path / "a.fap")
    assert f"off by up to {0.24 - 0.24**2:.3f} s" in times.note
    *_, picture = EXPORTERS.get("gltf-modes").write(other, tmp_path / "a.glb")
    assert picture.value == pytest.approx(30, abs=0.01)
    assert "up to 30.0 px off" in picture.note
    for name in ("fap", "gltf-modes", "praat"):
        out = tmp_path / f"even{EXPORTERS.get(name).suffix}"
        assert not any(loss.note for loss in export_run(folder, name, out))


@pytest.mark.parametrize("text", ["", '{"settings": {"sound": 0.1', "[]", "\0"])
def test_a_damaged_summary_does_not_pass_for_none(folder, tmp_path, capsys, text):
    heard = tmp_path / "heard"
    shutil.copytree(folder, heard)
    (heard / "run.json").write_text(text)
    out = tmp_path / "praat"
    assert main(["export", str(heard), "--to", "praat", "-o", str(out)]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert "run.json is damaged; restore it" in line
    assert not out.exists()


def test_a_summary_with_nan_says_when_the_sound_begins(folder, tmp_path):
    heard = tmp_path / "heard"
    shutil.copytree(folder, heard)
    told = '{"settings": {"sound": 0.25}, "summary": {"deviation": NaN}}'
    (heard / "run.json").write_text(told)
    assert read_run(heard).sound == 0.25
    (heard / "run.json").unlink(missing_ok=True)
    assert read_run(heard).sound == 0.0


def test_fap_starts_from_a_face_whose_lips_meet(run):
    marks, rest = run.speaker.points["landmark_68"], neutral(run)
    assert run.mesh.mean[marks[62], 1] > run.mesh.mean[marks[66], 1] + 5
    np.testing.assert_allclose(rest[[61, 62, 63], 1], rest[[67, 66, 65], 1], atol=1e-4)
    np.testing.assert_array_equal(rest, run.neutral[marks])  # one face for all formats
    shut = np.sqrt(((run.landmarks[0] - rest)[48:] ** 2).sum(axis=1).mean())
    assert shut < 1  # mm; the mean of the mesh is 3.4 mm away
    assert 1024 * fapu(run)["MNS"] == pytest.approx(rest[33, 1] - rest[62, 1])
    assert 1024 * fapu(run)["MW"] == pytest.approx(rest[54, 0] - rest[48, 0])


@pytest.mark.parametrize(("name", "part", "instead", "named"), [
    ("openface", "openface._cells", lambda numbers, _: ["0.0"] * numbers.size, "place of the head"),
    ("gltf", "gltf._animations", lambda *_: [], "times"),
    ("landmarks", "landmarks.time_cell", lambda _: "", "times"),
])  # fmt: skip
def test_what_is_not_written_is_missed(name, part, instead, named, folder, tmp_path, monkeypatch):
    monkeypatch.setattr(f"abs_engine.export.{part}", instead)
    with pytest.raises(OutputError, match=f"read back, does not have the run's {named}"):
        export_run(folder, name, tmp_path / f"out{EXPORTERS.get(name).suffix}")
    assert list(tmp_path.iterdir()) == []


def test_what_is_written_wrong_shows(folder, tmp_path, monkeypatch):
    animations, still = gltf._animations, {"translation": np.zeros((len(POSTURES), 3))}
    monkeypatch.setattr(
        gltf, "_animations", lambda run, *rest: animations(
            replace(run, arrays=run.arrays | still), *rest
        ),
    )  # fmt: skip
    monkeypatch.setattr("abs_engine.export.landmarks.time_cell", lambda time: f"{2 * time}")
    lost = [export_run(folder, name, tmp_path / file)
            for name, file in (("gltf", "a.glb"), ("landmarks", "b.csv"))]  # fmt: skip
    off = {loss.of: loss.value for loss in (*lost[0], *lost[1][:1])}
    assert off["68 landmarks before the camera"] > 100
    assert off["times"] > 0.1


@pytest.mark.parametrize("name", ["arkit", "landmarks", "obj", "praat"])
def test_times_of_long_clips_are_as_exact(name, run, tmp_path):
    late = replace(run, arrays=run.arrays | {"time": run.arrays["time"] + 12000})
    (tmp_path / "folder").mkdir()
    at = tmp_path / (f"a{EXPORTERS.get(name).suffix}" if EXPORTERS.get(name).suffix else "folder")
    off = {loss.of: loss.value for loss in EXPORTERS.get(name).write(late, at)}
    assert off["times"] < 1e-4


@pytest.mark.parametrize("name", sorted(EXPORTERS))
def test_a_run_without_a_tracked_frame_is_refused(name, tmp_path, capsys):
    none = written_run(tmp_path / "none", [None, None])
    out = tmp_path / f"out{EXPORTERS.get(name).suffix}"
    assert main(["export", str(none), "--to", name, "-o", str(out)]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert "no frame of the run was tracked" in line
    assert list(tmp_path.iterdir()) == [none]


def test_the_command_reports_what_is_lost(folder, tmp_path, capsys):
    out = tmp_path / "lips.csv"
    assert main(["export", str(folder), "--to", "landmarks", "-o", str(out)]) == 0
    said = capsys.readouterr().out.splitlines()
    assert said == ["read back, exact but for rounding: times, 68 landmarks", f"wrote {out}"]
    for name, by, of in (
        ("arkit", "ARKit's 52 weights", "lips"),
        ("fap", "MPEG-4's parameters", "points of the lips"),
    ):
        out = tmp_path / f"face{EXPORTERS.get(name).suffix}"
        assert main(["export", str(folder), "--to", name, "-o", str(out)]) == 0
        said = capsys.readouterr().out.splitlines()
        assert re.match(rf"loss: {by} reproduce {of} to 0?\d*\.?\d+ mm RMS$", said[0])
        assert "head angles" in said[-2]


def test_a_difference_is_of_rounding_or_it_is_printed():
    assert Loss(9e-7, "s", "times").rounded
    assert not Loss(2e-6, "s", "times").rounded
    assert not Loss(0.0, "mm", "lips", by="ARKit's 52 weights").rounded
    assert not Loss(float("nan"), "mm", "lips").rounded
    assert str(Loss(0.25, "mm", "lips")) == "lips: 0.25 mm RMS"


def test_what_cannot_be_exported_is_refused(folder, tmp_path):
    with pytest.raises(ParameterError, match="did you mean 'praat'"):
        export_run(folder, "prat", tmp_path / "x")
    with pytest.raises(OutputError, match=r"does not end in \.glb"):
        export_run(folder, "gltf", tmp_path / "head.csv")
    with pytest.raises(InputFileError, match="is not a run"):
        export_run(tmp_path, "obj", tmp_path / "x")
    (tmp_path / "there").mkdir()
    with pytest.raises(OutputError, match="exists already"):
        export_run(folder, "obj", tmp_path / "there")
    other = tmp_path / "other"
    other.mkdir()
    for path in folder.iterdir():
        (other / path.name).write_bytes(path.read_bytes())
    arrays = dict(np.load(folder / "mesh.npz"))
    np.savez(other / "mesh.npz", **(arrays | {"faces": arrays["faces"][:, ::-1]}))
    with pytest.raises(ModelFormatError, match="tracked with another head"):
        export_run(other, "obj", tmp_path / "x")
    assert sorted(one.name for one in tmp_path.iterdir()) == ["other", "there"]


def test_lips_that_stay_closed_are_closed_to_the_end_of_the_grid():
    times = np.arange(10) / 25.0
    arrays = {
        "time": times,
        "closure_frames": np.array([[2, 4], [7, 9]]),
        "closure_times": np.array([[0.07, 0.18], [0.27, np.nan]]),
    }
    run = SimpleNamespace(arrays=arrays, rate=25.0)
    np.testing.assert_allclose(closures(run), [[0.07, 0.18], [0.27, 0.4]])


def _leaves(_run, path: Path) -> None:
    path.write_text("half")
    raise OSError("bad")


def _ends(*_) -> None:
    raise SystemExit(5)


def _says_nothing(_run, path: Path) -> None:
    path.write_text("x")


@pytest.mark.parametrize(
    ("write", "suffix", "said"),
    [
        (_leaves, ".e", r"fails \(OSError: bad\) in test_export\.py, line \d+; correct its plugin"),
        (_ends, ".e", r"fails \(SystemExit: 5\)"),
        (_ends, "", r"fails \(SystemExit: 5\)"),
        (_says_nothing, ".e", "does not return what is lost; return a tuple of Loss"),
        (lambda *_: (), ".e", r"wrote no file out\.e"),
        (lambda _, path: path.mkdir() or (), ".e", r"wrote no file out\.e"),
        (lambda *_: (3,), "", "does not return what is lost"),
        (lambda *_: (Loss(0.0, "mm", "all"),), "", "wrote nothing"),
    ],
)
def test_an_exporter_of_one_s_own_that_fails_is_named(
    write, suffix, said, folder, tmp_path, request
):
    EXPORTERS.add("own", Exporter("own", write, suffix))
    request.addfinalizer(lambda: EXPORTERS._added.pop("own"))
    with pytest.raises(PluginError, match=f"the exporter 'own' {said}"):
        export_run(folder, "own", tmp_path / f"out{suffix}")
    assert list(tmp_path.iterdir()) == []


def test_the_table_that_a_run_has_is_named_unless_a_plugin_exports_one(folder, tmp_path, request):
    with pytest.raises(ParameterError, match=r"no format 'csv'; use results\.csv of the run"):
        export_run(folder, "csv", tmp_path / "out.csv")
    for name in ("TextGrid", "elan"):
        with pytest.raises(ParameterError, match=f"no format '{name}'; use praat, "):
            export_run(folder, name, tmp_path / "out")
    with pytest.raises(ParameterError, match="no format 'svg'; choose one of arkit"):
        export_run(folder, "svg", tmp_path / "out.svg")
    EXPORTERS.add("csv", Exporter("own", lambda _, path: path.write_text("x") and (), ".csv"))
    request.addfinalizer(lambda: EXPORTERS._added.pop("csv"))
    export_run(folder, "csv", tmp_path / "out.csv")
    assert (tmp_path / "out.csv").is_file()


@pytest.mark.parametrize("name", ["take.one", "out.v2a", "talk.3", "2024.May.3"])
def test_a_folder_may_have_a_dot_in_its_name(folder, tmp_path, name):
    export_run(folder, "praat", tmp_path / name)
    assert (tmp_path / name / "closures.TextGrid").is_file()


@pytest.mark.parametrize("suffix", [".TextGrid", ".textgrid"])
def test_a_folder_that_is_named_like_a_file_is_refused(folder, tmp_path, suffix):
    with pytest.raises(
        OutputError, match=rf"named like a file, .*; choose a name without \{suffix}"
    ):
        export_run(folder, "praat", tmp_path / f"praat{suffix}")
    assert list(tmp_path.iterdir()) == []
