"""Every table and figure of Odisio and Bailly (2003) on our own data, beside the paper's."""

from __future__ import annotations

import json
import resource
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.clock import write_timing
from abs_engine.core.provenance import made_by
from abs_engine.face.talking import MODELS, TalkingFace
from abs_engine.face.talking_file import save_talking
from abs_engine.io.files import png
from abs_engine.learn.articulatory import dense_head, leave_out_in_turn
from abs_engine.learn.training import checksum
from abs_engine.papers.odisio2004.filmed import BEADS
from abs_engine.papers.odisio2004.gathered import Report
from abs_engine.papers.odisio2004.page import reproduction_page
from abs_engine.papers.odisio2004.search import compare_solvers, compare_tolerances
from abs_engine.papers.odisio2004.viseme_figures import (
    points_figure,
    residual_figure,
    texture_nomograms,
)
from abs_engine.papers.odisio2004.visemes import (
    ASKED,
    Speech,
    VisemeError,
    film_speech,
    find_visemes,
    splits,
    summary,
)
from abs_engine.report.articulation.figures import boxplot_figure, nomogram_figure
from abs_engine.report.articulation.tables import boxes, results, variance_text
from abs_engine.report.drawing.figure import figure_bytes

RESULTS, PAGE, FACE = "results.json", "index.html", "face.npz"
FILMED = "filmed"
REPORTED = 300
"""Evaluations of each fit, of which results.json tells."""
ERRORS = "errors"
"""Of a round of visemes, while it is kept."""
Split = tuple[NDArray[np.int64], NDArray[np.int64]]
Part = Callable[[Report, Speech], None]
"""A later experiment: a report, and the filmed corpus with beads."""


def reproduce(report: Report, parts: tuple[Part, ...] = ()) -> dict[str, Any]:
    """Make tables, figures and a page in the report's folder.

    Parameters
    ----------
    report : Report
        Its folder is empty, or as an interrupted run with the same choices left it; it gets
        ``index.html``, ``results.json``, ``timing.json``, figures, the filmed corpora, the tracked
        sentences, and ``face.npz``, the bare face learned from all visemes.
    parts : tuple of callable
        Further experiments, which add to the results and the figures.

    Returns
    -------
    dict
        What ``results.json`` holds.
    """
    folder = report.folder
    (folder / FILMED).mkdir(exist_ok=True)
    report.results |= _empty()
    report.tell("filming visemes with beads")
    beaded = filmed(report, "beads", BEADS)
    report.stage("shape", lambda own: _shape(own, beaded))
    report.tell("filming visemes of the bare face")
    bare = filmed(report, "bare", 0)
    report.stage("visemes", lambda own: _visemes(own, beaded, bare))
    report.stage("face", lambda own: _face(own, bare))
    report.stage("search", lambda own: _search(own, bare))
    for part in parts:
        part(report, beaded)
    report.results |= {
        "command": report.command, "person": report.person, "seed": report.seed,
        "quick": report.quick, "renderer": report.renderer.description,
        **made_by(),
    }  # fmt: skip
    took = round(sum(stage["seconds"] for stage in report.timing.values()), 1)
    timing = {"seconds": took, "peak_memory_mb": _peak(), "stages": report.timing}
    write_timing(folder, timing)
    text = json.dumps(report.results, indent=1) + "\n"
    (folder / RESULTS).write_text(text, encoding="utf-8")
    page = reproduction_page(report.results, report.figures)
    (folder / PAGE).write_text(page, encoding="utf-8")
    return report.results


def _peak() -> float:
    """Largest memory of this process and of any that it started, MB."""
    both = resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN
    return round(max(resource.getrusage(who).ru_maxrss for who in both) / 1024, 1)


def _empty() -> dict[str, Any]:
    """The keys that later experiments fill."""
    keys = ("rms_mm", "evaluations_per_frame", "closure_precision", "closure_recall")
    return {
        "sentences": {name: dict.fromkeys(keys) for name in MODELS},
        "teleconference": {n: {"rms_mm": None} for n in ("tex_cst", "la_lin", "la_lin_heldout")},
    }


def filmed(report: Report, name: str, beads: int, size: tuple[int, int] | None = None) -> Speech:
    """Filmed visemes of the report's person, by default as large as its amount says."""
    folder, size = report.folder / FILMED / name, size or report.amount.size
    return film_speech(
        report.speaker, report.person, folder, beads=beads, size=size, seed=report.seed
    )


def _shape(report: Report, speech: Speech) -> None:
    """Table 1, figures 2 and 3."""
    report.tell("the articulatory model")
    built, model = speech.built, speech.built.model
    report.results |= results(built, leave_out_in_turn(speech.spoken.corpus).errors)
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
        asked = ASKED if len(rounds) > 1 else MODELS  # the short run has no time for both rules
        for k, split in enumerate(rounds):
            report.tell(f"visemes, {title}: {k + 1} of {len(rounds)}")
            errors += _round(report, f"{key}-{k}", speech, split, asked)
        report.results[key] = summary(errors)
        found[title] = errors
    report.figure(
        "figure6.png", figure_bytes(residual_figure(found)),
        "Figure 6: residuals of visemes that appearance was not learned from, the worst named.",
    )  # fmt: skip


def _round(
    report: Report, name: str, speech: Speech, split: Split, models: Sequence[str]
) -> list[VisemeError]:
    """Errors of the visemes that a split leaves to be tested; the first one's figures, too."""

    def found(own: Report) -> None:
        face = speech.learn(split[0], own.renderer)
        errors = find_visemes(speech, face, split[1], own.renderer, models)
        own.results[ERRORS] = [vars(e) | {"distances": e.distances.tolist()} for e in errors]
        if name.endswith("-0"):
            key = f"texture_variance{'' if speech.beads else '_bare'}"
            own.results[key] = face.tex_lin.explained
            _appearance(own, speech, face)

    report.stage(name, found)
    rows = report.results.pop(ERRORS)
    return [VisemeError(**{**row, "distances": np.array(row["distances"])}) for row in rows]


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


def _face(report: Report, speech: Speech) -> None:
    """The face's file, for `track`; its appearance is of all visemes."""
    report.tell("learning the face")
    face = speech.learn(range(len(speech.pictures)), report.renderer)
    path = report.folder / FACE
    path.unlink(missing_ok=True)  # of a run that was cut off just here
    save_talking(path, face, report.person, checksum(report.speaker))
    report.results["face"] = FACE


def _search(report: Report, speech: Speech) -> None:
    """Solvers and stopping rules, on visemes that the face is not learned from.

    The first round of splits learns from them, too. With a single round, as with ``--quick``, no
    result is reported of them; of several rounds, the others test on them.
    """
    amount, seed = report.amount, report.seed
    trained, _ = splits(len(speech.pictures), seed, amount.rounds)[0]
    inner, outer = splits(len(trained), seed + 1, 1)[0]
    learned, kept = trained[inner], trained[outer]
    face = speech.learn(learned, report.renderer)
    report.tell("comparing solvers")
    table = compare_solvers(
        speech, face, kept[: amount.searched], report.renderer, budgets=amount.budgets, seed=seed
    )
    report.timing["seconds_per_fit"] = {
        f"{row['solver']}, {row['budget']} evaluations": row.pop("seconds") for row in table
    }
    report.results["search_table"] = table
    report.results["search"] = {
        row["solver"]: {key: row[key] for key in ("mm", "lips_mm", "failures", "evaluations")}
        for row in table
        if row["budget"] == REPORTED
    }
    report.tell("comparing stopping rules")
    report.results["stopping"] = compare_tolerances(
        speech, face, kept[: amount.stopped], report.renderer
    )
