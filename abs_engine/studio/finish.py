"""From chunks to a data set: gathers numbers, encodes videos, writes card and checksums."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from abs_engine.core.clock import Clock, write_timing
from abs_engine.core.provenance import made_by
from abs_engine.dataset import (
    ClipEntry,
    camera_json,
    dataset_record,
    write_points,
    write_sums,
    write_truth,
)
from abs_engine.dataset.card import card_text
from abs_engine.dataset.coco import coco
from abs_engine.dataset.codec import (
    CAMERA,
    CLOSED_BELOW,
    COCO,
    DATASET,
    FRAMES,
    README,
    VIDEO,
    frame_name,
)
from abs_engine.dataset.picture import read_picture
from abs_engine.io.assets import LIPS_OF_68, Speaker
from abs_engine.io.naming import rename_new
from abs_engine.io.npz import read_npz
from abs_engine.io.video import VideoWriter
from abs_engine.studio.chunk import FORMAT, VERSION, Job, seconds_of
from abs_engine.studio.plan import ClipPlan, View

_LANDMARKS = ("outer_lip", "outer_lip_20", "inner_lip_8", "mouth_corners")
_SUMMED = ("boxes", "areas", "gap")
Advance = Callable[[], None]


def finish_clip(
    plan: ClipPlan,
    jobs: list[Job],
    chunks: Path,
    dataset: Path,
    speaker: Speaker,
    *,
    keep_frames: bool,
    advance: Advance,
    clock: Clock,
) -> None:
    """Write a clip's numbers and videos from its chunks.

    Parameters
    ----------
    jobs : list of Job
        Those of the clip, whose numbers are in `chunks`.
    dataset : Path
        Folder of the data set in the making.
    keep_frames : bool
        Whether the pictures stay when they are encoded.
    clock : Clock
        Gets the seconds by part that filming took.
    """
    for number, view in enumerate(plan.views):
        left = [chunks / job.name for job in jobs if job.view == number]
        parts = [read_npz(path, FORMAT, VERSION) for path in left]
        for part in parts:
            for name, seconds in seconds_of(part).items():
                clock.seconds[name] += seconds
        names = [n for n in parts[0] if n not in ("format", "version") and "seconds_" not in n]
        numbers = {name: np.concatenate([part[name] for part in parts]) for name in names}
        if number == 0:
            write_truth(dataset / plan.name, **truth_arrays(plan, speaker, numbers["gap"]))
        finish_view(plan, view, numbers, dataset / plan.name / view.name)
        encode(plan, view, dataset / plan.name / view.name, advance)
        if not keep_frames:
            shutil.rmtree(dataset / plan.name / view.name / FRAMES, ignore_errors=True)


def truth_arrays(plan: ClipPlan, speaker: Speaker, gap: Any) -> dict[str, Any]:
    """Arrays of ``truth.npz``."""
    labels = [interval[0] for interval in plan.intervals]
    return {
        "rate": plan.rate,
        "seed": plan.seed,
        "person": plan.person,
        "sentence": plan.sentence,
        "command": plan.command,
        "unit_names": speaker.unit_names,
        "unit_weights": plan.weights,
        "identity_weights": plan.identity_weights,
        "neutral": plan.neutral,
        "faces": speaker.faces,
        "facet_class": speaker.facet_class,
        "class_names": speaker.class_names,
        "uv": speaker.uv,
        "rotations": plan.rotations,
        "translations": plan.translations,
        "phonemes": np.array(plan.phonemes, np.str_),
        "phoneme_label": np.array(labels, np.str_),
        "phoneme_start": np.array([i[1] for i in plan.intervals], np.float64),
        "phoneme_end": np.array([i[2] for i in plan.intervals], np.float64),
        "gap": np.asarray(gap, np.float64),
        "closed": np.asarray(gap < CLOSED_BELOW),
        "dots": plan.dots,
        "landmark_68": speaker.points["landmark_68"],
        **{name: speaker.landmarks[name] for name in _LANDMARKS},
    }


def finish_view(plan: ClipPlan, view: View, numbers: dict[str, Any], folder: Path) -> None:
    """Write ``camera.json``, ``points.npz`` and ``coco.json`` of a camera."""
    text = camera_json(view.camera, view.rotations, view.translations, view.mirror)
    (folder / CAMERA).write_text(text, encoding="utf-8")
    arrays = {k: v for k, v in numbers.items() if k not in _SUMMED}
    for prefix in ("", "mirror_"):
        if f"{prefix}landmark_pixels" in arrays:
            for what in ("pixels", "visible"):
                arrays[f"{prefix}lip_{what}"] = arrays[f"{prefix}landmark_{what}"][:, LIPS_OF_68]
    write_points(folder, **arrays, in_picture=numbers["areas"] > 0)
    labels = coco(
        [f"{FRAMES}/{frame_name(i)}" for i in range(len(plan))],
        view.camera.size,
        numbers["landmark_pixels"],
        numbers["landmark_visible"],
        numbers["boxes"],
        numbers["areas"],
    )
    (folder / COCO).write_text(json.dumps(labels) + "\n", encoding="utf-8")


def encode(plan: ClipPlan, view: View, folder: Path, advance: Advance) -> None:
    """Encode the pictures of a camera as its video; nothing is done if that was done before."""
    made, size = folder / f".{VIDEO}", view.camera.size
    if (folder / VIDEO).is_file():
        for _ in range(len(plan)):
            advance()
        return
    with VideoWriter(made, size, plan.rate, view.crf) as video:
        for frame in range(len(plan)):
            video.write(read_picture(folder / FRAMES / frame_name(frame), FRAMES, size))
            advance()
    rename_new(made, folder / VIDEO)


def clip_entry(plan: ClipPlan) -> ClipEntry:
    """A clip as ``dataset.json`` lists it."""
    cameras = tuple(view.name for view in plan.views)
    return ClipEntry(plan.name, plan.person, plan.sentence, len(plan), plan.rate, cameras)


def finish_dataset(
    dataset: Path,
    clips: list[ClipEntry],
    *,
    command: str,
    seed: int,
    labels: tuple[str, ...],
    seconds: dict[str, float],
) -> None:
    """Write what tells of the whole: ``dataset.json``, the card, timing and checksums."""
    frames = sum(clip.frames * len(clip.cameras) for clip in clips)
    cost = {name: round(1000 * value / max(frames, 1), 3) for name, value in seconds.items()}
    made = made_by()
    record = dataset_record(
        command=command,
        seed=seed,
        engine=made["engine_version"],
        commit=made["commit"],
        dirty=made["dirty"],
        clips=clips,
        labels=("ids", "depth", *labels),
    )
    (dataset / DATASET).write_text(json.dumps(record, indent=1) + "\n", encoding="utf-8")
    (dataset / README).write_text(card_text(record), encoding="utf-8")
    write_timing(dataset, {"milliseconds_per_frame": cost})
    write_sums(dataset)
