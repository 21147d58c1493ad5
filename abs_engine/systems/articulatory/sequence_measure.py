"""What prediction and stopping are worth: searches side by side on a sentence kept for practice."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from abs_engine.scene import Renderer
from abs_engine.systems.articulatory.models import TalkingFace
from abs_engine.systems.articulatory.sentences_filmed import Filmed
from abs_engine.systems.articulatory.sequence import PAPER, Settings, track
from abs_engine.systems.articulatory.visemes import Speech

TOLERANCES = (1e-2, 1e-3, 1e-4)


@dataclass(frozen=True)
class Measured:
    """A search over a sequence.

    Parameters
    ----------
    rms_mm : float
        Mean over the frames of the root mean square over the points, head coordinates.
    evaluations_per_frame : float
    restarted : float
        Share of the frames that started again from the corpus.
    """

    rms_mm: float
    evaluations_per_frame: float
    restarted: float


def searches(usual: Settings) -> dict[str, Settings]:
    """The paper's warm start, the same with prediction, and the search along axes without it."""
    return {
        "simplex": PAPER,
        "simplex_predicted": replace(PAPER, predict=True),
        "axes": replace(usual, predict=False),
        "axes_predicted": usual,
    }


def stopping(usual: Settings, tolerances: tuple[float, ...] = TOLERANCES) -> dict[str, Settings]:
    """The same search with looser and tighter ends."""
    return {f"{t:g}": replace(usual, tolerance=t, coarse=min(usual.coarse, t)) for t in tolerances}


def compare_searches(
    speech: Speech,
    face: TalkingFace,
    model: str,
    filmed: Filmed,
    renderer: Renderer,
    which: Mapping[str, Settings],
    frames: int | None = None,
) -> dict[str, Measured]:
    """Track one sequence with several searches.

    Parameters
    ----------
    speech : Speech
        The corpus that `face` was learned from.
    face : TalkingFace
    model : str
        Of appearance.
    filmed : Filmed
        Of `french.PRACTICE`, so that nothing is chosen on what is reported.
    renderer : Renderer
    which : mapping of str to Settings
    frames : int, optional
        From the start; by default all.
    """
    out = {}
    for name, how in which.items():
        found = track(
            face, model, filmed.pictures[:frames], filmed.camera, filmed.poses[0],
            face.shape.neutral, renderer, how, speech.built.alpha,
        )  # fmt: skip
        points = np.array([face.shape.points(row) for row in found.alpha])
        away = ((points - filmed.points[:frames]) ** 2).sum(axis=2)
        out[name] = Measured(
            float(np.sqrt(away.mean(axis=1)).mean()), float(found.evaluations.mean()),
            float(found.restarted.mean()),
        )  # fmt: skip
    return out
