"""`abs-engine render`: files that appear, what they show, and one line for what is wrong."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest
from inspected import CAMERA, RATE, frames, labels, write_dataset, write_run, write_video

from abs_engine.cli import main
from abs_engine.dataset import write_sums
from abs_engine.dataset.sums import digest
from abs_engine.io.assets import load_speaker
from abs_engine.io.head_file import write_head
from abs_engine.io.video import probe, read_frames
from abs_engine.report.drawing.palette import CLASS_COLOURS, colours_of
from abs_engine.report.inspect.request import CHOICES


@pytest.fixture(scope="module")
def place(tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("inspected")
    write_run(folder / "run")
    write_dataset(folder / "data")
    write_video(folder / "video.mp4")
    return folder


@pytest.fixture
def render(tmp_path, capsys):
    """Run the command; the picture it wrote, or the path of the film."""

    def run(*words: object, name: str = "made.png"):
        path = tmp_path / name
        typed = ["render", *map(str, words), "-o", str(path), "--renderer", "cpu"]
        assert main(typed) == 0, capsys.readouterr().err
        return path if name.endswith("mp4") else cv2.imread(str(path))[..., ::-1]

    return run


@pytest.fixture
def fails(tmp_path, capsys):
    """Run the command that is to fail; its line."""

    def run(*words: object, name: str = "made.png") -> str:
        before = sorted(tmp_path.rglob("*"))
        output = [] if "-o" in words else ["-o", str(tmp_path / name)]
        status = main(["render", *map(str, words), *output, "--renderer", "cpu"])
        lines = [
            row for row in capsys.readouterr().err.splitlines() if not row.startswith("drawing: ")
        ]
        assert status == 2
        assert len(lines) == 1, lines
        assert "; " in lines[0], "what to do is missing"
        assert sorted(tmp_path.rglob("*")) == before
        return lines[0]

    return run


def test_a_portrait_is_the_default(render):
    picture = render("--unit", "jawOpen=0.4", "--palette", "classes")
    assert picture.shape == (512, 512, 3)
    assert (picture[:4] == 255).all()
    assert (picture[256, 256] != 255).any()


def test_of_another_head_the_first_person_is_drawn(render, tmp_path):
    bundled, path = load_speaker(), tmp_path / "kofi.face"
    people = {name: bundled.people[name] for name in ("kofi", "mei")}
    write_head(path, replace(bundled, people=people, own_texture=bundled.texture("kofi")))
    size = ("--size", 48, 56)
    picture = render(*size, "--speaker", path)
    assert (picture == render(*size, "--person", "kofi", name="own.png")).all()
    assert (picture != render(*size, "--speaker", path, "--person", "mei", name="2.png")).any()


def test_kinds_may_be_named_after_options(render):
    sheet = render("--size", 48, 56, "turntable", "--views", 4, "--palette", "clay")
    columns = 3  # what is nearest to 1.6 times as wide as high
    assert sheet.shape == (2 * (56 + 22 + 4) + 4, columns * 52 + 4, 3)


def test_a_turntable_as_a_film(render):
    path = render("turntable", "--views", 3, "--size", 48, 56, name="t.mp4")
    shown = list(read_frames(path))
    assert len(shown) == 3
    assert shown[0].shape == (56, 48, 3)
    assert np.abs(shown[0].astype(int) - shown[1]).max() > 50


def test_postures_and_nomograms_as_films(render):
    rows = "--rows", "jawOpen", "--size", 48, 56
    for kind in ("postures", "nomogram"):
        shown = list(read_frames(render(kind, *rows, name=f"{kind}.mp4")))
        assert len(shown) == 26
        assert np.abs(shown[13].astype(int) - shown[0]).max() > 50


def test_a_nomogram_of_modes(render):
    sheet = render("nomogram", "--modes", 2, "--columns", 3, "--size", 40, 48, "--crop", "mouth")
    assert sheet.shape == (24 + 2 * 52, 124 + 3 * 44, 3)


def test_a_nomogram_of_a_run(render, place):
    sheet = render("nomogram", place / "run", "--columns", 3, "--size", 40, 48)
    assert sheet.shape == (24 + 52, 124 + 3 * 44, 3)


@pytest.mark.parametrize("style", ["wireframe", "contour", "blend"])
def test_an_overlay_changes_the_face_and_nothing_else(render, place, style):
    drawn = render("overlay", place / "run", "--frame", 0, "--style", style)
    scale = -(-640 // CAMERA.size[1])
    large = drawn[: scale * CAMERA.size[1]]
    plain = CAMERA.whole.__class__(0, 0, *CAMERA.size, scale).sample(_video_frame(place, 0))
    change = np.abs(large.astype(int) - plain).max(axis=2) > 12
    covered = cv2.resize(
        (labels()[0].ids > 0).astype(np.uint8), (large.shape[1], large.shape[0]),
        interpolation=cv2.INTER_NEAREST,
    )  # fmt: skip
    near = cv2.dilate(covered, np.ones((4 * scale, 4 * scale))) > 0
    assert change[covered > 0].mean() > {"contour": 0.01, "wireframe": 0.2, "blend": 0.4}[style]
    assert not change[~near].any()


def _video_frame(place: Path, number: int) -> np.ndarray:
    return list(read_frames(place / "video.mp4"))[number]


def test_an_overlay_film_and_its_lost_frame(render, place):
    path = render("overlay", place / "run", name="o.mp4")
    info = probe(path)
    assert (info.frames, info.rate) == (3, RATE)
    lost = list(read_frames(path))[1]
    scale = lost.shape[1] // CAMERA.size[0]
    plain = CAMERA.whole.__class__(0, 0, *CAMERA.size, scale).sample(_video_frame(place, 1))
    assert np.abs(lost[: plain.shape[0]].astype(int) - plain).mean() < 4


@pytest.mark.parametrize("kind", ["overlay", "ids"])
def test_a_film_of_an_uneven_video_shows_frames_at_their_times(kind, render, place, tmp_path):
    shutil.copytree(place / "run", tmp_path / "uneven")
    arrays = dict(np.load(tmp_path / "uneven/results.npz"))
    arrays["time"] = np.array([0.5, 0.54, 1.3])
    np.savez(tmp_path / "uneven/results.npz", **arrays)
    video = ["--video", place / "video.mp4"] if kind == "overlay" else []
    film = render(kind, tmp_path / "uneven", *video, name="u.mp4")
    np.testing.assert_allclose(probe(film).times, [0, 0.04, 0.8], atol=1e-3)


def test_labels_of_a_dataset(render, place):
    shown = {
        kind: render(kind, "--truth", place / "data", "--frame", 1, name=f"{kind}.png")
        for kind in ("ids", "classes", "depth", "normals", "albedo", "flow")
    }
    height, width = CAMERA.size[1], CAMERA.size[0]
    frame, inside = labels()[1], np.zeros((height, width), bool)
    inside[1:-1, 1:-1] = True  # within the grey frame
    seen = (frame.ids > 0) & inside
    top = {
        kind: (picture.shape[0] - height - 22) // 2 if kind not in ("ids", "albedo") else 0
        for kind, picture in shown.items()
    }
    cut = {kind: shown[kind][top[kind] : top[kind] + height, :width] for kind in shown}
    for picture in cut.values():
        assert (picture[~(frame.ids > 0) & inside] == 255).all()
    class_id = np.concatenate([[0], load_speaker().facet_class])[frame.ids]
    assert (cut["classes"][seen] == CLASS_COLOURS[class_id][seen]).all()
    assert (cut["albedo"][seen] == frames()[1][seen]).all()
    depth = frame.read("depth")
    scale = colours_of("viridis_r").astype(int)
    low, high = 10 * np.floor(depth[frame.ids > 0].min() / 10), 10 * np.ceil(depth.max() / 10)
    index = np.rint((depth - low) / (high - low) * 255).astype(int)[seen]
    assert np.abs(cut["depth"][seen] - scale[index]).max() < 5
    normals = 127.5 * (frame.read("normals") * [1, -1, -1] + 1)
    assert np.abs(cut["normals"][seen] - normals[seen]).max() < 1.5
    assert len(np.unique(cut["flow"][seen].reshape(-1, 3), axis=0)) == 1
    assert len(np.unique(cut["ids"][seen].reshape(-1, 3), axis=0)) > 10


def test_labels_of_a_run_and_of_a_posture(render, place):
    of_run = render("classes", place / "run", "--frame", 0)
    assert of_run.shape[1] > CAMERA.size[0] + 100  # with its legend
    sheet = render("normals", "--size", 64, 72, "--views", 4, name="n.png")
    assert sheet.shape[0] >= 200
    film = render("depth", "--size", 64, 72, "--views", 3, name="d.mp4")
    assert probe(film).frames == 3


def test_the_error_of_a_run_is_what_it_was_made_with(render, place):
    for more in ((), ("--frame", 2)):
        name = f"e{len(more)}.png"
        heat = render(
            "error", place / "run", "--truth", place / "data", "--max", 10, "--size", 60, 70, *more,
            name=name,
        )  # fmt: skip
        face = heat[25:45, 60 + 20 : 60 + 40].reshape(-1, 3).astype(float)
        colour = colours_of("viridis")[round(5 / 10 * 255)]
        hue = face / face.sum(axis=1, keepdims=True)
        assert np.abs(hue - colour / colour.sum()).max() < 0.03


@pytest.fixture(scope="module")
def several(tmp_path_factory) -> Path:
    """Two clips, and a run of the second."""
    folder = tmp_path_factory.mktemp("several")
    data = write_dataset(folder / "data")
    write_video(data / "clip/front/video.mp4")
    shutil.copytree(data / "clip", data / "other")
    with (data / "other/front/video.mp4").open("ab") as file:
        file.write(b"more")
    record = json.loads((data / "dataset.json").read_text())
    record["clips"].append({**record["clips"][0], "name": "other"})
    (data / "dataset.json").write_text(json.dumps(record))
    write_sums(data)
    write_run(folder / "run")
    told = {"video": "x.mp4", "video_sha256": digest(data / "other/front/video.mp4")}
    (folder / "run/run.json").write_text(json.dumps({"settings": told}))
    return folder


def test_a_run_is_drawn_beside_the_clip_that_was_tracked(render, fails, several):
    run, data = several / "run", several / "data"
    for kind, more in (("error", ("--size", 60, 70)), ("overlay", ("--frame", 2))):
        words = kind, run, "--truth", data, *more
        found = render(*words, name=f"{kind}.png")
        named = render(*words, "--clip", "other", "--camera", "front", name=f"{kind}2.png")
        assert (found == named).all()
    of_other = fails("error", run, "--truth", data / "clip", "--frame", 2)
    assert "is of other/front/video.mp4 of the same dataset" in of_other
    assert "choose with --clip and --camera" in fails("ids", "--truth", data)
    assert "give --truth" in fails("error", run, "--clip", "other")


def test_an_array_is_painted(render, tmp_path):
    np.save(tmp_path / "v.npy", np.full(len(load_speaker().vertices), 2.0))
    film = render(
        "error", "--values", tmp_path / "v.npy", "--views", 2, "--size", 48, 56, name="a.mp4"
    )
    assert probe(film).frames == 2


def test_unknown_names(fails):
    assert "did you mean 'jawOpen'?" in fails("--unit", "jawOpn=1")
    assert "did you mean 'mouthPucker'?" in fails("postures", "--rows", "mouthpuker")
    assert "did you mean 'clara'?" in fails("--person", "clra")
    assert "there is no choice 'nomogramm'; did you mean 'nomogram'?" in fails("nomogramm")


def test_files_that_cannot_be_written(fails, tmp_path):
    (tmp_path / "there.png").touch()
    assert "exists already" in fails("-o", tmp_path / "there.png")
    assert "neither PNG nor MP4" in fails(name="made.gif")
    assert "there is no folder" in fails(name="none/made.png")


def test_choices_that_do_not_go_together(fails, place):
    run, data = place / "run", place / "data"
    assert "takes no --truth" in fails("turntable", "--truth", data)
    assert "takes no RUN" in fails("postures", run)
    assert "takes no --unit" in fails("overlay", run, "--unit", "jawOpen=1")
    assert "needs a run" in fails("overlay")
    assert "only one" in fails("ids", run, "--truth", data)
    assert "one frame is not a film" in fails("ids", run, "--frame", 0, name="f.mp4")
    assert "--values FILE, or RUN --truth DIR" in fails("error")
    assert "stored in datasets only" in fails("flow")
    assert "--rows names face units" in fails("nomogram", "--modes", 2, "--rows", "jawOpen")
    assert "modes asked for" in fails("nomogram", "--modes", 99)
    assert "3 modes asked for, the run's head has 1" in fails("nomogram", run, "--modes", 3)


def test_numbers_that_make_no_sense(fails, place):
    run, data = place / "run", place / "data"
    assert "no frame 9" in fails("ids", run, "--frame", 9)
    assert "no frame -1" in fails("depth", "--truth", data, "--frame", -1)
    last = len(frames()) - 1
    assert f"no flow is known from frame {last}" in fails("flow", "--truth", data, "--frame", last)
    assert "was not found in frame 1" in fails("error", run, "--truth", data, "--frame", 1)
    assert "NaN" in fails("--unit", "jawOpen=nan")
    assert "NaN" in fails("--turn", "nan")
    assert "--range ends" in fails("depth", "--range", 900, 800)
    said = fails("error", run, "--truth", data, "--max", -3)
    assert "the scale begins at 0 and ends at -3; give a greater --max" in said
    assert "give 16 to 4096 pixels" in fails("--size", 4, 40)
    assert "give 16 to 4096 pixels" in fails("--size", 40, 60000)


def test_runs_and_data_that_do_not_fit(fails, place, tmp_path):
    np.save(tmp_path / "v.npy", np.zeros(7))
    assert "holds 7 numbers, the head has" in fails("error", "--values", tmp_path / "v.npy")
    assert "is not a run" in fails("overlay", tmp_path)
    small = tmp_path / "small.mp4"
    write_small(small)
    assert "has 32x24 pixels, the run 96x72" in fails("overlay", place / "run", "--video", small)
    short = tmp_path / "short.mp4"
    write_small(short, CAMERA.size)
    line = fails("overlay", place / "run", "--video", short, name="f.mp4")
    assert "differ in number of frames: 1 and 3; give the tracked video" in line


def write_small(path: Path, size: tuple[int, int] = (32, 24)) -> None:
    from abs_engine.io.video import VideoWriter

    with VideoWriter(path, size, RATE) as writer:
        writer.write(np.zeros((size[1], size[0], 3), np.uint8))


def test_a_run_whose_video_is_elsewhere(render, fails, place, tmp_path):
    run = write_run(tmp_path / "alone")
    line = fails("overlay", run)
    assert "is not beside the run" in line
    assert "--video FILE, or its dataset with --truth DIR" in line
    assert (render("overlay", run, "--truth", place / "data") != 255).any()


def test_what_has_no_effect_on_a_run_is_refused(fails, place):
    run, data = place / "run", place / "data"
    assert "--person does not go with RUN" in fails("classes", run, "--person", "kofi")
    assert "--unit does not go with --truth" in fails("ids", "--truth", data, "--unit", "jawOpen=1")
    assert "--turn does not go with RUN" in fails("depth", run, "--turn", 30)
    error = "error", run, "--truth", data
    assert "--person does not go with RUN" in fails(*error, "--person", "kofi")


@pytest.mark.parametrize("kind", ["portrait", "ids", "depth"])
def test_a_head_that_is_shown_from_all_sides_is_not_turned(fails, kind):
    rest = "which shows the head from all sides; leave one of them out"
    line = fails(kind, "--turn", 30, "--views", 4)
    assert f"--turn does not go with --views, {rest}" in line
    assert f"--turn does not go with an MP4, {rest}" in fails(kind, "--turn", 30, name="t.mp4")


def test_what_has_no_effect_on_other_styles_or_films_is_refused(fails, place):
    run = place / "run"
    for style in ("contour", "wireframe"):
        line = fails("overlay", run, "--style", style, "--palette", "clay")
        assert f"a {style} has no --palette; give --style blend" in line
    assert "a film has no --columns" in fails("nomogram", "--columns", 3, name="n.mp4")


def test_a_wrong_head_is_refused_before_a_renderer_is_opened(fails, place, monkeypatch):
    opened: list[object] = []
    monkeypatch.setattr("abs_engine.render.select.open_renderer", opened.append)
    assert "is not an NPZ file" in fails("overlay", place / "run", "--speaker", __file__)
    assert not opened


def test_a_wrong_person_is_told_before_a_renderer_is_opened(fails, monkeypatch):
    def opened(*_):
        raise AssertionError("a renderer was opened")

    monkeypatch.setattr("abs_engine.render.select.open_renderer", opened)
    for kind in ("portrait", "nomogram", "classes"):
        assert "did you mean 'clara'?" in fails(kind, "--person", "clra")


def test_modes_show_the_mouth(render):
    mouth = render("nomogram", "--modes", 1, "--columns", 2, "--size", 40, 48, name="m.png")
    head = "nomogram", "--modes", 1, "--columns", 2, "--size", 40, 48, "--crop", "head"
    assert (mouth != render(*head, name="h.png")).any()


def test_every_kind_says_what_it_takes():
    from abs_engine.cli.commands.render import KINDS

    assert set(KINDS) == set(CHOICES)


def test_a_file_whose_name_is_no_text_is_named(tmp_path):
    name = os.fsencode(tmp_path) + b"/\xff.png"
    words = ["render", "--size", "48", "56", "--renderer", "cpu", "-o", name]
    run = subprocess.run([sys.executable, "-m", "abs_engine", *words], capture_output=True)
    assert run.returncode == 0, run.stderr
    assert rb"\udcff.png" in run.stdout
    assert os.path.exists(name)
