"""Texture and local appearance of a speaker's face: learned from what was tracked, and compared."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from abs_engine.core.camera import Camera
from abs_engine.core.geometry import Pose, rotations
from abs_engine.core.scene import Renderer, Scene
from abs_engine.face.appearance.visibility import Sighting
from abs_engine.face.base import Face
from abs_engine.face.compared import ComparedHead
from abs_engine.face.learned_appearance import Appearance, LocalLooks, TextureLooks
from abs_engine.fit.talking import over_face
from abs_engine.fit.terms import LOOKS
from abs_engine.io.assets import Speaker
from abs_engine.learn.articulated import compared_head
from abs_engine.learn.posture_space import PostureSpace
from abs_engine.learn.settings import LEARNING
from abs_engine.learn.talking import learn_appearance
from abs_engine.tracking.runs.recordings import Recording
from abs_engine.tracking.speaker.recorded_frames import sighted
from abs_engine.tracking.speaker.speaker_face import SpeakerFace


def can_look(speaker: Speaker) -> bool:
    """Whether a head has texture coordinates; of one without, no appearance is learned."""
    return bool(speaker.uv.any())


def compared(face: SpeakerFace, speaker: Speaker) -> ComparedHead:
    """Parts of a face's head that are compared by texture and local appearance."""
    texture = speaker.texture()
    classes = speaker.facet_class.astype(np.int32)
    mean, modes = face.expression.mean, face.expression.modes
    whole = Scene(mean, modes, speaker.faces, speaker.uv, classes, texture)
    pivot = face.neutral[speaker.lip_ring].mean(axis=0).astype(np.float64)
    return compared_head(speaker, whole, face.posture, pivot)


def with_appearance(
    face: SpeakerFace,
    speaker: Speaker,
    space: PostureSpace,
    recordings: Sequence[Recording],
    camera: Camera,
    renderer: Renderer,
) -> SpeakerFace:
    """The face with texture and local appearance, of frames that show all of its postures.

    The recordings were tracked with the postures that the space was learned from.

    Raises
    ------
    NothingSeenError, ParameterError
        If they do not show the face.
    """
    head, each = compared(face, speaker), max(2, LEARNING.looks_frames // len(recordings))
    seen = [list(_sightings(face, head, space, r, each)) for r in recordings]
    counts = [
        len(part) for own in seen for part in np.array_split(np.arange(len(own)), parts(seen))
    ]
    together = np.repeat(np.arange(len(counts)), counts)
    every = [one for own in seen for one in own]
    return replace(face, appearance=learn_appearance(head, every, together, camera, renderer))


def parts(recordings: Sequence[object]) -> int:
    """Number of parts of a recording that are left out one by one, see `LEARNING.looks_parts`."""
    return -(-LEARNING.looks_parts // len(recordings))


def _sightings(
    face: SpeakerFace, head: ComparedHead, space: PostureSpace, recording: Recording, count: int
) -> Iterator[Sighting]:
    """Frames of a recording with what was tracked in them, in the face's own postures."""
    run, postures = recording.run, space.parameters(recording.postures)
    turns = rotations(np.nan_to_num(run["rotation"]))
    for index, image, marks in sighted(recording, list(recording.spread(count))):
        own = face.posture.clip(postures[index])
        pose = Pose(turns[index], run["translation"][index])
        usual = face.light.balanced(image, marks)
        yield Sighting(usual, head.scene.vertices(own), pose, own)


def looking(face: Face, own: Appearance, head: ComparedHead) -> Face:
    """The face that a clip is tracked with, by texture and local appearance of its head, too."""
    dressed = own.texture.dress(head.surface)
    noise = own.texture_noise, own.texture_observations
    texture = TextureLooks(own.texture, head.surface, dressed, *noise)
    # the texture is rendered no finer, the descriptors just as finely as they were learned
    local = LocalLooks(own.local.within(head.kept), head.outer, 1.0, own.per_mm, own.own_share)
    looks: dict[str, object] = dict(zip(LOOKS, (texture, local), strict=True))
    return replace(face.looking(**looks), own_terms=over_face(head.surface, own.texture_per_mm))
