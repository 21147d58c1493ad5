"""Visibility of the mouth: by its place and look by landmarks, or by its blob."""

from __future__ import annotations

from dataclasses import dataclass

from abs_engine.core.arrays import FloatArray, Image
from abs_engine.core.camera import Camera
from abs_engine.core.geometry import Pose
from abs_engine.face.appearance.colour import ColourClasses
from abs_engine.face.head import MouthModel
from abs_engine.tracking.blob_visibility import (
    COVERED,
    OUTSIDE,
    MouthEvidence,
    UsualMouth,
    mouth_evidence,
)
from abs_engine.tracking.cut_faces import MouthInPicture
from abs_engine.tracking.frame_state import HeadFrame
from abs_engine.tracking.mouth_visibility import MouthLook, UsualLook


@dataclass(frozen=True, eq=False)
class ByLook:
    """By the colours within and around the lips where landmarks put them, and by their place.

    Parameters
    ----------
    classes : ColourClasses
    usual : UsualLook or None
        Without it no mouth counts as covered.
    place : MouthInPicture, optional
        Of the person; without it only the landmarks of lips say whether they are in the picture.
    """

    classes: ColourClasses
    usual: UsualLook | None
    place: MouthInPicture | None = None

    def hidden(self, frame: HeadFrame, pose: Pose) -> str:
        """Reason why the mouth cannot be seen; empty where it can."""
        if frame.face is None:  # its pose is given
            return "" if self.place is None or self.place.shown(pose) else OUTSIDE
        seen, fit = frame.face.landmarks, frame.face.fit
        if self.place is not None and not self.place.whole(seen, fit):
            return OUTSIDE
        if self.usual is None or frame.grey:
            return ""
        look = MouthLook.of(self.classes, frame.in_usual_light, seen)
        if look is None:
            return OUTSIDE
        return COVERED if self.usual.hidden(look) else ""


@dataclass(frozen=True, eq=False)
class ByBlob:
    """By the lips' blob where the head's pose puts them.

    Parameters
    ----------
    classes : ColourClasses
    model : MouthModel
    camera : Camera
    person : (Q,) float64
    usual : UsualMouth, optional
        What is usual in the clip; without it nothing counts as hidden.
    """

    classes: ColourClasses
    model: MouthModel
    camera: Camera
    person: FloatArray
    usual: UsualMouth | None = None

    def hidden(self, frame: HeadFrame, pose: Pose) -> str:
        """Reason why the mouth cannot be seen; empty where it can."""
        if self.usual is None:
            return ""
        now = self.evidence(frame.image, pose)
        if now is None:
            return OUTSIDE
        return COVERED if self.usual.covered(now) else ""

    def evidence(self, image: Image, pose: Pose) -> MouthEvidence | None:
        """The lips' blob in a frame; None outside of the picture."""
        return mouth_evidence(self.classes, self.model, self.camera, image, pose, self.person)
