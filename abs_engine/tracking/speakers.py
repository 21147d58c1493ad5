"""A clip of a speaker whose face was learned from other recordings."""

from __future__ import annotations

from dataclasses import replace
from itertools import islice
from pathlib import Path

from abs_engine.core.errors import FaceNotFoundError, ParameterError
from abs_engine.core.scene import Renderer
from abs_engine.face.appearance.colourless import in_colour
from abs_engine.face.appearance.exposure import Exposure, colourless
from abs_engine.io.assets import Speaker, load_speaker
from abs_engine.tracking.face_choice import FaceChoice, FaceFollower
from abs_engine.tracking.heads import correspondence_of, head_setting
from abs_engine.tracking.initial_pose import FaceBox
from abs_engine.tracking.light import SkinLight
from abs_engine.tracking.options import (
    LANDMARKS,
    Clip,
    ClipTracker,
    Leaves,
    Model,
    Tell,
    TrackOptions,
)
from abs_engine.tracking.settings.preparation import PREPARATION
from abs_engine.tracking.speaker_face import SpeakerFace, load_speaker_face
from abs_engine.tracking.speaker_looks import LOOKS, compared, looking


def prepare_speaker(
    clip: Clip, options: TrackOptions, leaves: Leaves, renderer: Renderer, tell: Tell
) -> ClipTracker:
    """Make a clip ready for the face of its speaker: only the face has to be found.

    Raises
    ------
    InputFileError, ModelFormatError
        If the face's file cannot be read, or is of another head.
    FaceNotFoundError
        If no face is found.
    ParameterError
        If no file is given, or the clip has no colour but the face was learned in colour.
    """
    path, speaker = options.model_file, load_speaker(options.speaker)
    if path is None:
        raise ParameterError("a speaker's face is learned", "give its file: --model me.face")
    face = load_speaker_face(path, speaker)
    _check(path, face, leaves, options)
    return track_speaker(clip, face, options, leaves, renderer, tell, speaker=speaker)


def _check(path: Path, face: SpeakerFace, leaves: Leaves, options: TrackOptions) -> None:
    """Raise `ParameterError` if the evidence does not go with the face, or with other choices."""
    asked = [name for name in LOOKS if name in leaves.kinds]
    if asked and face.appearance is None:
        raise ParameterError(
            f"{path} has no {asked[0]} to compare",
            "use --terms colour, or learn it again: with an earlier release, or of a head without "
            "texture coordinates, none is learned",
        )
    if asked and options.colours is not None:
        raise ParameterError(
            f"{asked[0]} is compared in the light that the face was learned in, not in that of "
            "--colours",
            "leave out --colours, or use --terms colour",
        )
    leaves.check("speaker", ("colour", *LOOKS))


def track_speaker(
    clip: Clip,
    face: SpeakerFace,
    options: TrackOptions,
    leaves: Leaves,
    renderer: Renderer,
    tell: Tell,
    first: int = 0,
    speaker: Speaker | None = None,
) -> ClipTracker:
    """A clip of the speaker with this face, from frame `first` on; errors as `prepare_speaker`.

    The face is made of the head `speaker`, by default that of the options.
    """
    speaker = load_speaker(options.speaker) if speaker is None else speaker
    correspondence = correspondence_of(speaker, renderer)
    box = None if options.mouth is None else FaceBox.around_mouth(*options.mouth)
    choice = FaceChoice(options.face, box)
    tell("finding the face")
    follower = FaceFollower(choice)
    seen = None
    for image in islice(clip.frames(), first, first + PREPARATION.look_at):
        found = follower.step(image)
        if found is not None:
            seen = image, found
            break
    if seen is None:
        raise FaceNotFoundError(
            f"no face was found in {len(follower.found)} frames of {clip.video}",
            "give a video with a frontal face, or the mouth's box in the first frame with --mouth",
        )
    shown = [(seen[0], seen[1].pixels)]
    exposure = Exposure.of(shown)
    if face.classes.chromatic and not in_colour(shown):
        raise ParameterError(
            f"{colourless(clip.video, exposure)}, but the face was learned in colour",
            "track it without --model, or learn a face from recordings without colour",
        )
    if clip.colours is not None:
        face = face.coloured(clip.colours, SkinLight.of([seen]))
    face = replace(face, classes=replace(face.classes, exposure=exposure))
    fitted = face.fitted(speaker, correspondence, clip.camera, renderer)
    before = clip.first(follower.found)
    head = fitted.face
    if face.appearance is not None and any(name in leaves.kinds for name in LOOKS):
        head = looking(head, face.appearance, compared(face, speaker))
    setting = head_setting(clip, fitted, renderer, options, leaves, choice, before, head)
    facts = {"start": LANDMARKS, "evidence": options.evidence}
    return ClipTracker(clip.video, clip.info, setting, face.scale, follower.remarks(), facts)


SPEAKER = Model(
    prepare_speaker, starts=(LANDMARKS,), without=("physics", "person", "poses", "pupil_distance")
)
"""Found from landmarks, as a stranger is; nothing is learned of the clip."""
