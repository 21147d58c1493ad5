"""Every table and figure of Basu et al. (1998) on our own data, beside the paper's numbers."""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from abs_engine.compare.forces import Rule as Integral
from abs_engine.core.clock import write_timing
from abs_engine.core.errors import InputFileError
from abs_engine.core.provenance import made_by
from abs_engine.core.scene import Renderer
from abs_engine.dataset.view import Truth
from abs_engine.io.assets import Speaker, load_speaker
from abs_engine.learn.cameras import camera_results
from abs_engine.learn.reconstruction import table_1
from abs_engine.learn.training import train
from abs_engine.papers.basu1998.collected import BEST, Report, fit_figures
from abs_engine.papers.basu1998.experiment import (
    OBSERVED,
    FrameError,
    TrainedLips,
    converged,
    learn_lips,
    placed_by_blob,
    pose_estimated,
    pose_known,
    rms_of,
)
from abs_engine.papers.basu1998.figures import draw_dots, draw_modes
from abs_engine.papers.basu1998.filmed import (
    FRONT,
    FULL,
    QUICK,
    YAWS,
    camera_name,
    film,
    learn_colours,
)
from abs_engine.papers.basu1998.incremental_training import (
    further_motion,
    further_trained,
    lip_clip,
    with_sample_variances,
)
from abs_engine.papers.basu1998.motion import (
    Motion,
    authored_motion,
    observed_motion,
    recorded_motion,
    recording_path,
)
from abs_engine.papers.basu1998.page import reproduction_page
from abs_engine.papers.basu1998.real_clips import grid_agreement
from abs_engine.papers.basu1998.remarks import REMARKS, WINDOWS
from abs_engine.papers.basu1998.single_frames import AS_PRINTED
from abs_engine.papers.basu1998.viseme_information import SYLLABLES, viseme_information

WAYS: tuple[tuple[str, str, str, Integral], ...] = (
    ("forces", "forces", "whole", "exact"),
    ("forces_one_sample", "forces", "sample", "sample"),
    ("forces_exact", "forces", "exact", "exact"),
    ("gradient", "gradient", "whole", "exact"),
    ("simplex", "simplex", "whole", "exact"),
    ("simplex_one_sample", "simplex", "whole", "sample"),
)
"""Name in the results, driver, rule of the forces, and how the posterior is integrated (5.4)."""
LITERAL = "forces_as_printed"
"""One fixed step from one start, the mean shape: eqs. 8, 10, 12 and 13 as they are printed."""
FURTHER = ("before_mm", "cross_validated_mm", "after_mm")
"""Lips of five seconds of dots with the variances of these, with cross-validated ones, and after
further training."""
QUICK_SYLLABLES = 30
"""Of each person, for `viseme_information`."""
SPARSE = {LITERAL: 5, "simplex_one_sample": 5}
"""Every how many frames are fitted where that takes long: one sample is not fused into drawing."""


def reproduce(
    folder: Path,
    kept: Path,
    renderer: Renderer,
    *,
    quick: bool,
    seed: int,
    tell: Callable[[str], None],
) -> dict[str, Any]:
    """Fill a folder with tables, figures, ``results.json``, ``timing.json`` and ``index.html``.

    Parameters
    ----------
    folder : Path
        Exists, and is empty or as an interrupted run left it.
    kept : Path
        Gets the fits, frame by frame, and has those of an interrupted run.
    renderer : Renderer
    quick : bool
        One person, few frames, and no real clips.
    seed : int
    tell : callable
        Called with what is begun.

    Returns
    -------
    dict
        What ``results.json`` holds.
    """
    begun = time.perf_counter()
    amount, speaker, report = QUICK if quick else FULL, load_speaker(), Report(folder)
    tell("learning from dots")
    _learned(report, speaker, amount.people[0], renderer, seed)
    tell("reading visemes")
    syllables = QUICK_SYLLABLES if quick else SYLLABLES
    report.results["viseme_information"] = viseme_information(speaker, seed, syllables)
    tell("filming heads without dots")
    views = film(amount, folder / "filmed", seed)
    known: list[FrameError] = []
    blob, moving = [], []
    further: list[tuple[float, ...]] = []
    for person in amount.people:
        tell(f"learning {person}'s lips and colours")
        seen = [views[person, "colours", camera_name(y)] for y in (YAWS[0], 0, YAWS[-1])]
        lips = learn_lips(speaker, person, learn_colours(seen), seed)
        sides = {camera_name(y): views[person, "test", camera_name(y)] for y in YAWS}
        for name, driver, rule, score in WAYS:
            tell(f"fitting {person} by {name.replace('_', ' ')}")
            step = SPARSE.get(name, 1)
            own = kept / person / name
            fits = pose_known(lips, sides, renderer, driver, rule, score, step, own)
            known += _named(name, fits)
        tell(f"fitting {person} by forces as printed")
        step, own = SPARSE[LITERAL], kept / person / LITERAL
        fits = pose_known(lips, sides, renderer, AS_PRINTED, "sample", "sample", step, own)
        known += _named(LITERAL, fits)
        tell(f"fitting {person} from the blob, and moving")
        blob += list(placed_by_blob(lips, sides, renderer, "forces", kept / person / "blob"))
        turning, own = views[person, "moving", FRONT], kept / person
        moving += list(pose_estimated(lips, speaker, turning, renderer, BEST, own))
        tell(f"training {person}'s lips further")
        further.append(_further(speaker, lips, seen, sides[FRONT], renderer, seed, own))
        if person == amount.people[0]:
            fit_figures(report, lips, sides, known, renderer)
    _fitted(report, known, blob, len(amount.people) * len(YAWS) * amount.test, moving, further)
    tell("real clips")
    grid = None if quick else grid_agreement(renderer, tell, kept / "grid")
    report.results["grid"] = grid or {"closure_precision": None, "closure_recall": None}
    report.results |= _circumstances(amount.people, renderer, quick, seed)
    took = round(time.perf_counter() - begun, 1)
    write_timing(folder, {"seconds": took, "seconds_per_frame": _seconds(known)})
    (folder / "results.json").write_text(json.dumps(report.results, indent=2) + "\n")
    page = reproduction_page(report.results, report.figures, report.remarks)
    (folder / "index.html").write_text(page)
    return report.results


def _circumstances(
    people: Sequence[str], renderer: Renderer, quick: bool, seed: int
) -> dict[str, Any]:
    """By which command, of whom and by what the results were made."""
    return {
        "people": list(people), "quick": quick, "seed": seed,
        "command": f"abs-engine reproduce 000{' --quick' if quick else ''} --seed {seed}",
        "renderer": renderer.description, **made_by(),
    }  # fmt: skip


def _motion(speaker: Speaker, person: str) -> tuple[Motion, str]:
    """The recording if it is there, or the authored speech; and a remark."""
    try:
        return recorded_motion(speaker, person, recording_path()), "the recording of a real face"
    except InputFileError:
        return authored_motion(speaker, person), "authored speech, as the recording is not there"


def _learned(report: Report, speaker: Speaker, person: str, renderer: Renderer, seed: int) -> None:
    """Sections 3, 4 and 6.2: ten modes, figure 2 and table 1."""
    motion, told = _motion(speaker, person)
    done = train(observed_motion(speaker, motion, noise=OBSERVED, seed=seed), speaker, person)
    exact = train(observed_motion(speaker, motion), speaker, person)
    report.results |= {
        "motion": motion.source,
        "variance_10_modes": done.physics.held,
        "variance": [float(v) for v in done.physics.shares],
        "table1": {row.part.key: row.error for row in table_1(done)},
        "table1_without_noise": {row.part.key: row.error for row in table_1(exact)},
        "cameras": camera_results(done.physics, speaker),
    }
    report.picture(
        "figure1.png", draw_dots(renderer, done.shell, done.correspondence),
        "Figure 1: where the sixteen dots of the lips are on the shell; one more is on the nose.",
    )  # fmt: skip
    report.picture(
        "figure2.png", draw_modes(renderer, done.shell, done.physics),
        "Figure 2: the mean displacement and the first modes, two standard deviations each way.",
    )  # fmt: skip
    report.remarks += [
        f"The dots are moved by {told}; {OBSERVED:g} mm of noise are added to each coordinate, "
        "about what filmed sessions have. 140 frames are learned from, the next ten tested on. "
        + WINDOWS
        * motion.recorded,
        *REMARKS,
    ]


def _named(name: str, errors: Iterable[FrameError]) -> list[FrameError]:
    return [replace(e, driver=name) for e in errors]


def _further(
    speaker: Speaker,
    lips: TrainedLips,
    clips: Sequence[Truth],
    test: Truth,
    renderer: Renderer,
    seed: int,
    kept: Path,
) -> tuple[float, ...]:
    """Error on the test, mm, by each of `FURTHER`, of lips that five seconds of dots gave."""
    motion = further_motion(speaker, lips.person)
    before = learn_lips(speaker, lips.person, lips.classes, seed, motion)
    after = further_trained(before, [lip_clip(before, clips, renderer)])[0]
    each = dict(zip(FURTHER, (with_sample_variances(before), before, after), strict=True))
    return tuple(
        rms_of(list(pose_known(x, {FRONT: test}, renderer, BEST, kept=kept / name)))
        for name, x in each.items()
    )


def _fitted(
    report: Report,
    known: Sequence[FrameError],
    blob: Sequence[FrameError],
    filmed: int,
    moving: Sequence[FrameError],
    further: Sequence[tuple[float, ...]],
) -> None:
    """Sections 5 and 6.1 as numbers; `filmed` frames were there to be placed by the blob."""
    drivers: dict[str, dict[str, Any]] = {
        name: _driven([e for e in known if e.driver == name]) | {"posterior_rule": score}
        for name, _, _, score in WAYS
    }
    literal = [e for e in known if e.driver == LITERAL]
    drivers[LITERAL] = _driven(literal) | {"posterior_rule": "sample"}
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
        "further_training": _trained(further),
    }  # fmt: skip


def _trained(further: Sequence[tuple[float, ...]]) -> dict[str, float]:
    """Errors of all people by each of `FURTHER`, mm, and what is left of the first."""
    rms = np.sqrt(np.mean(np.square(further), axis=0))
    left = {"left": float(rms[-1] / rms[0])}
    return {**dict(zip(FURTHER, map(float, rms), strict=True)), **left}


def _seconds(errors: Sequence[FrameError]) -> dict[str, float | None]:
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
