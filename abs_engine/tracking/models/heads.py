"""A head made ready: its face found, its person fitted, the clip's colours learned."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import cast

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.arrays import Image
from abs_engine.core.errors import FaceNotFoundError, MeshError
from abs_engine.core.foreign import own
from abs_engine.core.pose import no_correction
from abs_engine.core.scene import Renderer
from abs_engine.core.threads import meanwhile
from abs_engine.face.base import Face
from abs_engine.fit.shading import NAME as SHADED
from abs_engine.io.assets import Speaker, load_speaker
from abs_engine.io.video import read_frames
from abs_engine.learn.heads.table import EYES_MM
from abs_engine.tracking.detection.face_choice import LARGEST, FaceChoice, FaceFollower, by_size
from abs_engine.tracking.detection.face_detection import faces_any_way_up
from abs_engine.tracking.detection.first_look import follower_of
from abs_engine.tracking.detection.initial_pose import FaceBox
from abs_engine.tracking.detection.landmarks import Landmarks
from abs_engine.tracking.frame.clip_setting import NO_FACE, NO_POSE, ClipSetting
from abs_engine.tracking.frame.cut_faces import shows_eyes
from abs_engine.tracking.frame.external_poses import GivenMotion
from abs_engine.tracking.frame.frame_state import ShiftedMotion
from abs_engine.tracking.frame.head_frame import HeadBinder
from abs_engine.tracking.frame.landmark_motion import LandmarkMotion
from abs_engine.tracking.frame.mouth_landmarks import BOTH, LipLandmarks, MouthLandmarks
from abs_engine.tracking.frame.mouth_visibility import ByLook
from abs_engine.tracking.head.head_fit import AverageHead
from abs_engine.tracking.landmark import landmark_jacobian
from abs_engine.tracking.landmark.landmark_correspondence import Correspondence
from abs_engine.tracking.landmark.rendered_landmarks import correspondence_of
from abs_engine.tracking.options import LANDMARKS, Clip, ClipTracker, Leaves, Tell, TrackOptions
from abs_engine.tracking.person.expected_person import anybody
from abs_engine.tracking.person.frame_choice import candidate_frames, frames_to_learn, to_learn_from
from abs_engine.tracking.person.scale import (
    Scale,
    known_scale,
    proportion,
    pupil_distance,
    pupil_scale,
)
from abs_engine.tracking.results.run_warnings import NO_EYES, stretched
from abs_engine.tracking.start import beforehand
from abs_engine.tracking.start.blob_start import by_blobs, mouth_model, physics_expression
from abs_engine.tracking.start.given_head import GivenHead
from abs_engine.tracking.start.person_fit import FittedPerson, fit_person
from abs_engine.tracking.start.plugin_trial import Trial
from abs_engine.tracking.start.shaded_skin import with_shaded_skin


def prepare_head(
    clip: Clip,
    options: TrackOptions,
    leaves: Leaves,
    renderer: Renderer,
    stage: Tell,
    speaker: Speaker | None = None,
) -> ClipTracker:
    """Find the face, learn the clip's colours and fit the person's head.

    Parameters
    ----------
    clip : Clip
    options : TrackOptions
    leaves : Leaves
    renderer : Renderer
    stage : callable
        Called with what is begun, in a few words.
    speaker : Speaker, optional
        The head; by default that of `options.speaker`, or the bundled one.

    Raises
    ------
    InputFileError, VideoError
        If the video cannot be read.
    FaceNotFoundError
        If no face is found.
    TooFewPixelsError
        If too little of it is seen to learn its colours; from landmarks that is no reason.
    ParameterError
        If given poses do not fit the video, or the evidence or the driver not the head.
    MeshError
        If a plugin's head has fewer vertices than its facets name, vertices that are not
        finite, no skin or lips, or no human size.
    TermError
        If a plugin's evidence fails on a drawing of the average head, or is not finite there.
    """
    leaves.check("head")
    speaker = load_speaker(options.speaker) if speaker is None else speaker
    _check_made(speaker)
    if not all(own(kind.bind) for kind in leaves.kinds.values()):
        Trial(mouth_model(speaker, None), clip.camera, renderer).check(leaves.kinds)
    placed = options.start == LANDMARKS and options.poses is None  # by landmarks, known or not
    if options.from_landmarks or (speaker.imported and placed):
        correspondence = correspondence_of(speaker, renderer)
        try:
            return stated(
                by_landmarks(clip, speaker, correspondence, renderer, options, leaves, stage)
            )
        except FaceNotFoundError:
            expected = options.mouth is not None or options.poses is not None
            if not expected or options.pupil_distance or options.evidence != BOTH:
                raise
        if options.mouth is not None:
            _check_box(clip.video, FaceBox.around_mouth(*options.mouth))
        remark = "no face was seen where it was expected: started from colours"
        with _box_named(options):
            plain = leaves.without(SHADED)
            by_colour = by_blobs(clip, speaker, renderer, options, plain, stage)
        return stated(replace(by_colour, remarks=remark))
    with _box_named(options):
        return stated(by_blobs(clip, speaker, renderer, options, leaves, stage))


def stated(made: ClipTracker) -> ClipTracker:
    """The same, which states the evidence that is compared: shading may have been left out."""
    kinds = cast(HeadBinder, made.setting.binder).kinds
    return replace(made, facts={**made.facts, "terms": list(kinds)})


@contextmanager
def _box_named(options: TrackOptions) -> Iterator[None]:
    """Advice of who gave the mouth's box, and no face is found there, not to give it."""
    try:
        yield
    except FaceNotFoundError as error:
        if options.mouth is None or "--mouth" not in error.remedy:
            raise
        raise FaceNotFoundError(
            error.problem, "check that --mouth holds the whole mouth in the first frame"
        ) from error


_OUTSIDE = ("skin", "upper_lip", "lower_lip")
"""Facet classes that no head does without."""


def _check_made(speaker: Speaker) -> None:
    """Raise `MeshError` for a head that a plugin made wrongly; files were checked."""
    vertices, needed = speaker.vertices, int(speaker.faces.max(initial=-1)) + 1
    fault = ""
    if len(vertices) < needed:
        fault = f"has {len(vertices)} vertices, but its facets need {needed}"
    elif not np.isfinite(vertices).all():
        fault = "has vertices that are not all finite"
    elif bare := [one for one in _OUTSIDE if not speaker.facets_of(one).any()]:
        fault = f"has no facets of {', '.join(bare)}"
    elif "landmark_68" in speaker.points:
        outer = vertices[speaker.points["landmark_68"][[36, 45]]]
        eyes, (_, least, most) = float(np.linalg.norm(outer[1] - outer[0])), EYES_MM
        if not least < eyes < most:
            fault = f"has the outer corners of its eyes {eyes:.0f} mm apart"
    if fault:
        raise MeshError(f"the head {fault}", "correct the model that makes it")


def _check_box(video: Path, box: FaceBox) -> None:
    """Raise `FaceNotFoundError` if the first frame shows a face whose mouth lies elsewhere."""
    faces = faces_any_way_up(next(iter(read_frames(video))))
    if faces and box.shown(faces) is None:
        x, y = by_size(faces)[0].mouth
        raise FaceNotFoundError(
            f"no face has its mouth in that box; the largest face has it at {x:.0f} {y:.0f}",
            "give the box of its mouth in the first frame, or leave out --mouth",
        )


def by_landmarks(
    clip: Clip,
    speaker: Speaker,
    correspondence: Correspondence,
    renderer: Renderer,
    options: TrackOptions,
    leaves: Leaves,
    tell: Tell,
) -> ClipTracker:
    """Start from landmarks: they place the whole head, and colours are learned where it lies.

    Of a person whose head is known, only how it looks in the clip is learned.
    """
    known, made_with = options.person is not None, speaker
    speaker, correspondence, scale = _begun_from(speaker, correspondence, options)
    given = None if options.poses is None else GivenHead.read(options.poses, clip, speaker)
    choice = FaceChoice.asked(options.face, options.mouth)
    if given is not None:
        choice = given.choice(speaker)
    tell("finding the face")
    expression = None
    if options.physics is not None:
        expression = physics_expression(made_with, speaker.vertices, options.physics)
    follower = follower_of(clip.video, choice)

    def loaded() -> AverageHead:
        landmark_jacobian.load()
        beforehand.load_tables()
        return AverageHead.of(speaker, correspondence, scale, expression, known=known)

    with meanwhile(loaded) as average:
        numbered = candidate_frames(_numbered(clip, follower), str(clip.video))
    seen, grey = to_learn_from([(image, marks) for image, (_, marks) in numbered])
    chosen, turned = frames_to_learn(seen)
    tell("fitting the head")
    fitted = fit_person(
        average.result(), chosen, clip.camera, renderer, clip.colours, tell, turned, grey, seen
    )
    leaves, face, warnings = with_shaded_skin(leaves, fitted.face, clip.camera, fitted.posed)
    poses = None if given is None else given.aligned(fitted, numbered)
    first = clip.first(follower.found)
    setting = head_setting(clip, fitted, renderer, options, leaves, choice, first, face, poses)
    if not known:
        eyes = [shows_eyes(marks, clip.info.size) for _, marks in turned]
        scale, doubts = _measured(scale, eyes, fitted.model.head.mean, speaker)
        warnings = (*doubts, *warnings)
    setting = replace(setting, warnings=warnings)
    facts = {"start": LANDMARKS, "evidence": options.evidence}
    return ClipTracker(clip.video, clip.info, setting, scale, follower.remarks(), facts)


def _begun_from(
    speaker: Speaker, correspondence: Correspondence, options: TrackOptions
) -> tuple[Speaker, Correspondence, Scale]:
    """The head that a fit begins with, a known person's or anybody's, its landmarks and scale."""
    if options.person is None:
        scale = pupil_scale(options.pupil_distance)
        return *anybody(speaker, correspondence), scale
    person = replace(speaker, vertices=speaker.named(options.person))
    scale = known_scale(pupil_distance(person, person.vertices), person=True, poses=False)
    return person, correspondence, scale


def _measured(
    scale: Scale, eyes: Sequence[bool], head: NDArray[np.floating], speaker: Speaker
) -> tuple[Scale, tuple[str, ...]]:
    """The scale of a fitted head (V, 3), and warnings, by whether frames show its eyes."""
    if 2 * sum(eyes) < len(eyes):
        scale = scale.without_eyes
        return scale, (NO_EYES.format(scale.uncertainty),)
    return scale, stretched(proportion(head, speaker))


def _numbered(
    clip: Clip, follower: FaceFollower
) -> Iterator[tuple[Image, tuple[int, Landmarks] | None]]:
    """A clip's frames, and where they show the face, their numbers and its landmarks."""
    for k, image in enumerate(clip.frames()):
        marks = follower.step(image)
        yield image, None if marks is None else (k, marks)


def head_setting(
    clip: Clip,
    fitted: FittedPerson,
    renderer: Renderer,
    options: TrackOptions,
    leaves: Leaves,
    choice: FaceChoice,
    found: Sequence[Landmarks | None],
    face: Face,
    given: GivenMotion | None = None,
) -> ClipSetting:
    """A clip of a person whose head and colours are known.

    `found` are its first landmarks; `face` is the person's, with what else was learned of it;
    `given` are the head's poses, where they are known.
    """
    model, classes, shape = fitted.model, fitted.classes, fitted.shape
    # The person's landmarks are as uncertain as anybody's: what a fit may lie off them
    noisy = replace(shape, deviation=fitted.deviation)
    lips = LipLandmarks.of(noisy, model.n_expression, clip.camera)
    marks = MouthLandmarks(model.n_expression, lips, options.evidence)
    binder = HeadBinder(
        model,
        face,
        clip.camera,
        renderer,
        clip.info.rate,
        marks,
        leaves.kinds,
        steps=fitted.steps,
        seen=fitted.seen,
    )
    own = LandmarkMotion(
        shape, fitted.textured, choice, tuple(found), fitted.light, given, fitted.grey_below,
        clip.info.rate,
    )  # fmt: skip
    motion = ShiftedMotion(own, no_correction(), model.pivot)
    return ClipSetting(
        face, clip.camera, renderer, clip.info.rate, motion, binder, leaves.driver.minimiser(),
        ByLook(classes, fitted.look, fitted.place), clip.info.times,
        NO_FACE if given is None else NO_POSE, landmarks=marks,
        learned_lips=options.physics is not None, others=choice == LARGEST,
    )  # fmt: skip
