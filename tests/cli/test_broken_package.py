"""An installed package whose parts cannot be imported stops no command that does not need them."""

from __future__ import annotations

import json
import logging
from importlib import metadata

import pytest
import reported

from abs_engine.cli import main
from abs_engine.core.errors import PluginError
from abs_engine.core.registry import EXPORTERS, METRICS
from abs_engine.evaluate.truth_report import score

ENTRIES = """\
[abs_engine.metrics]
broken_mm = no_such_package_here:METRIC
[abs_engine.exporters]
broken = no_such_package_here:EXPORTER
"""
FAULT = "warning: the metric 'broken_mm' cannot be imported from no_such_package_here:METRIC"


@pytest.fixture
def broken(tmp_path, monkeypatch):
    """An installed package with a metric and an exporter whose module is missing."""
    own = tmp_path / "site" / "broken-1.0.dist-info"
    own.mkdir(parents=True)
    (own / "METADATA").write_text("Metadata-Version: 2.1\nName: broken\nVersion: 1.0\n")
    (own / "entry_points.txt").write_text(ENTRIES)
    for registry in (METRICS, EXPORTERS):
        monkeypatch.delattr(registry, "_installed")  # found once, and kept
    monkeypatch.setattr("abs_engine.core.registry._entry_points", metadata.entry_points)
    monkeypatch.syspath_prepend(own.parent)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    place = tmp_path_factory.mktemp("scored")
    reported.write_dataset(place / "data")
    reported.write_exact(place / "run")
    return place


def test_evaluate_warns_once_and_scores(broken, folder, tmp_path, caplog):
    words = [folder / "run", "--truth", folder / "data", "-o", tmp_path / "scores"]
    assert main(["evaluate", *map(str, words)]) == 0
    assert [r.getMessage()[: len(FAULT)] for r in caplog.records].count(FAULT) == 1
    metrics = json.loads((tmp_path / "scores" / "scores.json").read_text())["metrics"]
    assert "aperture_rms_mm" in metrics
    assert "broken_mm" not in metrics


def test_report_warns_once_and_writes_the_page(broken, folder, tmp_path, caplog):
    words = [folder / "run", "--truth", folder / "data", "-o", tmp_path / "page.html"]
    assert main(["report", *map(str, words)]) == 0
    assert [r.getMessage()[: len(FAULT)] for r in caplog.records].count(FAULT) == 1
    assert (tmp_path / "page.html").is_file()


def test_score_from_python_warns(broken, folder, caplog):
    with caplog.at_level(logging.WARNING):
        assert score(folder / "run", folder / "data")["aperture_rms_mm"].value < 0.01
    assert FAULT in caplog.text


def test_help_of_export_says_which_format_is_broken(broken, capsys, tmp_path):
    assert main(["export", "--help"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert "  broken      cannot be imported" in lines
    assert any(line.startswith("  praat       a folder") for line in lines)
    words = [tmp_path, "--to", "broken", "-o", tmp_path / "x"]
    assert main(["export", *map(str, words)]) == 2
    assert "the exporter 'broken' cannot be imported" in capsys.readouterr().err


def test_what_works_and_what_does_not_are_told_apart(broken):
    entries, faults = EXPORTERS.working()
    assert "praat" in entries
    assert list(faults) == ["broken"]
    assert {*entries, *faults} == set(EXPORTERS)
    with pytest.raises(PluginError, match="the exporter 'broken' cannot be imported"):
        EXPORTERS.get("broken")
