"""Mouths of several frames whose heads are placed: their colours, likelihoods and postures."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import NDArray

from abs_engine.compare.facets import FacetLikelihood
from abs_engine.core.arrays import BoolArray, FloatArray, Image
from abs_engine.core.camera import Camera, Window
from abs_engine.core.geometry import Pose
from abs_engine.core.pose import PoseFrame, at_base, parted
from abs_engine.core.scene import Renderer
from abs_engine.core.threads import in_threads, workers
from abs_engine.face.appearance.chroma import sampled
from abs_engine.face.appearance.colour import ColourClasses
from abs_engine.face.appearance.colours_by_head import PLACES, learn_placed
from abs_engine.face.head import IN_OPEN_MOUTH, MouthModel
from abs_engine.fit.head_frame import class_maps, likelihood_of, mouth_window, seam_of
from abs_engine.optimise.newton import Newton
from abs_engine.tracking.detection.mouth_search import shifted
from abs_engine.tracking.frame.frame_state import SeenFace
from abs_engine.tracking.frame.mouth_place import mouth_place
from abs_engine.tracking.person.identity_fit import fit_posture
from abs_engine.tracking.settings.preparation import PREPARATION

_FIRST = Newton(limit=PREPARATION.posture_limit, polished=0)
_NEXT_TO_NOTHING = 1e-6  # weight of colours in a frame without any
_AGAIN = replace(_FIRST, reaches=PREPARATION.reaches_again)


@dataclass(frozen=True, eq=False)
class PlacedFrame:
    """A frame that the person is fitted on, its head placed by landmarks.

    Parameters
    ----------
    image : (H, W, 3) uint8 RGB
    grey : bool
        Whether it has no colour, while the clip has: then only its landmarks count.
    """

    image: Image
    face: SeenFace
    grey: bool = False

    @property
    def pose(self) -> Pose:
        """The head's pose by the landmarks."""
        return self.face.fit.pose

    def start(self, modes: int) -> FloatArray:
        """Pose (6) and posture by the landmarks, (6 + P,)."""
        return np.asarray(at_base(self.face.fit.posture[:modes]), np.float64)


@dataclass(frozen=True, eq=False)
class PlacedMouths:
    """Places of the frames' mouths.

    Parameters
    ----------
    shift : (6,) float64
        Constant correction of the poses, radians and mm.
    person : (Q,) float64
        Weights of the person modes.
    """

    model: MouthModel
    placed: Sequence[PlacedFrame]
    camera: Camera
    renderer: Renderer
    shift: FloatArray
    person: FloatArray

    def base(self, k: int) -> PoseFrame:
        """The corrected pose of a frame."""
        pivot = self.model.pivot
        return PoseFrame(shifted(self.placed[k].pose, self.shift, pivot), pivot)

    def window(self, k: int) -> Window:
        """Window about the mouth in a frame."""
        return mouth_window(self.model, self.base(k).base, self.camera, self.person)

    def learned(self, vectors: FloatArray, blur: float, chromatic: bool) -> ColourClasses:
        """The colours by where the mouths are drawn (N, 6 + P), blurred by `blur` mm.

        `chromatic` is whether the clip is in colour.
        """

        def shown(k: int) -> tuple[NDArray[np.generic], FloatArray]:
            window = self.window(k)
            patch = sampled(window, self.placed[k].image)
            return patch, self._places(k, window, vectors[k], blur)

        coloured = [k for k, frame in enumerate(self.placed) if not frame.grey]
        each = in_threads(shown, coloured, workers(self.renderer))
        patches, places = zip(*each, strict=True)
        return learn_placed(patches, places, chromatic)

    def _places(self, k: int, window: Window, vector: FloatArray, blur: float) -> FloatArray:
        """Probability that each of `PLACES` is seen at each drawn pixel, (4, H, W)."""
        model, base = self.model, self.base(k)
        weights = np.r_[parted(vector)[1], self.person][None]
        candidate = base.candidates(parted(vector[None])[0], weights)
        drawn = self.renderer.draw(model.scene, candidate, self.camera, window)[0]
        names = model.speaker.class_names
        depth = float(base.base.apply(model.pivot)[2])
        sigma = blur * float(self.camera.matrix[0, 0]) / depth * window.scale
        planes = []
        for place in PLACES:
            shown = IN_OPEN_MOUTH if place == "inside" else (place,)
            ids = [names.index(n) for n in shown if n in names]
            plane = np.isin(drawn.class_id, ids).astype(np.float64)
            planes.append(cv2.GaussianBlur(plane, (0, 0), sigma))
        places = np.stack(planes)
        opening = _opening(drawn.class_id, names, sigma * PREPARATION.placed_opening / blur)
        places[3] = np.maximum(
            places[3], PREPARATION.placed_inside * opening * places[1:].sum(axis=0)
        )
        inside = in_picture(window, self.placed[k].image.shape)
        return np.asarray(
            PREPARATION.placed * places / np.maximum(places.sum(axis=0), 1.0) * inside
        )

    def terms(self, classes: ColourClasses, vectors: FloatArray) -> list[FacetLikelihood]:
        """The frames' likelihoods with these colours."""
        colours = self.model.colour_classes

        def made(k: int) -> FacetLikelihood:
            window = self.window(k)
            place = mouth_place(
                self.model, self.base(k), self.camera, window, self.person, vectors[k]
            )
            maps = class_maps(classes, colours, window, self.placed[k].image, place)
            drawn = self.renderer, self.model.scene, self.camera
            weight = _NEXT_TO_NOTHING if self.placed[k].grey else classes.weight
            return likelihood_of(*drawn, window, maps, weight, seam_of(colours))

        return in_threads(made, range(len(self.placed)), workers(self.renderer))

    def postures(
        self,
        terms: Sequence[FacetLikelihood],
        vectors: FloatArray,
        landmarks: bool = True,
        again: bool = False,
    ) -> FloatArray:
        """Pose and posture of every frame, (N, 6 + P), each from where it was.

        By colours and, if asked, `landmarks`. A posture that is fitted `again` hardly moves.
        """
        self.model.held(self.person)  # made once, for all threads
        solver = _AGAIN if again else _FIRST

        def fitted(k: int) -> FloatArray:
            told = self.placed[k].face.fit.evidence(self.model.n_expression)
            more, base = (told,) if landmarks else (), self.base(k)
            return fit_posture(self.model, terms[k], base, self.person, vectors[k], solver, more).x

        return np.stack(in_threads(fitted, range(len(terms)), workers(self.renderer)))


def _opening(classes: NDArray[np.integer], names: Sequence[str], sigma: float) -> FloatArray:
    """Nearness of each drawn pixel (H, W) to where the lips meet or part, 0 to 1."""
    upper, lower, inside = (
        cv2.GaussianBlur(
            np.isin(classes, [names.index(n) for n in shown if n in names]).astype(np.float64),
            (0, 0),
            sigma,
        )
        for shown in (("upper_lip",), ("lower_lip",), IN_OPEN_MOUTH)
    )
    meet = 4 * upper * lower / np.maximum((upper + lower) ** 2, 1e-9)
    return np.asarray(np.maximum(meet, np.minimum(2 * inside, 1.0)))


def in_picture(window: Window, shape: tuple[int, ...]) -> BoolArray:
    """Mask of the drawn pixels (H, W) of a window that lie in the picture."""
    (x, y), (height, width) = window.places, shape[:2]
    across, down = (x > -0.5) & (x < width - 0.5), (y > -0.5) & (y < height - 0.5)
    return np.asarray(down[:, None] & across)
