"""Numbers of a reproduction, by driver, side and what is known of the pose; remarks on them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from abs_engine.compare.forces import Rule as Integral
from abs_engine.papers.basu1998.collected import BEST, Report
from abs_engine.papers.basu1998.experiment import FrameError, converged, rms_of
from abs_engine.papers.basu1998.filmed import FRONT, YAWS, camera_name
from abs_engine.papers.basu1998.single_frames import AS_PRINTED

WAYS: tuple[tuple[str, str, str, Integral], ...] = (
    ("forces", "forces", "whole", "exact"),
    ("forces_one_sample", "forces", "sample", "sample"),
    ("forces_exact", "forces", "exact", "exact"),
    ("gradient", "gradient", "whole", "exact"),
    ("simplex", "simplex", "whole", "exact"),
    ("simplex_one_sample", "simplex", "whole", "sample"),
    ("forces_as_printed", AS_PRINTED, "sample", "sample"),
)
"""Name in the results, driver, rule of the forces, and how the posterior is integrated (5.4).

As printed is one fixed step from one start, the mean shape: eqs. 8, 10, 12 and 13.
"""
FURTHER = ("before_mm", "cross_validated_mm", "after_mm")
"""Lips of five seconds of dots with the variances of these, with cross-validated ones, and after
further training."""


@dataclass(frozen=True)
class Fits:
    """Fits of all people.

    Parameters
    ----------
    known, blob, moving : list of FrameError
        With the pose known, placed by the blob, and of the head that turns.
    further : list of tuple of float
        Of each person, errors in mm by `FURTHER`.
    """

    known: list[FrameError]
    blob: list[FrameError]
    moving: list[FrameError]
    further: list[tuple[float, ...]]


def fitted(report: Report, fits: Fits, filmed: int) -> None:
    """Sections 5 and 6.1 as numbers; `filmed` frames were there to be placed by the blob."""
    known, blob, moving = fits.known, fits.blob, fits.moving
    drivers: dict[str, dict[str, Any]] = {
        name: _driven([e for e in known if e.driver == name]) | {"posterior_rule": score}
        for name, _, _, score in WAYS
    }
    best = [e for e in known if e.driver == BEST]
    people = sorted({e.person for e in best})
    yaws = {
        person: {
            c: rms_of([e for e in best if (e.person, e.camera) == (person, c)])
            for c in map(camera_name, YAWS)
        }
        for person in people
    }
    turning = {p: rms_of([e for e in moving if e.person == p]) for p in people}
    from_blob, frontal = _driven(blob), _driven([e for e in blob if e.camera == FRONT])
    for name in ("simplex", "simplex_one_sample"):
        drivers[name]["iterations"] = None
    report.results |= {
        "drivers": drivers,
        "iterations_to_converge": from_blob.get("iterations"),
        "blob": from_blob | {
            "found": len(blob) / filmed,
            "converged": converged(blob) * len(blob) / filmed if blob else 0.0,
            "most_iterations": max((e.fit.solution.n_iterations for e in blob), default=None),
            "frontal": frontal,
        },
        "yaw_mm": yaws,
        "pose": {
            "known": rms_of(best), "frontal": rms_of([e for e in best if e.camera == FRONT]),
            "worst": max(mm for of in yaws.values() for mm in of.values()),
            "blob": from_blob.get("mm"), "blob_frontal": frontal.get("mm"),
            "estimated": rms_of(moving),
            "estimated_mm": turning, "estimated_worst": max(turning.values()),
            "highest": float(np.sqrt(np.mean([e.highest**2 for e in best]))),
            "frames": {"blob": len(blob), "blob_filmed": filmed, "estimated": len(moving)},
        },
        "further_training": _trained(fits.further),
    }  # fmt: skip


def _trained(further: Sequence[tuple[float, ...]]) -> dict[str, float]:
    """Errors of all people by each of `FURTHER`, mm, and what is left of the first."""
    rms = np.sqrt(np.mean(np.square(further), axis=0))
    left = {"left": float(rms[-1] / rms[0])}
    return {**dict(zip(FURTHER, map(float, rms), strict=True)), **left}


def seconds(errors: Sequence[FrameError]) -> dict[str, float | None]:
    """Mean seconds a frame, by driver, of those frames that no interrupted run had fitted."""
    took: dict[str, list[float]] = {}
    for error in errors:
        took.setdefault(error.driver, []).append(error.fit.seconds)
    means = {name: np.mean([s for s in own if s == s] or [np.nan]) for name, own in took.items()}
    return {name: None if mean != mean else round(float(mean), 5) for name, mean in means.items()}


def _driven(errors: Sequence[FrameError]) -> dict[str, float | None]:
    if not errors:
        return {}
    found = [e.fit.solution for e in errors]
    return {
        "mm": rms_of(errors),
        "highest_mm": float(np.sqrt(np.mean([e.highest**2 for e in errors]))),
        "evaluations": float(np.mean([s.n_evaluations for s in found])),
        "iterations": float(np.mean([s.n_iterations for s in found])),
        "posterior": float(np.mean([s.value for s in found])),
        "converged": converged(errors),
    }


REMARKS = (
    "What is tracked was learned from 40 seconds of authored speech, other sentences than those "
    "of the test; its colours from labelled pixels of another clip. Starts are 48 typical shapes "
    "of the training, compared in one batch; the best four are refined. The lips found are "
    "the mean of the four ends by their probability; beside their error stands that of the "
    "highest end alone, whose posterior, iterations and convergence are reported.",
    "Between the shell's rings and behind its inner one, lips are drawn as the person's are at "
    "rest. How these parts follow the shell is taken from the head's face units, three numbers "
    "for each ring that hold for everybody; the filmed speech is made of such units.",
    "From the blob: depth and rotation are given, the visible lips' centroid is brought to the "
    "blob's, then forces move shape and place. An iteration asks for one direction and looks at "
    "three strides along it, of place and shape each, after the first with four multiples of the "
    "step before. It has converged when it gains less than 0.1 of -log posterior. Errors by camera "
    "are those of Nelder-Mead. Frames without a found mouth are left out of errors; `pose.frames` "
    "counts the others. Nelder-Mead by one sample is measured on every fifth frame.",
    "Closures in real clips are those of `abs-engine track` with unknown persons, whose mouths "
    "move in components of face units: no dots of those speakers are known. A spike is a single "
    "frame that is off its neighbours' aperture by 4 mm.",
    "Further training starts from five seconds in which speech's rounded lips are hardly or not "
    "seen: the recording, or authored speech without rounded vowels. Shapes that the full-rank "
    "shell found in a clip of other words, seen from three sides at once, are added with the "
    "covariance of their posterior, in three rounds; the round is kept by which the last fifth of "
    "that clip, which is not learned from, is most probable.",
)
