"""The fits of the experiments: by every driver, from every side, with and without the pose."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import islice
from pathlib import Path

import numpy as np

from abs_engine.compare.forces import Rule as Integral
from abs_engine.core.arrays import FloatArray, Image
from abs_engine.core.camera import Camera
from abs_engine.core.geometry import Pose
from abs_engine.core.scene import Renderer
from abs_engine.dataset.view import Truth
from abs_engine.face.appearance.colour import ColourClasses
from abs_engine.face.shape.lip_model import LipModel, lip_model
from abs_engine.face.shape.lip_shell import COLUMNS
from abs_engine.fit.shell import POSE_FREE, ShellSetting
from abs_engine.io.assets import Speaker
from abs_engine.learn.training import Training, train
from abs_engine.papers.basu1998.motion import Motion, observed_motion, spoken_motion
from abs_engine.papers.basu1998.single_frames import (
    AS_PRINTED,
    ITERATIONS,
    ShellFit,
    fit_frames,
    seen_shapes,
    typical_shapes,
)
from abs_engine.tracking.frame.blobs import find_lips
from abs_engine.tracking.frame.external_poses import GivenFollower, GivenMotion
from abs_engine.tracking.frame.frame_state import HeadFrame, Memory
from abs_engine.tracking.frame.head_tracking import HeadMotion
from abs_engine.tracking.models.shells import BY_BLOB
from abs_engine.tracking.start.blob_start import mouth_model as head_model

OBSERVED = 0.12
"""mm of error in each coordinate of a dot: 0.21 mm in space, as in the filmed sessions."""


@dataclass(frozen=True, eq=False)
class TrainedLips:
    """A person's lips, ready to be found.

    Parameters
    ----------
    starts : (K, P) float64
    """

    person: str
    training: Training
    model: LipModel
    starts: FloatArray
    classes: ColourClasses

    def setting(
        self, camera: Camera, renderer: Renderer, pose_deviation: FloatArray | None = None
    ) -> ShellSetting:
        """Setting of a fit."""
        scene = self.model.scene()
        seen = seen_shapes(self.model.physics, self.training.displacements)
        return ShellSetting(
            self.model, scene, self.classes, camera, renderer, pose_deviation, seen=seen
        )


def learn_lips(
    speaker: Speaker, person: str, classes: ColourClasses, seed: int, motion: Motion | None = None
) -> TrainedLips:
    """Lips of a person from dots; by default while they speak (`spoken_motion`)."""
    motion = spoken_motion(speaker, person) if motion is None else motion
    dots = observed_motion(speaker, motion, noise=OBSERVED, seed=seed)
    training = train(dots, speaker, person, n_train=len(motion))
    model = lip_model(speaker, training.shell, training.physics, speaker.named(person))
    starts = typical_shapes(training.physics, training.displacements, seed=seed)
    return TrainedLips(person, training, model, starts, classes)


@dataclass(frozen=True, eq=False)
class FrameError:
    """Errors of one fit.

    Parameters
    ----------
    rms : float, mm
        Of the lip nodes, head coordinates.
    highest : float, mm
        The same of the highest maximum alone.
    """

    person: str
    camera: str
    driver: str
    frame: int
    rms: float
    highest: float
    fit: ShellFit

    @classmethod
    def of(
        cls, lips: TrainedLips, camera: str, driver: str, fit: ShellFit, view: Truth
    ) -> FrameError:
        """Errors of a fit to a view's frame, by the view's truth."""
        truth = lips.model.shell.nodes(view.vertices(fit.frame))
        rms, highest = (lip_error(nodes, truth) for nodes in (fit.nodes, fit.highest))
        return cls(lips.person, camera, driver, fit.frame, rms, highest, fit)


def lip_error(nodes: FloatArray, truth: FloatArray) -> float:
    """RMS distance, mm, of the lips' nodes (three rings) from the truth; both (N, 3)."""
    away = (nodes - truth)[: 3 * COLUMNS]
    return float(np.sqrt((away**2).sum(axis=1).mean()))


def pose_known(
    lips: TrainedLips,
    views: Mapping[str, Truth],
    renderer: Renderer,
    driver: str,
    rule: str = "whole",
    score: Integral = "exact",
    step: int = 1,
    kept: Path | None = None,
    prior_width: float = 1.0,
) -> Iterator[FrameError]:
    """Fit frames of every view, each by itself, with the pose known.

    Parameters
    ----------
    driver, rule : str
        As of `fit_frames`; `AS_PRINTED` is from one start, with one Gaussian as the prior.
    score : {"exact", "sample"}
        How the posterior is integrated.
    step : int
        Every so many frames.
    kept : Path, optional
        Folder that gets a journal of each view's fits, and has those of an interrupted run.
    prior_width : float
        As of `ShellSetting`; a wider prior is one Gaussian.
    """
    starts = lips.starts[:1] if driver == AS_PRINTED else lips.starts
    for camera, view in views.items():
        usual = lips.setting(view.camera, renderer)
        seen = None if driver == AS_PRINTED or prior_width != 1 else usual.seen
        setting = replace(usual, score=score, seen=seen, prior_width=prior_width)
        motion = GivenMotion(poses_of(view)[::step])
        pictures, journal = islice(view.pictures(), None, None, step), _journal(kept, camera)
        for fit in fit_frames(setting, pictures, motion, starts, driver, rule, False, journal):
            placed = replace(fit, frame=fit.frame * step)
            yield FrameError.of(lips, camera, driver, placed, view)


def _journal(kept: Path | None, camera: str) -> Path | None:
    """The journal of a view's fits."""
    return None if kept is None else kept / f"{camera}.journal"


def poses_of(view: Truth) -> tuple[Pose, ...]:
    """The head's true pose in every frame."""
    return tuple(view.pose(frame) for frame in range(len(view)))


@dataclass(frozen=True, eq=False)
class BlobPlaces(GivenMotion):
    """Depth and rotation are given, the place in the picture is that of the lips' blob (5.3)."""

    classes: ColourClasses

    def follower(self) -> BlobPlacer:
        """Filter that finds the blobs."""
        return BlobPlacer(self.given, self.classes)


class BlobPlacer(GivenFollower):
    """Finds the lips' blob in each frame by itself."""

    def __init__(self, given: tuple[Pose | None, ...], classes: ColourClasses) -> None:
        super().__init__(given)
        self._classes = classes

    def step(self, image: Image, memory: Memory | None = None) -> HeadFrame:
        """The next frame with its blob; without one, no pose."""
        frame, blob = super().step(image, memory), find_lips(self._classes, image)
        return frame._replace(pose=None if blob is None else frame.pose, blob=blob)


def placed_by_blob(
    lips: TrainedLips, views: Mapping[str, Truth], renderer: Renderer, kept: Path
) -> Iterator[FrameError]:
    """As the paper does, by forces: depth and rotation are given, the place is the blob's.

    Frames in which no mouth is found are left out. `kept` is as of `pose_known`.
    """
    for camera, view in views.items():
        setting = lips.setting(view.camera, renderer, BY_BLOB)
        motion, own = BlobPlaces(poses_of(view), lips.classes), _journal(kept, camera)
        for fit in fit_frames(setting, view.pictures(), motion, lips.starts, "forces", kept=own):
            yield FrameError.of(lips, camera, "forces", fit, view)


def pose_estimated(
    lips: TrainedLips,
    speaker: Speaker,
    view: Truth,
    renderer: Renderer,
    driver: str,
    kept: Path | None = None,
) -> Iterator[FrameError]:
    """Fit a moving head: its pose is found by details of the upper face, then fitted along.

    Frames in which no mouth is found are left out. `kept` is as of `pose_known`.
    """
    setting = lips.setting(view.camera, renderer, POSE_FREE)
    motion = HeadMotion(head_model(speaker, lips.person), view.camera, renderer)
    journal = _journal(kept, "moving")
    for fit in fit_frames(setting, view.pictures(), motion, lips.starts, driver, kept=journal):
        yield FrameError.of(lips, "moving", driver, fit, view)


def rms_of(errors: Sequence[FrameError]) -> float:
    """RMS over frames, mm."""
    return float(np.sqrt(np.mean([e.rms**2 for e in errors]))) if errors else float("nan")


def converged(errors: Sequence[FrameError]) -> float:
    """Share of fits that ended by themselves within the paper's iterations."""
    ended = [
        e.fit.solution.status == "converged" and e.fit.solution.n_iterations <= ITERATIONS
        for e in errors
    ]
    return float(np.mean(ended))
