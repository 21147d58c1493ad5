"""The `reproduce` command: what it passes on, what it prints, and that its folder appears whole."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from types import ModuleType

import pytest

from abs_engine.cli import main
from abs_engine.cli.commands.reproduce import _SENTENCES, PAPERS
from abs_engine.core.errors import ParameterError
from abs_engine.io.naming import RECORD
from abs_engine.studio.french import SENTENCES

MODULE = "abs_engine.papers.basu1998.reproduce"


@pytest.fixture
def asked(monkeypatch):
    """What the reproduction was asked for; it writes a page and no more."""
    calls = []

    def reproduce(folder, kept, renderer, *, quick, seed, tell):
        assert kept.is_dir()
        assert not list(kept.iterdir())
        calls.append({"quick": quick, "seed": seed, "renderer": renderer})
        assert folder.is_dir()
        assert not list(folder.iterdir())
        tell("filming")
        (folder / "index.html").write_text("page", encoding="utf-8")
        return {"variance_10_modes": 0.9961, "quick": quick}

    _put(monkeypatch, reproduce)
    return calls


def _put(monkeypatch, reproduce) -> None:
    module = ModuleType(MODULE)
    module.reproduce = reproduce
    monkeypatch.setitem(sys.modules, MODULE, module)


def run(*words: object) -> int:
    return main(["reproduce", *map(str, words), "--renderer", "cpu"])


def test_the_main_numbers_stand_beside_the_papers(asked, tmp_path, capsys):
    assert run("000", "-o", tmp_path / "report", "--quick", "--seed", 5) == 0
    assert asked[0]["quick"]
    assert asked[0]["seed"] == 5
    printed = capsys.readouterr().out
    ten = next(line for line in printed.splitlines() if "ten modes" in line)
    assert "99.61%" in ten
    assert "99.20% (paper)" in ten
    assert "left out by --quick" in printed
    assert str(tmp_path / "report" / "index.html") in printed
    assert (tmp_path / "report" / "index.html").read_text() == "page"


def test_reports_are_numbered(asked, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert [run("000"), run("000")] == [0, 0]
    made = sorted(p.relative_to(tmp_path).as_posix() for p in Path("runs").absolute().iterdir())
    assert made == ["runs/reproduce-000", "runs/reproduce-000-2"]
    assert asked[0]["seed"] == 0
    assert not asked[0]["quick"]


@pytest.mark.parametrize(
    ("error", "status", "begun"),
    [
        (ParameterError("it broke", "correct it"), 2, True),
        (KeyboardInterrupt(), 130, False),
    ],
)
def test_a_failure_leaves_nothing_of_use(error, status, begun, tmp_path, monkeypatch, capsys):
    def fail(folder, *_, **__):
        if begun:
            (folder / "half").write_text("written")
        raise error

    _put(monkeypatch, fail)
    monkeypatch.chdir(tmp_path)
    assert run("000") == status
    assert not list(tmp_path.iterdir())
    assert capsys.readouterr().err.startswith("abs-engine: ")


@pytest.mark.parametrize("words", [["--quick"], []])
@pytest.mark.parametrize(
    "error", [KeyboardInterrupt(), MemoryError(), OSError(28, "No space left")]
)
def test_an_interrupted_report_is_resumed_by_the_same_command(words, error, tmp_path, monkeypatch):
    found, errors = [], [error]

    def make(folder, kept, *_, **__):
        found.append([sorted(p.name for p in one.iterdir()) for one in (folder, kept)])
        for one in (folder, kept):
            (one / "half").touch()
        if errors:
            raise errors.pop()
        return {}

    _put(monkeypatch, make)
    monkeypatch.chdir(tmp_path)
    assert run("000", *words) == (130 if isinstance(error, KeyboardInterrupt) else 2)
    assert run("000", *words) == 0
    assert found == [[[], []], [["half"], ["half"]]]
    made = tmp_path / "runs"
    assert [p.name for p in made.iterdir()] == ["reproduce-000"]
    assert {p.name for p in (made / "reproduce-000").iterdir()} == {"half", RECORD}


def test_hours_of_work_are_not_removed_for_other_choices(tmp_path, monkeypatch, capsys):
    def make(folder, *_, **__):
        (folder / "half").touch()
        raise KeyboardInterrupt

    _put(monkeypatch, make)
    assert run("000", "-o", tmp_path / "report") == 130
    for other in (("--seed", 2), ("--quick",)):
        assert run("000", "-o", tmp_path / "report", *other) == 2
        assert "finish it by the same command" in capsys.readouterr().err.splitlines()[-1]
    assert (tmp_path / ".report.partial" / "whole" / "half").is_file()


def test_the_same_again_is_there_already(asked, tmp_path, capsys):
    report = tmp_path / "report"
    assert run("000", "-o", report, "--quick") == 0
    capsys.readouterr()
    assert run("000", "-o", report, "--quick", "--quiet") == 0
    (line,) = capsys.readouterr().out.splitlines()
    assert line.startswith(f"{report} already exists and is complete (made by this same command)")
    assert run("000", "-o", report, "--quick", "--json") == 0
    assert json.loads(capsys.readouterr().out) == {"output": str(report), "made_before": True}
    assert run("000", "-o", report, "--quick", "--seed", 5) == 2
    assert "exists already" in capsys.readouterr().err
    assert len(asked) == 1
    assert [p.name for p in tmp_path.iterdir()] == ["report"]


@pytest.mark.parametrize(
    "words", [("--person", "clara"), ("--sentences", 3), ("--twins", 3), ("--workers", 1)]
)
def test_options_of_the_other_paper_are_refused(asked, words, tmp_path, capsys):
    assert run("000", "-o", tmp_path / "report", *words) == 2
    assert f"{words[0]} is for 001; leave it out" in capsys.readouterr().err
    assert not asked


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("--sentences", 78), "78 is not in the range 1<=x<=77"),
        (("--twins", 78), "78 is not in the range 1<=x<=77"),
        (("--quick", "--twins", 1), "leave out --twins"),
        (("--sentences", 2, "--twins", 3), "--twins 3 is more than --sentences 2"),
    ],
)
def test_amounts_that_change_nothing_are_refused(words, said, tmp_path, monkeypatch, capsys):
    monkeypatch.setitem(PAPERS, "001", lambda *_: pytest.fail("it was begun"))
    assert run("001", "-o", tmp_path / "report", *words) == 2
    assert said in capsys.readouterr().err
    assert not list(tmp_path.iterdir())


def test_as_many_sentences_as_there_are_can_be_asked_for():
    assert len(SENTENCES) == _SENTENCES


def test_what_exists_is_not_written_over(asked, tmp_path, capsys):
    assert run("000", "-o", tmp_path) == 2
    assert "exists already" in capsys.readouterr().err
    assert not asked


def test_an_unknown_paper(tmp_path, capsys):
    assert run("007", "-o", tmp_path / "report") == 2
    assert "000" in capsys.readouterr().err
