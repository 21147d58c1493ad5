"""The person's mouth and the clip's colours, where landmarks have placed the head already.

With the place known, one start is enough: each round learns the colours where the drawn head shows
them, fits the frames' postures, then one mouth and one correction of the poses to all of them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import NamedTuple

import numpy as np

from abs_engine.core.arrays import FloatArray, Image
from abs_engine.core.camera import Camera
from abs_engine.core.errors import FaceNotFoundError
from abs_engine.core.geometry import Pose
from abs_engine.core.pose import PoseFrame, no_correction, parted
from abs_engine.core.scene import Renderer
from abs_engine.core.threads import in_threads, workers
from abs_engine.face.appearance.colour import ColourClasses
from abs_engine.face.appearance.colourless import is_grey
from abs_engine.face.appearance.exposure import Exposure
from abs_engine.face.head import MouthModel
from abs_engine.fit.evidence import Term
from abs_engine.fit.head_frame import COLOUR
from abs_engine.optimise.newton import Newton
from abs_engine.tracking.detection.landmarks import LIPS, Landmarks
from abs_engine.tracking.detection.light import SkinLight
from abs_engine.tracking.detection.mouth_search import shifted
from abs_engine.tracking.frame.frame_state import SeenFace
from abs_engine.tracking.frame.mouth_landmarks import LipLandmarks, LipOutline
from abs_engine.tracking.frame.placed_mouths import PlacedFrame, PlacedMouths
from abs_engine.tracking.head.head_pose import TexturedHead, placed_fit
from abs_engine.tracking.landmark.landmark_correspondence import Correspondence
from abs_engine.tracking.landmark.landmark_fit import FrameLandmarks, fit_frame
from abs_engine.tracking.landmark.landmark_shape import LandmarkShape
from abs_engine.tracking.person.identity_fit import Calibration, fit_shared
from abs_engine.tracking.settings.landmarks import LANDMARK_EVIDENCE


class PosedFrame(NamedTuple):
    """A frame, about where its head is, and a correction of that and the posture (6 + P,)."""

    frame: PlacedFrame
    pose: Pose
    vector: FloatArray


@dataclass(frozen=True, eq=False)
class PlacedHead:
    """A head that landmarks place, before its mouth is fitted.

    Parameters
    ----------
    light : SkinLight, optional
        In which colours are learned; by default each frame is taken as it is.
    grey_below : float, levels of 255
        Spread of a face's chroma below which a frame has no colour; 0 where none is asked.
    """

    model: MouthModel
    textured: TexturedHead
    correspondence: Correspondence
    renderer: Renderer
    light: SkinLight | None = None
    grey_below: float = 0.0

    def frames(self, seen: Sequence[tuple[Image, Landmarks]]) -> list[PlacedFrame]:
        """The frames with the head placed by the person's landmarks and texture."""
        shape = self.textured.shape
        return placed_frames(self.textured, shape, seen, self.light, self.grey_below)

    def again(self, frame: PlacedFrame, shape: LandmarkShape, shift: FloatArray) -> PlacedFrame:
        """One of the `frames`, once more is known of the person's landmarks, and of all poses.

        The texture lies where it lay, so that it is not looked for again. A frame that leads astray
        stays as it was.
        """
        fit, seen = frame.face.fit, frame.face.landmarks
        held = fit.held
        if held is not None:
            held = replace(held, pose=shifted(held.pose, shift, shape.pivot))
        try:
            found = fit_frame(shape, seen, self.textured.camera, fit, held)
        except np.linalg.LinAlgError:
            return frame
        return replace(frame, face=SeenFace(seen, found)) if found.sound(shape) else frame

    def mouths(self, placed: Sequence[PlacedFrame], person: FloatArray) -> PlacedMouths:
        """The mouths of frames, of a person (Q,), where the poses put them."""
        still, camera = no_correction(), self.textured.camera
        return PlacedMouths(self.model, placed, camera, self.renderer, still, person)

    @cached_property
    def lips(self) -> LipLandmarks:
        """Its lips, with the person modes."""
        person = self.correspondence.of(self.model.person_modes)
        textured = self.textured
        return LipLandmarks.of(textured.shape, self.model.n_expression, textured.camera, person)

    def posed(self, frames: Sequence[PlacedFrame], found: Calibration) -> list[PosedFrame]:
        """The frames as a calibration has posed their heads and mouths."""
        pivot = self.model.pivot
        each = zip(frames, found.expressions, strict=True)
        return [PosedFrame(f, shifted(f.pose, found.shift, pivot), v) for f, v in each]

    def known(self, posed: Sequence[PosedFrame], person: FloatArray) -> LandmarkShape:
        """The landmarks of a person (Q,) in fitted frames, and what the network is biased by."""
        model, shape, camera = self.model, self.textured.shape, self.textured.camera
        moved = np.tensordot(person, self.correspondence.of(model.person_modes), 1)
        own = replace(shape, mean=shape.mean + moved)
        p, off = model.n_expression, []
        for one in sorted(posed, key=lambda one: one.frame.face.landmarks.openness):
            pose, face = PoseFrame(one.pose, model.pivot).pose(one.vector), one.frame.face
            posture = np.r_[parted(one.vector)[1], face.fit.posture[p:]]
            off.append(own.off(face.landmarks, camera, pose, posture))
        return shape.known(moved, off)


def placed_frames(
    textured: TexturedHead,
    shape: LandmarkShape,
    seen: Sequence[tuple[Image, Landmarks]],
    light: SkinLight | None = None,
    grey_below: float = 0.0,
) -> list[PlacedFrame]:
    """The frames with the head where a person's landmarks and its texture place it.

    Without those whose landmarks are no face's. By default each is taken in its own light.
    """

    def placed(one: tuple[Image, Landmarks]) -> FrameLandmarks | None:
        return placed_fit(textured, shape, *one)

    fits = in_threads(placed, seen, workers(textured.renderer))
    return [
        PlacedFrame(
            i if light is None else light.balanced(i, m),
            SeenFace(m, fit),
            is_grey(i, m.pixels, grey_below),
        )
        for (i, m), fit in zip(seen, fits, strict=True)
        if fit is not None
    ]


def calibrate_placed(
    head: PlacedHead,
    seen: Sequence[tuple[Image, Landmarks]],
    known: ColourClasses | None = None,
    chromatic: bool = True,
) -> tuple[Calibration, LandmarkShape, list[PosedFrame]]:
    """Fit the person's mouth and learn the clip's colours about heads that landmarks have placed.

    With `known` colours only the mouth is fitted. `chromatic` is whether they, and the clip, are in
    colour.

    Returns
    -------
    Calibration
        Its shift is of the poses by texture and landmarks.
    LandmarkShape
        The person's landmarks, and what the network is biased by.
    list of PosedFrame
        The frames as they were fitted last.

    Raises
    ------
    FaceNotFoundError
        If the mouth lies outside of the picture in all of them.
    """
    person, shift = np.zeros(head.model.n_person), no_correction()
    threads, camera = workers(head.renderer), head.textured.camera
    first = placed = head.frames(seen)
    for blur in LANDMARK_EVIDENCE.place_rounds:
        learned = placed if known is not None else [frame for frame in placed if not frame.grey]
        if not learned:
            given = not np.array_equal(camera.matrix, Camera.ideal(camera.size).matrix)
            raise FaceNotFoundError(
                "the landmarks found are not those of a face" + given * " by the given camera",
                "give a video with a face" + given * ", and check --camera",
            )
        found = _round(head, placed, person, blur, known, chromatic)
        posed = head.posed(placed, found)
        person, shift = found.person, shift + found.shift
        shape = head.known(posed, person)
        moved = partial(head.again, shape=shape, shift=shift)
        placed = in_threads(moved, first, threads)
    coloured = [frame for frame in placed if not frame.grey]
    agreement = _agreement(head, coloured, found)
    exposure = Exposure.of([(image, marks.pixels) for image, marks in seen])
    classes = replace(found.classes, agreement=agreement, exposure=exposure)
    return replace(found, shift=shift, classes=classes), shape, posed


def _agreement(head: PlacedHead, placed: Sequence[PlacedFrame], found: Calibration) -> float:
    """Growth of apertures by colours alone with those by landmarks, see `following`.

    1 where the mouth is closed and hardly moves by the landmarks, or no frame has colour: then
    there is nothing to judge by.
    """
    if not placed:
        return 1.0
    model = head.model
    stand = head.mouths(placed, found.person)
    starts = np.stack([f.start(model.n_expression) for f in placed])
    classes = replace(found.classes, agreement=1.0, separability={})
    told = _apertures(model, found.person, starts)
    if not (_moves(told) or _open(told)):
        return 1.0
    terms = stand.terms(classes, starts)
    alone = stand.postures(terms, starts, landmarks=False)
    seen = _apertures(model, found.person, alone)
    return following(told, seen)


def following(marked: FloatArray, seen: FloatArray) -> float:
    """Growth of apertures (N,), mm, by colours alone with those by landmarks: a slope, about 1.

    Or, where that is less than both the slope and 1, the share of the other aperture in the median
    frame of a mouth that is plainly open: a slope rests on the widest openings, and may hide that
    most others are taken for closed. Where they hardly move there is no slope.
    """
    moves = _moves(marked)
    slope = float(np.cov(marked, seen, bias=True)[0, 1] / marked.var()) if moves else 1.0
    if not _open(marked):
        return slope
    plain = marked > LANDMARK_EVIDENCE.plainly_open
    share = float(np.median(seen[plain] / marked[plain]))
    return min(slope, share) if share < 1 else slope


def _moves(marked: FloatArray) -> bool:
    """Whether apertures (N,), mm, change by enough to judge by."""
    return bool(marked.std() >= LANDMARK_EVIDENCE.least_motion)


def _open(marked: FloatArray) -> bool:
    """Whether enough of them are plainly open."""
    plain = marked > LANDMARK_EVIDENCE.plainly_open
    return bool(plain.sum() >= LANDMARK_EVIDENCE.fewest_open)


def _round(
    head: PlacedHead,
    placed: Sequence[PlacedFrame],
    person: FloatArray,
    blur: float,
    known: ColourClasses | None,
    chromatic: bool,
) -> Calibration:
    """Colours, then postures, then one mouth and one correction of the poses; postures again."""
    model = head.model
    depth = float(np.median([f.pose.translation[2] for f in placed]))
    deviation = LANDMARK_EVIDENCE.shift_deviation * np.r_[np.ones(5), depth]
    vectors = np.stack([f.start(model.n_expression) for f in placed])
    stand = head.mouths(placed, person)
    classes = known or stand.learned(vectors, blur, chromatic)
    terms = stand.terms(classes, vectors)
    vectors = stand.postures(terms, vectors)

    # all frames say as much as one
    share = len(LIPS) / LANDMARK_EVIDENCE.inner_together / len(placed)
    seen = [LipOutline(head.lips, f.face.landmarks, share) for f in placed]
    both = zip(terms, seen, strict=True)
    evidence: list[dict[str, Term]] = [{COLOUR: c, "landmarks": o} for c, o in both]
    poses, threads = [f.pose for f in placed], workers(head.renderer)
    solver, begun = Newton(limit=LANDMARK_EVIDENCE.person_limit, polished=0), (stand.shift, person)
    shift, person = fit_shared(model, poses, evidence, vectors, deviation, begun, solver, threads)
    stand = replace(stand, shift=shift, person=person)
    vectors = stand.postures(terms, vectors, again=True)
    return Calibration(person, shift, classes, vectors)


def _apertures(model: MouthModel, person: FloatArray, vectors: FloatArray) -> FloatArray:
    """Apertures (N,), mm, of a person in some poses and postures (N, 6 + P)."""
    return np.array([model.aperture(person, parted(v)[1]) for v in vectors], np.float64)
