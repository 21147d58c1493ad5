"""Summary of a run: counts of its frames, means, agreement with the landmarks, and warnings."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from abs_engine.face.appearance.colour import ColourClasses
from abs_engine.face.base import Face
from abs_engine.fit.opening import NAME as OPENING
from abs_engine.fit.shading import NAME as SHADED
from abs_engine.fit.terms import LOOKS
from abs_engine.tracking.detection.shot_cuts import anew_line, cut_line
from abs_engine.tracking.frame.clip_setting import HELD, ClipSetting
from abs_engine.tracking.results.less_explained import partly_explained
from abs_engine.tracking.results.run_warnings import (
    all_closed,
    close_up,
    doubts,
    little_explained,
    mostly_lost,
    reasons_lost,
    small_mouth,
    unlike_shots,
    untimed,
    without_colour,
)
from abs_engine.tracking.settings.detection import DETECTION


def summary(
    arrays: Mapping[str, NDArray[Any]], setting: ClipSetting, seen: Sequence[str] = ()
) -> dict[str, Any]:
    """Counts of frames; mean evaluations and score of the tracked. Covered ones are lost.

    The arrays are as ``results.npz`` has them; `seen` are warnings of what frames' pictures
    show beside what is drawn.
    """
    face = setting.face
    found, cuts = arrays["found"], arrays["index"][arrays["cut"]].tolist()
    small = small_mouth(_mouth_width(arrays))
    worn = OPENING in arrays["term_names"]
    near = [] if worn else close_up(_pixel(arrays), setting.camera.size)
    landmarks = _by_landmarks(arrays, face, bool(small))
    shots = _shots(arrays)
    scores = arrays["score"][found & np.isfinite(arrays["score"])]
    score = float(scores.mean()) if len(scores) else None  # where no evidence says
    source = score_of(arrays["term_names"].tolist(), face.name)
    little = little_explained(source or "colour", score)
    lost = mostly_lost(found, arrays["status"])
    shut = all_closed(arrays["closed"][found], arrays["time"][found])
    grey = without_colour(arrays["status"])
    dropped = not np.array_equal(arrays["index"], np.arange(len(found)))  # by a camera
    timed = [] if dropped else untimed(len(found), len(setting.times))
    less = arrays["less_explained"]
    partly = partly_explained(less[found], arrays["index"][found])
    lost += unlike_shots(found, arrays["status"], arrays["cut"], arrays["index"])
    told = landmarks.get("warnings", ())
    doubted = [*lost, *little, *partly, *seen, *shut, *grey, *told]
    hints = [setting.hint] if doubted and setting.hint else []
    warnings = [*setting.warnings, *timed, *shots, *small, *near, *doubted, *hints]
    work = arrays["evaluations"][found]
    return {
        "frames": len(found),
        "lost_frames": len(found) - len(work),
        "lost_reasons": reasons_lost(found, arrays["status"]),
        "covered_frames": int(arrays["covered"].sum()),
        "closed_frames": int(arrays["closed"].sum()),
        "less_explained_frames": int(less.sum()),
        "mean_evaluations": float(work.mean()) if len(work) else 0.0,
        "mean_score": score,
        **({"score_of": source} if source else {}),
        **landmarks,
        "cuts": cuts,
        "warnings": warnings,
    }


def _shots(arrays: Mapping[str, NDArray[Any]]) -> list[str]:
    """Lines about frames that begin another shot, or may show another person."""
    index, seen = arrays["index"], np.isfinite(arrays["translation"][:, 2])
    begun, long = np.flatnonzero(arrays["cut"]), DETECTION.patience + 1
    gone = [k for k in begun if seen[k] and seen[:k].any() and not seen[max(k - long, 0) : k].any()]
    anew, cuts = index[gone].tolist(), index[np.setdiff1d(begun, gone)].tolist()
    return [*([cut_line(cuts)] if cuts else []), *([anew_line(anew)] if anew else [])]


def score_of(terms: Sequence[str], model: str) -> str:
    """Name of what scores compare, as results state it: a head's colours'; empty without terms."""
    if not terms:
        return ""
    name = next((term for term in terms if term != SHADED), terms[0])
    return name if model == "head" else f"{model}: {name}"


def _mouth_width(arrays: Mapping[str, NDArray[Any]]) -> float:
    """Width of the mouth in the median tracked frame, px; NaN without any."""
    found = arrays["found"]
    if not found.any():
        return float("nan")
    away = arrays["translation"][found, 2]
    return float(np.median(arrays["camera_matrix"][0, 0] * arrays["width"][found] / away))


def _pixel(arrays: Mapping[str, NDArray[Any]]) -> float:
    """Millimetres that a pixel covers at the head in the median tracked frame; NaN without any."""
    away = arrays["translation"][arrays["found"], 2]
    return float(np.median(away) / arrays["camera_matrix"][0, 0]) if len(away) else float("nan")


def _by_landmarks(
    arrays: Mapping[str, NDArray[Any]], face: Face, small: bool = False
) -> dict[str, Any]:
    """Agreement of landmarks and colours, where landmarks were asked of a mouth, small or not.

    Colours are doubted unless a learned appearance is compared in their place.
    """
    asked = arrays["found"] & np.isfinite(arrays["landmark_aperture"])
    if not asked.any() or "colour" not in face.appearance:
        return {}
    held, against = arrays["status"][asked] == HELD, arrays["contradicted"][asked]
    off, drawn, seen = (
        arrays[k][asked] for k in ("landmark_distance", "aperture", "landmark_aperture")
    )
    classes: ColourClasses = face.learned("colour")
    apart, agreement = classes.separability, classes.agreement
    names = set(arrays["term_names"].tolist())
    if "colour" in names or names.isdisjoint(LOOKS):
        told = doubts(
            against, held, apart, agreement, classes.chromatic, classes.exposure, small,
            classes.blue,
        )  # fmt: skip
    else:
        told = doubts(against, held, {})
    return {
        "held_frames": int(held.sum()),
        "landmark_distance_mm": float(np.median(off)),
        "aperture_difference_mm": float(np.sqrt(np.mean((drawn - seen) ** 2))),
        "contradicted_frames": int(against.sum()),
        "separability": dict(apart),
        "colour_agreement": agreement,
        "colour_weight": classes.weight,
        "warnings": told,
    }
