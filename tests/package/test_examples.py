"""The examples: each in one file of at most 30 lines of its own, found by the registry."""

from __future__ import annotations

import ast
from contextlib import closing
from dataclasses import replace
from itertools import islice
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from drawn import lit
from heads import seen_at
from hurried import hurried
from results import clip, perfect
from runs import write_kind, written_run

from abs_engine.core.registry import (
    DRIVERS,
    EXPORTERS,
    METRICS,
    MODELS,
    RENDERERS,
    TERMS,
    load_plugin,
)
from abs_engine.evaluate.score import measure, summary
from abs_engine.export.writing import export_run
from abs_engine.render.cpu import CpuRenderer
from abs_engine.render.select import open_renderer
from abs_engine.tracking.options import Leaves, TrackOptions
from abs_engine.tracking.presets import resolved
from abs_engine.tracking.run import prepare

EXAMPLES = sorted((Path(__file__).parents[2] / "examples").glob("*.py"))
KINDS = {"new_term": TERMS, "new_solver": DRIVERS, "new_renderer": RENDERERS, "new_head": MODELS,
         "new_exporter": EXPORTERS, "new_metric": METRICS}  # fmt: skip
OPEN = (0.0, 0.12, 0.25, 0.35, 0.18)


def own_lines(path: Path) -> int:
    """Lines of code that are not empty, no import and no docstring."""
    tree, text = ast.parse(path.read_text()), path.read_text().splitlines()
    taken: set[int] = set()
    for node in ast.walk(tree):
        plain = isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)
        if isinstance(node, ast.Import | ast.ImportFrom) or plain:
            taken |= set(range(node.lineno, (node.end_lineno or node.lineno) + 1))
    return sum(bool(line.strip()) and k not in taken for k, line in enumerate(text, 1))


@pytest.fixture(scope="module")
def video(tmp_path_factory):
    pictures = [
        lit("amara", seen_at([0, 0.03 * k - 0.06, 0], [0, 0, 700]), jawOpen=amount)
        for k, amount in enumerate(OPEN)
    ]
    return write_kind(tmp_path_factory.mktemp("film") / "head.mp4", "libx264", pictures)


@pytest.fixture(scope="module")
def head(video):
    with hurried(frames=2, rounds=1):
        return prepare(video, CpuRenderer(), TrackOptions())


@pytest.fixture
def added():
    """The example of a name, and what it adds to its registry; taken out again."""
    taken = []

    def load(name: str) -> str:
        registry = KINDS[name]
        before = set(registry.names())
        load_plugin(next(path for path in EXAMPLES if path.stem == name))
        (own,) = set(registry.names()) - before
        taken.append((registry, own))
        return own

    yield load
    for registry, own in taken:
        registry._added.pop(own)


def aperture(made, frames: int = len(OPEN), **changes) -> np.ndarray:
    """Of the first frames, which must be found."""
    results = replace(made, setting=replace(made.setting, **changes)).results()
    with closing(results):
        found = [one for _, one in islice(results, frames)]
    assert all(one.found for one in found)
    return np.array([one.aperture for one in found])


def follows(found: np.ndarray) -> bool:
    return bool(np.corrcoef(found, OPEN)[0, 1] > 0.9)


def test_every_example_is_short_and_of_a_kind_that_is_tested():
    assert {path.stem for path in EXAMPLES} == set(KINDS)
    assert {path.stem: own_lines(path) <= 30 for path in EXAMPLES} == dict.fromkeys(KINDS, True)


def test_a_new_term(head, added):
    """It has no borders, so that a driver serves that needs none."""
    leaves = Leaves.of(resolved(TrackOptions(terms=("colour", added("new_term"))))[0])
    assert leaves.name == "simplex"
    driver = leaves.driver.minimiser()
    both = aperture(head, binder=replace(head.setting.binder, kinds=leaves.kinds), driver=driver)
    assert follows(both)
    assert not np.array_equal(both[:2], aperture(head, 2, driver=driver))


def test_a_new_solver(head, added):
    leaves = Leaves.of(TrackOptions(terms=("colour",), driver=added("new_solver")))
    assert follows(aperture(head, driver=leaves.driver.minimiser()))


def test_a_new_renderer_that_cannot_compare(head, added):
    """Its buffers are compared in place of its sums: about as well as at half the resolution."""
    with open_renderer(added("new_renderer")) as coarse:
        assert not hasattr(coarse, "measure")
        binder = replace(head.setting.binder, renderer=coarse)
        assert follows(aperture(head, binder=binder, renderer=coarse))


def test_a_new_head(video, added):
    with hurried(frames=2, rounds=1):
        made = prepare(video, CpuRenderer(), TrackOptions(model=added("new_head")))
    assert made.facts["model"] == "long-jawed"
    assert follows(aperture(made))


def test_a_new_exporter(added, tmp_path):
    name = added("new_exporter")
    export_run(written_run(tmp_path / "run", (0, 3, None, 2)), name, tmp_path / "lips.vtt")
    lines = (tmp_path / "lips.vtt").read_text(encoding="utf-8").splitlines()
    assert lines[0] == "WEBVTT"
    assert [line for line in lines if "-->" in line][2] == "00:00:00.120 --> 00:00:00.160"
    assert sum(line.startswith("lips ") for line in lines) == 3


@pytest.mark.parametrize(
    ("rate", "frame", "span"),
    [
        (30000 / 1001, 8991, "00:05:00.000 --> 00:05:00.033"),
        (30000 / 1001, 8990, "00:04:59.966 --> 00:05:00.000"),
        (25.0, 92500, "01:01:40.000 --> 01:01:40.040"),
    ],
)
def test_times_of_a_new_exporter_carry_into_the_minute(added, tmp_path, rate, frame, span):
    entry = EXPORTERS.get(added("new_exporter"))
    arrays = {"aperture": np.array([4.0]), "time": np.array([frame / rate])}
    entry.write(SimpleNamespace(arrays=arrays, rate=rate), tmp_path / "lips.vtt")
    assert span in (tmp_path / "lips.vtt").read_text(encoding="utf-8").splitlines()


def test_a_new_metric(added):
    """Widths that are 5 % too large make the ratio 1 / 1.05 of what it is."""
    truth, name = clip(), added("new_metric")
    said = perfect(truth)
    said = replace(said, curves={**said.curves, "width": 1.05 * truth.width})
    scores = summary([measure(said, truth, None)])
    expected = np.sqrt(np.mean((truth.aperture / truth.width * (1 - 1 / 1.05)) ** 2))
    assert scores[name].value == pytest.approx(expected)
