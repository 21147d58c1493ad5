"""A camera worn before the mouth: what mouths look like is learned, then a close-up is tracked."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import numpy as np
import pytest
from drawn import lit, speaker, vertices_of
from heads import seen_at
from runs import write_kind

import abs_engine
from abs_engine.cli import main
from abs_engine.core.camera import Camera
from abs_engine.face.appearance.opening import MouthSpot, OpeningLooks
from abs_engine.face.rings import lip_rings
from abs_engine.io.video import VideoInfo, probe
from abs_engine.learn.opening import (
    POINTS,
    LabelledMouth,
    disagreement,
    doubt,
    learn_opening,
    sides_of,
    spot_of,
)
from abs_engine.render.cpu import CpuRenderer
from abs_engine.tracking.detection.initial_pose import with_mouth_at
from abs_engine.tracking.models import worn, worn_fit
from abs_engine.tracking.models.worn import _doubts, _whole_faces, found_mouth, load_looks
from abs_engine.tracking.models.worn_fit import find_mouth, unsettled
from abs_engine.tracking.models.worn_labels import COLUMNS, read_mouths
from abs_engine.tracking.options import Clip, TrackOptions
from abs_engine.tracking.run import prepare_clip
from abs_engine.tracking.runs.record import load_run
from abs_engine.tracking.settings.worn import CLOSE_UP

CAMERA = Camera.ideal((160, 120))
POSE = with_mouth_at(
    seen_at([0, 0, 0], [0, 0, 250]), np.array([78, 56]), CAMERA,
    vertices_of(None)[speaker().lip_ring].mean(axis=0),
)  # fmt: skip
OPEN = (0.0, 0.12, 0.3, 0.05, 0.2)
NEW = (0.0, 0.08, 0.16, 0.26, 0.35, 0.2, 0.04, 0.3)
LABELLED = ("walter", "amara")


def close_up(person: str, amount: float) -> np.ndarray:
    """A grey close-up (120, 160, 3) of somebody's mouth."""
    picture = lit(person, POSE, CAMERA, jawOpen=amount).mean(axis=2, keepdims=True)
    return np.repeat(picture, 3, axis=2).astype(np.uint8)


def inner_points(person: str, amount: float) -> np.ndarray:
    """`POINTS` (8, 2) of the same, px."""
    at, rings = vertices_of(person, jawOpen=amount), lip_rings(speaker())
    lines = [CAMERA.project(POSE.apply(at[rings[name]])) for name in ("corners", "upper", "lower")]
    corners, upper, lower = (line[np.argsort(line[:, 0])] for line in lines)
    x = corners[0, 0] + np.repeat([0.25, 0.5, 0.75], 2) * np.ptp(corners[:, 0])
    y = np.array([np.interp(a, *line.T) for a, line in zip(x, [upper, lower] * 3, strict=True)])
    y[1::2] = np.maximum(y[::2], y[1::2])
    return np.vstack([corners, np.column_stack([x, y])])


def test_a_picture_of_a_whole_face_is_no_close_up():
    whole = lit("walter", seen_at([0, 0, 0], [0, 0, 700]), Camera.ideal((320, 320)))
    near = close_up("walter", 0.2)
    assert _whole_faces([whole, whole, near])
    assert not _whole_faces([near, near, whole])


def test_looks_from_several_places_end_at_a_mouth_and_elsewhere_without_one():
    rng = np.random.default_rng(0)
    noise = [rng.integers(0, 255, (120, 160, 3), dtype=np.uint8) for _ in range(3)]
    wall = np.clip(rng.normal(170, 4, (3, 120, 160, 1)) + np.zeros(3), 0, 255).astype(np.uint8)
    mouths = [close_up("walter", amount) for amount in (0.0, 0.1, 0.3)]
    assert unsettled(mouths) < CLOSE_UP.most_unsettled
    assert unsettled(noise) > CLOSE_UP.most_unsettled
    assert unsettled(list(wall)) > CLOSE_UP.most_unsettled
    assert unsettled([np.zeros((8, 8, 3), np.uint8)]) > CLOSE_UP.most_unsettled


def test_a_mouth_that_is_upside_down_is_warned_of():
    images = [close_up("amara", amount) for amount in (0.0, 0.1, 0.3)]
    assert not _doubts(images, found=True)
    assert "upside down" in _doubts([image[::-1, ::-1] for image in images], found=False)[0]


def test_few_frames_that_are_astray_hide_no_mouth(monkeypatch):
    monkeypatch.setattr(worn_fit, "_spread_of_widths", lambda image: float(image.max()))
    astray = [np.full((64, 64, 3), k in (0, 4, 7), np.uint8) for k in range(CLOSE_UP.fitted)]
    monkeypatch.setattr(worn, "upside_down", lambda _images: False)
    assert not _doubts(astray, found=True)
    assert _doubts([astray[0]] * 3, found=True)
    assert not _doubts([astray[0]] * 3, found=False)


def write_clip(path, person: str, amounts) -> None:
    write_kind(path, "libx264", [close_up(person, a) for a in amounts])


def write_labels(folder, change=lambda row: row):
    path = folder / "labels.csv"
    with path.open("w", encoding="utf-8", newline="") as file:
        table = csv.writer(file)
        table.writerow(["video", "frame", *COLUMNS])
        for person in LABELLED:
            for k, amount in enumerate(OPEN):
                points = inner_points(person, amount).ravel()
                table.writerow(change([f"{person}.mp4", k, *points]))
    return path


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Labelled clips of two people, what was learned of them, and other clips of one."""
    made = tmp_path_factory.mktemp("close-ups")
    for person in LABELLED:
        write_clip(made / f"{person}.mp4", person, OPEN)
    write_clip(made / "new.mp4", "amara", NEW)
    write_clip(made / "short.mp4", "amara", NEW[2:4])
    labels = write_labels(made)
    assert main(["mouths", str(labels), "-o", str(made / "mouths.face"), "--quiet"]) == 0
    return made


@pytest.mark.parametrize(("frames", "videos", "warned"), [(20, 3, 0), (19, 3, 1), (40, 2, 1)])
def test_few_labelled_frames_or_videos_are_warned_of(frames, videos, warned):
    points = inner_points("amara", 0.5)
    spots = [spot_of([points + k]) for k in range(videos)]
    closed = points.copy()
    closed[2::2] = closed[3::2]
    mouths = [LabelledMouth(np.zeros((2, 2, 3), np.uint8), at, spots[k % videos])
              for k, at in enumerate([closed] + [points] * (frames - 1))]  # fmt: skip
    assert doubt(mouths[1:])[-1].startswith("warning: no closed mouth is labelled")
    said = doubt(mouths)
    assert len(said) == warned
    assert not said or f"warning: {frames} frames of {videos} videos may show too" in said[0]


@pytest.fixture(scope="module")
def run(folder):
    """The other clip, tracked by what was learned."""
    words = ["track", "new.mp4", "-o", "run", "--worn", "--model", "mouths.face"]
    paths = [str(folder / w) if "." in w or w == "run" else w for w in words]
    assert main([*paths, "--renderer", "cpu", "--quiet"]) == 0
    return folder / "run"


def test_a_close_up_is_followed(run):
    tracked, setting = load_run(run), json.loads((run / "run.json").read_text())
    assert tracked["found"].all()
    assert setting["settings"]["model"] == "worn"
    assert setting["settings"]["evidence"] is None
    assert setting["summary"]["warnings"] == []
    true = np.array([inner_points("amara", a) for a in NEW])
    width = np.ptp(true[0, :2, 0])
    labelled = (true[:, 5] - true[:, 4])[:, 1] / width
    shares = np.asarray(tracked["aperture"]) / np.asarray(tracked["width"])
    assert np.corrcoef(labelled, shares)[0, 1] > 0.95
    assert np.abs(shares - labelled).max() < 0.08


def test_a_camera_that_is_worn_is_learned_from_as_it_films(folder):
    shown = tuple(close_up("amara", amount) for amount in NEW[1:4])
    clip = Clip(Path("camera 0"), VideoInfo((160, 120), 25.0, 0), CAMERA, None, shown)
    options = TrackOptions(model=str(folder / "mouths.face"))
    made = prepare_clip(clip, CpuRenderer(), options, print)
    assert made.setting.warnings == ()


def test_a_run_of_whole_faces_keeps_the_warning(folder):
    whole = lit("walter", seen_at([0, 0, 0], [0, 0, 700]), Camera.ideal((320, 320)))
    video = write_kind(folder / "whole.mp4", "libx264", [whole] * 2)
    run = abs_engine.track(video, worn=True, model=folder / "mouths.face", renderer="cpu")
    assert [line for line in run.warnings if "without --worn" in line]
    assert run.settings["remarks"] == run.warnings[0]


def test_a_box_for_the_mouth_silences_no_warning_of_whole_faces(folder, monkeypatch):
    monkeypatch.setattr(worn, "_whole_faces", lambda _images: True)
    choices = {"worn": True, "model": folder / "mouths.face", "renderer": "cpu"}
    run = abs_engine.track(folder / "short.mp4", mouth=(50, 40, 60, 40), **choices)
    assert [line for line in run.warnings if "without --worn" in line]


def test_a_run_of_no_mouth_keeps_the_warning(folder):
    walls = np.clip(np.random.default_rng(0).normal(170, 4, (2, 120, 160, 1)), 0, 255)
    video = write_kind(
        folder / "wall.mp4", "libx264", list(np.repeat(walls, 3, 3).astype(np.uint8))
    )
    run = abs_engine.track(video, worn=True, model=folder / "mouths.face", renderer="cpu")
    assert [line for line in run.warnings if line.startswith("no mouth is seen for sure")]
    assert run.settings["remarks"] == run.warnings[0]


def test_a_run_without_a_model_warns_once_and_keeps_it(folder, tmp_path, capsys):
    words = ["track", str(folder / "short.mp4"), "-o", str(tmp_path / "run"), "--worn"]
    assert main([*words, "--renderer", "cpu", "--quiet"]) == 0
    said = [
        line for line in capsys.readouterr().out.splitlines() if "openings are less exact" in line
    ]
    assert len(said) == 1
    assert said[0].startswith("warning: without a model")
    assert "'mouths'" in said[0]
    told = json.loads((tmp_path / "run" / "run.json").read_text())
    assert said[0].removeprefix("warning: ") in told["summary"]["warnings"]


def test_the_mouth_is_found_in_a_close_up():
    images = [close_up("amara", a) for a in OPEN[:2]]
    spot = find_mouth(images)
    left, right = inner_points("amara", 0.0)[:2]
    true = MouthSpot.between(left, right)
    assert abs(spot.x - true.x) < 0.15 * true.width
    assert abs(spot.y - true.y) < 0.15 * true.width
    assert 0.75 < spot.width / true.width < 1.33


def test_looks_are_learned_from_more_frames_than_the_head_is_fitted_to(tmp_path, monkeypatch):
    monkeypatch.setattr(worn, "learn_opening", list)
    write_clip(tmp_path / "clip.mp4", "amara", NEW * 2)
    info = probe(tmp_path / "clip.mp4")
    clip = Clip(tmp_path / "clip.mp4", info, CAMERA, None)
    images, opening, _ = found_mouth(clip, TrackOptions(worn=True), None, str)
    assert len(images) == CLOSE_UP.fitted
    assert len(opening.looks) == len(NEW * 2)


def by_points(images, points) -> list[LabelledMouth]:
    """Frames of one clip with points."""
    return [LabelledMouth(i, p, spot_of(points)) for i, p in zip(images, points, strict=True)]


def test_a_model_disagrees_with_mouths_unlike_those_that_it_was_learned_from(folder):
    looks = load_looks(folder / "mouths.face")
    images, points = ([made("amara", a) for a in NEW] for made in (close_up, inner_points))
    mouths = by_points(images, points)
    assert disagreement(looks, mouths) < 0
    assert disagreement(looks, by_points([255 - i for i in images], points)) > CLOSE_UP.most_unlike
    assert disagreement(looks, by_points(images, points[::-1])) > disagreement(looks, mouths) + 0.5
    unseen = by_points(images[:1], [np.full((8, 2), np.nan)])
    assert disagreement(looks, [*mouths, *unseen]) == disagreement(looks, mouths)
    assert np.isnan(disagreement(looks, unseen))
    assert np.isnan(disagreement(looks, mouths[:1] * 8))  # a mouth that does not move


@pytest.mark.parametrize(("mouth", "unlike", "warned"), [
    (None, 1.1, 1), (None, 0.9, 0), (None, float("nan"), 0), ((50, 40, 60, 40), 1.1, 0),
])  # fmt: skip
def test_a_model_of_another_kind_of_camera_is_warned_of(folder, monkeypatch, mouth, unlike, warned):
    monkeypatch.setattr(worn, "disagreement", lambda *_: unlike * CLOSE_UP.most_unlike)
    choices = {"worn": True, "model": folder / "mouths.face", "renderer": "cpu", "mouth": mouth}
    run = abs_engine.track(folder / "short.mp4", **choices)
    assert ["track without --model" in line for line in run.warnings] == [True] * warned


def test_sides_are_where_the_lips_part():
    spot = MouthSpot(80.0, 60.0, 64.0)
    points = np.array([[48, 60], [112, 60], [64, 56], [64, 64], [80, 54], [80, 66], [96, 56],
                       [96, 64]], float)  # fmt: skip
    sides, _ = sides_of(spot.to_normalised(points))
    x, y = np.rint(spot.to_normalised(np.array([80.0, 60.0]))).astype(int)
    assert [sides[y - 15, x], sides[y, x], sides[y + 15, x]] == [0, 1, 2]
    assert sides[y, x - 40] == sides[y, x + 40] == 3
    shut = points.copy()
    shut[3::2, 1] = shut[2::2, 1]
    assert (sides_of(spot.to_normalised(shut))[0] == 1).sum() < (sides == 1).sum() / 4


def test_what_was_learned_is_kept_and_is_the_same_again(folder):
    kept = load_looks(folder / "mouths.face")
    again = learn_opening(read_mouths(folder / "labels.csv"))
    assert isinstance(kept, OpeningLooks)
    np.testing.assert_array_equal(kept.layers[0][0], again.layers[0][0])
    image, spot = close_up("amara", 0.2), MouthSpot(80, 60, 70)
    maps = kept.probabilities(image, spot)
    np.testing.assert_allclose(maps.sum(axis=0), 1, atol=1e-5)


def one_line(capsys) -> str:
    lines = capsys.readouterr().err.splitlines()
    assert len(lines) == 1, lines
    return lines[0]


def shut(row):
    """The same label with closed lips; a label by hand may be off by a pixel."""
    points = np.reshape(row[2:], (8, 2))
    points[2::2] = points[3::2] - [0, 0.5]
    return [*row[:2], *points.ravel()]


def test_labels_of_closed_mouths_alone_are_refused(folder, tmp_path, capsys):
    for name in [f"{person}.mp4" for person in LABELLED]:
        (tmp_path / name).symlink_to(folder / name)
    labels = str(write_labels(tmp_path, shut))
    assert main(["mouths", labels, "-o", str(tmp_path / "out.face"), "--quiet"]) == 2
    assert "labels.csv: no open mouth is labelled; label frames in which" in one_line(capsys)
    assert not (tmp_path / "out.face").exists()


def exchanged(flat, one, other):
    """A row's points, with two exchanged."""
    points = np.reshape(flat, (-1, 2))
    points[[one, other]] = points[[other, one]]
    return points.ravel()


def upside_down(flat):
    """A row's points, with each lip labelled as the other."""
    return np.reshape(flat, (-1, 2))[[0, 1, 3, 2, 5, 4, 7, 6]].ravel()


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda row: [*row[:-1], ""], "a cell is empty"),
        (
            lambda row: [row[0], row[1] + 90, *row[2:]],
            "has 5 frames and no frame 90; count frames from 0",
        ),
        (lambda row: [row[0], row[1] + 0.5, *row[2:]], "frame 0.5 is not a whole number"),
        (lambda row: [row[0], row[1] // 2, *row[2:]], "is labelled twice"),
        (lambda row: [*row[:2], *row[4:6], *row[2:4], *row[6:]], "the left corner is not left"),
        (
            lambda row: [
                *row[:2],
                *exchanged(row[2:], 2, 6),
            ],
            "points of the upper lip are out of order",
        ),
        (lambda row: [*row[:2], *upside_down(row[2:])], "the upper lip lies below the lower"),
        (lambda row: [*row[:-1], 5000], "a point lies outside of the picture"),
        (
            lambda row: [*row[:2], *(np.reshape(row[2:], (-1, 2)) / CAMERA.size).ravel()],
            "the mouth is 0.5 px wide in a picture of 160; give pixels",
        ),
    ],
)
def test_labels_that_do_not_fit_are_refused(folder, tmp_path, capsys, change, said):
    for person in LABELLED:
        (tmp_path / f"{person}.mp4").symlink_to(folder / f"{person}.mp4")
    labels = write_labels(tmp_path, change)
    assert main(["mouths", str(labels), "-o", str(tmp_path / "m.face"), "--quiet"]) == 2
    assert said in one_line(capsys)
    assert not (tmp_path / "m.face").exists()


@pytest.mark.parametrize(
    ("more", "said"),
    [
        (["--model", "head"], "is not tracked by the model 'head'"),
        (["--preset", "basu1998"], "is for the model 'shell', not for 'worn'"),
        (["--terms", "colour"], "has no colour to compare"),
        (["--person", "clara"], "does nothing for the model 'worn'"),
    ],
)
def test_what_a_worn_camera_cannot_have_is_refused(folder, tmp_path, capsys, more, said):
    words = ["track", str(folder / "new.mp4"), "-o", str(tmp_path / "r"), "--worn", "--quiet"]
    assert main([*words, "--renderer", "cpu", *more]) == 2
    assert said in one_line(capsys)
    assert not (tmp_path / "r").exists()


def test_points_have_names():
    assert len(COLUMNS) == 2 * len(POINTS) == 16
