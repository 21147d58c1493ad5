"""The corpus of a bundled speaker as a user would bring an own one: points and two tables."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from abs_engine.face.shape.predictors import PAPER_PREDICTORS, Predictor
from abs_engine.learn.spoken import SpokenCorpus, upper_teeth_of
from abs_engine.report.articulation.predictor_file import predictors_text

POINTS, ROLES, PREDICTORS = "points.csv", "roles.csv", "predictors.toml"
_TEETH = {"right": "upper_right", "left": "upper_left", "front": "upper_front"}


def write_example(
    folder: Path, spoken: SpokenCorpus, predictors: Sequence[Predictor] = PAPER_PREDICTORS
) -> None:
    """Write the points of a corpus as recorded in the head frame, their roles, and the predictors.

    Parameters
    ----------
    folder : Path
        Exists. Gets ``points.csv`` (a line for each point and viseme, mm), ``roles.csv`` and
        ``predictors.toml``.
    """
    texts = {
        POINTS: _points(spoken), ROLES: _roles(spoken),
        PREDICTORS: predictors_text(predictors),
    }  # fmt: skip
    for name, text in texts.items():
        (folder / name).write_text(text, encoding="utf-8")


def _points(spoken: SpokenCorpus) -> str:
    """A line for each point of each viseme, those of the upper teeth last."""
    corpus = spoken.corpus
    to_bite = corpus.frame
    back = to_bite.inverse
    teeth = upper_teeth_of(spoken.speaker, spoken.neutral)
    lines = ["frame,point,x,y,z"]
    for frame, places in enumerate(corpus.points):
        recorded = np.concatenate([back.apply(places), teeth])
        for name, (x, y, z) in zip((*corpus.names, *_TEETH.values()), recorded, strict=True):
            lines.append(f"{frame},{name},{x:.4f},{y:.4f},{z:.4f}")
    return "\n".join(lines) + "\n"


def _roles(spoken: SpokenCorpus) -> str:
    """Groups of each point, frames of each viseme, and which points are on the upper teeth."""
    corpus = spoken.corpus
    lines = ["what,name,value"]
    for name in corpus.names:
        own = [group for group, members in corpus.groups.items() if name in members]
        lines.append(f"point,{name},{' '.join(own)}")
    lines += [f"viseme,{name},{frame}" for frame, name in enumerate(corpus.visemes)]
    lines += [f"teeth,{role},{name}" for role, name in _TEETH.items()]
    return "\n".join(lines) + "\n"
