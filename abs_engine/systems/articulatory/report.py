"""Model, tables and figures of a bundled speaker in a folder: table 1, figures 2 and 3."""

from __future__ import annotations

import json
from pathlib import Path

from abs_engine.assets import Speaker
from abs_engine.files import NewFolder, png
from abs_engine.scene import Renderer
from abs_engine.synth.corpus import NOISE, PAPER_VISEMES, speak_corpus
from abs_engine.systems.articulatory.build import Build, build, dense_head, left_out_errors
from abs_engine.systems.articulatory.figures import boxplot_figure, figure_bytes, nomogram_figure
from abs_engine.systems.articulatory.tables import boxes, results, variance_text

MODEL, CORPUS, TABLE, RESULTS = "model.npz", "corpus.npz", "variance.md", "results.json"
BOXPLOTS, NOMOGRAMS, PROFILES = "figure2.svg", "figure3.png", "figure3_side.png"
_SIDE = -60.0


def write_report(
    folder: Path,
    speaker: Speaker,
    person: str,
    renderer: Renderer,
    *,
    noise: float = NOISE,
    seed: int = 0,
) -> Build:
    """Speak the corpus, build the model, and write all that section 2 shows of it.

    Parameters
    ----------
    folder : Path
        New. Gets the corpus, the model, table 1 in Markdown, ``results.json`` (fractions, mm),
        figure 2 as SVG, and figure 3 of the mouth from the front and of the head from the side.
    speaker : Speaker
    person : str
        One of the speaker's.
    renderer : Renderer
    noise : float
        mm; see `abs_engine.synth.corpus.NOISE`.
    seed : int

    Raises
    ------
    OutputError
        If the folder exists or cannot be written.
    ParameterError
        If there is no such person, or the noise is negative.
    """
    with NewFolder(folder) as new:
        spoken = speak_corpus(speaker, speaker.named(person), PAPER_VISEMES, noise=noise, seed=seed)
        built = build(spoken.corpus)
        told = results(built, left_out_errors(spoken.corpus))
        told |= {"person": person, "noise_mm": noise, "seed": seed}
        told["variance_without_noise"] = results(build(spoken.noiseless))["variance"]
        spoken.corpus.save(new.work / CORPUS)
        built.model.save(new.work / MODEL)
        (new.work / TABLE).write_text(variance_text(built.model), encoding="utf-8")
        (new.work / RESULTS).write_text(json.dumps(told, indent=1) + "\n", encoding="utf-8")
        shown = boxes(built.corpus.visemes, built.model.names, built.errors)
        (new.work / BOXPLOTS).write_bytes(figure_bytes(boxplot_figure(shown), "svg"))
        dense = dense_head(built, spoken)
        for name, turn, crop in ((NOMOGRAMS, 0.0, "mouth"), (PROFILES, _SIDE, "head")):
            picture = nomogram_figure(
                renderer, speaker, dense, built.model.parameters, person=person, turn=turn,
                crop=crop,
            )  # fmt: skip
            (new.work / name).write_bytes(png(picture))
        new.finish()
    return built
