"""Runs as clips that learned physics goes on learning from: pictures, poses, colours, lips."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from abs_engine.capture.settings import CAPTURE
from abs_engine.core.arrays import BoolArray, FloatArray, evenly
from abs_engine.core.errors import (
    InputFileError,
    ModelFormatError,
    ParameterError,
    TooFewFramesError,
)
from abs_engine.core.scene import Renderer
from abs_engine.dataset.sums import check_distinct, digest
from abs_engine.face.appearance.colour import ColourClasses
from abs_engine.face.shape.lip_model import LipModel
from abs_engine.face.shape.lip_shell import LipShell
from abs_engine.face.shape.modal import LearnedPhysics, load_physics
from abs_engine.face.shape.physics_head import physics_shape
from abs_engine.fit.shell import ShellSetting, shell_colours
from abs_engine.fit.shell_relaxation import Seen
from abs_engine.io.assets import Speaker, shipped
from abs_engine.io.video import read_frames
from abs_engine.learn.further import LipClip
from abs_engine.learn.settings import LEARNING
from abs_engine.learn.training import check_speaker
from abs_engine.tracking.models.shells import BUNDLED, person_lips
from abs_engine.tracking.results.run_mesh import load_mesh_of
from abs_engine.tracking.results.run_table import sure_frames
from abs_engine.tracking.runs.record import SUMMARY, camera_of, stated_settings
from abs_engine.tracking.runs.recordings import Recording, load_recording, pose_in

COLOURS = "colours.npz"


@dataclass(frozen=True, eq=False)
class LipRun:
    """A run, as one camera of a clip.

    Parameters
    ----------
    rest : (V, 3) float32, mm
        The person's head at rest.
    tracked : (T, N, 3) float64, mm
        The shell's displacement from rest as it was tracked; NaN in lost frames.
    """

    folder: Path
    recording: Recording
    colours: ColourClasses
    rest: NDArray[np.float32]
    tracked: FloatArray

    @property
    def sure(self) -> BoolArray:
        """Frames (T,) in which the mouth was found and seen, and nothing throws doubt on it."""
        return sure_frames(self.recording.run)

    def seen(self, frames: NDArray[np.intp], lips: LipModel, renderer: Renderer) -> list[Seen]:
        """Some frames, as evidence about lips."""
        run = self.recording.run
        setting = ShellSetting(lips, lips.scene(), self.colours, camera_of(run), renderer)
        wanted, out = set(frames.tolist()), list[Seen]()
        for frame, picture in enumerate(read_frames(self.recording.video)):
            if frame in wanted:
                pose = pose_in(run, frame)
                out.append(Seen(replace(shell_colours(setting, picture, pose), pull=None), pose))
            if len(out) == len(wanted):
                break
        return out


def load_lip_runs(
    groups: Sequence[Sequence[Path]], speaker: Speaker, shell: LipShell
) -> list[list[LipRun]]:
    """Runs of clips, each a group of cameras; raises as `load_lip_run`, and for a video twice."""
    runs = [[load_lip_run(folder, speaker, shell) for folder in group] for group in groups]
    check_distinct([(run.folder, run.recording.video) for group in runs for run in group])
    return runs


def load_lip_run(folder: Path, speaker: Speaker, shell: LipShell) -> LipRun:
    """A run as one camera's part of a clip.

    Raises
    ------
    InputFileError, ModelFormatError
        If it cannot be read, its video or the physics that it was tracked with is not there, or it
        was tracked with another head or without colours.
    """
    recording, mesh = load_recording(folder, speaker), load_mesh_of(folder, speaker)
    rest = _rest(folder, mesh.mean, speaker, shell) if mesh.rest is None else mesh.rest
    moved = shell.nodes(mesh.modes.astype(np.float64)).reshape(len(mesh.modes), -1)
    offset = shell.nodes(mesh.mean.astype(np.float64) - rest)
    tracked = (mesh.weights @ moved).reshape(len(mesh), *offset.shape) + offset
    if not (folder / COLOURS).is_file():
        raise InputFileError(
            f"{folder} was tracked without colours, as with --worn",
            "track its video by colour, which is the default",
        )
    colours = ColourClasses.load(folder / COLOURS)
    return LipRun(folder, recording, colours, rest, tracked)


def lip_clip(
    runs: Sequence[LipRun],
    speaker: Speaker,
    shell: LipShell,
    physics: LearnedPhysics,
    renderer: Renderer,
) -> LipClip:
    """A clip of one person, of one run or of several cameras that filmed at once.

    Raises
    ------
    ParameterError
        If the runs have other numbers of frames, or other rates.
    TooFewFramesError
        If in too few of them the mouth was found by every camera.
    """  # fmt: skip
    first = runs[0]
    for run in runs[1:]:
        rates = [float(one.recording.run["rate"]) for one in (first, run)]
        if abs(rates[0] / rates[1] - 1) > CAPTURE.rates_apart:
            raise ParameterError(
                f"{first.folder} has {rates[0]:g} frames/s, {run.folder} {rates[1]:g}",
                "join runs of videos that were taken together",
            )
        if run.recording.count != first.recording.count:
            raise ParameterError(
                f"{first.folder} has {first.recording.count} frames, {run.folder} "
                f"{run.recording.count}",
                "join runs of videos that begin and end at the same time",
            )
    sure = np.flatnonzero(np.all([run.sure for run in runs], axis=0))
    if len(sure) < LEARNING.clip_least:
        raise TooFewFramesError(
            f"the mouth was found for certain in {len(sure)} frames of {first.folder}",
            f"give runs with {LEARNING.clip_least} or more",
        )
    at = sure[evenly(len(sure), LEARNING.clip_most)]
    lips = person_lips(speaker, shell, physics, first.rest)
    moments = zip(*(run.seen(at, lips, renderer) for run in runs), strict=True)
    return LipClip(lips, tuple(moments), first.tracked[at])


def _rest(
    folder: Path, mean: NDArray[np.float32], speaker: Speaker, shell: LipShell
) -> NDArray[np.float32]:
    """The head (V, 3) nearly at rest, of a run that does not say it, as those of earlier versions.

    It is without the mean posture of physics that it was tracked with; without any, it is the mean.
    """
    physics = _physics_of(folder)
    if physics is None:
        return mean
    check_speaker(physics, speaker)
    none = np.zeros_like(mean)
    return np.asarray(mean - physics_shape(speaker, none, shell, physics).mean, np.float32)


def _physics_of(folder: Path) -> LearnedPhysics | None:
    """The physics that a run was tracked with; None for a head that moved otherwise."""
    try:
        told = stated_settings(folder)
        shell = told.get("model") == "shell"
        named = "model_file" if shell and not told.get("physics") else "physics"
        name, known = told.get(named), told.get(f"{named.removesuffix('_file')}_sha256")
    except (OSError, ValueError, KeyError) as error:
        raise ModelFormatError(
            f"{folder / SUMMARY} does not say how it was tracked", "track the video again"
        ) from error
    if name is None:
        return load_physics(shipped(BUNDLED)) if shell else None
    places = [folder.parent / Path(name).name, Path(Path(name).name)]
    there = [p for p in places if p.is_file()]
    if not there:
        raise InputFileError(
            f"{name}, the lips that {folder} was tracked with, are not there",
            "put the file beside the run or into this folder",
        )
    found = next((p for p in there if known in (None, digest(p))), None)
    if found is None:
        raise InputFileError(
            f"{name}, the lips that {folder} was tracked with, have changed since",
            "put the file that they were beside the run, or track the video again",
        )
    return load_physics(found)
