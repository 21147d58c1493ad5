"""A person's head and colours, fitted to frames of one clip or of several."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from abs_engine.core.arrays import FloatArray, Image
from abs_engine.core.camera import Camera
from abs_engine.core.geometry import Pose
from abs_engine.core.params import ParamSpec
from abs_engine.core.pose import no_correction
from abs_engine.core.scene import Renderer
from abs_engine.core.threads import in_threads
from abs_engine.face.appearance.colour import ColourClasses, usable
from abs_engine.face.appearance.colourless import in_colour, is_grey
from abs_engine.face.base import Face
from abs_engine.face.head import MouthModel, build_mouth_model
from abs_engine.face.held_head import held_head
from abs_engine.tracking.detection.landmarks import Landmarks
from abs_engine.tracking.detection.light import SkinLight
from abs_engine.tracking.frame.cut_faces import MouthInPicture
from abs_engine.tracking.frame.landmark_calibration import (
    PlacedHead,
    PosedFrame,
    calibrate_placed,
    placed_frames,
)
from abs_engine.tracking.frame.mouth_visibility import MouthLook
from abs_engine.tracking.frame.placed_mouths import PlacedMouths
from abs_engine.tracking.head.head_fit import AverageHead, seen_in
from abs_engine.tracking.head.head_pose import TexturedHead
from abs_engine.tracking.landmark.landmark_shape import LandmarkShape
from abs_engine.tracking.person.frame_choice import Sighted, frames_to_learn
from abs_engine.tracking.person.multistart import learning
from abs_engine.tracking.settings.landmarks import LANDMARK_EVIDENCE
from abs_engine.tracking.settings.preparation import PREPARATION

Posed = tuple[Image, Pose, FloatArray]
"""A frame whose head and mouth are posed: see `FittedPerson.posed`."""


@dataclass(frozen=True, eq=False)
class FittedPerson:
    """A person's head, mouth and colours, as frames are tracked with them.

    Parameters
    ----------
    person : (Q,) float64
        The mouth: weights of the person modes.
    textured : TexturedHead
        The head with what frames show of it, its poses corrected by the mouth.
    shape : LandmarkShape
        The person's landmarks, and what the network is biased by.
    deviation : (468, 3) float64, mm
        That of the network on anybody.
    light : SkinLight
        In which the colours were learned.
    posture : ParamSpec or None
        Names and bounds of the model's expression; by default those of anybody's modes.
    steps : (P,) float64 or None
        How far each of them moves in 40 ms, standard deviations, where that was learned.
    seen : (K, P) float64 or None
        Postures that were seen of this person.
    grey_below : float
        See `LandmarkMotion`.
    posed : sequence
        Frames (H, W, 3) in colour that the mouth was fitted to and shows in, if any; each with
        about where its head is, and a correction of that and the posture (6 + P,).
    """

    model: MouthModel
    person: FloatArray
    textured: TexturedHead
    shape: LandmarkShape
    deviation: FloatArray
    classes: ColourClasses
    light: SkinLight
    look: MouthLook | None
    posture: ParamSpec | None = None
    steps: FloatArray | None = None
    seen: FloatArray | None = None
    grey_below: float = 0.0
    posed: Sequence[Posed] = ()

    @cached_property
    def face(self) -> Face:
        """The head with the person held, and its colours."""
        face = held_head(self.model, self.person, self.classes)
        return face if self.posture is None else replace(face, posture=self.posture)

    @cached_property
    def place(self) -> MouthInPicture:
        """Test of whether the mouth lies in a frame's picture."""
        return MouthInPicture(self.shape, self.model.n_expression, self.textured.camera)

    def shows(self, image: Image, seen: Landmarks) -> bool:
        """Whether a frame shows the mouth; of a clip without a usual look, each does it whole."""
        if not self.place.whole(seen):
            return False
        if self.look is None:
            return True
        if is_grey(image, seen.pixels, self.grey_below) and not self.light.same_hue(image, seen):
            return True
        now = MouthLook.of(self.classes, self.light.balanced(image, seen), seen)
        return now is not None and not self.look.hidden(now)

    def posed_in(self, seen: Sequence[Sighted], renderer: Renderer) -> Iterator[Posed]:
        """The frames that show the mouth, with where the head and its posture are in them."""
        shown = [one for one in seen if self.shows(*one)]
        placed = placed_frames(self.textured, self.shape, shown, self.light)
        if not placed:
            return
        model, still = self.model, no_correction()
        mouths = PlacedMouths(model, placed, self.textured.camera, renderer, still, self.person)
        starts = np.stack([frame.start(model.n_expression) for frame in placed])
        vectors = mouths.postures(mouths.terms(self.classes, starts), starts)
        for frame, vector in zip(placed, vectors, strict=True):
            yield frame.image, frame.pose, vector

    def posed_by(self, posed: Iterable[PosedFrame]) -> FittedPerson:
        """The same with those frames that a calibration has posed and that show the mouth."""
        frames = [
            (frame.image, pose, vector)
            for frame, pose, vector in posed
            if not frame.grey and self.shows(frame.image, frame.face.landmarks)
        ]
        return replace(self, posed=frames)


def fit_person(
    average: AverageHead,
    chosen: Sequence[tuple[Image, Landmarks]],
    camera: Camera,
    renderer: Renderer,
    colours: ColourClasses | None,
    tell: Callable[[str], None],
    turned: Sequence[tuple[Image, Landmarks]] | None = None,
    grey_below: float = 0.0,
    others: Sequence[tuple[Image, Landmarks]] = (),
) -> FittedPerson:
    """Fit the whole head, the mouth and the colours to frames of one camera that show one person.

    Again without those in which the mouth is hidden, if there are any: frames are then chosen anew
    among `others`, where there are some. The head is fitted to the frames `turned`, by default to
    the `chosen` ones, too. Given `colours` are not learned.
    `tell` is called with what is begun, in a few words. A frame whose face has a spread of chroma
    below `grey_below` has no colour, and nothing hides its mouth.

    Raises
    ------
    FaceNotFoundError
        If the mouth lies outside of the picture in all of them.
    """
    given = camera, renderer, colours, tell, grey_below
    turned = turned or chosen
    fitted = _fitted(average, chosen, turned, *given)
    for _ in range(PREPARATION.hidden_rounds):
        if all(fitted.shows(*one) for one in (*chosen, *turned)):
            break
        shown = [one for one in others or chosen if fitted.shows(*one)]
        if len(shown) < PREPARATION.least_shown:
            break
        facing = [one for one in turned if fitted.shows(*one)]
        if others:
            chosen, turned = frames_to_learn(shown)
        else:
            chosen, turned = shown, facing if len(facing) >= PREPARATION.least_shown else shown
        fitted = _fitted(average, chosen, turned, *given)
    return fitted


def _fitted(
    average: AverageHead,
    chosen: Sequence[Sighted],
    turned: Sequence[Sighted],
    camera: Camera,
    renderer: Renderer,
    colours: ColourClasses | None,
    tell: Callable[[str], None],
    grey_below: float,
) -> FittedPerson:
    """The person by these frames, whether the mouth is hidden in them or not."""
    speaker = average.speaker
    seen = in_threads(lambda one: seen_in(*one), turned)
    head = average.fitted(seen, camera, renderer)
    model = build_mouth_model(
        head.speaker, head.neutral, speaker.texture(),
        free_person=not average.known, expression=head.expression,
        person_spread=PREPARATION.person_spread,
    )  # fmt: skip
    coloured = [one for one in chosen if not is_grey(one[0], one[1].pixels, grey_below)]
    below = grey_below if coloured else 0.0
    coloured = coloured or list(chosen)
    chromatic = in_colour([(image, landmarks.pixels) for image, landmarks in coloured])
    known = usable(colours, chromatic)
    tell(learning(known))
    light = SkinLight.of(coloured)
    placed = PlacedHead(model, head.textured, average.correspondence, renderer, light, below)
    # Where there is no colour, landmarks are all that is known of the mouth, and err
    telling = coloured if len(coloured) >= LANDMARK_EVIDENCE.closest else chosen
    found, shape, posed = calibrate_placed(placed, telling, known, chromatic)

    def looked(one: Sighted) -> MouthLook | None:
        image, marks = one
        return MouthLook.of(found.classes, light.balanced(image, marks), marks)

    look = MouthLook.usual(in_threads(looked, coloured))
    fitted = FittedPerson(
        model, found.person, replace(head.textured, shift=found.shift), shape,
        head.textured.shape.deviation, found.classes, light, look, grey_below=below,
    )  # fmt: skip
    return fitted.posed_by(posed)
