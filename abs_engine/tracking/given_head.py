"""A head that is fitted to landmarks, while its poses are given."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from abs_engine.core.arrays import Image
from abs_engine.core.camera import Camera
from abs_engine.core.errors import FaceNotFoundError
from abs_engine.core.geometry import Pose
from abs_engine.io.assets import Speaker
from abs_engine.tracking.aligned_poses import PosedMotion, aligned, pupils_by
from abs_engine.tracking.clip_setting import NO_POSE, ClipSetting
from abs_engine.tracking.external_poses import GivenMotion
from abs_engine.tracking.head_fit import AverageHead
from abs_engine.tracking.head_pose import placed_fit
from abs_engine.tracking.initial_pose import FaceBox
from abs_engine.tracking.landmark_motion import LandmarkMotion
from abs_engine.tracking.landmarks import Landmarks
from abs_engine.tracking.options import Clip
from abs_engine.tracking.person_fit import FittedPerson
from abs_engine.tracking.poses_file import read_poses
from abs_engine.tracking.scale import Scale, scale_by_poses
from abs_engine.tracking.settings.preparation import PREPARATION

PosedFrame = tuple[int, Image, Landmarks]
"""Number of a frame, its picture (H, W, 3) uint8 RGB, and the landmarks of the face."""


@dataclass(frozen=True, eq=False)
class GivenHead:
    """Given poses of a clip's head, before it is known who it is.

    Parameters
    ----------
    poses : tuple of (Pose or None)
        Of each frame.
    camera : Camera
    """

    poses: tuple[Pose | None, ...]
    camera: Camera

    @classmethod
    def read(cls, path: Path, clip: Clip, speaker: Speaker) -> GivenHead:
        """Those of a file.

        Raises
        ------
        AbsEngineError
            As `read_poses` and `GivenPoses.check` raise them.
        FaceNotFoundError
            If they put the mouth outside of the picture in all frames.
        """
        mouth = speaker.vertices[speaker.lip_ring].astype(np.float64).mean(axis=0)
        given = read_poses(path)
        given.check(clip.info.frames, clip.camera, mouth)
        GivenMotion(given.poses).in_picture(clip.camera, mouth, clip.video)
        return cls(given.poses, clip.camera)

    def box(self, speaker: Speaker) -> FaceBox | None:
        """The face that they are of, in the first frame; None where that has no pose."""
        first = self.poses[0]
        if first is None:
            return None
        lips = speaker.vertices[speaker.lip_ring].astype(np.float64)
        pixels = self.camera.project(first.apply(lips))
        low, size = pixels.min(axis=0), np.ptp(pixels, axis=0)
        return FaceBox.around_mouth(*low.tolist(), *size.tolist())

    def posed(
        self, seen: Sequence[tuple[Image, Landmarks]], found: Sequence[Landmarks | None]
    ) -> list[PosedFrame]:
        """Those of the frames that have a pose, by what was `found` frame after frame.

        Raises
        ------
        FaceNotFoundError
            If none has.
        """
        where = {id(marks): k for k, marks in enumerate(found)}
        numbered = [(where.get(id(marks), -1), image, marks) for image, marks in seen]
        there = [one for one in numbered if one[0] >= 0 and self.poses[one[0]] is not None]
        if not there:
            raise FaceNotFoundError(
                "no frame that shows a face has a pose", "give poses of this video"
            )
        return there

    def scale(self, frames: Sequence[PosedFrame], average: AverageHead) -> Scale:
        """The scale that the poses' distances and the eyes tell.

        Raises
        ------
        ParameterError
            If nobody's pupils are so far apart.
        """
        pairs = [(pose, marks) for k, _, marks in frames if (pose := self.poses[k]) is not None]
        return scale_by_poses(pupils_by(pairs, average.shape, average.scale.pupils, self.camera))

    def holding(
        self,
        setting: ClipSetting,
        fitted: FittedPerson,
        own: LandmarkMotion,
        frames: Sequence[PosedFrame],
    ) -> ClipSetting:
        """The setting of a clip with the head in its given poses.

        Parameters
        ----------
        setting : ClipSetting
        fitted : FittedPerson
        own : LandmarkMotion
            By which the head would be followed without them.
        frames : sequence of PosedFrame
            Some of them, evenly spread, are where both are laid on each other.

        Raises
        ------
        ParameterError
            If they do not turn as the face does.
        """
        placed = [
            (k, fit.pose)
            for k, image, marks in frames[:: max(1, len(frames) // PREPARATION.learn_from)]
            if (fit := placed_fit(fitted.textured, fitted.shape, image, marks)) is not None
        ]
        given = GivenMotion(aligned(self.poses, placed, fitted.model.pivot))
        return replace(setting, motion=PosedMotion(own, given), why_lost=NO_POSE)
