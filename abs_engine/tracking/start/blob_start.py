"""A head made ready by its face's six points and the colours about them, or one that is known."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.arrays import FloatArray
from abs_engine.core.camera import Camera
from abs_engine.core.errors import ParameterError
from abs_engine.core.geometry import Pose
from abs_engine.core.scene import Renderer
from abs_engine.face.appearance.colour import usable
from abs_engine.face.appearance.colourless import in_colour
from abs_engine.face.appearance.exposure import Exposure, colourless
from abs_engine.face.head import MouthModel, build_mouth_model
from abs_engine.face.held_head import held_head
from abs_engine.face.shape.linear import LinearShape
from abs_engine.io.assets import Speaker
from abs_engine.tracking.detection.initial_pose import FaceBox
from abs_engine.tracking.detection.mouth_search import CalibrationFrame, shifted
from abs_engine.tracking.frame.blob_visibility import ByBlob, MouthEvidence
from abs_engine.tracking.frame.clip_setting import NO_FACE, NO_POSE, ClipSetting
from abs_engine.tracking.frame.external_poses import GivenMotion
from abs_engine.tracking.frame.frame_state import ShiftedMotion
from abs_engine.tracking.frame.head_frame import HeadBinder
from abs_engine.tracking.frame.head_tracking import HeadMotion, followed
from abs_engine.tracking.frame.mouth_landmarks import MouthLandmarks
from abs_engine.tracking.options import BLOBS, Clip, ClipTracker, Leaves, Tell, TrackOptions
from abs_engine.tracking.person.frame_choice import choose_frames
from abs_engine.tracking.person.identity_fit import Calibration
from abs_engine.tracking.person.multistart import calibrate_well
from abs_engine.tracking.person.scale import known_scale, pupil_distance
from abs_engine.tracking.runs.poses_file import read_poses
from abs_engine.tracking.start.shaded_skin import with_shaded_skin


def by_blobs(
    clip: Clip,
    speaker: Speaker,
    renderer: Renderer,
    options: TrackOptions,
    leaves: Leaves,
    tell: Tell,
) -> ClipTracker:
    """Start from a face's six points and the colours about them, or with a head that is known."""
    model = mouth_model(speaker, options.person, options.physics)
    calibration, own, frames = _calibrated(clip, model, renderer, options, tell)
    given = isinstance(own, GivenMotion)
    held = given and model.known  # then poses are taken as they are
    shift = np.zeros(len(calibration.shift)) if held else calibration.shift
    face = held_head(model, calibration.person, calibration.classes)
    posed = [(f.image, shifted(f.pose, shift, model.pivot)) for f in frames]
    shown = ((*one, v) for one, v in zip(posed, calibration.expressions, strict=True))
    leaves, face, warnings = with_shaded_skin(leaves, face, clip.camera, shown)
    binder = HeadBinder(
        model, face, clip.camera, renderer, clip.info.rate, MouthLandmarks(model.n_expression),
        leaves.kinds, held,
    )  # fmt: skip
    sight = ByBlob(calibration.classes, model, clip.camera, calibration.person)
    usual = MouthEvidence.usual([sight.evidence(*one) for one in posed])
    pupils = pupil_distance(speaker, model.whole(calibration.person))
    motion = ShiftedMotion(own, shift, model.pivot)
    setting = ClipSetting(
        face, clip.camera, renderer, clip.info.rate, motion, binder, leaves.driver.minimiser(),
        replace(sight, usual=usual), clip.info.times,
        NO_POSE if given else NO_FACE, pose_held=held, warnings=warnings,
    )  # fmt: skip
    scale = known_scale(pupils, options.person is not None, given)
    facts = {"start": BLOBS, "evidence": None}
    return ClipTracker(clip.video, clip.info, setting, scale, facts=facts)


def _outline(model: MouthModel, pose: Pose, camera: Camera) -> FloatArray:
    """Points (N, 2), px, whose hull holds the upper face and the lips."""
    head = model.head
    points = np.vstack([head.mean[np.unique(head.faces[model.rigid])], model.border()])
    return camera.project(pose.apply(points))


def _calibrated(
    clip: Clip, model: MouthModel, renderer: Renderer, options: TrackOptions, tell: Tell
) -> tuple[Calibration, HeadMotion | GivenMotion, list[CalibrationFrame]]:
    """Follow the face, learn the clip's colours about it and fit the mouth to some frames.

    Raises
    ------
    FaceNotFoundError
        If no face is found.
    TooFewPixelsError
        If too little of it is seen to learn its colours.
    ParameterError
        If the video has none, and the head is not known.
    """
    video, camera, colours = clip.video, clip.camera, clip.colours
    given = None if options.poses is None else read_poses(options.poses)
    motion: HeadMotion | GivenMotion
    if given is None:
        box = None if options.mouth is None else FaceBox.around_mouth(*options.mouth)
        motion = HeadMotion(model, camera, renderer, box)
        tell("finding and following the face")
        frames = choose_frames(followed(motion, clip.frames()), str(video))
    else:
        given.check(clip.info.frames, camera, model.pivot, held=model.known)
        motion = GivenMotion(given.poses)
        shown = motion.in_picture(camera, model.pivot, video)
        frames = choose_frames(followed(shown, clip.frames()), str(video), least=0.0)
    faces = [(f.image, _outline(model, f.pose, camera)) for f in frames]
    chromatic, exposure = in_colour(faces), Exposure.of(faces)
    if not (chromatic or model.known):
        raise _no_colour(video, exposure, boxed=given is None and options.mouth is not None)
    colours = usable(colours, chromatic)
    told = given is not None or options.mouth is not None
    found = calibrate_well(model, frames, camera, renderer, tell, colours, placed=told)
    classes = replace(found.classes, chromatic=chromatic, exposure=exposure)
    calibration = replace(found, classes=classes)
    if isinstance(motion, HeadMotion):
        motion = replace(motion, colours=calibration.classes, rate=clip.info.rate)
    return calibration, motion, frames


def _no_colour(video: Path, exposure: Exposure, boxed: bool) -> ParameterError:
    """The error of a face without colour; `boxed` where --mouth says where the face is."""
    if boxed:
        return ParameterError(
            f"{colourless(video, exposure)} where --mouth puts the face, and a start by colour "
            "finds no lips there",
            "check that --mouth holds the whole mouth in the first frame; if it does, leave out "
            "what replaces the start from landmarks: --start blobs or a preset",
        )
    return ParameterError(
        f"{colourless(video, exposure)}, and a start by colour finds no lips in it",
        "leave out what replaces the start from landmarks: --start blobs, --poses, a preset "
        "or a box in which no face is seen",
    )


def mouth_model(speaker: Speaker, person: str | None, physics: Path | None = None) -> MouthModel:
    """The mouth model of the average head, or of a person whose head is known.

    Raises
    ------
    InputFileError, ModelFormatError
        If `physics` cannot be read, or was learned on another speaker.
    """
    neutral = speaker.vertices if person is None else speaker.named(person)
    texture = speaker.texture(person)
    expression = None if physics is None else physics_expression(speaker, neutral, physics)
    return build_mouth_model(
        speaker, neutral, texture, free_person=person is None, expression=expression
    )


def physics_expression(speaker: Speaker, neutral: NDArray[np.float32], path: Path) -> LinearShape:
    """Motion of a head (V, 3) by learned physics."""
    # not for every clip: sparse matrices take a while to import
    from abs_engine.face.shape.lip_shell import cut_lip_shell
    from abs_engine.face.shape.modal import load_physics
    from abs_engine.face.shape.physics_head import physics_shape
    from abs_engine.learn.training import check_speaker

    physics = load_physics(path)
    check_speaker(physics, speaker)
    return physics_shape(speaker, neutral, cut_lip_shell(speaker), physics)
