"""The person's mouth and the clip's colours, where landmarks have placed the head already.

With the place known, one start is enough: each round learns the colours where the drawn head shows
them, fits the frames' postures, then one mouth and one correction of the poses to all of them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import cv2
import numpy as np
from numpy.typing import NDArray

from abs_engine.compare.facets import FacetLikelihood
from abs_engine.core.blocks import IDENTITY, POSE
from abs_engine.core.camera import Camera, Window
from abs_engine.core.errors import FaceNotFoundError
from abs_engine.core.geometry import Pose
from abs_engine.core.pose import PoseFrame, at_base, no_correction, parted
from abs_engine.core.scene import Renderer
from abs_engine.core.threads import in_threads, workers
from abs_engine.face.appearance.chroma import sampled
from abs_engine.face.appearance.colour import ColourClasses
from abs_engine.face.appearance.colours_by_head import PLACES, learn_placed
from abs_engine.face.head import IN_OPEN_MOUTH, MouthModel
from abs_engine.fit.evidence import Term
from abs_engine.fit.head_frame import COLOUR, class_maps, likelihood_of, mouth_window, seam_of
from abs_engine.optimise.newton import Newton
from abs_engine.tracking.frame_state import SeenFace
from abs_engine.tracking.head_pose import TexturedHead, placed_fit
from abs_engine.tracking.identity_fit import Calibration, fit_posture, person_problem
from abs_engine.tracking.landmark_correspondence import Correspondence
from abs_engine.tracking.landmark_fit import INNER_TOGETHER, FrameLandmarks
from abs_engine.tracking.landmark_shape import LandmarkShape
from abs_engine.tracking.landmarks import LIPS, Landmarks
from abs_engine.tracking.light import SkinLight
from abs_engine.tracking.lip_landmarks import LipLandmarks, LipOutline
from abs_engine.tracking.mouth_place import mouth_place
from abs_engine.tracking.mouth_search import CalibrationFrame, shifted

FloatArray = NDArray[np.float64]
Image = NDArray[np.uint8]

SHIFT_DEVIATION = np.array([0.002, 0.002, 0.002, 0.8, 1.0, 0.003])
"""How far the landmarks put a whole clip's poses off: radians, mm, and a share of the depth."""
ROUNDS = (3.0, 2.0)
"""How unsure a class's place is in each round, mm: the landmarks' noise, then that of fits."""
OPENING = 2.5  # mm from where lips meet, how far a mouth may be open that is drawn closed
INSIDE = 0.6  # of where lips are drawn: how much may be the mouth's inside, as the posture may err
LEAST_MOTION = 0.7  # mm, standard deviation of apertures from which on colours are judged by them
_PERSON_LIMIT, _POSTURE_LIMIT = 80, 60  # evaluations of the person's fit, and of a posture's


@dataclass(frozen=True, eq=False)
class PlacedFrame:
    """A frame that the person is fitted on, its head placed by landmarks.

    Parameters
    ----------
    image : (H, W, 3) uint8 RGB
    face : SeenFace
    """

    image: Image
    face: SeenFace

    @property
    def pose(self) -> Pose:
        """The head's pose by the landmarks."""
        return self.face.fit.pose

    @property
    def calibration(self) -> CalibrationFrame:
        """The frame and its pose."""
        return CalibrationFrame(self.image, self.pose)

    def start(self, modes: int) -> FloatArray:
        """Pose (6) and posture by the landmarks, (6 + P,)."""
        return np.asarray(at_base(self.face.fit.posture[:modes]), np.float64)


@dataclass(frozen=True, eq=False)
class PlacedHead:
    """A head that landmarks place, before its mouth is fitted.

    Parameters
    ----------
    model : MouthModel
    shape : LandmarkShape
    textured : TexturedHead
    correspondence : Correspondence
    camera : Camera
    renderer : Renderer
    light : SkinLight, optional
        In which colours are learned; by default each frame is taken as it is.
    """

    model: MouthModel
    shape: LandmarkShape
    textured: TexturedHead
    correspondence: Correspondence
    camera: Camera
    renderer: Renderer
    light: SkinLight | None = None

    def frames(
        self, shape: LandmarkShape, seen: Sequence[tuple[Image, Landmarks]]
    ) -> list[PlacedFrame]:
        """The frames with the head placed by a person's landmarks as they are known so far."""

        def placed(one: tuple[Image, Landmarks]) -> FrameLandmarks | None:
            return placed_fit(self.textured, shape, *one)

        fits = in_threads(placed, seen, workers(self.renderer))
        return [
            PlacedFrame(i if self.light is None else self.light.balanced(i, m), SeenFace(m, fit))
            for (i, m), fit in zip(seen, fits, strict=True)
            if fit is not None
        ]

    @cached_property
    def lips(self) -> LipLandmarks:
        """Its lips, with the person modes."""
        person = self.correspondence.of(self.model.person_modes)
        return LipLandmarks.of(self.shape, self.model.n_expression, self.camera, person)

    def known(self, frames: Sequence[PlacedFrame], found: Calibration) -> LandmarkShape:
        """The person's landmarks once the mouth was fitted, and what the network is biased by."""
        model = self.model
        moved = np.tensordot(found.person, self.correspondence.of(model.person_modes), 1)
        own = replace(self.shape, mean=self.shape.mean + moved)
        p, off = model.n_expression, []
        pairs = list(zip(frames, found.expressions, strict=True))
        for frame, vector in sorted(pairs, key=lambda pair: pair[0].face.landmarks.openness):
            base = PoseFrame(shifted(frame.pose, found.shift, model.pivot), model.pivot)
            posture = np.r_[parted(vector)[1], frame.face.fit.posture[p:]]
            off.append(own.off(frame.face.landmarks, self.camera, base.pose(vector), posture))
        return self.shape.known(moved, off)


def calibrate_placed(
    head: PlacedHead,
    seen: Sequence[tuple[Image, Landmarks]],
    known: ColourClasses | None = None,
    chromatic: bool = True,
) -> tuple[Calibration, LandmarkShape]:
    """Fit the person's mouth and learn the clip's colours about heads that landmarks have placed.

    Parameters
    ----------
    head : PlacedHead
    seen : sequence of (image, Landmarks)
    known : ColourClasses, optional
        Colours that were learned before; then only the mouth is fitted.
    chromatic : bool
        Whether the clip is in colour.

    Returns
    -------
    Calibration
        Its shift is of the poses by texture and landmarks.
    LandmarkShape
        The person's landmarks, and what the network is biased by.

    Raises
    ------
    FaceNotFoundError
        If the mouth lies outside of the picture in all of them.
    """
    person, shape, shift = np.zeros(head.model.n_person), head.shape, no_correction()
    for blur in ROUNDS:
        placed = head.frames(shape, seen)
        if not placed:
            raise FaceNotFoundError(
                "the landmarks that were seen are no face's", "give a video with a face"
            )
        found = _round(head, placed, person, blur, known)
        person, shape, shift = found.person, head.known(placed, found), shift + found.shift
        head = replace(head, textured=replace(head.textured, shift=shift))
    agreement = _agreement(head, head.frames(shape, seen), found)
    classes = replace(found.classes, agreement=agreement, chromatic=chromatic)
    return replace(found, shift=shift, classes=classes), shape


def _agreement(head: PlacedHead, placed: Sequence[PlacedFrame], found: Calibration) -> float:
    """By how much apertures by colours alone grow with those by landmarks: a slope, about 1.

    1 where the mouth hardly moves by the landmarks: then nothing is told.
    """
    model = head.model
    stand = _Stand(model, placed, head.camera, head.renderer, no_correction(), found.person)
    starts = np.stack([f.start(model.n_expression) for f in placed])
    classes = replace(found.classes, agreement=1.0, separability={})
    told = _apertures(model, found.person, starts)
    if told.std() < LEAST_MOTION:
        return 1.0
    terms = stand.terms(classes, starts)
    alone = stand.postures(terms, starts, landmarks=False)
    seen = _apertures(model, found.person, alone)
    return float(np.cov(told, seen, bias=True)[0, 1] / told.var())


def _round(
    head: PlacedHead,
    placed: Sequence[PlacedFrame],
    person: FloatArray,
    blur: float,
    known: ColourClasses | None,
) -> Calibration:
    """Colours, then postures, then one mouth and one correction of the poses; postures again."""
    model = head.model
    depth = float(np.median([f.pose.translation[2] for f in placed]))
    deviation = SHIFT_DEVIATION * np.r_[np.ones(5), depth]
    vectors = np.stack([f.start(model.n_expression) for f in placed])
    stand = _Stand(model, placed, head.camera, head.renderer, no_correction(), person)
    classes = known or stand.learned(vectors, blur)
    terms = stand.terms(classes, vectors)
    vectors = stand.postures(terms, vectors)

    share = len(LIPS) / INNER_TOGETHER / len(placed)  # all frames say as much as one
    seen = [LipOutline(head.lips, f.face.landmarks, share) for f in placed]
    both = zip(terms, seen, strict=True)
    evidence: list[dict[str, Term]] = [{COLOUR: c, "landmarks": o} for c, o in both]
    frames, threads = [f.calibration for f in placed], workers(head.renderer)
    joint = person_problem(model, frames, evidence, vectors, deviation, threads)
    start = joint.blocks.vector({IDENTITY: person})
    found = Newton(limit=_PERSON_LIMIT, polished=40).minimise(joint, start, joint.spec).x
    shift, person = (joint.blocks.part(found, name) for name in (POSE, IDENTITY))
    stand = replace(stand, shift=shift, person=person)
    vectors = stand.postures(terms, vectors)
    return Calibration(person, shift, classes, vectors)


def _apertures(model: MouthModel, person: FloatArray, vectors: FloatArray) -> FloatArray:
    """Apertures (N,), mm, of a person in some poses and postures (N, 6 + P)."""
    return np.array([model.aperture(person, parted(v)[1]) for v in vectors], np.float64)


@dataclass(frozen=True, eq=False)
class _Stand:
    """Places of the frames' mouths."""

    model: MouthModel
    placed: Sequence[PlacedFrame]
    camera: Camera
    renderer: Renderer
    shift: FloatArray
    person: FloatArray

    def base(self, k: int) -> PoseFrame:
        pivot = self.model.pivot
        return PoseFrame(shifted(self.placed[k].pose, self.shift, pivot), pivot)

    def window(self, k: int) -> Window:
        return mouth_window(self.model, self.base(k).base, self.camera, self.person)

    def learned(self, vectors: FloatArray, blur: float) -> ColourClasses:
        """The colours by where the mouths are drawn (N, 6 + P), blurred by `blur` mm."""

        def shown(k: int) -> tuple[NDArray[np.generic], FloatArray]:
            window = self.window(k)
            patch = sampled(window, self.placed[k].image)
            return patch, self._places(k, window, vectors[k], blur)

        each = in_threads(shown, range(len(self.placed)), workers(self.renderer))
        return learn_placed([patch for patch, _ in each], [places for _, places in each])

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
        opening = _opening(drawn.class_id, names, sigma * OPENING / blur)
        places[3] = np.maximum(places[3], INSIDE * opening * places[1:].sum(axis=0))
        inside = in_picture(window, self.placed[k].image.shape)
        return np.asarray(0.95 * places / np.maximum(places.sum(axis=0), 1.0) * inside)

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
            return likelihood_of(*drawn, window, maps, classes.weight, seam_of(colours))

        return in_threads(made, range(len(self.placed)), workers(self.renderer))

    def postures(
        self, terms: Sequence[FacetLikelihood], vectors: FloatArray, landmarks: bool = True
    ) -> FloatArray:
        """Pose and posture of every frame, (N, 6 + P), each from where it was."""
        self.model.held(self.person)  # made once, for all threads

        def fitted(k: int) -> FloatArray:
            return self.fitted(k, terms[k], vectors[k], landmarks)

        return np.stack(in_threads(fitted, range(len(terms)), workers(self.renderer)))

    def fitted(
        self, k: int, term: FacetLikelihood, last: FloatArray, landmarks: bool = True
    ) -> FloatArray:
        """Pose and posture (6 + P,) of a frame by its colours, and by its landmarks, too."""
        told = self.placed[k].face.fit.evidence(self.model.n_expression)
        more = (told,) if landmarks else ()
        return fit_posture(
            self.model, term, self.base(k), self.person, last, _POSTURE_LIMIT, more
        ).x


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


def in_picture(window: Window, shape: tuple[int, ...]) -> NDArray[np.bool_]:
    """Mask of the drawn pixels (H, W) of a window that lie in the picture."""
    width, height = window.drawn
    grid = np.stack(np.meshgrid(np.arange(width), np.arange(height)), axis=-1)
    x, y = np.moveaxis(window.to_image(grid.astype(np.float64)), -1, 0)
    return np.asarray((x > -0.5) & (x < shape[1] - 0.5) & (y > -0.5) & (y < shape[0] - 0.5))
