"""Every table and figure of seed 001 on our own data, beside the paper's numbers."""

from __future__ import annotations

import json
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

from abs_engine.assets import Speaker, load_speaker
from abs_engine.files import png
from abs_engine.release import engine_version
from abs_engine.scene import Renderer
from abs_engine.systems.articulatory.build import dense_head, left_out_errors
from abs_engine.systems.articulatory.figures import boxplot_figure, figure_bytes, nomogram_figure
from abs_engine.systems.articulatory.filmed import BEADS
from abs_engine.systems.articulatory.models import MODELS, TalkingFace
from abs_engine.systems.articulatory.page import reproduction_page
from abs_engine.systems.articulatory.search import compare_solvers, compare_tolerances
from abs_engine.systems.articulatory.tables import boxes, results, variance_text
from abs_engine.systems.articulatory.viseme_figures import (
    points_figure,
    residual_figure,
    texture_nomograms,
)
from abs_engine.systems.articulatory.visemes import (
    Speech,
    VisemeError,
    film_speech,
    find_visemes,
    splits,
    summary,
)

PERSON = "clara"
RESULTS, PAGE = "results.json", "index.html"
SEARCH_MODEL, REPORTED = "tex_lin", 300
"""Model of the comparison of solvers, and the budget of which results.json tells."""


@dataclass(frozen=True)
class Amount:
    """How much is done.

    Parameters
    ----------
    size : tuple of int
        Of the pictures.
    rounds : int
        Splits of the visemes; five test each once.
    searched, stopped : int
        Visemes in the comparisons of solvers and of stopping rules.
    budgets : tuple of int
    """

    size: tuple[int, int]
    rounds: int
    searched: int
    stopped: int
    budgets: tuple[int, ...]


QUICK = Amount((320, 240), 1, 4, 4, (150, 300))
FULL = Amount((640, 480), 5, 14, 11, (150, 300, 600))


@dataclass
class Report:
    """What is collected on the way; the parts that come later add to it.

    Parameters
    ----------
    folder : Path
    renderer : Renderer
    speaker : Speaker
    person : str
    seed : int
    quick : bool
    tell : callable
        Told what is done next.
    results : dict
    figures : list of (str, str)
        Address and caption.
    """

    folder: Path
    renderer: Renderer
    speaker: Speaker
    person: str
    seed: int
    quick: bool
    tell: Callable[[str], None]
    results: dict[str, Any] = field(default_factory=dict)
    figures: list[tuple[str, str]] = field(default_factory=list)

    @property
    def amount(self) -> Amount:
        """How much is done."""
        return QUICK if self.quick else FULL

    def figure(self, name: str, content: bytes, caption: str) -> None:
        """Write a figure."""
        (self.folder / name).write_bytes(content)
        self.figures.append((name, caption))


Part = Callable[[Report, Speech, TalkingFace], None]
"""A later experiment: a report, the filmed corpus with beads, and a face learned from all of it."""


def reproduce(
    folder: Path,
    renderer: Renderer,
    *,
    quick: bool = False,
    seed: int = 0,
    person: str = PERSON,
    tell: Callable[[str], None] = lambda _text: None,
    parts: tuple[Part, ...] = (),
) -> dict[str, Any]:
    """Make tables, figures and a page.

    Parameters
    ----------
    folder : Path
        Empty; gets ``index.html``, ``results.json``, figures, and the filmed corpora.
    renderer : Renderer
    quick : bool
        Small pictures and one split: minutes.
    seed : int
    person : str
        One of the bundled speaker's.
    tell : callable
        Told what is done next.
    parts : tuple of callable
        Further experiments, which add to the results and the figures.

    Returns
    -------
    dict
        What ``results.json`` holds.
    """
    started = time.perf_counter()
    report = Report(folder, renderer, load_speaker(), person, seed, quick, tell)
    (folder / "filmed").mkdir()
    report.results |= _empty()
    tell("filming visemes with beads")
    beaded = _filmed(report, "beads", BEADS)
    _shape(report, beaded)
    tell("filming visemes of the bare face")
    bare = _filmed(report, "bare", 0)
    _visemes(report, beaded, bare)
    _search(report, bare)
    if parts:
        whole = beaded.learn(range(len(beaded.pictures)), renderer)
        for part in parts:
            part(report, beaded, whole)
    report.results |= {
        "command": f"abs-engine reproduce 001{' --quick' if quick else ''} --seed {seed} "
        f"--person {person}",
        "person": person, "seed": seed, "quick": quick, "renderer": renderer.description,
        "engine_version": engine_version(), "seconds": round(time.perf_counter() - started, 1),
    }  # fmt: skip
    text = json.dumps(report.results, indent=1) + "\n"
    (folder / RESULTS).write_text(text, encoding="utf-8")
    page = reproduction_page(report.results, report.figures)
    (folder / PAGE).write_text(page, encoding="utf-8")
    return report.results


def _empty() -> dict[str, Any]:
    """The keys that later experiments fill."""
    keys = ("rms_mm", "evaluations_per_frame", "closure_precision", "closure_recall")
    return {
        "sentences": {name: dict.fromkeys(keys) for name in MODELS},
        "teleconference": {n: {"rms_mm": None} for n in ("tex_cst", "la_lin", "la_lin_heldout")},
    }


def _filmed(report: Report, name: str, beads: int) -> Speech:
    return film_speech(
        report.speaker, report.person, report.folder / "filmed" / name, beads=beads,
        size=report.amount.size, seed=report.seed,
    )  # fmt: skip


def _shape(report: Report, speech: Speech) -> None:
    """Table 1, figures 2 and 3."""
    report.tell("the articulatory model")
    built, model = speech.built, speech.built.model
    report.results |= results(built, left_out_errors(speech.spoken.corpus))
    (report.folder / "variance.md").write_text(variance_text(model), encoding="utf-8")
    shown = boxes(built.corpus.visemes, model.names, built.errors)
    report.figure(
        "figure2.svg", figure_bytes(boxplot_figure(shown), "svg"),
        "Figure 2: direct inversion of the learning data, a box for each viseme.",
    )  # fmt: skip
    dense = dense_head(built, speech.spoken)
    picture = nomogram_figure(
        report.renderer, report.speaker, dense, model.parameters, person=report.person, crop="mouth"
    )
    report.figure("figure3.png", png(picture), "Figure 3: the seven elementary movements.")


def _visemes(report: Report, beaded: Speech, bare: Speech) -> None:
    """Figures 4, 5 and 6."""
    found: dict[str, list[VisemeError]] = {}
    for key, title, speech in (
        ("visemes", "with beads", beaded), ("visemes_bare", "bare face", bare)
    ):  # fmt: skip
        errors: list[VisemeError] = []
        rounds = splits(len(speech.pictures), report.seed, report.amount.rounds)
        for k, (trained, tests) in enumerate(rounds):
            report.tell(f"visemes, {title}: {k + 1} of {len(rounds)}")
            face = speech.learn(trained, report.renderer)
            errors += find_visemes(speech, face, tests, report.renderer)
            if k == 0:
                report.results[f"texture_variance{'' if speech.beads else '_bare'}"] = (
                    face.tex_lin.explained
                )
                _appearance(report, speech, face)
        report.results[key] = summary(errors)
        found[title] = errors
    report.figure(
        "figure6.png", figure_bytes(residual_figure(found)),
        "Figure 6: residuals of visemes that appearance was not learned from, the worst named.",
    )  # fmt: skip


def _appearance(report: Report, speech: Speech, face: TalkingFace) -> None:
    """Figures 4 and 5 of the bare face, whose appearance is seen best."""
    if speech.beads:
        return
    seen = speech.pictures
    picture = texture_nomograms(face, seen.camera, seen.poses[0], report.renderer)
    report.figure("figure4.png", png(picture), "Figure 4: nomograms of texture, jaw1 and lips1.")
    shown = [seen.visemes.index(v) for v in ("i", "a", "u")]
    report.figure(
        "figure5.png", png(points_figure(speech, face, shown)),
        "Figure 5: the points that were chosen for local appearance.",
    )  # fmt: skip


def _search(report: Report, speech: Speech) -> None:
    """Solvers and stopping rules, on visemes that neither training nor tests have."""
    amount, seed = report.amount, report.seed
    trained, _ = splits(len(speech.pictures), seed, amount.rounds)[0]
    inner, outer = splits(len(trained), seed + 1, 1)[0]
    learned, kept = trained[inner], trained[outer]
    face = speech.learn(learned, report.renderer)
    report.tell("comparing solvers")
    rows = compare_solvers(
        speech, face, kept[: amount.searched], report.renderer, model=SEARCH_MODEL,
        budgets=amount.budgets, seed=seed,
    )  # fmt: skip
    report.results["search_table"] = [asdict(row) for row in rows]
    report.results["search"] = {
        row.solver: {
            "mm": row.mm, "lips_mm": row.lips_mm, "failures": row.failures,
            "seconds": row.seconds, "evaluations": row.evaluations,
        }
        for row in rows if row.budget == REPORTED
    }  # fmt: skip
    report.tell("comparing stopping rules")
    stops = compare_tolerances(
        speech, face, kept[: amount.stopped], report.renderer, model=SEARCH_MODEL
    )
    report.results["stopping"] = [asdict(row) for row in stops]
