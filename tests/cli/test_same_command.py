"""The same command given again, when its output is there: nothing is done, and that is success."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from drawn import lit
from heads import seen_at
from runs import noise, write_kind

from abs_engine.cli import main
from abs_engine.io.files import png
from abs_engine.io.naming import CHOICES, partial_of
from abs_engine.io.unfinished import Unfinished
from abs_engine.tracking.options import TrackOptions
from abs_engine.tracking.run import _choices

SCENE = """\
format = "abs_engine.scene"
version = 1
size = [96, 72]
[background]
picture = "wall.png"
[[clip]]
sentence = "demo"
frames = 2
"""


def held(folder: Path) -> dict[Path, tuple[bytes, int]]:
    """The bytes of the files of a folder, and when they were written."""
    files = [path for path in folder.rglob("*") if path.is_file()]
    return {path: (path.read_bytes(), path.stat().st_mtime_ns) for path in files}


@pytest.fixture
def again(capsys, monkeypatch):
    """Give a command that is killed once its output has its name, then others; see what comes."""

    class Again:
        def __init__(self, folder: Path, *words: object) -> None:
            self.folder, self.words = folder, [*map(str, words), "-o", str(folder), "--quiet"]
            monkeypatch.setattr(Unfinished, "discard", Unfinished.release)
            assert main(self.words) == 0
            monkeypatch.undo()
            assert (partial_of(folder) / CHOICES).is_file()
            self.before = held(folder)

        def says(self, *more: object) -> str:
            capsys.readouterr()
            assert main([*self.words, *map(str, more)]) == 0
            assert held(self.folder) == self.before
            assert not partial_of(self.folder).exists()
            return capsys.readouterr().out

        def refused(self, *more: object) -> None:
            assert main([*self.words, *map(str, more)]) == 2
            assert f"{self.folder} exists already" in capsys.readouterr().err
            assert held(self.folder) == self.before

        def check(self) -> None:
            (line,) = self.says().splitlines()
            assert line.startswith(f"{self.folder} already exists and is complete (made by")
            facts = {"output": str(self.folder), "made_before": True}
            assert json.loads(self.says("--json")) == facts

    return Again


@pytest.mark.slow
@pytest.mark.usefixtures("soon_ready")
def test_of_track(again, tmp_path):
    pictures = [lit("amara", seen_at([0, 0, 0], [0, 0, 700]), jawOpen=w) for w in (0.0, 0.2)]
    video, colours = write_kind(tmp_path / "head.mp4", "libx264", pictures), tmp_path / "a.npz"
    assert main(["track", str(video), "-o", str(tmp_path / "own"), "--renderer", "cpu"]) == 0
    colours.write_bytes((tmp_path / "own" / "colours.npz").read_bytes())
    run = again(tmp_path / "run", "track", video, "--renderer", "cpu", "--colours", colours)
    run.check()
    run.refused("--driver", "simplex")
    with np.load(colours) as given:
        arrays = dict(given)
    (tmp_path / "deep").mkdir()
    run.folder = (tmp_path / "run").rename(tmp_path / "deep" / "run")
    run.words, run.before = [*run.words, "-o", str(run.folder)], held(run.folder)
    run.check()
    np.savez(colours, **arrays)  # the same colours, other bytes
    run.refused()


@pytest.mark.slow
def test_of_synth(again, tmp_path):
    scene, wall = tmp_path / "scene.toml", tmp_path / "wall.png"
    scene.write_text(SCENE)
    wall.write_bytes(png(noise(1)[0]))
    data = again(tmp_path / "data", "synth", scene, "--processes", 1)
    data.check()
    data.says("--processes", 2)
    assert main(["check", str(tmp_path / "data")]) == 0
    wall.write_bytes(png(noise(2)[1]))
    data.refused()


@pytest.mark.slow
@pytest.mark.usefixtures("soon_ready")
def test_of_the_demo(again, tmp_path):
    demo = again(tmp_path / "demo", "demo", "--frames", 2, "--renderer", "cpu")
    demo.check()
    demo.refused("--average-head")
    (tmp_path / "demo" / "index.html").unlink()
    demo.before = held(tmp_path / "demo")
    demo.refused()


@pytest.mark.parametrize("option", ["colours", "physics", "poses", "speaker", "texture"])
def test_the_content_of_a_file_counts_and_not_its_name(tmp_path, option):
    def digest(folder: str, content: str) -> str:
        place = tmp_path / folder
        place.mkdir(exist_ok=True)
        for name in ("head.npz", "texture_mei.jpg", "a.npz"):
            (place / name).write_text("same")
        beside = {"speaker": "head.npz", "texture": "texture_mei.jpg"}.get(option, "a.npz")
        (place / beside).write_text(content)
        given = "speaker" if option == "texture" else option
        path = place / ("head.npz" if given == "speaker" else "a.npz")
        (tmp_path / "video.mp4").touch()
        return _choices(tmp_path / "video.mp4", TrackOptions(**{given: path}), {})

    assert digest("one", "this") == digest("other", "this") != digest("one", "that")


def test_the_place_of_a_file_in_the_settings_and_comments_do_not_count(tmp_path):
    def digest(settings: str) -> str:
        (tmp_path / "video.mp4").touch()
        return _choices(tmp_path / "video.mp4", TrackOptions(), {"settings.toml": settings})

    one = digest('renderer = "cpu"\nplugin = [\n    "../a \\"b\\".py",\n    "../c.py",\n]\n')
    other = digest('renderer = "cpu"\nplugin = [\n    "../../d/a.py",\n    "..",\n]\n')
    assert one == other
    assert digest("# abs-engine 9: track\nface = 1\n") == digest("# another\nface = 1\n")
    assert one != digest('renderer = "gl"\nplugin = [\n    "../a.py",\n    "../c.py",\n]\n')
    assert one != digest('renderer = "cpu"\nplugin = [\n    "../a.py",\n]\n')
