"""Sentences, trees and teleconference as parts of ``abs-engine reproduce 001``."""

from __future__ import annotations

from abs_engine.systems.articulatory.filmed import SIZE
from abs_engine.systems.articulatory.models import TalkingFace
from abs_engine.systems.articulatory.reproduce import Report
from abs_engine.systems.articulatory.sentences import (
    FIGURE,
    TREES,
    run_quick,
    run_sentences,
    run_trees,
)
from abs_engine.systems.articulatory.teleconference import FIGURE as FIGURE_10
from abs_engine.systems.articulatory.teleconference import run_teleconference
from abs_engine.systems.articulatory.trees import CONSONANTS, VOWELS
from abs_engine.systems.articulatory.visemes import Speech, film_speech

_CUT = {VOWELS: 3, CONSONANTS: 6}
"""Into how many groups the paper's text cuts its trees."""


def sentences_part(report: Report, speech: Speech, face: TalkingFace) -> None:
    """Figures 7 and 8 and the table over the sentences, 320x240."""
    if speech.pictures.camera.size != SIZE:
        report.tell("filming visemes for the sentences")
        speech = film_speech(
            report.speaker, report.person, report.folder / "filmed" / "sentences",
            beads=speech.beads, size=SIZE, seed=report.seed,
        )  # fmt: skip
        face = speech.learn(range(len(speech.pictures)), report.renderer)
    run = run_quick if report.quick else run_sentences
    done = run(
        report.speaker, speech, face, report.renderer, report.folder, seed=report.seed,
        tell=report.tell,
    )  # fmt: skip
    report.results["sentences"] = done.told()
    report.figures.append((FIGURE, "Figure 8: a tracked sentence; the truth is the solid line."))
    trees = run_trees(done, face, report.folder)
    report.results["trees"] = {
        kind: [list(group) for group in tree.groups(_CUT[kind])] for kind, tree in trees.items()
    }
    report.figures.append((TREES, "Figure 7: phonemes by the faces that tex_cst found."))


def teleconference_part(report: Report, speech: Speech, face: TalkingFace) -> None:
    """Figure 10 and the errors with the worn camera; in the quick version of fewer frames."""
    done = run_teleconference(
        report.speaker, speech, report.renderer, report.folder, seed=report.seed,
        tell=report.tell, frames=24 if report.quick else None,
    )  # fmt: skip
    report.results["teleconference"] = done.told()
    report.figures.append((FIGURE_10, "Figure 10: a sequence that a worn camera filmed."))


PARTS = (sentences_part, teleconference_part)
