"""A head that is fitted to landmarks, while its poses are given."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from abs_engine.core.arrays import Image
from abs_engine.core.camera import Camera
from abs_engine.core.geometry import Pose
from abs_engine.io.assets import Speaker
from abs_engine.tracking.detection.face_choice import LARGEST, FaceChoice
from abs_engine.tracking.detection.initial_pose import FaceBox
from abs_engine.tracking.detection.landmarks import Landmarks
from abs_engine.tracking.frame.external_poses import GivenMotion
from abs_engine.tracking.head.head_pose import placed_fit
from abs_engine.tracking.options import Clip
from abs_engine.tracking.runs.poses_file import read_poses
from abs_engine.tracking.settings.preparation import PREPARATION
from abs_engine.tracking.start.person_fit import FittedPerson


@dataclass(frozen=True, eq=False)
class GivenHead:
    """Given poses of a clip's head, before it is known who it is.

    Parameters
    ----------
    poses : tuple of (Pose or None)
        Of each frame.
    first : Pose or None
        That of the first frame; None where it puts the mouth outside of the picture, too.
    """

    poses: tuple[Pose | None, ...]
    first: Pose | None
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
        shown = GivenMotion(given.poses).in_picture(clip.camera, mouth, clip.video)
        return cls(given.poses, shown.given[0], clip.camera)

    def choice(self, speaker: Speaker) -> FaceChoice:
        """The face that they are of: the one about which they put the mouth in the first frame.

        It may lie beside it, as their origin and scale may be another head's. The largest where
        that frame has no pose.
        """
        if self.first is None:
            return LARGEST
        lips = speaker.vertices[speaker.lip_ring].astype(np.float64)
        box = FaceBox.around_lips(self.camera.project(self.first.apply(lips)))
        return FaceChoice(box=box, about=True)

    def aligned(
        self, fitted: FittedPerson, frames: Sequence[tuple[Image, tuple[int, Landmarks]]]
    ) -> GivenMotion:
        """The poses as those of the head that was fitted, by some of the frames, evenly spread.

        Each is a picture (H, W, 3) uint8 RGB, its number, and the landmarks of the face.

        Raises
        ------
        ParameterError
            If they do not move as the face does.
        FaceNotFoundError
            If no frame that shows a face has a pose.
        """
        # only here, as its solver and rotations take a while to import
        from abs_engine.tracking.start.aligned_poses import aligned

        both = [one for one in frames if self.poses[one[1][0]] is not None]
        placed = [
            (k, fit.pose)
            for image, (k, marks) in both[:: max(1, len(both) // PREPARATION.learn_from)]
            if (fit := placed_fit(fitted.textured, fitted.shape, image, marks)) is not None
        ]
        return GivenMotion(aligned(self.poses, placed, fitted.model.pivot))
