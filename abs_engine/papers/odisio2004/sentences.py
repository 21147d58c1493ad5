"""Experiment (b): sentences, head motion and articulation tracked together (section 5.1)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from abs_engine.face.talking import MODELS, TalkingFace
from abs_engine.io.assets import Speaker
from abs_engine.papers.odisio2004.gathered import Report
from abs_engine.papers.odisio2004.sentences_filmed import RATE, Filmed
from abs_engine.papers.odisio2004.sentences_scores import Closures, Curves, closing_gap, closures
from abs_engine.papers.odisio2004.sentences_scores import curves as curves_of
from abs_engine.papers.odisio2004.sentences_work import Job, Work, track_sentences
from abs_engine.papers.odisio2004.sequence import Tracked
from abs_engine.papers.odisio2004.trees import Tree, faces_at_centres, phoneme_tree
from abs_engine.papers.odisio2004.visemes import Speech
from abs_engine.studio.french import SENTENCES, Sentence


@dataclass(frozen=True, eq=False)
class Run:
    """A sentence that was tracked with each model.

    Parameters
    ----------
    filmed : Filmed
        Without its pictures.
    tracked : dict of str to Tracked
        By model; not every sentence need have all.
    """

    filmed: Filmed
    tracked: dict[str, Tracked]
    curves: dict[str, Curves]
    closures: dict[str, Closures]


@dataclass(frozen=True, eq=False)
class Sentences:
    """All sentences that were tracked.

    Parameters
    ----------
    closed_below : float, mm
        See `sentences_scores.closing_gap`.
    """

    runs: tuple[Run, ...]
    closed_below: float

    def told(self) -> dict[str, Any]:
        """The table over all sentences, for ``results.json``."""
        out: dict[str, Any] = {"frames": sum(len(run.filmed) for run in self.runs)}
        out |= {"sentences": len(self.runs), "closed_below_mm": self.closed_below}
        for model in MODELS:
            own = [run for run in self.runs if model in run.curves]
            if own:
                out[model] = _told(model, own)
        return out

    def told_each(self) -> list[dict[str, Any]]:
        """A row for each sentence: what was said, frames, and by model its mm and closures."""
        place = {sentence.name: k for k, sentence in enumerate(SENTENCES)}
        return [_row(run) for run in sorted(self.runs, key=lambda run: place[run.filmed.name])]

    def took(self) -> dict[str, float | None]:
        """Mean seconds a frame, by model, of sentences that no interrupted run had begun."""
        out: dict[str, float | None] = {}
        for model in MODELS:
            tracked = [run.tracked[model] for run in self.runs if model in run.tracked]
            whole = [own for own in tracked if own.seconds == own.seconds]
            frames, seconds = sum(map(len, whole)), sum(own.seconds for own in whole)
            out[model] = round(seconds / frames, 5) if frames else None
        return out


def _told(model: str, runs: Sequence[Run]) -> dict[str, float]:
    """A model's line of the table."""
    curves = [run.curves[model] for run in runs]
    shut = sum((run.closures[model] for run in runs), Closures(0, 0, 0, 0))
    frames = sum(len(c.rms) for c in curves)
    return {
        "rms_mm": _mean([c.rms for c in curves]),
        "lips_mm": _mean([c.lips for c in curves]),
        "face_mm": _mean([c.rest for c in curves]),
        "depth_mm": _mean([c.depth for c in curves]),
        "worst_sentence_mm": max(float(c.rms.mean()) for c in curves),
        "evaluations_per_frame": _mean([c.evaluations for c in curves]),
        "closure_precision": shut.precision,
        "closure_recall": shut.recall,
        "closures": shut.spoken,
        "closures_found": shut.found,
        "sentences": len(runs),
        "frames": frames,
    }


def _row(run: Run) -> dict[str, Any]:
    """A sentence's line."""
    row: dict[str, Any] = {"name": run.filmed.name, "text": run.filmed.text}
    row |= {"frames": len(run.filmed)}
    for model, own in run.curves.items():
        shut = run.closures[model]
        row[model] = {
            **own.told(), "worst_frame_mm": float(own.rms.max()),
            "spoken": shut.spoken, "closed": shut.closed, "found": shut.found, "true": shut.true,
        }  # fmt: skip
    return row


def _mean(rows: Sequence[Any]) -> float:
    return float(np.concatenate(rows).mean())


def chosen(count: int | None) -> tuple[Sentence, ...]:
    """So many sentences, evenly spread, the first among them, in their order; None for all.

    Fewer are always among more, so that a run may be made longer.
    """
    spread = in_spread_order()[:count]
    return tuple(s for s in SENTENCES if s in spread)


def in_spread_order() -> tuple[Sentence, ...]:
    """All, such that those of any beginning are evenly spread: by their reversed binary number."""
    bits = (len(SENTENCES) - 1).bit_length()
    order = sorted(range(len(SENTENCES)), key=lambda k: f"{k:0{bits}b}"[::-1])
    return tuple(SENTENCES[k] for k in order)


def run_sentences(report: Report, work: Work, speech: Speech, jobs: Sequence[Job]) -> Sentences:
    """Film sentences and track each with its models; what is kept of an earlier run is taken.

    The head's pose in the first frame is given, about, and the face, which was learned from
    `speech`, starts from rest. Errors are those of `track_sentences`.
    """
    speaker, shape = report.speaker, work.face.shape
    track_sentences(
        work, jobs, speaker, report.renderer,
        workers=report.workers, renderer_name=report.renderer_name, tell=report.tell,
    )  # fmt: skip
    report.tell("scoring sentences")
    below = closing_gap(speaker, shape, speech.spoken.corpus.visemes, speech.built.alpha)
    return Sentences(tuple(_run(work, job, speaker, below) for job in jobs), below)


def _run(work: Work, job: Job, speaker: Speaker, below: float) -> Run:
    """Scores of a sentence that is kept."""
    filmed, shape = work.truth(speaker, job.sentence), work.face.shape
    kept = {model: work.load(job.sentence, model) for model in job.models}
    tracked = {model: own for model, own in kept.items() if own is not None}
    curves = {m: curves_of(speaker, shape, filmed, own) for m, own in tracked.items()}
    shut = {m: closures(filmed, own.gap, below) for m, own in curves.items()}
    return Run(filmed, tracked, curves, shut)


def trees_of(done: Sentences, face: TalkingFace, model: str) -> dict[str, Tree]:
    """Trees of vowels and of consonants in sentences tracked by a model, for figure 7.

    Raises `ParameterError` if fewer than two vowels or two consonants were said.
    """
    said = []
    for run in done.runs:
        if model not in run.tracked:
            continue
        points = np.array([face.shape.points(row) for row in run.tracked[model].alpha])
        inside = [s for s in run.filmed.utterance.segments if s.middle * RATE < len(points)]
        said.append((inside, RATE, points))
    return {kind: phoneme_tree(own) for kind, own in faces_at_centres(said).items()}
