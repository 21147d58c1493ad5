"""Lips that speak, drawn from several sides: clips without dots, and runs of them."""

from __future__ import annotations

import json
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
from heads import SIZE, colours_of, head_of, picture_of, seen_at
from runs import toy_result, toy_setting

from abs_engine.core.camera import Camera
from abs_engine.core.geometry import Pose
from abs_engine.dataset.sums import digest
from abs_engine.face.appearance.colour import ColourClasses
from abs_engine.fit.shell import shell_colours
from abs_engine.fit.shell_relaxation import Seen
from abs_engine.io.assets import load_speaker
from abs_engine.io.video import VideoWriter
from abs_engine.learn.further import LipClip
from abs_engine.papers.basu1998.experiment import TrainedLips, learn_lips
from abs_engine.papers.basu1998.motion import UNROUNDED, authored_motion
from abs_engine.render.cpu import CpuRenderer
from abs_engine.tracking.results.run_mesh import RunMesh
from abs_engine.tracking.runs.recorder import Recorder

CAMERA = Camera.ideal(SIZE)
SPEAKER = load_speaker()
FRONT, LEFT, RIGHT = (seen_at([0, yaw, 0], [0, 0, 560]) for yaw in (0.0, 0.7, -0.7))
SAID = authored_motion(SPEAKER, "clara", frames=30, sentences=("_ S u: f O: w u: _",))
HEADS = SAID.vertices(SPEAKER)


@cache
def lips() -> TrainedLips:
    """Lips that never saw rounding."""
    motion = authored_motion(SPEAKER, "clara", frames=60, sentences=UNROUNDED)
    return learn_lips(SPEAKER, "clara", classes(), 0, motion)


@cache
def classes() -> ColourClasses:
    """Clara's colours."""
    return colours_of(head_of("clara"), FRONT, CAMERA)


@cache
def picture(frame: int, pose: Pose) -> np.ndarray:
    """A frame of `SAID`."""
    return picture_of(replace(head_of("clara").head, mean=HEADS[frame]), pose, CAMERA)


@cache
def seen(frame: int, pose: Pose) -> Seen:
    """A frame as evidence about the lips."""
    setting = lips().setting(CAMERA, CpuRenderer())
    return Seen(shell_colours(setting, picture(frame, pose), pose), pose)


def clip(frames: range, poses: tuple[Pose, ...]) -> LipClip:
    """Some frames of `SAID`, seen from some sides at once."""
    moments = tuple(tuple(seen(k, pose) for pose in poses) for k in frames)
    return LipClip(lips().model, moments, np.zeros((len(frames), len(lips().model.shell), 3)))


def write_lip_run(folder: Path, frames: range, pose: Pose) -> Path:
    """A run whose mesh is the truth, about the average of speech, and its video beside it."""
    folder.mkdir()
    video = folder.with_suffix(".mp4")
    recorder = Recorder(replace(toy_setting(), camera=CAMERA))
    with VideoWriter(video, SIZE, 25.0) as writer:
        for index, frame in enumerate(frames):
            writer.write(picture(frame, pose))
            recorder.add(replace(toy_result(index), pose=pose))
    np.savez(folder / "results.npz", **recorder.record().arrays)
    mean, rest = HEADS.mean(axis=0), SPEAKER.named("clara")
    moved = HEADS[list(frames)] - mean
    RunMesh(mean, moved, np.eye(len(frames)), SPEAKER.faces, rest).save(folder)
    classes().save(folder / "colours.npz")
    settings = {
        "video": video.name, "video_sha256": digest(video), "model": "head",
        "scale": {"pupils": 63.4},
    }  # fmt: skip
    (folder / "run.json").write_text(json.dumps({"settings": settings}))
    return folder
