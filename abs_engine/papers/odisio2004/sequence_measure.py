"""Search, stopping and models side by side on a sentence kept for practice."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np

from abs_engine.core.scene import Renderer
from abs_engine.face.appearance.local_learning import learn_local
from abs_engine.face.appearance.point_selection import choose_points
from abs_engine.face.talking import TalkingFace
from abs_engine.learn.settings import LEARNING
from abs_engine.papers.odisio2004.sentences_filmed import Filmed
from abs_engine.papers.odisio2004.sentences_work import settings_of
from abs_engine.papers.odisio2004.sequence import PAPER, Settings, track
from abs_engine.papers.odisio2004.visemes import Speech

TOLERANCES = (1e-2, 1e-3, 1e-4)
_NEXT_TO_NOTHING = 1e-5


def searches(usual: Settings) -> dict[str, Settings]:
    """The paper's warm start, the same with prediction, and the search along axes without it."""
    return {
        "simplex": PAPER,
        "simplex_predicted": replace(PAPER, predict=True),
        "axes": replace(usual, predict=False),
        "axes_predicted": usual,
    }


def stopping(usual: Settings) -> dict[str, Settings]:
    """The same search with looser and tighter ends."""
    return {f"{t:g}": replace(usual, tolerance=t, coarse=min(usual.coarse, t)) for t in TOLERANCES}


def compare_searches(
    speech: Speech,
    face: TalkingFace,
    model: str,
    filmed: Filmed,
    renderer: Renderer,
    which: Mapping[str, Settings],
    kept: Path,
) -> dict[str, dict[str, float]]:
    """Track one sequence with several searches.

    Parameters
    ----------
    speech : Speech
        The corpus that `face` was learned from.
    filmed : Filmed
        Of `french.PRACTICE`, so that nothing is chosen on what is reported.
    kept : Path
        Folder that gets the frames, and has those of an interrupted run.

    Returns
    -------
    dict of str to dict
        Of each search: the mean over the frames of the root mean square over the points, head
        coordinates, and the share of the frames that started again from the corpus.
    """
    out = {}
    for k, (name, how) in enumerate(which.items()):
        found = track(
            face, model, filmed.pictures, filmed.camera, filmed.poses[0],
            face.shape.neutral, renderer, how, speech.built.alpha,
            kept / f"{k}.journal",
        )  # fmt: skip
        points = np.array([face.shape.points(row) for row in found.alpha])
        away = ((points - filmed.points) ** 2).sum(axis=2)
        out[name] = {
            "rms_mm": float(np.sqrt(away.mean(axis=1)).mean()),
            "evaluations_per_frame": float(found.evaluations.mean()),
            "restarted": float(found.restarted.mean()),
        }
    return out


def variants(speech: Speech, face: TalkingFace, renderer: Renderer) -> dict[str, TalkingFace]:
    """The face as it is, and with one thing at a time as it was before or as the paper has it."""
    shape, local = face.shape, face.la_lin
    free = replace(shape, penalty=replace(shape.penalty, strength=_NEXT_TO_NOTHING))
    return {
        "points by articulation only, as in the paper": by_articulation(
            speech, face, renderer, LEARNING.spacing, whiten=True
        ),
        "noise of each point for itself": replace(
            face, la_lin=replace(local, left_out=np.zeros_like(local.left_out))
        ),
        "hardly any A(a)": replace(face, shape=free),
    }


def by_articulation(
    speech: Speech,
    face: TalkingFace,
    renderer: Renderer,
    spacing: float = 0.0,
    *,
    whiten: bool = False,
) -> TalkingFace:
    """The face with as many points of la_lin, chosen by what articulation makes of them alone.

    It was learned from all of the corpus. `spacing` is the least distance of points, mm, and
    `whiten` is as of `choose_points`; the paper has neither.
    """
    shape, seen = face.shape, speech.sightings(range(len(speech.pictures)))
    every = learn_local(
        seen, shape.scene, shape.marks, speech.pictures.camera, renderer, scale=face.la_scale
    )
    places = shape.scene.mean[shape.marks].astype(np.float64)
    chosen = choose_points(every, len(face.la_lin), places, spacing, whiten)
    return replace(face, la_lin=every.only(chosen).within(shape.kept))


def practise(
    speech: Speech, face: TalkingFace, filmed: Filmed, renderer: Renderer, kept: Path
) -> list[dict[str, str | float]]:
    """A table of all of it: searches and stopping rules of both linear models, and variants.

    Parameters are as of `compare_searches`.
    """
    rows: list[dict[str, str | float]] = []

    def add(model: str, own: TalkingFace, which: Mapping[str, Settings]) -> None:
        aside = kept / f"{len(rows)}"
        found = compare_searches(speech, own, model, filmed, renderer, which, aside)
        rows.extend({"what": name, "model": model, **m} for name, m in found.items())

    others = variants(speech, face, renderer)
    for model in ("tex_lin", "la_lin"):
        usual = settings_of(model)
        ends = {f"axes_predicted, stopped at {k}": v for k, v in stopping(usual).items()
                if v != usual}  # fmt: skip
        add(model, face, {**searches(usual), **ends})
        for name, own in others.items():
            if model == "la_lin" or own.shape is not face.shape:
                add(model, own, {name: usual})
    return rows
