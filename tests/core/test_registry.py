"""What can be chosen by name: nearest names, entries that fail, files that add their own."""

from __future__ import annotations

from importlib import metadata
from pathlib import Path

import numpy as np
import pytest

from abs_engine.cli import main
from abs_engine.core.errors import (
    InputFileError,
    ModelFormatError,
    ParameterError,
    PluginError,
    TermError,
)
from abs_engine.core.registry import (
    DRIVERS,
    MODELS,
    PRESETS,
    RENDERERS,
    TERMS,
    Registry,
    load_plugin,
    nearest,
)
from abs_engine.core.scene import Candidates
from abs_engine.face.shape.modal import load_physics
from abs_engine.fit.evidence import valued
from abs_engine.fit.terms import term_kinds
from abs_engine.io.assets import shipped
from abs_engine.io.video import VideoInfo
from abs_engine.tracking.option_checks import check_options
from abs_engine.tracking.options import Leaves, TrackOptions
from abs_engine.tracking.presets import resolved


def test_the_nearest_name_is_given():
    assert nearest("simplx", ["simplex", "forces"]).startswith("did you mean 'simplex'?")
    assert nearest("zzz", ["simplex", "forces"]) == "choose one of simplex, forces"
    assert nearest("zzz", []) == "there is none to choose"


@pytest.mark.parametrize("registry", [MODELS, TERMS, DRIVERS, PRESETS])
def test_every_entry_of_the_engine_can_be_had(registry):
    assert registry.names()
    for name in registry.names():
        assert registry.get(name) is not None


def test_an_entry_that_is_added_is_found_and_an_unknown_one_named():
    toys = Registry("toy")
    toys.add("ball", 3)
    assert (toys.names(), toys.get("ball")) == (("ball",), 3)
    assert (list(toys), len(toys), "ball" in toys, "bal" in toys) == (["ball"], 1, True, False)
    with pytest.raises(ParameterError, match="the name of a toy is 3; give text"):
        toys.add(3, None)
    with pytest.raises(ParameterError, match="no toy 'bal'; did you mean 'ball'"):
        toys.get("bal")


def test_an_installed_entry_that_fails_is_named_and_the_rest_works(monkeypatch):
    group = "abs_engine.toys"
    points = [
        metadata.EntryPoint("whole", "math:pi", group),
        metadata.EntryPoint("broken", "no_such_package:thing", group),
        metadata.EntryPoint("empty", "math:no_such_thing", group),
    ]
    monkeypatch.setattr(
        "abs_engine.core.registry._entry_points", lambda: metadata.EntryPoints(points)
    )
    toys = Registry("toy")
    assert toys.names() == ("broken", "empty", "whole")
    assert toys.get("whole") == pytest.approx(3.14159, abs=1e-5)
    for name in ("broken", "empty"):
        with pytest.raises(PluginError, match=f"toy '{name}' cannot be imported") as caught:
            toys.get(name)
        assert "the others work" in caught.value.remedy


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"preset": "basu98"}, "no preset 'basu98'; did you mean 'basu1998'"),
        ({"model": "shel"}, "no model or file 'shel'; did you mean 'shell'"),
        ({"terms": ("colur",)}, "no term 'colur'; did you mean 'colour'"),
        ({"driver": "simplx"}, "no driver 'simplx'; did you mean 'simplex'"),
        ({"terms": "+"}, "no evidence is named; choose one of colour"),
        ({"preset": "basu1998", "model": "head"}, "'basu1998' is for the model 'shell', not for '"),
    ],
)
def test_a_leaf_that_is_misspelt_or_of_another_preset_is_refused(options, said):
    chosen = TrackOptions(**options)
    with pytest.raises(ParameterError) as caught:
        Leaves.of(resolved(chosen)[0])
    assert said in str(caught.value)


def test_what_is_chosen_counts_more_than_the_preset():
    chosen, _ = resolved(TrackOptions(preset="basu1998"))
    assert (chosen.model, chosen.terms, chosen.driver, chosen.start) == (
        "shell", ("colour",), "forces", "blobs",
    )  # fmt: skip
    other, _ = resolved(TrackOptions(preset="basu1998", driver="simplex", start="landmarks"))
    assert (other.model, other.driver, other.start) == ("shell", "simplex", "landmarks")
    usual, _ = resolved(TrackOptions(terms="colour"))
    assert (usual.model, usual.terms, usual.driver) == ("head", ("colour",), "newton")
    shell, _ = resolved(TrackOptions(model="shell"))
    assert shell.driver == "simplex"


@pytest.mark.parametrize(
    ("given", "terms"),
    [
        ({}, ("colour", "shading")),
        ({"driver": "simplex"}, ("colour", "shading")),
        ({"person": "clara", "start": "blobs"}, ("colour", "shading")),
        ({"start": "blobs"}, ("colour",)),
        ({"evidence": "landmarks"}, ("colour",)),
        ({"worn": True}, ("opening",)),
        ({"model": "shell"}, ("colour",)),
        ({"model": "speaker"}, ("colour", "shading")),
        ({"model": "speaker", "evidence": "landmarks"}, ("colour",)),
        ({"model": "talking"}, ("colour",)),
        ({"preset": "basu1998"}, ("colour",)),
    ],
)
def test_shading_is_compared_by_default_where_it_was_measured(given, terms):
    assert resolved(TrackOptions(**given))[0].terms == terms


@pytest.mark.parametrize(
    ("registry", "entry", "lacks"), [(DRIVERS, object, "minimiser"), (TERMS, object(), "bind")]
)
def test_an_entry_of_another_kind_is_named(registry, entry, lacks):
    with pytest.raises(PluginError, match=f"'odd' is a .* without '{lacks}'"):
        registry.add("odd", entry)
    assert "odd" not in registry


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"preset": "basu1998", "face": 2}, "--face has no effect with --preset"),
        ({"preset": "basu1998", "pupil_distance": 58.0}, "has no effect with --preset basu1998"),
        ({"driver": "forces", "evidence": "landmarks"}, "--driver has no effect with --evidence"),
        ({"model": "talking", "evidence": "landmarks"}, "--evidence does nothing for the model"),
        ({"model": "talking", "physics": Path("lips.npz")}, "--physics does nothing for the model"),
        ({"model": "talking", "face": 2}, "has no effect with --model"),
        ({"preset": "odisio2004", "start": "landmarks"}, "does not start from landmarks"),
    ],
)
def test_an_option_that_would_do_nothing_is_refused(options, said):
    info = VideoInfo(size=(320, 240), rate=25.0, frames=5, times=())
    with pytest.raises(ParameterError) as caught:
        check_options(TrackOptions(**options), info)
    assert said in str(caught.value)


def test_a_model_is_known_by_its_file(tmp_path):
    lips = shipped("lips/lips.npz")
    chosen, _ = resolved(TrackOptions(model=str(lips)))
    assert (chosen.model, chosen.model_file) == ("shell", lips)
    head = shipped("speaker/head.npz")
    chosen, _ = resolved(TrackOptions(model=str(head)))
    assert (chosen.model, chosen.speaker) == ("head", head)
    with pytest.raises(ParameterError, match="--speaker does nothing for"):
        resolved(TrackOptions(model=str(head), speaker=tmp_path / "other.face"))
    for other, said in (
        (shipped("speaker/landmarks.npz"), "abs_engine.landmarks"),
        (tmp_path / "x.npz", "not exist"),
    ):
        with pytest.raises(InputFileError, match=said):
            resolved(TrackOptions(model=str(other)))
    old = tmp_path / "old.npz"
    np.savez(old, format="abs_engine.learned_physics", version=9)
    assert resolved(TrackOptions(model=str(old)))[0].model == "shell"
    with pytest.raises(ModelFormatError, match="version 9"):
        load_physics(old)


def test_a_file_that_adds_entries(tmp_path):
    own = tmp_path / "own.py"
    own.write_text("from abs_engine import RENDERERS\nRENDERERS.add('mine', dict)\n")
    load_plugin(own)
    assert RENDERERS.get("mine") is dict
    RENDERERS._added.pop("mine")
    own.write_text("1 / 0\n")
    with pytest.raises(PluginError, match=r"own\.py fails \(ZeroDivisionError"):
        load_plugin(own)
    with pytest.raises(InputFileError, match="does not exist"):
        load_plugin(tmp_path / "none.py")
    with pytest.raises(InputFileError, match="is a folder; give the Python file in it"):
        load_plugin(tmp_path)


@pytest.mark.parametrize(
    ("fault", "said"),
    [
        ("\n\nint('three')\n", r"own\.py fails \(ValueError: .*\) in own\.py, line 3"),
        ("\nraise SystemExit(3)\n", r"own\.py fails \(SystemExit: 3\) in own\.py, line 2"),
        ("def f(:\n", r"own\.py fails \(SyntaxError: .*line 1\)\)"),
    ],
)
def test_the_line_of_a_file_that_fails_is_named(tmp_path, fault, said):
    own = tmp_path / "own.py"
    own.write_text(fault)
    with pytest.raises(PluginError, match=said):
        load_plugin(own)


@pytest.mark.parametrize("fault", [KeyError("lips"), SystemExit(3)])
def test_the_line_of_evidence_that_fails_is_named(fault):
    one = Candidates(np.zeros((1, 0)), np.eye(3)[None], np.zeros((1, 3)))
    with pytest.raises(TermError, match=r"'odd' fails \(.*\) in test_registry\.py, line \d+;"):
        valued("odd", Odd(fault), one)


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["trak", "a.mp4"], "there is no command 'trak'; did you mean 'track'?"),
        (["track", "a.mp4", "-o", "x", "--start", "blob"], "did you mean 'blobs'?"),
    ],
)
def test_a_command_or_choice_misspelt(words, said, capsys):
    assert main(words) == 2
    lines = capsys.readouterr().err.splitlines()
    assert len(lines) == 1
    assert said in lines[0]


def test_a_name_that_is_there_already_is_refused():
    with pytest.raises(PluginError, match="there is a term 'colour' already"):
        TERMS.add("colour", TERMS.get("colour"))


def test_evidence_that_is_named_twice_is_refused():
    with pytest.raises(ParameterError, match="'colour' is named twice"):
        term_kinds(("colour", "colour"))


class Odd:
    """Somebody's term."""

    def __init__(self, values) -> None:
        self.values = values

    def negative_log(self, _candidates):
        if isinstance(self.values, BaseException):
            raise self.values
        return self.values


@pytest.mark.parametrize(
    ("values", "said"),
    [
        (np.full(2, np.nan), "'odd' is not a finite number for each of the 2"),
        (np.zeros((2, 2)), "shape (2, 2)"),
        (np.zeros(2, complex), "shape (2,), complex128"),
        (ValueError("boom"), "'odd' fails (ValueError: boom)"),
    ],
)
def test_evidence_that_fails_or_is_not_finite_is_named(values, said):
    two = Candidates(np.zeros((2, 0)), np.tile(np.eye(3), (2, 1, 1)), np.zeros((2, 3)))
    with pytest.raises(TermError) as caught:
        valued("odd", Odd(values), two)
    assert said in str(caught.value)
