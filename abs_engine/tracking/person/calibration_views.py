"""Calibration views: the mouths of a clip's frames, and the colours that are learned there."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import cv2
import numpy as np

from abs_engine.compare.facets import FacetLikelihood
from abs_engine.compare.prior import GaussianPrior
from abs_engine.core.arrays import FloatArray
from abs_engine.core.camera import Camera, Window
from abs_engine.core.pose import PoseFrame, no_correction, parted
from abs_engine.core.scene import Renderer
from abs_engine.face.appearance.chroma import sampled
from abs_engine.face.appearance.colour import ColourClasses
from abs_engine.face.appearance.colour_learning import PLACES, learn_classes, typical_classes
from abs_engine.face.head import MouthModel
from abs_engine.fit.head_frame import class_maps, likelihood_of, mouth_window, seam_of
from abs_engine.tracking.detection.mouth_search import CalibrationFrame, shifted
from abs_engine.tracking.settings.preparation import PREPARATION


@dataclass(frozen=True, eq=False)
class Stand:
    """Places of the frames' mouths, from which colours are learned.

    Parameters
    ----------
    frames : sequence of CalibrationFrame, N
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
    def bases(self) -> list[PoseFrame]:
        """Frames of the corrected poses, about the mouth."""
        pivot = self.model.pivot
        return [PoseFrame(shifted(f.pose, self.shift, pivot), pivot) for f in self.frames]

    @cached_property
    def windows(self) -> list[Window]:
        """Windows of the frames that are compared."""
        given = self.camera, self.person, self.more
        return [mouth_window(self.model, base.base, *given) for base in self.bases]

    @property
    def depth(self) -> float:
        """Distance of the head in the median frame, mm, as the poses have it."""
        return float(np.median([f.pose.translation[2] for f in self.frames]))

    def learned(self, vectors: FloatArray, turn: int) -> ColourClasses:
        """Colours by where mouths with these poses and postures (N, 6 + P) are drawn.

        At first those of anybody with such skin; where a known head stands is known well enough to
        learn its colours at once. `turn` is which of `PREPARATION.view_rounds`.
        """
        places = [self._places(k, vector, turn) for k, vector in enumerate(vectors)]
        patches = [sampled(w, f.image) for w, f in zip(self.windows, self.frames, strict=True)]
        if self.model.known or turn > 0:
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

    def _places(self, k: int, vector: FloatArray, turn: int) -> FloatArray:
        """Expected places (3, H, W) of skin, lips and the mouth's inside in frame `k`: blurred.

        At first the posture is not known: several are drawn and averaged. In a larger window, where
        the mouth is looked for, the place is less sure, and the blur grows with it.
        """
        model, window = self.model, self.windows[k]
        postures = model.prototypes[[0, 2, 3]] if turn == 0 else parted(vector)[1][None]
        weights = np.hstack([postures, np.tile(self.person, (len(postures), 1))])
        moved = np.tile(vector, (len(postures), 1))
        some = self.bases[k].candidates(moved, weights)
        drawn = self.renderer.draw(model.scene, some, self.camera, window)
        blur, share = PREPARATION.view_rounds[turn]
        sigma = blur * window.drawn[0] / 2.0
        planes = []
        for name in PLACES:
            colours = ("teeth", "dark") if name == "inside" else (name,)
            ids = [n for n, colour in enumerate(model.colour_classes) if colour in colours]
            plane = np.mean([np.isin(b.class_id, ids) for b in drawn], axis=0)
            planes.append(cv2.GaussianBlur(plane, (0, 0), sigma))
        places = np.stack(planes)
        near_lips = places[1] + places[2]
        places[2] = np.maximum(places[2], share * near_lips)  # it may show wherever lips are
        return np.asarray(PREPARATION.placed * places / np.maximum(places.sum(axis=0), 1.0))


def place_mouth(stand: Stand, classes: ColourClasses, deviation: FloatArray) -> FloatArray:
    """Coarse search of a person's mouth's place and size about where the poses put it.

    It gives a constant correction (6,) of the poses, radians and mm. What the person's drawn mouth
    covers is compared with what skin would explain there: nothing is gained by drawing it larger
    than the part of the picture that is looked at, or beside it. `deviation` (6,), radians and mm,
    is how far the poses may be off.
    """
    model, frames, person = stand.model, stand.frames, stand.person
    camera, renderer = stand.camera, stand.renderer
    across, down = PREPARATION.searched * deviation[3:5]
    grid = np.array(
        [
            [0, 0, 0, dx, dy, dz * deviation[5]]
            for dx in _to_both_sides(across, PREPARATION.search_steps[0])
            for dy in _to_both_sides(down, PREPARATION.search_steps[1])
            for dz in PREPARATION.search_depths
        ]
    )
    # closed, open and widely open: the coarsest choice of what a mouth may look like
    postures = np.hstack([model.prototypes, np.tile(person, (len(model.prototypes), 1))])
    total = np.zeros(len(grid))
    for frame in frames:
        base = PoseFrame(frame.pose, model.pivot)
        window = mouth_window(model, frame.pose, camera, person, PREPARATION.searched_more)
        maps = class_maps(classes, model.colour_classes, window, frame.image)
        skin = maps.maps[model.colour_classes.index("skin")]
        term = replace(likelihood_of(renderer, model.scene, camera, window, maps), outside=skin)
        values = [
            term.negative_log(base.candidates(grid, np.tile(b, (len(grid), 1))))
            for b in postures[[0, 2, 4]]
        ]
        total += np.min(values, axis=0)
    prior = GaussianPrior(no_correction(), deviation)
    total = total * PREPARATION.frames_together / len(frames) + np.array(
        [prior.negative_log(g) for g in grid]
    )
    return np.asarray(grid[int(np.argmin(total))])


def _to_both_sides(reach: float, step: float) -> FloatArray:
    """Steps to `reach` and from it, 0 among them."""
    count = np.ceil(reach / step)
    return np.asarray(step * np.arange(-count, count + 1))
