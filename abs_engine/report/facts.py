"""Provenance of a report's numbers: clip, runs, machine, packages, seeds, commands."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from abs_engine.core.provenance import FIGURES, described, made_by
from abs_engine.dataset import Truth
from abs_engine.dataset.dataset import dataset_root, read_record
from abs_engine.evaluate.machine import machine_facts
from abs_engine.report.data import Rows
from abs_engine.tracking.runs.record import stated

_MORE_PACKAGES = ("scipy", "opencv-contrib-python-headless", "nlopt", "av", "plotly")
_FIRST = ("engine_version", "commit", "dirty", "renderer")


def origins(runs: Mapping[str, Path], truth: Path | None = None) -> dict[str, dict[str, Any]]:
    """Provenance of all that a report's figures come from, for `caution`.

    Parameters
    ----------
    runs : mapping of str to Path
        Results by their names. Those of other systems are left out: no code of ours made them.
    truth : Path, optional
        The dataset, or a folder in it.
    """
    every = {FIGURES: made_by()}
    if truth is not None:
        every["the ground truth"] = _film_made(truth)
    for name, path in runs.items():
        if path.is_dir():
            every[f"the run '{name}'"] = _run_json(path) or {}
    return every


def truth_facts(truth: Truth, given: Path) -> dict[str, Rows]:
    """Facts of the film, and the command that made it."""
    camera = truth.camera
    focal = f"{camera.matrix[0, 0]:.1f} px"
    rows = (
        ("truth", str(given)),
        ("clip, camera", f"{truth.name}, {truth.folder.name}"),
        ("person", truth.person),
        ("sentence", truth.sentence),
        ("frames", f"{len(truth)} at {truth.rate:g} a second"),
        ("picture", f"{camera.size[0]}x{camera.size[1]} pixels, focal length {focal}"),
        ("filmed by", truth.command or "a program"),
        ("engine", described(_film_made(given))),
        ("seed", str(truth.seed)),
    )
    return {"Clip": rows}


def made_facts(command: str, seed: int | None) -> dict[str, Rows]:
    """Facts of the making of the report, and its machine."""
    machine = machine_facts(_MORE_PACKAGES)
    computer = {k: machine.pop(k) for k in ("cpu", "cores", "system", "python")}
    listed = ", ".join(f"{name} {version}" for name, version in sorted(machine.items()))
    rows = [("command", command or "a program"), ("engine", described(made_by()))]
    if seed is not None:
        rows.append(("seed of the confidence intervals", str(seed)))
    rows += [(name, str(value)) for name, value in computer.items()]
    return {"Report": (*rows, ("packages", listed))}


def run_facts(path: Path) -> Rows:
    """Facts of a run about its making; of another system's file, its name."""
    told = _run_json(path)
    if told is None:
        return (("results", str(path)),)
    rows = [("results", str(path))]
    rows += [(name.replace("_", " "), str(told[name])) for name in _FIRST if name in told]
    for part in ("settings", "summary"):
        values = told.get(part)
        rows += _flat(values) if isinstance(values, dict) else []
    return tuple(rows)


def _run_json(path: Path) -> dict[str, Any] | None:
    """Content of a run's ``run.json``; None where it cannot be read."""
    try:
        return stated(path)
    except (OSError, ValueError):
        return None


def _film_made(path: Path) -> dict[str, Any]:
    """Provenance of a dataset, from a folder in it."""
    dataset = read_record(dataset_root(path)[0])
    return {**dataset.record, "engine_version": dataset.engine}


def _flat(values: dict[str, Any], before: str = "") -> list[tuple[str, str]]:
    """Settings as rows; those within others after the names of these."""
    rows = []
    for name, value in values.items():
        spoken = before + name.replace("_", " ")
        if isinstance(value, dict):
            rows += _flat(value, f"{spoken}: ")
        elif isinstance(value, list):
            rows.append((spoken, ", ".join(str(v) for v in value) or "none"))
        else:
            shown = f"{value:.6g}" if isinstance(value, float) else str(value)
            rows.append((spoken, "not given" if value is None else shown or "none"))
    return rows
