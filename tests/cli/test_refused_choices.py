"""Choices of `track` that do not go together: one line, before anything is done."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from runs import write_noise
from talkers import learned_face

from abs_engine.cli import main
from abs_engine.cli.commands import track as track_module
from abs_engine.core.errors import ParameterError, PluginError
from abs_engine.core.registry import DRIVERS, PLUGINS, RENDERERS, load_plugin
from abs_engine.face.talking_file import save_talking
from abs_engine.fit.terms import COLOUR, TermKind
from abs_engine.io.assets import shipped
from abs_engine.io.naming import CHOICES, RECORD, WHOLE, partial_of
from abs_engine.io.video import VideoInfo
from abs_engine.optimise.drivers import Driver
from abs_engine.tracking.model_entry import Model, check_model
from abs_engine.tracking.option_checks import check_options
from abs_engine.tracking.options import Leaves, TrackOptions
from abs_engine.tracking.results.frame_journal import FRAMES

INFO = VideoInfo(size=(320, 240), rate=25.0, frames=5, times=())


@pytest.fixture(scope="module")
def video(tmp_path_factory) -> Path:
    return write_noise(tmp_path_factory.mktemp("noise") / "noise.mp4", 3)


@pytest.fixture(scope="module")
def bare(tmp_path_factory) -> Path:
    """A talking face without pictures."""
    path = tmp_path_factory.mktemp("face") / "bare.face"
    save_talking(path, learned_face().shape, "me", "")
    return path


@pytest.fixture
def refused(video, tmp_path, capsys, monkeypatch):
    """Line that `track` is refused with, everything left as it was and no renderer opened."""
    monkeypatch.setattr(track_module, "opened", lambda name: pytest.fail("a renderer is opened"))

    def run(*words: object) -> str:
        before = {path: path.is_file() and path.read_bytes() for path in tmp_path.rglob("*")}
        assert main(["track", str(video), "-o", str(tmp_path / "run"), *map(str, words)]) == 2
        (line,) = capsys.readouterr().err.splitlines()
        after = {path: path.is_file() and path.read_bytes() for path in tmp_path.rglob("*")}
        assert after == before
        return line

    return run


@pytest.fixture
def interrupted(tmp_path) -> None:
    """What a command with other options had kept as it was killed."""
    partial = partial_of(tmp_path / "run")
    (partial / WHOLE).mkdir(parents=True)
    (partial / CHOICES).write_text("track\nothers")
    (partial / FRAMES).write_bytes(b"frames")


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--terms", "texture"], "the model 'head' has no texture"),
        (["--model", "shell", "--terms", "shading"], "the model 'shell' has no shading"),
        (["--terms", "shading", "--driver", "simplex"], "use --terms colour+shading"),
        (["--driver", "levenberg"], "'levenberg' needs residuals"),
        (["--worn", "--terms", "colour"], "the model 'worn' has no colour"),
        (["--worn", "--terms", "texture"], "no texture to compare; use --terms opening"),
        (["--worn", "--terms", "local"], "no local appearance to compare; use --terms opening"),
        (["--worn", "--terms", "shading"], "no shading to compare; use --terms opening"),
        (["--terms", "local"], "has no local appearance to compare; use --model with a talking"),
        (["--terms", "opening"], "no close-up of a mouth to compare; use --worn if the video is"),
        (["--person", "amra"], "there is no person 'amra'; did you mean 'amara'?"),
        (["--pupil-distance", "abc"], "'--pupil-distance': 'abc' is not a number"),
        (["--mouth", "1", "2", "3", "x"], "'--mouth': 'x' is not a number"),
        (["--face", "one"], "'--face': 'one' is not a whole number"),
        (["--model", "talking"], "give its file: --model face.npz"),
        (["--model", "speaker"], "give its file: --model me.face"),
        (["--preset", "odisio2004", "--terms", "colour"], "use --terms texture or --terms local"),
        (["--preset", "odisio2004", "--driver", "sbplx"], "use --driver simplex or --driver axes"),
        (["--model", "FILE", "--terms", "texture"], "made without pictures and has no texture"),
        (["--preset", "odisio2004", "--model", "FILE"], "made without pictures and has no local"),
        (["--model", "FILE", "--person", "clara"], "is the face of 'me', not of 'clara'"),
        (["--model", "LIPS", "--physics", "LIPS"], "two files say how the lips move"),
    ],
)
def test_a_refused_combination_leaves_an_interrupted_run(words, said, refused, interrupted, bare):
    files = {"FILE": bare, "LIPS": shipped("lips/lips.npz")}
    assert said in refused(*(files.get(word, word) for word in words))


def test_a_run_that_is_there_does_not_hide_what_is_refused(refused, tmp_path):
    (tmp_path / "run").mkdir()
    (tmp_path / "run" / RECORD).write_text("others")
    assert "the model 'head' has no texture" in refused("--terms", "texture")


def test_a_plugins_model_may_refuse_before_anything_is_done():
    def refuse(options, leaves):
        raise ParameterError(f"no {options.model}", "use --model head")

    leaves = Leaves({"colour": COLOUR}, Leaves.of(TrackOptions(terms="colour")).driver, "simplex")
    chosen = TrackOptions(model="mine")
    with pytest.raises(ParameterError, match="no mine; use --model head"):
        check_model(Model(print, check=refuse), chosen, leaves)
    with pytest.raises(PluginError, match=r"check of the model 'mine' fails \(ZeroDivisionError"):
        check_model(Model(print, check=lambda options, leaves: 1 / 0), chosen, leaves)


def test_what_a_plugins_model_compares_is_its_own_affair_but_not_what_its_driver_needs():
    own = {"own": TermKind("own", print)}
    simplex = Leaves.of(TrackOptions(terms="colour"))
    check_model(Model(print), TrackOptions(model="mine"), Leaves(own, simplex.driver, "simplex"))
    newton = Leaves.of(TrackOptions(terms="colour", driver="newton"))
    with pytest.raises(ParameterError, match="'newton' needs borders"):
        check_model(Model(print), TrackOptions(model="mine"), Leaves(own, newton.driver, "newton"))


def test_from_python_it_is_refused_alike():
    with pytest.raises(ParameterError, match="the model 'head' has no local"):
        check_options(TrackOptions(terms="local"), INFO)


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--driver", ""], "driver is empty; give a name"),
        (["--model", ""], "model is empty; give a name"),
        (["--preset", " "], "preset is empty; give a name"),
        (["--terms", "colour+"], "a name in the terms 'colour+' is empty"),
        (["--terms", "colour++texture"], "a name in the terms 'colour++texture' is empty"),
    ],
)
def test_an_empty_name_is_no_default(words, said, refused):
    assert said in refused(*words)


@pytest.mark.parametrize(
    "given",
    [{"driver": ""}, {"model": ""}, {"person": ""}, {"start": " "}, {"terms": ("colour", "")}],
)
def test_an_empty_name_is_refused_from_python(given):
    with pytest.raises(ParameterError, match="is empty; "):
        TrackOptions(**given)


def test_a_plugin_that_adds_nothing_is_refused(refused, tmp_path):
    own = tmp_path / "own.py"
    own.write_text("x = 1\n")
    assert f"{own} adds nothing to the engine; add an entry" in refused("--plugin", own)
    assert own not in PLUGINS


def test_a_plugin_whose_module_adds_its_entries_may_be_run_again(tmp_path, monkeypatch):
    """As by a worker, clip by clip: the module is imported once."""
    (tmp_path / "adds_a_toy.py").write_text(
        "from abs_engine import RENDERERS\nRENDERERS.add('toy-once', dict)\n"
    )
    own, other = tmp_path / "own.py", tmp_path / "other.py"
    own.write_text("import adds_a_toy\n")
    other.write_text("x = 1\n")
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setattr("abs_engine.core.registry.PLUGINS", [])
    try:
        load_plugin(own)
        load_plugin(own)
    finally:
        RENDERERS._added.pop("toy-once")
    with pytest.raises(PluginError, match=r"other\.py adds nothing"):
        load_plugin(other)


def test_a_file_that_is_no_model_is_answered_with_the_commands_that_write_one(refused):
    line = refused("--model", shipped("speaker/landmarks.npz"))
    assert "or a file that 'import', 'train', 'articulate' or 'mouths' wrote" in line


def test_the_help_says_what_drivers_need(capsys):
    assert main(["track", "--help"]) == 0
    lines = capsys.readouterr().out.splitlines()
    for line in (
        "fixed-step and forces need colour",
        "newton and newton-quick need colour or opening",
        "axes and levenberg need local or texture, and take no colour, opening or shading",
    ):
        assert line in lines


def test_the_help_knows_the_needs_of_a_plugins_driver(capsys, monkeypatch):
    monkeypatch.setitem(DRIVERS._added, "mine", Driver(print, "borders"))
    assert main(["track", "--help"]) == 0
    assert "newton, newton-quick and mine need colour or opening" in capsys.readouterr().out


def test_what_the_page_says_of_drivers_is_what_they_need():
    """Each that needs something is named in the row of `--driver` before that, the others not."""
    page = Path(__file__).parents[2] / "docs" / "parts.md"
    (row,) = [line for line in page.read_text("utf-8").splitlines() if line.startswith("| `--dr")]
    needy = {"newton", "newton-quick", "forces", "fixed-step", "axes", "levenberg"}
    assert {n for n in DRIVERS if DRIVERS.get(n).needs != "values"} == needy
    assert "`axes` and `levenberg` (need texture or local" in row
    assert not re.search(r"`gradient`[^(]*\([^)]*need", row)
    for name in DRIVERS:
        assert f"`{name}`" in row
