"""Calibration views: the mouths of a clip's frames, and the colours that are learned there."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import cv2
import numpy as np

from abs_engine.compare.facets import FacetLikelihood
from abs_engine.core.arrays import FloatArray
from abs_engine.core.camera import Camera, Window
from abs_engine.core.geometry import Pose
from abs_engine.core.pose import PoseFrame, parted
from abs_engine.core.scene import Candidates, Renderer
from abs_engine.face.appearance.chroma import sampled
from abs_engine.face.appearance.colour import ColourClasses
from abs_engine.face.appearance.colour_learning import PLACES, learn_classes, typical_classes
from abs_engine.face.head import MouthModel
from abs_engine.fit.head_frame import class_maps, likelihood_of, mouth_window, seam_of
from abs_engine.tracking.mouth_search import CalibrationFrame, shifted
from abs_engine.tracking.settings.preparation import PREPARATION


@dataclass(frozen=True, eq=False)
class Stand:
    """Places of the frames' mouths, from which colours are learned.

    Parameters
    ----------
    model : MouthModel
    frames : sequence of CalibrationFrame, N
    camera : Camera
    renderer : Renderer
    shift : (6,) float64
        Constant correction of the poses, radians and mm.
    person : (Q,) float64
        Weights of the person modes.
    more : tuple of float
        Mouth widths that the windows are wider and higher by, where the mouth is not yet found.
    """

    model: MouthModel
    frames: Sequence[CalibrationFrame]
    camera: Camera
    renderer: Renderer
    shift: FloatArray
    person: FloatArray
    more: tuple[float, float] = (0.0, 0.0)

    @cached_property
    def poses(self) -> list[Pose]:
        """The corrected poses."""
        return [shifted(f.pose, self.shift, self.model.pivot) for f in self.frames]

    @cached_property
    def windows(self) -> list[Window]:
        """Windows of the frames that are compared."""
        given = self.camera, self.person, self.more
        return [mouth_window(self.model, pose, *given) for pose in self.poses]

    def learned(self, vectors: FloatArray, turn: int) -> ColourClasses:
        """Colours by where mouths with these poses and postures (N, 6 + P) are drawn.

        At first those of anybody with such skin; where a known head stands is known well enough to
        learn its colours at once. `turn` is which of `PREPARATION.view_rounds`.
        """
        model, pivot = self.model, self.model.pivot
        places = [
            _places(
                model, self.renderer, self.camera, window,
                PoseFrame(pose, pivot).candidates(v[None], np.r_[parted(v)[1], self.person][None]),
                turn,
            )
            for window, pose, v in zip(self.windows, self.poses, vectors, strict=True)
        ]  # fmt: skip
        patches = [sampled(w, f.image) for w, f in zip(self.windows, self.frames, strict=True)]
        if model.known or turn > 0:
            return learn_classes(patches, places)
        return typical_classes(patches, places, plain=self.more != (0.0, 0.0))

    def terms(self, classes: ColourClasses) -> list[FacetLikelihood]:
        """The frames' likelihoods with these colours."""
        colours, made = self.model.colour_classes, []
        drawn, seam = (self.renderer, self.model.scene, self.camera), seam_of(colours)
        for window, frame in zip(self.windows, self.frames, strict=True):
            maps = class_maps(classes, colours, window, frame.image)
            made.append(likelihood_of(*drawn, window, maps, seam=seam))
        return made


def _places(
    model: MouthModel,
    renderer: Renderer,
    camera: Camera,
    window: Window,
    candidate: Candidates,
    turn: int,
) -> FloatArray:
    """Expected places of skin, lips and the mouth's inside, (3, H, W): as drawn, blurred.

    At first the posture is not known: several are drawn and averaged. In a larger window, where
    the mouth is looked for, the place is less sure, and the blur grows with it.
    """
    if turn == 0:
        postures = model.prototypes[[0, 2, 3]]
        n = len(postures)
        person = candidate.weights[:, model.n_expression :]
        weights = np.hstack([postures, np.repeat(person, n, axis=0)])
        candidate = Candidates(
            weights,
            np.repeat(candidate.rotations, n, axis=0),
            np.repeat(candidate.translations, n, axis=0),
        )
    drawn = renderer.draw(model.scene, candidate, camera, window)
    blur, share = PREPARATION.view_rounds[turn]
    sigma = blur * window.drawn[0] / 2.0
    planes = []
    for name in PLACES:
        colours = ("teeth", "dark") if name == "inside" else (name,)
        ids = [k for k, colour in enumerate(model.colour_classes) if colour in colours]
        plane = np.mean([np.isin(b.class_id, ids) for b in drawn], axis=0)
        planes.append(cv2.GaussianBlur(plane, (0, 0), sigma))
    places = np.stack(planes)
    near_lips = places[1] + places[2]
    places[2] = np.maximum(places[2], share * near_lips)  # it may show wherever lips are
    return np.asarray(PREPARATION.placed * places / np.maximum(places.sum(axis=0), 1.0))
