"""Summary of a run: counts of its frames, means, agreement with the landmarks, and warnings."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from abs_engine.face.appearance.colour import ColourClasses
from abs_engine.face.base import Face
from abs_engine.tracking.clip_setting import FrameResult
from abs_engine.tracking.loop import HELD
from abs_engine.tracking.run_table import closed_frames, contradicted_frames
from abs_engine.tracking.run_warnings import doubts


def summary(results: Sequence[FrameResult], face: Face) -> dict[str, Any]:
    """Counts of frames; mean evaluations and score of the tracked. Covered ones are lost."""
    tracked = [r for r in results if r.found]
    work = [r.evaluations for r in tracked]
    return {
        "frames": len(results),
        "lost_frames": len(results) - len(tracked),
        "covered_frames": sum(r.covered for r in results),
        "closed_frames": int(sum(bool(closed_frames(r.aperture)) for r in tracked)),
        "mean_evaluations": float(np.mean(work)) if work else 0.0,
        "mean_score": _mean_score(tracked),
        **_score_of(results, face.name),
        **_by_landmarks(tracked, face),
    }


def _mean_score(tracked: Sequence[FrameResult]) -> float | None:
    """Mean of the scores; None where no evidence can say how much it explains."""
    scores = [r.score for r in tracked]
    if not np.isfinite(scores).all():
        return None
    return float(np.mean(scores)) if scores else 0.0


def _score_of(results: Sequence[FrameResult], model: str) -> dict[str, str]:
    """Name of the scores' source, where results state it: a head's colours'."""
    first = next((r for r in results if r.terms), None)
    if first is None:
        return {}
    name = next(iter(first.terms))
    return {"score_of": name if model == "head" else f"{model}: {name}"}


def _by_landmarks(tracked: Sequence[FrameResult], face: Face) -> dict[str, Any]:
    """Agreement of landmarks and colours, where landmarks were asked."""
    asked = [r for r in tracked if np.isfinite(r.landmark_aperture)]
    if not asked or "colour" not in face.appearance:
        return {}
    held, against = [r.status == HELD for r in asked], contradicted_frames(asked)
    off = np.array([r.landmark_distance for r in asked])
    drawn, seen = (
        np.array([getattr(r, k) for r in asked]) for k in ("aperture", "landmark_aperture")
    )
    classes: ColourClasses = face.learned("colour")
    apart = classes.separability
    return {
        "held_frames": int(sum(held)),
        "landmark_distance_mm": float(np.median(off)),
        "aperture_difference_mm": float(np.sqrt(np.mean((drawn - seen) ** 2))),
        "contradicted_frames": int(sum(against)),
        "separability": dict(apart),
        "colour_agreement": classes.agreement,
        "colour_weight": classes.weight,
        "warnings": doubts(against, held, apart, classes.agreement, classes.chromatic),
    }
