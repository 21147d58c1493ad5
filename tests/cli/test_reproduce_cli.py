"""The `reproduce` command: what it passes on, what it prints, and that its folder appears whole."""

from __future__ import annotations

import sys
from pathlib import Path
from types import ModuleType

import pytest

from abs_engine.cli import main
from abs_engine.core.errors import ParameterError

MODULE = "abs_engine.papers.basu1998.reproduce"


@pytest.fixture
def asked(monkeypatch):
    """What the reproduction was asked for; it writes a page and no more."""
    calls = []

    def reproduce(folder, renderer, *, quick, seed, tell):
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
    ("error", "status"), [(ParameterError("it broke", "correct it"), 2), (KeyboardInterrupt(), 130)]
)
def test_a_failure_leaves_nothing(error, status, tmp_path, monkeypatch, capsys):
    def fail(folder, *_, **__):
        (folder / "half").write_text("written")
        raise error

    _put(monkeypatch, fail)
    monkeypatch.chdir(tmp_path)
    assert run("000") == status
    assert not list(tmp_path.iterdir())
    assert capsys.readouterr().err.startswith("abs-engine: ")


def test_what_exists_is_not_written_over(asked, tmp_path, capsys):
    assert run("000", "-o", tmp_path) == 2
    assert "exists already" in capsys.readouterr().err
    assert not asked


def test_an_unknown_paper(tmp_path, capsys):
    assert run("007", "-o", tmp_path / "report") == 2
    assert "000" in capsys.readouterr().err
