"""The demo: a clip with known truth is filmed, tracked, compared with the truth, and reported."""

from __future__ import annotations

import shutil
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from abs_engine.core.provenance import code_digest, made_by
from abs_engine.core.scene import Renderer
from abs_engine.dataset import Truth, load_truth
from abs_engine.evaluate.catalogue import warn_of_faults
from abs_engine.evaluate.metrics.pose import position_errors
from abs_engine.evaluate.score import Score
from abs_engine.evaluate.score_table import as_json, shown, title, used
from abs_engine.evaluate.truth_report import draw
from abs_engine.io.naming import made_before
from abs_engine.io.unfinished import Unfinished, kept_if_of_use
from abs_engine.report.demo_page import camera_error, demo_page, head_given
from abs_engine.report.facts import origins
from abs_engine.report.scoring import SCORES, run_scores
from abs_engine.studio.filming import film_scene
from abs_engine.studio.make import Crew
from abs_engine.studio.scenefile import Label, sentence_scene
from abs_engine.tracking.options import TrackOptions
from abs_engine.tracking.run import track_video
from abs_engine.tracking.runs.output import Progress, read_facts
from abs_engine.tracking.runs.record import load_run

CLIP, RUN, EVALUATION, PAGE = "clip", "run", "evaluation", "index.html"
SHOWN = (
    "frames", "frames_lost", "lip_points_rms_head_mm", "lip_points_rms_head_offset_removed_mm",
    "lip_points_rms_camera_mm", "head_angle_rms_deg", "head_position_rms_mm", "aperture_rms_mm",
    "aperture_bias_mm", "aperture_correlation", "width_rms_mm", "width_bias_mm",
    "width_correlation", "closure_precision_frames", "closure_recall_frames",
)  # fmt: skip
"""Metrics on the demo's page."""


@dataclass(frozen=True)
class DemoOptions:
    """Options of the demo: its film, and the knowledge given to the tracker.

    Parameters
    ----------
    size : tuple of int
        Pixels.
    person_known : bool
        Track with the filmed person's own head, the speaker-specific case; otherwise with the
        average head, whose mouth is fitted to the clip. The camera is calibrated in both cases.
    """

    person: str = "clara"
    sentence: str = "demo"
    size: tuple[int, int] = (640, 480)
    frames: int = 50
    seed: int = 1
    person_known: bool = True


@dataclass(frozen=True)
class DemoResult:
    """Results of the demo.

    Parameters
    ----------
    folder : Path
        Holds ``index.html``.
    run : dict
        What ``run/run.json`` holds, and `timing`.
    scores : dict of str to Score
        By the name of the metric.
    remarks : tuple of str
        Which head was given, and what to know about the numbers.
    """

    folder: Path
    run: dict[str, Any]
    scores: dict[str, Score]
    remarks: tuple[str, ...]


def run_demo(
    folder: Path,
    renderer: Renderer,
    options: DemoOptions = DemoOptions(),
    filming: Progress | None = None,
    tracking: Progress | None = None,
    prepared: Callable[[float], None] | None = None,
    stage: Callable[[str], None] | None = None,
) -> DemoResult:
    """Film, track, evaluate and report.

    What was done when the process was killed is kept beside the folder: called again with the same
    options, it goes on there.

    Parameters
    ----------
    folder : Path
        Must not exist; it appears when everything is written.
    renderer : Renderer
        What the tracker draws with; the studio has its own.
    filming, tracking : callable, optional
        Called after every frame with the number of frames done and of all frames.
    prepared : callable, optional
        Called before the first frame is tracked with the seconds that the preparation took.
    stage : callable, optional
        Called with what the tracker's preparation begins, in a few words.

    Raises
    ------
    OutputError
        If the folder exists or cannot be written; `SameOutputError` if it is this demo, whole.
    StudioError
        If the studio cannot draw on this machine.
    """
    choices = f"{options}\n{renderer.description}\n{code_digest()}"
    with Unfinished(folder, choices, anew="demo") as made, kept_if_of_use(made, made.work):
        clip, run_folder, evaluation = (made.work / part for part in (CLIP, RUN, EVALUATION))
        if not made_before(clip):
            film_clip(
                clip, options.sentence, person=options.person, size=options.size,
                frames=options.frames, seed=options.seed, command="abs-engine demo",
                progress=filming, keep=True,
            )  # fmt: skip
        truth = load_truth(clip)
        known = options.person if options.person_known else None
        choice = TrackOptions(person=known, camera=truth.camera)
        if made_before(run_folder):
            run = read_facts(run_folder)
        else:
            run = track_video(truth.video, run_folder, renderer, choice, tracking, prepared, stage)
        scores, remarks = _evaluated(run_folder, truth, evaluation, options)
        video = truth.video.relative_to(made.work).as_posix()
        sources = origins({RUN: run_folder}, clip)
        page = demo_page(options.person, video, run, score_rows(scores), remarks, sources)
        (made.work / PAGE).write_text(page, encoding="utf-8")
        made.finish()
    return DemoResult(Path(folder), run, scores, remarks)


def _evaluated(
    run_folder: Path, truth: Truth, folder: Path, options: DemoOptions
) -> tuple[dict[str, Score], tuple[str, str]]:
    """Scores of a run, written into a folder of their own, and remarks on them."""
    shutil.rmtree(folder, ignore_errors=True)  # of a process killed just then
    folder.mkdir()
    arrays = load_run(run_folder)
    warn_of_faults()
    scores = run_scores(run_folder, truth)
    (folder / SCORES).write_text(as_json({RUN: scores}, made_by()), encoding="utf-8")
    draw(arrays, truth, folder)
    away = position_errors(arrays["translation"], truth.translations)
    return scores, (head_given(options.person, options.person_known), camera_error(*away))


def film_clip(
    folder: Path,
    sentence: str,
    *,
    person: str,
    size: tuple[int, int],
    frames: int | None = None,
    seed: int = 0,
    lossless: bool = False,
    labels: tuple[Label, ...] = (),
    command: str = "",
    progress: Progress | None = None,
    keep: bool = False,
) -> Path:
    """Film a bundled person with one ideal camera; see `abs_engine.studio.filming.film_scene`.

    Parameters
    ----------
    folder : Path
        Must not exist.
    sentence : str
        Name of a built-in sentence, or viseme symbols between spaces.
    size : tuple of int
        Width and height, even.
    frames : int, optional
        By default as many as the sentence takes.
    seed : int
        Of head motion, blinks and sensor noise.
    lossless : bool
        Also keep every picture as it was before compression.
    labels : tuple of {"normals", "albedo", "flow"}
        Label pictures that are written besides ids and depth.
    command : str
        Kept in the ground truth.
    keep : bool
        Whether what was filmed stays when it is interrupted, for the next call to go on from.

    Raises
    ------
    ParameterError
        If a value is of another kind, or there is no such sentence, person or label.
    """
    scene = sentence_scene(
        sentence, person=person, size=size, frames=frames, seed=seed, lossless=lossless,
        labels=labels,
    )  # fmt: skip
    return film_scene(scene, folder, command=command, crew=Crew(filming=progress, keep=keep)).folder


def score_rows(scores: Mapping[str, Score]) -> list[tuple[str, str]]:
    """Measures against the truth, each with its number, its interval and its unit."""
    metrics = [metric for metric in used([scores]) if metric.key in SHOWN]
    return [(title(one), " ".join(shown(one, scores[one.key])).rstrip()) for one in metrics]


def score_lines(scores: Mapping[str, Score]) -> list[str]:
    """`score_rows` as lines for a terminal."""
    return [f"{name:50} {number}" for name, number in score_rows(scores)]
