"""Experiment (b): sentences, head motion and articulation tracked together (section 5.1)."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from abs_engine.assets import Speaker
from abs_engine.scene import Renderer
from abs_engine.synth.french import QUICK, SENTENCES, Sentence
from abs_engine.systems.articulatory.figures import figure_bytes
from abs_engine.systems.articulatory.models import LOCALS, MODELS, TalkingFace
from abs_engine.systems.articulatory.sentences_figures import curves_figure
from abs_engine.systems.articulatory.sentences_filmed import RATE, Filmed, film_sentence
from abs_engine.systems.articulatory.sentences_scores import Closures, Curves, closing_gap, closures
from abs_engine.systems.articulatory.sentences_scores import curves as curves_of
from abs_engine.systems.articulatory.sequence import Settings, Tracked, track
from abs_engine.systems.articulatory.trees import (
    Tree,
    faces_at_centres,
    phoneme_tree,
    trees_figure,
)
from abs_engine.systems.articulatory.visemes import Speech

FIGURE, TREES = "figure8.svg", "figure7.svg"
QUICK_FRAMES = 36
"""Of each sentence, in the quick version."""
Tell = Callable[[str], None]

_OF_TEXTURES = Settings(limit=300)
_OF_POINTS = Settings(limit=280, coarse=1e-5, tolerance=1e-3, inertia=1e-5, unusual=2.0)


def settings_of(model: str) -> Settings:
    """How frames are searched with an appearance model; chosen on `french.PRACTICE`."""
    return _OF_POINTS if model in LOCALS else _OF_TEXTURES


@dataclass(frozen=True, eq=False)
class Run:
    """A sentence that was tracked with each model.

    Parameters
    ----------
    filmed : Filmed
        Without its pictures.
    tracked : dict of str to Tracked
        By model.
    curves : dict of str to Curves
    closures : dict of str to Closures
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
    runs : tuple of Run
    closed_below : float, mm
        See `sentences_scores.closing_gap`.
    """

    runs: tuple[Run, ...]
    closed_below: float

    def told(self) -> dict[str, Any]:
        """The table over all sentences, for ``results.json``."""
        out: dict[str, Any] = {"frames": sum(len(run.filmed) for run in self.runs)}
        out |= {"sentences": len(self.runs), "closed_below_mm": self.closed_below}
        for model in self.runs[0].curves:
            own = [run.curves[model] for run in self.runs]
            shut = sum((run.closures[model] for run in self.runs), Closures(0, 0, 0, 0))
            out[model] = {
                "rms_mm": _mean([c.rms for c in own]),
                "lips_mm": _mean([c.lips for c in own]),
                "evaluations_per_frame": _mean([c.evaluations for c in own]),
                "closure_precision": shut.precision,
                "closure_recall": shut.recall,
                "closures": shut.spoken,
            }
        return out


def _mean(rows: Sequence[Any]) -> float:
    return float(np.concatenate(rows).mean())


def run_sentences(
    speaker: Speaker,
    speech: Speech,
    face: TalkingFace,
    renderer: Renderer,
    folder: Path | None = None,
    *,
    sentences: Sequence[Sentence] = SENTENCES,
    models: Sequence[str] = MODELS,
    frames: int | None = None,
    seed: int = 0,
    tell: Tell = lambda _text: None,
) -> Sentences:
    """Film sentences and track each with each model.

    The head's pose in the first frame is given, about, and the face starts from rest.

    Parameters
    ----------
    speaker : Speaker
    speech : Speech
        The corpus that `face` was learned from; says how many beads are on the face.
    face : TalkingFace
    renderer : Renderer
    folder : Path, optional
        Gets figure 8, of the first sentence.
    sentences : sequence of Sentence
    models : sequence of str
    frames : int, optional
        Of each sentence, from its start; by default all.
    seed : int
        Of head motion, blinks and noise.
    tell : callable
        Told what is done next.

    Raises
    ------
    StudioError
        If pyrender cannot draw on this machine.
    """
    shape, camera = face.shape, speech.pictures.camera
    visemes = speech.spoken.corpus.visemes
    below = closing_gap(speaker, shape, visemes, speech.built.alpha)
    runs = []
    for number, sentence in enumerate(sentences):
        tell(f"filming sentence {number + 1} of {len(sentences)}, {sentence.name}")
        filmed = film_sentence(
            speaker, speech.person, sentence, camera, shape.vertices,
            seed=seed, beads=speech.beads, frames=frames,
        )  # fmt: skip
        tracked = {}
        for model in models:
            tell(f"tracking {sentence.name} with {model}")
            tracked[model] = track(
                face, model, filmed.pictures, camera, filmed.poses[0], shape.neutral, renderer,
                settings_of(model), speech.built.alpha,
            )  # fmt: skip
        runs.append(_scored(speaker, face, filmed, tracked, below))
    if folder is not None:
        first = runs[0]
        figure = curves_figure(shape, first.filmed, first.curves)
        (folder / FIGURE).write_bytes(figure_bytes(figure, "svg"))
    return Sentences(tuple(runs), below)


def run_quick(
    speaker: Speaker,
    speech: Speech,
    face: TalkingFace,
    renderer: Renderer,
    folder: Path,
    *,
    seed: int = 0,
    tell: Tell = lambda _text: None,
) -> Sentences:
    """The beginning of `french.QUICK`; see `run_sentences`."""
    return run_sentences(
        speaker, speech, face, renderer, folder, sentences=QUICK, frames=QUICK_FRAMES, seed=seed,
        tell=tell,
    )  # fmt: skip


def _scored(
    speaker: Speaker, face: TalkingFace, filmed: Filmed, tracked: dict[str, Tracked], below: float
) -> Run:
    curves = {m: curves_of(speaker, face.shape, filmed, own) for m, own in tracked.items()}
    shut = {m: closures(filmed, own.gap, below) for m, own in curves.items()}
    return Run(filmed.without_pictures(), tracked, curves, shut)


def run_trees(
    done: Sentences, face: TalkingFace, folder: Path | None = None, model: str = "tex_cst"
) -> dict[str, Tree]:
    """Figure 7: trees of vowels and of consonants, from the tracked sentences.

    Parameters
    ----------
    done : Sentences
    face : TalkingFace
    folder : Path, optional
        Gets the figure.
    model : str
        With which they were tracked; the paper's is tex_cst.

    Raises
    ------
    ParameterError
        If fewer than two vowels or two consonants were said.
    """
    said = []
    for run in done.runs:
        points = np.array([face.shape.points(row) for row in run.tracked[model].alpha])
        inside = [s for s in run.filmed.utterance.segments if s.middle * RATE < len(points)]
        said.append((inside, RATE, points))
    trees = {kind: phoneme_tree(own) for kind, own in faces_at_centres(said).items()}
    if folder is not None:
        (folder / TREES).write_bytes(figure_bytes(trees_figure(trees), "svg"))
    return trees
