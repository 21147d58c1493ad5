"""The paper's own training (section 3), five seconds of a recording, on motion that is not in it.

Each person's lips are learned from 150 frames of a recorded face, and found in pictures of the same
person who speaks. Beside the error stands how much of it other things than the picture make.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from abs_engine.capture.dot_annotations import LIPS16
from abs_engine.core.arrays import FloatArray
from abs_engine.core.scene import Renderer
from abs_engine.dataset.view import Truth
from abs_engine.face.shape.lip_dots import lips17
from abs_engine.io.assets import Speaker
from abs_engine.learn.training import reached
from abs_engine.papers.basu1998.collected import BEST, Report
from abs_engine.papers.basu1998.experiment import (
    TrainedLips,
    learn_lips,
    lip_error,
    pose_known,
    rms_of,
)
from abs_engine.papers.basu1998.filmed import (
    FILMED,
    FRONT,
    FRONTS,
    FULL,
    YAWS,
    Amount,
    camera_name,
    film,
    learn_colours,
)
from abs_engine.papers.basu1998.motion import recorded_motion

PARTS = ("interpolation_mm", "modes_mm", "picture_mm", "mm")
"""Errors, mm RMS of the lips' nodes.

Of the shell that exact dots reach (eq. 2); of the nearest shape to it in the ten modes; of what is
found in the picture with a prior that says next to nothing; of the same with the usual prior. The
first is part of the second, and both are limits of the last two.
"""
WEAK = 10.0
"""Factor of the prior's standard deviations where it says next to nothing."""


def recorded_training(report: Report, people: Sequence[str], recording: Path) -> dict[str, Any]:
    """Errors by `PARTS` of each person, seen from the front, the pose known.

    Returns
    -------
    dict
        ``people``, of each the errors, ``all``, their RMS, and ``motion``, what was learned from.
    """
    speaker, seed = report.speaker, report.seed
    report.tell("filming fronts")
    amount = Amount(tuple(people), report.amount.recorded, FULL.colours, 0)
    views = film(amount, report.folder / FILMED, seed, (FRONTS,))
    found, source = {}, ""
    for person in people:
        report.tell(f"{person}'s lips, learned from the recording")
        motion = recorded_motion(speaker, person, recording)
        source = motion.source
        seen = [views[person, "colours", camera_name(y)] for y in (YAWS[0], 0, YAWS[-1])]
        lips = learn_lips(speaker, person, learn_colours(seen), seed, motion)
        test, kept = views[person, "test", FRONT], report.kept / f"recorded-{person}"
        found[person] = errors(speaker, lips, test, report.renderer, kept)
    each = np.array([list(row.values()) for row in found.values()])
    pooled = np.sqrt((each**2).mean(axis=0)).tolist()
    return {"motion": source, "people": found, "all": dict(zip(PARTS, pooled, strict=True))}


def errors(
    speaker: Speaker, lips: TrainedLips, view: Truth, renderer: Renderer, kept: Path | None = None
) -> dict[str, float]:
    """Errors of a person's lips in a view, by `PARTS`; `kept` is as of `pose_known`."""
    heads = [view.vertices(frame) for frame in range(len(view))]
    truth = np.stack([lips.model.shell.nodes(head) for head in heads])
    by_dots = _by_dots(speaker, lips, np.stack(heads).astype(np.float64))
    physics = lips.training.physics
    nearest = physics.shape(physics.coefficients(by_dots))
    found = (
        rms_of(list(pose_known(lips, {FRONT: view}, renderer, BEST, kept=own, prior_width=width)))
        for width, own in ((WEAK, None if kept is None else kept / "weak"), (1.0, kept))
    )
    return dict(zip(PARTS, (_rms(by_dots, truth), _rms(nearest, truth), *found), strict=True))


def _by_dots(speaker: Speaker, lips: TrainedLips, heads: FloatArray) -> FloatArray:
    """Nodes (T, N, 3) of the shell that the dots of heads (T, V, 3) reach, without noise."""
    laid, dots = lips.training.correspondence, heads[:, lips17(speaker)[: len(LIPS16)]]
    return laid.rest + reached(lips.training.shell, laid, laid.goals(dots))


def _rms(shapes: FloatArray, truth: FloatArray) -> float:
    """RMS over frames of the lips' error, mm, of nodes (T, N, 3)."""
    pairs = zip(shapes, truth, strict=True)
    return float(np.sqrt(np.mean([lip_error(own, true) ** 2 for own, true in pairs])))
