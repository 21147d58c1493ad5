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
from abs_engine.tracking.blobs import LipPrior, find_lips
from abs_engine.tracking.settings.blobs import BLOB_START

COVERED, OUTSIDE = "mouth covered", "mouth outside of the picture"


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


def mouth_evidence(
    classes: ColourClasses,
    model: MouthModel,
    camera: Camera,
    image: Image,
    pose: Pose,
    person: FloatArray,
) -> MouthEvidence | None:
    """The lips' blob where a head's pose puts a person's mouth; None outside of the picture."""
    centre = camera.project(pose.apply(model.border(person).mean(axis=0)))
    width, height = camera.size
    if not (0 <= centre[0] < width and 0 <= centre[1] < height):
        return None
    across = mouth_window(model, pose, camera, person).width / HEAD_FIT.window[0]
    prior = LipPrior(centre, np.full(2, BLOB_START.reach * across), BLOB_START.area * across**2)
    blob = find_lips(classes, image, prior)
    return (
        MouthEvidence(0.0, 0.0)
        if blob is None
        else MouthEvidence(blob.area / across**2, blob.posterior)
    )


@dataclass(frozen=True)
class UsualMouth:
    """Usual evidence in a clip: the medians over some of its frames.

    Parameters
    ----------
    area, posterior : float
        See `MouthEvidence`.
    """

    area: float
    posterior: float

    @classmethod
    def of(cls, seen: Sequence[MouthEvidence | None]) -> UsualMouth | None:
        """The medians; None where no frame shows lips."""
        there = [e for e in seen if e is not None and e.area > 0]
        if not there:
            return None
        area, posterior = np.median([(e.area, e.posterior) for e in there], axis=0)
        return cls(float(area), float(posterior))

    def covered(self, now: MouthEvidence) -> bool:
        """Whether lips as in `now` are hidden: too few of their colour, too faint, or too many."""
        return not (
            BLOB_START.least_area * self.area < now.area < BLOB_START.most_area * self.area
            and now.posterior > BLOB_START.least_posterior * self.posterior
        )
