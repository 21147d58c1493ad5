"""Every table and figure of Basu et al. (1998) on our own data, beside the paper's numbers."""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from abs_engine.core.clock import write_timing
from abs_engine.core.errors import InputFileError
from abs_engine.core.provenance import made_by
from abs_engine.core.scene import Renderer
from abs_engine.dataset.view import Truth
from abs_engine.io.assets import load_speaker
from abs_engine.io.files import png
from abs_engine.learn.cameras import camera_results
from abs_engine.learn.reconstruction import table_1
from abs_engine.learn.training import train
from abs_engine.papers.basu1998.collected import BEST, Report, fit_figures
from abs_engine.papers.basu1998.experiment import (
    OBSERVED,
    TrainedLips,
    learn_lips,
    placed_by_blob,
    pose_estimated,
    pose_known,
    rms_of,
)
from abs_engine.papers.basu1998.figures import draw_dots, draw_modes
from abs_engine.papers.basu1998.filmed import (
    FILMED,
    FRONT,
    FULL,
    QUICK,
    YAWS,
    camera_name,
    film,
    learn_colours,
)
from abs_engine.papers.basu1998.incremental_training import (
    further_trained,
    lip_clip,
    with_sample_variances,
)
from abs_engine.papers.basu1998.motion import (
    AUTHORED,
    UNROUNDED,
    observed_motion,
    recorded_or_authored,
    recording_path,
)
from abs_engine.papers.basu1998.page import reproduction_page
from abs_engine.papers.basu1998.real_clips import grid_agreement
from abs_engine.papers.basu1998.recorded_training import recorded_training
from abs_engine.papers.basu1998.summary import (
    FURTHER,
    REMARKS,
    WAYS,
    Fits,
    fitted,
    seconds,
)
from abs_engine.papers.basu1998.viseme_information import SYLLABLES, viseme_information

QUICK_SYLLABLES = 30
"""Of each person, for `viseme_information`."""
SPARSE = {"forces_as_printed": 5, "simplex_one_sample": 5}
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
    folder, kept, tell
        As of `Report`; the folder exists, and is empty or as an interrupted run left it.
    quick : bool
        One person, few frames, and no real clips.

    Returns
    -------
    dict
        What ``results.json`` holds.
    """
    begun = time.perf_counter()
    amount, speaker = QUICK if quick else FULL, load_speaker()
    report = Report(folder, kept, renderer, speaker, seed, tell, amount)
    tell("learning from dots")
    _learned(report, amount.people[0])
    tell("reading visemes")
    syllables = QUICK_SYLLABLES if quick else SYLLABLES
    report.results["viseme_information"] = viseme_information(speaker, seed, syllables)
    tell("filming heads without dots")
    views = film(amount, folder / FILMED, seed)
    fits = Fits([], [], [], [])
    for person in amount.people:
        own = {key[1:]: view for key, view in views.items() if key[0] == person}
        lips, sides = _fit_person(report, fits, person, own)
        if person == amount.people[0]:
            fit_figures(report, lips, sides, fits.known)
    fitted(report, fits, len(amount.people) * len(YAWS) * amount.test)
    report.results["recorded"] = _recorded(report)
    tell("real clips")
    grid = None if quick else grid_agreement(renderer, tell, kept / "grid")
    report.results |= {
        "grid": grid or {"closure_precision": None, "closure_recall": None},
        "people": list(amount.people), "quick": quick, "seed": seed,
        "command": f"abs-engine reproduce 000{' --quick' if quick else ''} --seed {seed}",
        "renderer": renderer.description, **made_by(),
    }  # fmt: skip
    took = round(time.perf_counter() - begun, 1)
    write_timing(folder, {"seconds": took, "seconds_per_frame": seconds(fits.known)})
    (folder / "results.json").write_text(json.dumps(report.results, indent=2) + "\n")
    page = reproduction_page(report.results, report.figures, report.remarks)
    (folder / "index.html").write_text(page)
    return report.results


def _fit_person(
    report: Report, fits: Fits, person: str, views: Mapping[tuple[str, str], Truth]
) -> tuple[TrainedLips, dict[str, Truth]]:
    """Add the fits of a person's views by kind of clip and camera; the lips, and the test clips."""
    speaker, renderer, tell = report.speaker, report.renderer, report.tell
    kept = report.kept / person
    tell(f"learning {person}'s lips and colours")
    seen = [views["colours", camera_name(y)] for y in (YAWS[0], 0, YAWS[-1])]
    lips = learn_lips(speaker, person, learn_colours(seen), report.seed)
    sides = {camera_name(y): views["test", camera_name(y)] for y in YAWS}
    for name, driver, rule, score in WAYS:
        tell(f"fitting {person} by {name.replace('_', ' ')}")
        step = SPARSE.get(name, 1)
        found = pose_known(lips, sides, renderer, driver, rule, score, step, kept / name)
        fits.known.extend(replace(e, driver=name) for e in found)
    tell(f"fitting {person} from the blob, and moving")
    fits.blob.extend(placed_by_blob(lips, sides, renderer, kept / "blob"))
    turning = views["moving", FRONT]
    fits.moving.extend(pose_estimated(lips, speaker, turning, renderer, BEST, kept))
    tell(f"training {person}'s lips further")
    fits.further.append(_further(report, lips, seen, sides[FRONT]))
    return lips, sides


def _recorded(report: Report) -> dict[str, Any] | None:
    """The paper's own training on other motion, of all people; None without the recording."""
    if not report.amount.recorded:
        return None
    try:
        path = recording_path()
    except InputFileError:
        return None
    return recorded_training(report, list(report.speaker.people), path)


def _learned(report: Report, person: str) -> None:
    """Sections 3, 4 and 6.2: ten modes, figure 2 and table 1."""
    speaker, renderer, seed = report.speaker, report.renderer, report.seed
    motion, told = recorded_or_authored(speaker, person), "the recording of a real face"
    if motion.source == AUTHORED:
        told = "authored speech, as the recording is not there"
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
    report.figure(
        "figure1.png", png(draw_dots(renderer, done.shell, done.correspondence)),
        "Figure 1: where the sixteen dots of the lips are on the shell; one more is on the nose.",
    )  # fmt: skip
    report.figure(
        "figure2.png", png(draw_modes(renderer, done.shell, done.physics)),
        "Figure 2: the mean displacement and the first modes, two standard deviations each way.",
    )  # fmt: skip
    report.remarks += [
        f"The dots are moved by {told}; {OBSERVED:g} mm of noise are added to each coordinate, "
        "about what filmed sessions have. 140 frames are learned from, the next ten tested on.",
        *REMARKS,
    ]


def _further(
    report: Report, lips: TrainedLips, clips: Sequence[Truth], test: Truth
) -> tuple[float, ...]:
    """Error on the test, mm, by each of `FURTHER`, of lips that five seconds of dots gave."""
    speaker, renderer, kept = report.speaker, report.renderer, report.kept / lips.person
    motion = recorded_or_authored(speaker, lips.person, UNROUNDED)  # leaves much to be learned
    before = learn_lips(speaker, lips.person, lips.classes, report.seed, motion)
    after = further_trained(before, [lip_clip(before, clips, renderer)])[0]
    each = dict(zip(FURTHER, (with_sample_variances(before), before, after), strict=True))
    return tuple(
        rms_of(list(pose_known(x, {FRONT: test}, renderer, BEST, kept=kept / name)))
        for name, x in each.items()
    )
