"""A talking face made ready for a clip of its speaker."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import numpy as np

from abs_engine.compare.prior import GaussianPrior, PenaltyPrior, Prior
from abs_engine.core.arrays import FloatArray
from abs_engine.core.blocks import POSTURE
from abs_engine.core.camera import Camera
from abs_engine.core.errors import ModelFormatError, ParameterError
from abs_engine.core.geometry import Pose
from abs_engine.core.pose import PoseFrame, at_base, free_blocks, joined, parted
from abs_engine.core.scene import Renderer
from abs_engine.face.articulated import FaceShape
from abs_engine.face.base import Face
from abs_engine.face.talking import TalkingFace, as_face, shape_as_face
from abs_engine.face.talking_file import StoredTalker, load_talking, read_whose
from abs_engine.fit.head_frame import contact_of, lip_window
from abs_engine.fit.problem import Problem
from abs_engine.fit.talking import over_face
from abs_engine.fit.terms import LOCAL, TEXTURE, TermKind, bound
from abs_engine.fit.view import View
from abs_engine.io.assets import Speaker, load_speaker
from abs_engine.learn.training import checksum
from abs_engine.tracking.frame.clip_setting import UNEXPLAINED, Work
from abs_engine.tracking.frame.frame_state import HeadFrame, Memory
from abs_engine.tracking.frame.head_frame import explained, mobility_of, step_deviation
from abs_engine.tracking.landmark.rendered_landmarks import correspondence_of
from abs_engine.tracking.model_entry import Model, own_file
from abs_engine.tracking.models.heads import by_landmarks
from abs_engine.tracking.options import BLOBS, Clip, ClipTracker, Leaves, Tell, TrackOptions
from abs_engine.tracking.person.identity_fit import POSE_DEVIATION
from abs_engine.tracking.settings.frames import FRAME_LOOP
from abs_engine.tracking.start.blob_start import by_blobs


@dataclass(frozen=True, eq=False)
class FaceBinder:
    """Binds evidence to a face whose head is followed by its motion.

    Parameters
    ----------
    rate : float, frames per second
    priors : tuple of Prior
        What is likely of postures beforehand, over (6 + P).
    """

    face: Face
    camera: Camera
    renderer: Renderer
    rate: float
    kinds: Mapping[str, TermKind]
    priors: tuple[Prior, ...]
    pose_held: bool = False

    def work(self, frame: HeadFrame, pose: Pose, memory: Memory) -> Work:
        """Objective of a frame whose head is about a pose, and the start of its search.

        A posture is likely to be near that of the frame before.
        """
        face, count = self.face, len(self.face.posture)
        last = None if memory.vector is None else at_base(parted(memory.vector)[1])
        starts = at_base(face.starts) if last is None else np.vstack([last, at_base(face.starts)])
        base, window = PoseFrame(pose, face.pivot), lip_window(face.border, pose, self.camera)
        given = frame.image, self.camera, self.renderer, base, window, starts[0]
        terms = bound(self.kinds, face, View(*given))
        step = step_deviation(self.rate, memory.gap)
        still = np.full(count, np.inf if last is None else step)
        near = GaussianPrior(starts[0], joined(POSE_DEVIATION, still))
        free, priors = free_blocks(self.pose_held), (*self.priors, near)
        problem = Problem(base, face.blocks, terms, priors, free, mobility=mobility_of(count))
        return Work(problem, starts, partial(explained, terms), doubt=self._doubt)

    def _doubt(self, _x: FloatArray, score: float) -> str:
        return UNEXPLAINED if score < FRAME_LOOP.least_explained else ""


@dataclass(frozen=True, eq=False)
class Talker:
    """A clip whose head is found and followed, and the talking face of its speaker.

    Parameters
    ----------
    base : ClipTracker
        Of the speaker's head.
    talking : TalkingFace or None
        The same with its appearance, where that was learned.
    """

    base: ClipTracker
    shape: FaceShape
    talking: TalkingFace | None

    @property
    def learned(self) -> TalkingFace:
        """The talking face with its appearance.

        Raises
        ------
        ParameterError
            If none was learned.
        """
        if self.talking is None:
            raise ParameterError("the face was made without pictures", "use --terms colour")
        return self.talking

    @property
    def face(self) -> Face:
        """The talking face with the clip's colours; textures are compared over all of it."""
        colours = self.base.setting.face.learned("colour")
        face = shape_as_face(self.shape) if self.talking is None else as_face(self.talking)
        return replace(face.looking(colour=colours), own_terms=over_face(self.shape.surface))


def _path(options: TrackOptions) -> Path:
    return own_file(options, "a talking face is a speaker's own", "face.npz")


def check_talker(options: TrackOptions, leaves: Leaves) -> None:
    """Refuse what does not go with a talking face, of whose file little is read.

    Raises
    ------
    InputFileError, ModelFormatError
        If the face's file cannot be read.
    ParameterError
        If no file is given, it has nothing for the evidence, or is the face of somebody else.
    """
    leaves.check("talking")
    path = _path(options)
    person, pictured = read_whose(path)
    lacking = [kind for kind in (TEXTURE, LOCAL) if kind.name in leaves.kinds]
    if lacking and not pictured:
        raise ParameterError(
            f"{path} was made without pictures and has no {lacking[0].what} to compare",
            "use --terms colour, or make it again with 'articulate --face FILE --pictures TABLE'",
        )
    if options.person not in (None, person):
        raise ParameterError(
            f"{path} is the face of '{person}', not of '{options.person}'", "leave out --person"
        )


def found_talker(
    clip: Clip, options: TrackOptions, leaves: Leaves, renderer: Renderer, tell: Tell
) -> Talker:
    """Find and follow the head of a talking face's speaker, and learn the clip's colours.

    Raises
    ------
    InputFileError, ModelFormatError
        If the face's file cannot be read, or is of another head.
    ParameterError
        If no file is given, or what is chosen does not go together.
    AbsEngineError
        As `heads.prepare_head`.
    """
    check_talker(options, leaves)
    path = _path(options)
    stored, speaker = load_talking(path), load_speaker(options.speaker)
    if stored.speaker and stored.speaker != checksum(speaker):
        raise ModelFormatError(
            f"{path} is of another head", "give its head with --speaker, or make it again"
        )
    plain = Leaves.of(replace(options, terms=("colour",), driver="simplex"))
    known = replace(options, person=stored.person)
    own = _own_head(stored, speaker)
    if own is speaker or options.poses is not None:
        base = by_blobs(clip, own, renderer, known, plain, tell)
    else:  # how the whole head looks is not known
        places = correspondence_of(speaker, renderer)
        base = by_landmarks(clip, own, places, renderer, known, plain, tell)
        unchecked, facts = replace(base.setting, landmarks=None), {**base.facts, "evidence": None}
        base = replace(base, setting=unchecked, facts=facts)
    return Talker(base, stored.shape, stored.face)


def _own_head(stored: StoredTalker, speaker: Speaker) -> Speaker:
    """The speaker with a person who is none of its people as the only one."""
    if stored.neutral is None:
        return speaker
    nobody = np.zeros(len(speaker.identity_names), np.float32)
    return replace(
        speaker, vertices=stored.neutral, people={stored.person: nobody},
        own_texture=stored.shape.scene.texture, looks={},
    )  # fmt: skip


def prepare_talker(
    clip: Clip, options: TrackOptions, leaves: Leaves, renderer: Renderer, tell: Tell
) -> ClipTracker:
    """Make a clip ready for the talking face of its speaker.

    Poses are those of the head's motion, corrected in each frame; what is likely of a posture is
    that of the corpus.

    Raises
    ------
    AbsEngineError
        As `found_talker`.
    """
    talker = found_talker(clip, options, leaves, renderer, tell)
    base, shape, face = talker.base, talker.shape, talker.face
    likely = 0.5 * len(shape.spec) / shape.penalty.strength  # A(a) in nats: a Gaussian's at first
    prior = PenaltyPrior(shape.penalty, likely, shape.blocks.places[POSTURE])
    touching = contact_of(face.scene, face.rings, shape.neutral)
    binder = FaceBinder(
        face, clip.camera, renderer, clip.info.rate, leaves.kinds, (prior, touching),
        base.setting.pose_held,
    )  # fmt: skip
    setting = replace(base.setting, face=face, binder=binder, driver=leaves.driver.minimiser())
    return replace(base, setting=setting)


TALKING = Model(
    prepare_talker, starts=(BLOBS,), without=("physics", "evidence"), check=check_talker
)
"""Found by the texture of its speaker's head."""
