"""An articulatory model with its tables and figures in a folder: table 1, figures 2 and 3."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path

from abs_engine.core.scene import Renderer
from abs_engine.io.files import png
from abs_engine.io.new_folder import NewFolder
from abs_engine.learn.articulatory import build, dense_head
from abs_engine.learn.spoken import SpokenCorpus
from abs_engine.report.articulation.analysis import Analysis
from abs_engine.report.articulation.example import write_example
from abs_engine.report.articulation.figures import boxplot_figure, nomogram_figure
from abs_engine.report.articulation.model_page import model_page
from abs_engine.report.articulation.point_figures import point_nomograms
from abs_engine.report.articulation.tables import boxes, results, variance_text
from abs_engine.report.drawing.figure import figure_bytes

MODEL, CORPUS, TABLE, RESULTS = "model.npz", "corpus.npz", "variance.md", "results.json"
PAGE, BOXPLOTS, NOMOGRAMS = "index.html", "boxplots.svg", "nomograms.svg"
HEADS = {"heads_front.png": (0.0, "mouth"), "heads_side.png": (-60.0, "head")}
"""Degrees by which the head is turned, and what is shown of it."""
_ABREAST = 40
"""Boxes beside each other."""
_CAPTIONS = {
    BOXPLOTS: "Direct inversion of the corpus: a box of the points' errors for each viseme, from "
    "the worst to the best; the dot is their root mean square.",
    NOMOGRAMS: "Elementary movements: the way of each point from -2 to +2 standard deviations of "
    "a parameter, with a dot at the end. Red: the points that the parameter is made of.",
    "heads_front.png": "The same movements of the head, seen near the mouth.",
    "heads_side.png": "The same of the whole head, from the side.",
}


@dataclass(frozen=True, eq=False)
class Heads:
    """A bundled speaker, whose whole head can be drawn, in the skin of one of its people."""

    spoken: SpokenCorpus
    person: str
    renderer: Renderer


def write_report(folder: Path, done: Analysis, heads: Heads | None = None) -> None:
    """Write a model and all that section 2 shows of it.

    Parameters
    ----------
    folder : Path
        New. Gets ``model.npz``, the corpus without what was kept out, table 1 in Markdown,
        ``results.json`` (fractions, mm), boxplots and nomograms as SVG, and ``index.html``.
    heads : Heads, optional
        Of a bundled speaker: nomograms of the head, too, and its points and tables to start from;
        see `write_example`.

    Raises
    ------
    OutputError
        If the folder exists or cannot be written.
    """
    built, told = done.built, done.as_json()
    with NewFolder(folder) as new:
        built.corpus.save(new.work / CORPUS)
        built.model.save(new.work / MODEL)
        (new.work / TABLE).write_text(variance_text(built.model), encoding="utf-8")
        shown = boxes(built.corpus.visemes, built.model.names, built.errors)
        pictures = {
            BOXPLOTS: figure_bytes(boxplot_figure(shown, -(-len(shown) // _ABREAST)), "svg"),
            NOMOGRAMS: figure_bytes(point_nomograms(built.model), "svg"),
        }
        if heads is not None:
            write_example(new.work, heads.spoken, built.model.predictors)
            pictures |= _drawn(done, heads)
            told["person"] = heads.person
            exact = build(heads.spoken.noiseless.without(done.asked), built.model.predictors)
            told["variance_without_noise"] = results(exact)["variance"]
        for name, content in pictures.items():
            (new.work / name).write_bytes(content)
        (new.work / RESULTS).write_text(json.dumps(told, indent=1) + "\n", encoding="utf-8")
        page = model_page(done, [(name, _CAPTIONS[name]) for name in pictures])
        (new.work / PAGE).write_text(page, encoding="utf-8")
        new.finish()


def _drawn(done: Analysis, heads: Heads) -> dict[str, bytes]:
    """Figure 3 of the whole head, by file."""
    dense = dense_head(done.built, heads.spoken)
    return {
        name: png(
            nomogram_figure(
                heads.renderer, heads.spoken.speaker, dense, done.built.model.parameters,
                person=heads.person, turn=turn, crop=crop,
            )
        )
        for name, (turn, crop) in HEADS.items()
    }  # fmt: skip
