"""A speaker's face in a clip where it looks different from the recordings it was learned from.

In another light, by another camera or with another expression, the colours, the texture and the
landmark network's bias of the recordings are not those of the clip. The head and its postures are.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from abs_engine.core.errors import FaceNotFoundError
from abs_engine.core.scene import Renderer
from abs_engine.io.assets import Speaker
from abs_engine.tracking.detection.face_choice import FaceChoice, FaceFollower
from abs_engine.tracking.head.head_fit import AverageHead
from abs_engine.tracking.head.head_pose import TexturedHead
from abs_engine.tracking.landmark.rendered_landmarks import correspondence_of
from abs_engine.tracking.options import Clip, Tell
from abs_engine.tracking.person.expected_person import anybody
from abs_engine.tracking.person.frame_choice import (
    Sighted,
    candidate_frames,
    frames_to_learn,
    to_learn_from,
)
from abs_engine.tracking.person.scale import pupil_distance
from abs_engine.tracking.settings.doubts import DOUBTS
from abs_engine.tracking.settings.frames import FRAME_LOOP
from abs_engine.tracking.speaker.speaker_face import SpeakerFace
from abs_engine.tracking.start.person_fit import FittedPerson, fit_person

ANEW = (
    "the face looks different here than in its recordings, in light or expression: its "
    "appearance, and where landmarks lie on it, are learned from this clip"
)


def looks_alike(face: SpeakerFace, seen: Sequence[Sighted], misfit: float) -> bool:
    """Whether frames of a clip have the light of a face's recordings, and landmarks lie on it.

    `misfit` is how far these lie off, in standard deviations.
    """
    changes = np.stack([np.abs(face.light.change(*one)).max() for one in seen])
    same = float(np.median(changes)) < FRAME_LOOP.light_full
    return same and misfit < DOUBTS.most_speaker_misfit


def with_looks_of_clip(
    clip: Clip,
    choice: FaceChoice,
    face: SpeakerFace,
    average: AverageHead,
    renderer: Renderer,
    tell: Tell,
) -> FittedPerson | None:
    """The speaker with looks that are learned from the clip; None if too few frames show the face.

    `average` is the speaker's head, which is known.
    """
    follower = FaceFollower(choice)
    try:
        found = candidate_frames(
            ((image, follower.step(image)) for image in clip.frames()), str(clip.video)
        )
        seen, grey = to_learn_from(found)
        chosen, turned = frames_to_learn(seen)
        fitted = fit_person(
            average, chosen, clip.camera, renderer, clip.colours, tell, turned, grey, seen
        )
    except FaceNotFoundError:
        return None
    postures = face.seen if len(face.seen) else None
    return replace(fitted, posture=face.posture, steps=face.steps, seen=postures)


def known_head(face: SpeakerFace, textured: TexturedHead, speaker: Speaker) -> AverageHead:
    """The head of a face that is made of the head `speaker`, as one that is known."""
    anyone, correspondence = anybody(speaker, correspondence_of(speaker, textured.renderer))
    sized = anyone.scaled(face.scale.pupils / pupil_distance(anyone, anyone.vertices))
    own = replace(sized, vertices=face.neutral)
    nobody = np.zeros((0, *face.neutral.shape), np.float32)
    return AverageHead(
        own, face.expression, nobody, textured.body, textured.shape, correspondence, face.scale
    )
