"""Visibility of the mouth by blobs: its lip blob beside those of the clip's other frames.

A hand or a microphone before the mouth leaves the drawn lips without lip colour, or paints all
around them with it. The fit then still gives numbers, so they are to be told by the colours.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from abs_engine.core.arrays import FloatArray, Image
from abs_engine.core.camera import Camera
from abs_engine.core.geometry import Pose
from abs_engine.face.appearance.colour import ColourClasses
from abs_engine.face.head import MouthModel
from abs_engine.fit.head_frame import mouth_window
from abs_engine.fit.settings import HEAD_FIT
from abs_engine.tracking.frame.blobs import LipPrior, find_lips
from abs_engine.tracking.frame.frame_state import HeadFrame
from abs_engine.tracking.settings.blobs import BLOB_START

COVERED, OUTSIDE = "mouth covered", "mouth outside of the picture"
DARK, BRIGHT = "face too dark", "face too bright"


@dataclass(frozen=True)
class MouthEvidence:
    """Evidence of the colours about a mouth.

    Parameters
    ----------
    area : float
        Of the lips' blob, in squares of the mouth's width.
    posterior : float
        Of the blob, 0 to 1; see `LipBlob`.
    """

    area: float
    posterior: float

    @classmethod
    def usual(cls, seen: Sequence[MouthEvidence | None]) -> MouthEvidence | None:
        """The medians over some frames of a clip; None where no frame shows lips."""
        there = [(e.area, e.posterior) for e in seen if e is not None and e.area > 0]
        return cls(*map(float, np.median(there, axis=0))) if there else None

    def covered(self, now: MouthEvidence) -> bool:
        """Whether lips as in `now` are hidden, where this evidence is usual.

        Too little or too much has their colour, or it is too faint.
        """
        return not (
            BLOB_START.least_area * self.area < now.area < BLOB_START.most_area * self.area
            and now.posterior > BLOB_START.least_posterior * self.posterior
        )


@dataclass(frozen=True, eq=False)
class ByBlob:
    """By the lips' blob where the head's pose puts them.

    Parameters
    ----------
    person : (Q,) float64
    usual : MouthEvidence, optional
        What is usual in the clip; without it nothing counts as hidden.
    """

    classes: ColourClasses
    model: MouthModel
    camera: Camera
    person: FloatArray
    usual: MouthEvidence | None = None

    def hidden(self, frame: HeadFrame, pose: Pose) -> str:
        """Reason why the mouth cannot be seen; empty where it can."""
        if self.usual is None:
            return ""
        now = self.evidence(frame.image, pose)
        if now is None:
            return OUTSIDE
        return COVERED if self.usual.covered(now) else ""

    def evidence(self, image: Image, pose: Pose) -> MouthEvidence | None:
        """The lips' blob where the pose puts the mouth in a frame; None outside of the picture."""
        centre = self.camera.project(pose.apply(self.model.border(self.person).mean(axis=0)))
        width, height = self.camera.size
        if not (0 <= centre[0] < width and 0 <= centre[1] < height):
            return None
        window = mouth_window(self.model, pose, self.camera, self.person)
        across = window.width / HEAD_FIT.window[0]
        deviation = np.full(2, BLOB_START.reach * across)
        prior = LipPrior(centre, deviation, BLOB_START.area * across**2)
        blob = find_lips(self.classes, image, prior)
        if blob is None:
            return MouthEvidence(0.0, 0.0)
        return MouthEvidence(blob.area / across**2, blob.posterior)
