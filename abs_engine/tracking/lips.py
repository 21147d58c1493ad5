"""Lips tracked in raw video by colour-class likelihoods (Basu, Oliver, Pentland 1998).

The paper's loop (sections 5.1 to 5.4) with other leaves: principal components over face units in
place of learned physics, unless it is given, and Nelder-Mead in place of forces.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from abs_engine.assets import Speaker, load_speaker
from abs_engine.core.camera import Camera
from abs_engine.core.errors import FaceNotFoundError
from abs_engine.core.scene import Renderer
from abs_engine.face.appearance.colour import ColourClasses
from abs_engine.face.head import MouthModel, build_mouth_model
from abs_engine.face.shape.linear import LinearShape
from abs_engine.face.shape.lip_shell import cut_lip_shell
from abs_engine.face.shape.modal import load_physics
from abs_engine.face.shape.physics_head import physics_shape
from abs_engine.learn.training import check_speaker
from abs_engine.tracking.correspondence import (
    USUAL_DEVIATION,
    Correspondence,
    learn_correspondence,
    load_correspondence,
)
from abs_engine.tracking.detect import find_faces
from abs_engine.tracking.faces import FaceChoice, FaceFollower, by_size, face_lines
from abs_engine.tracking.given import GivenMotion
from abs_engine.tracking.head_fit import fit_head, seen_in
from abs_engine.tracking.landmark_motion import LandmarkMotion
from abs_engine.tracking.lip_landmarks import LipLandmarks
from abs_engine.tracking.locate import FaceBox
from abs_engine.tracking.mouth_look import MouthLook, UsualLook
from abs_engine.tracking.person import Calibration
from abs_engine.tracking.place import CalibrationFrame
from abs_engine.tracking.placed import PlacedHead, calibrate_placed
from abs_engine.tracking.poses_file import read_poses
from abs_engine.tracking.prepare import HeadMotion, choose_frames, spread_frames
from abs_engine.tracking.restart import calibrate_well
from abs_engine.tracking.scale import Scale, known_scale, pupil_distance, pupil_scale
from abs_engine.tracking.setting import BOTH, FrameResult, TrackerSetting
from abs_engine.tracking.sightings import sightings_of
from abs_engine.tracking.tracker import Image, track, usual_mouth
from abs_engine.video import VideoInfo, probe, read_frames

LANDMARKS, BLOBS = STARTS = "landmarks", "blobs"
PERSON_SPREAD = 0.35
"""How far a mouth may differ from that of a head fitted to landmarks, as a share of how far people
differ from the average."""


@dataclass(frozen=True)
class LipOptions:
    """What a user may choose.

    Parameters
    ----------
    person : str or None
        A person of the speaker whose head is known; by default the average head, whose mouth is
        fitted to the clip.
    mouth : tuple of float or None
        Left, top, width and height of the mouth in the first frame, pixels.
    camera : Camera or None
        Its calibration; by default an ideal camera of a usual field of view.
    speaker : Path or None
        A `head.npz`; by default the bundled head.
    colours : Path or None
        The `colours.npz` of another run; by default colours are learned from the clip.
    physics : Path or None
        Lips that `train` learned from dots; by default the mouth moves in components of face units.
    poses : Path or None
        Head poses of all frames (see `tracking.poses_file`); by default they are estimated. With
        a known head they are taken as they are, with the average head as a first guess.
    start : str
        "landmarks": a network's landmarks place the whole head, and are one soft term in each
        frame; "blobs": as in the papers, by colour about a face that was detected. A known head
        is found by its texture, and given poses place it.
    face : int or None
        Which face, where there are several, counted from 1, the largest first.
    pupil_distance : float or None
        Of the person, mm: it sets the scale.
    evidence : str
        See `TrackerSetting`.
    """

    person: str | None = None
    mouth: tuple[float, float, float, float] | None = None
    camera: Camera | None = None
    speaker: Path | None = None
    colours: Path | None = None
    physics: Path | None = None
    poses: Path | None = None
    start: str = LANDMARKS
    face: int | None = None
    pupil_distance: float | None = None
    evidence: str = BOTH


@dataclass(frozen=True, eq=False)
class Clip:
    """A video as it is tracked.

    Parameters
    ----------
    video : Path
    info : VideoInfo
    camera : Camera
    colours : ColourClasses or None
        Those learned before.
    """

    video: Path
    info: VideoInfo
    camera: Camera
    colours: ColourClasses | None


@dataclass(frozen=True, eq=False)
class LipTracker:
    """A clip made ready: iterate `results` for the frames.

    Parameters
    ----------
    video : Path
    info : VideoInfo
    setting : TrackerSetting
    motion : LandmarkMotion, HeadMotion or GivenMotion
    scale : Scale
        What millimetres rest on.
    faces : str
        What is said of several faces, or of a box in which none was seen; empty without either.
    """

    video: Path
    info: VideoInfo
    setting: TrackerSetting
    motion: LandmarkMotion | HeadMotion | GivenMotion
    scale: Scale
    faces: str = ""

    def results(self) -> Iterator[tuple[Image, FrameResult]]:
        """Each frame with what was found in it."""
        return track(self.setting, self.motion.frames(read_frames(self.video)))


def prepare_lips(
    video: Path,
    renderer: Renderer,
    options: LipOptions = LipOptions(),
    stage: Callable[[str], None] | None = None,
) -> LipTracker:
    """Find the face, learn the clip's colours and fit the person's head.

    Parameters
    ----------
    video : Path
    renderer : Renderer
    options : LipOptions
    stage : callable, optional
        Told what is begun, in a few words.

    Raises
    ------
    InputFileError, VideoError
        If the video cannot be read.
    FaceNotFoundError
        If no face is found.
    TooFewPixelsError
        If too little of it is seen to learn its colours; from landmarks that is no reason.
    ParameterError
        If given poses do not fit the video.
    """
    tell = stage or _silent
    tell("reading the video")
    info = probe(video)
    colours = None if options.colours is None else ColourClasses.load(options.colours)
    clip = Clip(video, info, options.camera or Camera.ideal(info.size), colours)
    speaker = load_speaker(options.speaker)
    if options.start == LANDMARKS and options.person is None and options.poses is None:
        correspondence = correspondence_of(speaker, renderer)
        try:
            return by_landmarks(clip, speaker, correspondence, renderer, options, tell)
        except FaceNotFoundError:
            if options.mouth is None or options.pupil_distance or options.evidence != BOTH:
                raise
        _check_box(video, FaceBox.around_mouth(*options.mouth))
        remark = "no face was seen about the mouth that was given: started from its colours"
        return replace(_by_blobs(clip, speaker, renderer, options, tell), faces=remark)
    return _by_blobs(clip, speaker, renderer, options, tell)


def _check_box(video: Path, box: FaceBox) -> None:
    """Raise `FaceNotFoundError` if the first frame shows a face whose mouth lies elsewhere."""
    faces = find_faces(next(iter(read_frames(video))))
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
    options: LipOptions,
    tell: Callable[[str], None],
) -> LipTracker:
    """Start from landmarks: they place the whole head, and colours are learned where it lies."""
    scale = pupil_scale(options.pupil_distance)
    box = None if options.mouth is None else FaceBox.around_mouth(*options.mouth)
    choice = FaceChoice(options.face, box)
    tell("finding the face")
    follower = FaceFollower(choice)
    found = ((image, follower.step(image)) for image in read_frames(clip.video))
    chosen = spread_frames(found, str(clip.video), order=lambda seen: seen.openness)
    several = len(follower.faces) > 1
    faces = face_lines(follower.faces, options.face or 1) if several else ""
    tell("fitting the head")
    expression = None
    if options.physics is not None:
        expression = _physics_shape(speaker, speaker.vertices, options.physics)
    seen = [seen_in(image, landmarks) for image, landmarks in chosen]
    head = fit_head(speaker, correspondence, seen, clip.camera, scale, renderer, expression)
    model = build_mouth_model(
        head.speaker, head.neutral, speaker.texture(next(iter(speaker.people))),
        expression=head.expression, person_spread=PERSON_SPREAD,
    )  # fmt: skip
    tell("fitting the mouth" if clip.colours else "learning the clip's colours, fitting the mouth")
    placed = PlacedHead(model, head.shape, head.textured, correspondence, clip.camera, renderer)
    calibration, shape = calibrate_placed(placed, chosen, clip.colours)
    textured = replace(head.textured, shift=calibration.shift)
    calibration = replace(calibration, shift=np.zeros(6))  # the poses have it
    noisy = replace(shape, deviation=head.shape.deviation)
    lips = LipLandmarks.of(noisy, model.n_expression, clip.camera)
    setting = TrackerSetting(
        model, model.held(calibration.person), calibration, clip.camera, renderer, clip.info.rate,
        times=clip.info.times, lips=lips, evidence=options.evidence,
    )  # fmt: skip
    look = UsualLook.of([MouthLook.of(calibration.classes, i, s) for i, s in chosen])
    motion = LandmarkMotion(shape, textured, choice)
    return LipTracker(clip.video, clip.info, replace(setting, look=look), motion, scale, faces)


def _by_blobs(
    clip: Clip,
    speaker: Speaker,
    renderer: Renderer,
    options: LipOptions,
    tell: Callable[[str], None],
) -> LipTracker:
    """Start from a face's six points and the colours about them, or with a head that is known."""
    video, info, camera, colours = clip.video, clip.info, clip.camera, clip.colours
    given = None if options.poses is None else read_poses(options.poses)
    model = lip_model(speaker, options.person, options.physics)
    motion: HeadMotion | GivenMotion
    if given is None:
        box = None if options.mouth is None else FaceBox.around_mouth(*options.mouth)
        motion = HeadMotion(model, camera, renderer, box)
        tell("finding and following the face")
        frames = choose_frames(motion.poses(read_frames(video)), str(video))
    else:
        given.check(info.frames, camera, model.pivot, held=model.known)
        motion = GivenMotion(given.poses)
        frames = _frames_of_poses(video, motion, camera, model)
    tell("fitting the mouth" if colours else "learning the clip's colours, fitting the mouth")
    told = given is not None or options.mouth is not None
    calibration = calibrate_well(model, frames, camera, renderer, colours, placed=told)
    if isinstance(motion, HeadMotion):
        motion = replace(motion, colours=calibration.classes, rate=info.rate)
    setting = _setting(model, calibration, camera, renderer, info, given is not None)
    usual = usual_mouth(setting, frames)
    pupils = pupil_distance(speaker, model.whole(calibration.person))
    scale = known_scale(pupils, options.person is not None, given is not None)
    return LipTracker(video, info, replace(setting, usual=usual), motion, scale)


def correspondence_of(speaker: Speaker, renderer: Renderer) -> Correspondence:
    """Where the landmarks lie on a speaker's head: beside its file, or by drawing it and looking.

    Raises
    ------
    FaceNotFoundError
        If the network sees no face in the drawings.
    """
    beside = load_correspondence(speaker)
    if beside is not None:
        return beside
    texture = speaker.texture(next(iter(speaker.people)))
    vertices = speaker.vertices.astype(np.float64)
    found = learn_correspondence(speaker, list(sightings_of(speaker, vertices, texture, renderer)))
    usual = load_correspondence(load_speaker())
    noise = found.noise if usual is None else replace(usual.noise, bias=found.noise.bias)
    deviation = np.maximum(found.deviation, USUAL_DEVIATION)
    return replace(found, deviation=deviation, noise=noise)


def _frames_of_poses(
    video: Path, motion: GivenMotion, camera: Camera, model: MouthModel
) -> list[CalibrationFrame]:
    """Frames to learn from, of those in whose picture the given poses put the mouth."""
    seen = motion.seen(camera, model.pivot)
    if all(pose is None for pose in seen.given):
        raise FaceNotFoundError(
            f"by the given poses the mouth is in the picture in no frame of {video}",
            "check that they are of this video, and give the camera's calibration with --camera",
        )
    return choose_frames(seen.poses(read_frames(video)), str(video), least=0.0)


def _silent(_stage: str) -> None:
    """Tell nobody."""


def lip_model(speaker: Speaker, person: str | None, physics: Path | None = None) -> MouthModel:
    """The mouth model of the average head, or of a person whose head is known.

    Raises
    ------
    InputFileError, ModelFormatError
        If `physics` cannot be read, or was learned on another speaker.
    """
    neutral = speaker.vertices if person is None else speaker.named(person)
    texture = speaker.texture(person or next(iter(speaker.people)))
    expression = None if physics is None else _physics_shape(speaker, neutral, physics)
    return build_mouth_model(
        speaker, neutral, texture, free_person=person is None, expression=expression
    )


def _physics_shape(speaker: Speaker, neutral: NDArray[np.float32], path: Path) -> LinearShape:
    physics = load_physics(path)
    check_speaker(physics, speaker)
    return physics_shape(speaker, neutral, cut_lip_shell(speaker), physics)


def _setting(
    model: MouthModel,
    calibration: Calibration,
    camera: Camera,
    renderer: Renderer,
    info: VideoInfo,
    poses_given: bool,
) -> TrackerSetting:
    scene = model.held(calibration.person)
    setting = TrackerSetting(
        model, scene, calibration, camera, renderer, info.rate, times=info.times,
        poses_given=poses_given,
    )  # fmt: skip
    if not setting.pose_held:
        return setting
    return replace(setting, calibration=replace(calibration, shift=np.zeros(6)))
