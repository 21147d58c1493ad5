"""`abs-engine track` from landmarks, from a film to the run's folder, and what it refuses."""

from __future__ import annotations

import csv
import json

import cv2
import numpy as np
import pytest
from drawn import OPEN, film, lit
from heads import seen_at
from runs import write_kind

from abs_engine.cli import main
from abs_engine.tracking.runs.record import load_run
from abs_engine.tracking.settings.stages import stage_values


@pytest.fixture(scope="module")
def video(tmp_path_factory):
    return film(tmp_path_factory.mktemp("film") / "head.mp4")


def track(video, folder, *more):
    """Exit status of the command."""
    words = ["track", video, "-o", folder, "--renderer", "cpu", *more]
    return main([str(w) for w in words])


@pytest.fixture
def refused(capsys, tmp_path):
    """The one line with which a command is refused, nothing written."""

    def run(video, *more):
        before = sorted(tmp_path.rglob("*"))
        assert track(video, tmp_path / "run", "--quiet", *more) == 2
        lines = capsys.readouterr().err.splitlines()
        assert len(lines) == 1, lines
        assert lines[0].startswith("abs-engine: error: ")
        assert sorted(tmp_path.rglob("*")) == before
        return lines[0]

    return run


def cut_film(path):
    """A drawn head before a wall, then three frames of it elsewhere before another."""
    pictures, chance = [], np.random.default_rng(5)
    walls = [cv2.resize(chance.integers(0, 255, (6, 8, 3), np.uint8), (480, 240)) for _ in range(2)]
    for k, amount in enumerate(OPEN):
        head = lit("amara", seen_at([0, 0.05 * k - 0.1, 0], [0, 0, 700]), jawOpen=amount)
        height, width = head.shape[:2]
        wall = cv2.resize(walls[k > 1], (2 * width, height), interpolation=cv2.INTER_NEAREST)
        left = 0 if k < 2 else width
        wall[:, left : left + width] = head
        pictures.append(wall)
    return write_kind(path, "libx264", pictures)


@pytest.mark.slow
@pytest.mark.usefixtures("soon_ready")
def test_a_cut_is_named_before_the_first_frame_and_in_the_run(tmp_path, capsys):
    video = cut_film(tmp_path / "cut.mp4")
    assert track(video, tmp_path / "run") == 0
    printed = capsys.readouterr()
    assert (printed.out + printed.err).count("the film is cut before frame 2: ") == 1
    told = json.loads((tmp_path / "run" / "run.json").read_text())
    assert told["summary"]["cuts"] == [2]
    assert "the film is cut before frame 2: " in told["summary"]["warnings"][0]
    assert load_run(tmp_path / "run")["cut"].tolist() == [False, False, True, False, False]


@pytest.mark.slow
def test_a_film_of_a_head_becomes_a_run(video, tmp_path, capsys):
    folder = tmp_path / "run"
    assert track(video, folder, "--pupil-distance", "62.5") == 0
    said = capsys.readouterr().out
    assert "scale: pupil distance, pupils 62.5 mm apart, ± 1%" in said
    with (folder / "results.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert [row["found"] for row in rows] == ["1"] * len(OPEN)
    for row in rows:
        assert 0 <= float(row["landmark_distance"]) < 4.0  # mm
        assert float(row["landmark_aperture"]) >= 0
    told = json.loads((folder / "run.json").read_text())
    assert told["settings"]["start"] == "landmarks"
    assert told["settings"]["scale"]["source"] == "pupil distance"
    assert told["settings"]["scale"]["pupils"] == 62.5
    assert told["settings"]["tuning"] == json.loads(json.dumps(stage_values()))
    assert isinstance(told["summary"]["warnings"], list)
    assert set(told["summary"]["separability"]) == {"upper_lip", "lower_lip"}
    found = load_run(folder)
    assert np.corrcoef(found["aperture"], OPEN)[0, 1] > 0.9
    turn = found["rotation"][-1] - found["rotation"][0]
    assert np.linalg.norm(turn) > 0.1
    for name in ("head.png", "contact_sheet.png", "overlay.mp4", "colours.npz", "mesh.npz"):
        assert (folder / name).stat().st_size > 0


@pytest.mark.slow
def test_a_black_and_white_film_runs(tmp_path):
    folder = tmp_path / "run"
    assert track(film(tmp_path / "grey.mp4", 3, grey=True), folder) == 0
    found = load_run(folder)
    assert found["found"].all()
    assert np.isfinite(found["lip_points"]).all()
    told = json.loads((folder / "run.json").read_text())
    assert told["settings"]["scale"]["source"] == "usual pupil distance"
    assert "the video has no colour" in told["summary"]["warnings"][0]


@pytest.mark.slow
def test_a_mouth_of_a_dozen_pixels_runs_or_is_refused_in_a_line(tmp_path, capsys):
    small = film(tmp_path / "small.mp4", 3, factor=0.3)
    folder = tmp_path / "run"
    status = track(small, folder)
    errors = capsys.readouterr().err.splitlines()
    if status == 0:
        found = load_run(folder)
        seen = found["found"]
        assert np.isfinite(found["lip_points"][seen]).all()
        assert (found["aperture"][seen] < 40).all()
    else:
        assert status == 2
        assert len([line for line in errors if line.startswith("abs-engine: error")]) == 1
        assert not folder.exists()


def test_a_film_that_shows_nobody(refused, tmp_path):
    blank = write_kind(
        tmp_path / "blank.mp4", "libx264", [np.full((240, 320, 3), 120, np.uint8)] * 5
    )
    assert "no face was found" in refused(blank)


def test_a_third_face_where_there_is_one(refused, video):
    line = refused(video, "--face", "3")
    assert "there is no face 3: the first frame with a face shows 1 face;" in line


def test_a_pupil_distance_that_is_none_is_refused_before_any_work(refused, video, monkeypatch):
    def never(*_all, **_more):
        raise AssertionError("work was begun")

    monkeypatch.setattr("abs_engine.tracking.run.prepare", never)
    monkeypatch.setattr("abs_engine.tracking.models.heads.load_speaker", never)
    assert "5 mm is not a plausible pupil distance; give millimetres, 30 to 90" in refused(
        video, "--pupil-distance", "5"
    )


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("--face", "1", "--person", "mei"), "leave out --face, or --person"),
        (("--pupil-distance", "60", "--start", "blobs"), "out --pupil-distance, or --start blobs"),
        (("--evidence", "landmarks", "--person", "mei"), "leave out --evidence, or --person"),
        (("--face", "1", "--mouth", "10", "10", "30", "20"), "leave out --face, or --mouth"),
        (("--face", "1", "--preset", "odisio2004"), "leave out --face, or --preset odisio2004"),
    ],
)
def test_what_landmarks_alone_can_do_is_refused_elsewhere(refused, video, words, said):
    assert said in refused(video, *words)


@pytest.mark.slow
@pytest.mark.parametrize(("more", "looked"), [((), True), (("--face", "1"), False)])
def test_other_faces_and_a_stretched_picture_are_warned_of(
    video, tmp_path, monkeypatch, more, looked
):
    proportions = iter([1.9, 1.5])  # of the head that was fitted, and of the usual one
    monkeypatch.setattr("abs_engine.tracking.models.heads.proportion", lambda *_: next(proportions))
    asked = []
    where = "abs_engine.tracking.results.other_faces.find_faces"
    monkeypatch.setattr(where, lambda *_, **__: asked.append(1) or [])
    assert track(video, tmp_path / "run", *more) == 0
    told = json.loads((tmp_path / "run" / "run.json").read_text())
    assert sum("much wider for its height" in w for w in told["summary"]["warnings"]) == 1
    assert bool(asked) is looked
