"""Scores results of one system or several against ground truth, and writes what was found."""

from __future__ import annotations

import logging
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.errors import InputFileError, ParameterError
from abs_engine.core.provenance import made_by
from abs_engine.core.words import legible
from abs_engine.dataset import Truth
from abs_engine.evaluate import score_table
from abs_engine.evaluate.arkit_csv import is_arkit, read_arkit
from abs_engine.evaluate.catalogue import warn_of_faults
from abs_engine.evaluate.clip_views import found_truth
from abs_engine.evaluate.estimate import Estimate, check_run, of_run
from abs_engine.evaluate.landmark_csv import Reference, read_landmarks
from abs_engine.evaluate.metrics.bootstrap import LEVEL
from abs_engine.evaluate.same_clip import check_clip
from abs_engine.evaluate.score import ClipScores, Score, error_map, measure, summary
from abs_engine.evaluate.truth_report import draw
from abs_engine.io.assets import Speaker, load_speaker
from abs_engine.io.csv_table import read_table
from abs_engine.io.new_folder import NewFolder
from abs_engine.report.score_notes import doubts, offsets
from abs_engine.tracking.results.run_mesh import MESH, load_mesh
from abs_engine.tracking.runs.record import load_run

SCORES, TABLE = "scores.json", "scores.csv"
MAP_FORMAT, MAP_VERSION = "abs_engine.error_map", 1
POOLED = "all clips"
_RESULTS = "give a run's folder or a CSV file"

View = tuple[str | None, str | None]
_log = logging.getLogger(__name__)


@dataclass(frozen=True)
class Evaluation:
    """Results of an evaluation.

    Parameters
    ----------
    folder : Path
        Holds ``scores.json``, ``scores.csv`` and an ``error_map_NAME.npz`` for each result.
    systems : dict
        Scores by the name of the result and of the metric.
    """

    folder: Path
    systems: dict[str, dict[str, Score]]

    def lines(self) -> list[str]:
        """The scores side by side, for a terminal."""
        return score_table.lines(self.systems)


def evaluate(
    results: Sequence[Path],
    truths: Sequence[Path],
    folder: Path,
    *,
    seed: int = 0,
    view: View = (None, None),
) -> Evaluation:
    """Score results and write the scores.

    Parameters
    ----------
    results : sequence of Path
        Runs of this engine (folders), landmark files or ARKit files (CSV).
    truths : sequence of Path
        One, of which all results are; or one for each result, which are then pooled as clips of
        one system, too.
    folder : Path
        Must not exist.
    seed : int
        Of the confidence intervals.
    view : two of str, optional
        Names of clip and camera that the truths leave open. Where several fit, it is the view
        whose very video was tracked.

    Raises
    ------
    InputFileError
        If a result or a truth cannot be read.
    ParameterError
        If a result is of other frames or of another mesh than its truth.
    OutputError
        If the folder exists or cannot be written.
    """
    if len(truths) not in (1, len(results)):
        raise ParameterError(
            f"there are {len(results)} results and {len(truths)} truths",
            "give one truth, or one for each result",
        )
    for path in map(Path, results):
        _check_result(path)
    warn_of_faults()
    with NewFolder(folder) as made:
        scored = _scored(results, truths, view, seed, made.work)
        systems = {one.name: one.scores for one in scored}
        if len(truths) > 1:
            systems[POOLED] = summary([one.clip for one in scored], seed=seed)
        facts = {
            **made_by(),
            "seed": seed,
            "confidence": LEVEL,
            "truths": [str(path) for path in truths],
            "views": [one.view for one in scored],
            "notes": {one.name: list(one.notes) for one in scored if one.notes},
        }
        (made.work / SCORES).write_text(score_table.as_json(systems, facts), encoding="utf-8")
        (made.work / TABLE).write_text(score_table.as_csv(systems), encoding="utf-8")
        made.finish()
    return Evaluation(Path(folder), systems)


@dataclass(frozen=True, eq=False)
class _Scored:
    """A result, held against the view of its truth."""

    name: str
    clip: ClipScores
    scores: dict[str, Score]
    view: str
    notes: tuple[str, ...]


def _scored(
    results: Sequence[Path], truths: Sequence[Path], view: View, seed: int, folder: Path
) -> list[_Scored]:
    """Score each result, say what is doubtful, and write its error map and its curves."""
    speaker = load_speaker()
    out: list[_Scored] = []
    maps: set[str] = set()
    for name, path, truth in _loaded(results, truths, view):
        marks = landmarks_of(truth, speaker)
        estimate = read_result(path, truth, speaker, marks)
        clip = measure(replace(estimate, name=name), truth, marks)
        scores = summary([clip], seed=seed)
        told = notes_of(clip, scores)
        for note in told:
            _log.warning("%s: %s", path, note)
        _save_map(folder / f"error_map_{_plain(name, maps)}.npz", estimate, truth)
        if len(results) == 1 and path.is_dir():
            draw(load_run(path), truth, folder)
        out.append(_Scored(name, clip, scores, "/".join(truth.folder.parts[-2:]), told))
    return out


def notes_of(clip: ClipScores, scores: Mapping[str, Score]) -> tuple[str, ...]:
    """Notes about the scores of a clip, one sentence each."""
    return (*clip.notes, *doubts(scores), *offsets(scores))


def default_folder(results: Sequence[Path]) -> Path:
    """Default folder of scores: RUN/evaluation, NAME-evaluation, or ./evaluation."""
    if len(results) > 1:
        return Path("evaluation")
    only = Path(results[0])
    return only.with_name(f"{only.stem}-evaluation") if only.is_file() else only / "evaluation"


def run_scores(path: Path, truth: Truth) -> dict[str, Score]:
    """Scores of a run, as `evaluate` gives them.

    Raises
    ------
    InputFileError, ParameterError
        As `read_result`.
    """
    speaker = load_speaker()
    marks = landmarks_of(truth, speaker)
    return summary([measure(read_result(path, truth, speaker, marks), truth, marks)])


def read_result(path: Path, truth: Truth, speaker: Speaker, marks: NDArray[Any] | None) -> Estimate:
    """Read what a system says about the truth's frames.

    Parameters
    ----------
    path : Path
        A run's folder, or a CSV file of landmarks or of ARKit's face units.
    speaker : Speaker
        Whose areas and face units are used if the truth has its mesh.
    marks : (68,) int, optional
        The landmarks on the truth's mesh.

    Raises
    ------
    InputFileError
        If it cannot be read, or lacks columns.
    ParameterError
        If it is of other frames or of another mesh.
    """
    path = Path(path)
    areas = dict(speaker.points) if same_mesh(truth, speaker) else {}
    areas.pop("landmark_68", None)  # `measure` adds these to every system alike
    if path.is_dir():
        run = load_run(path)
        check_run(run, len(truth), len(truth.neutral))
        check_clip(path, run, truth)
        surface = load_mesh(path) if (path / MESH).is_file() else None
        if surface is not None and (len(surface), len(surface.mean)) != (
            len(truth),
            len(truth.neutral),
        ):
            raise ParameterError(
                f"{path / MESH} is of other frames or of another mesh than the truth",
                "track with the speaker that was filmed",
            )
        return of_run(path.name, run, surface, areas)
    if marks is None:
        raise InputFileError(
            f"the ground truth of {path} has no 68 landmarks", "film it again with this release"
        )
    clip = Reference(len(truth), truth.rate, truth.neutral.astype(np.float64), marks)
    if not is_arkit(list(read_table(path, remedy=_RESULTS).columns)):
        return read_landmarks(path, clip)
    if not areas:
        raise ParameterError(
            "the truth is of another head than the bundled one", "score landmarks instead"
        )
    return read_arkit(path, clip, speaker.unit_names, speaker.units, areas)


def landmarks_of(truth: Truth, speaker: Speaker) -> NDArray[Any] | None:
    """The 68 landmarks (68,) on the truth's mesh: its own list, or the bundled head's."""
    if "landmark_68" in truth.landmarks:
        return truth.landmarks["landmark_68"]
    return speaker.points.get("landmark_68") if same_mesh(truth, speaker) else None


def same_mesh(truth: Truth, speaker: Speaker) -> bool:
    """Whether the truth's mesh is the speaker's."""
    return np.array_equal(truth.faces, speaker.faces)


def _check_result(path: Path) -> None:
    """Raise `InputFileError` for what is no result at all, before anything slow is read."""
    if path.is_dir():
        load_run(path)
    elif not path.is_file():
        raise InputFileError(f"{path} does not exist", _RESULTS)


def _loaded(
    results: Sequence[Path], truths: Sequence[Path], view: View
) -> Iterator[tuple[str, Path, Truth]]:
    """Name, path and truth of each result; a truth that serves all is read once."""
    names: list[str] = []
    shared = found_truth(truths[0], *view, results) if len(truths) == 1 else None
    for k, path in enumerate(map(Path, results)):
        name = legible(path.resolve().name if path.is_dir() else path.stem)
        if name in (*names, POOLED):
            name = f"{legible(path.resolve().parent.name)}/{name}"
        while name in (*names, POOLED):
            name += "'"
        names.append(name)
        yield name, path, shared if shared is not None else found_truth(truths[k], *view, [path])


def _plain(name: str, taken: set[str]) -> str:
    """A name for a file like none that is taken, capitals or not; it is taken then."""
    base = plain = re.sub(r"[^\w.-]+", "_", name)
    count = 1
    while plain.casefold() in taken:
        count += 1
        plain = f"{base}_{count}"
    taken.add(plain.casefold())
    return plain


def _save_map(path: Path, estimate: Estimate, truth: Truth) -> None:
    """Write the error of each vertex, if the estimate says anything about them."""
    errors = error_map(estimate, truth)
    if np.isfinite(errors).any():
        rms = errors.astype(np.float32)
        np.savez_compressed(path, format=MAP_FORMAT, version=MAP_VERSION, vertex_rms_mm=rms)
