"""Faces besides the one that is followed: a larger one, or one where it is not found.

The first frame with a face says which one is followed. Who comes later, in front of a picture on
the wall or after somebody who leaves, is noticed here.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from abs_engine.core.arrays import FloatArray, Image
from abs_engine.core.geometry import Pose
from abs_engine.core.words import counted
from abs_engine.tracking.detection.face_choice import by_size
from abs_engine.tracking.detection.face_detection import Face, find_faces
from abs_engine.tracking.frame.clip_setting import ClipSetting, FrameResult
from abs_engine.tracking.settings.doubts import DOUBTS

LARGER = (
    "a larger face than the one that is followed is seen in {} of {} that were looked at, first in "
    "frame {} about {:.0f} {:.0f} ({:.0f} pixels): if you mean that one, give --mouth with a box "
    "about its mouth, or cut the video so that it begins there"
)
ANOTHER = (
    "where the face that is followed is not found, another is seen: in {} of {} that were looked "
    "at, first in frame {} about {:.0f} {:.0f} ({:.0f} pixels); if it is the same person's, or the "
    "one that you mean, cut the video there and track each part"
)


@dataclass
class Sightings:
    """Looks at frames, each for the frames up to the next one, and those that show another face.

    Parameters
    ----------
    looks, with_face : list of int
        Frames that each stands for, of all looks and of those with such a face.
    first : (int, Face) or None
        The first frame that shows one, and that face.
    """

    looks: list[int] = field(default_factory=list)
    with_face: list[int] = field(default_factory=list)
    first: tuple[int, Face] | None = None

    def add(self, index: int, frames: int, faces: Sequence[Face]) -> None:
        """Count a look at a frame that stands for so many, with the faces that it shows."""
        self.looks.append(frames)
        if faces:
            self.with_face.append(frames)
            self.first = self.first or (index, faces[0])

    def warnings(self, text: str) -> list[str]:
        """The text about the first such face, if several looks show one, for enough frames."""
        least = DOUBTS.most_others * sum(self.looks)
        if self.first is None or len(self.with_face) < 2 or sum(self.with_face) < least:
            return []
        (index, face), frames = self.first, counted(len(self.looks), "frame")
        return [text.format(len(self.with_face), frames, index, *face.centre, face.size)]


def face_at(setting: ClipSetting, pose: Pose) -> tuple[FloatArray, float]:
    """Place of the mouth (2,) of a face at a pose, and the side of its square, px.

    The square is that in which the detector would see it.
    """
    mouth = setting.camera.project(pose.apply(setting.face.border)).mean(axis=0)
    depth = float(pose.apply(setting.face.pivot)[2])
    return mouth, DOUBTS.face_square * float(setting.camera.matrix[0, 0]) / depth


class OtherFaces:
    """Looks for other faces now and then in a clip.

    Parameters
    ----------
    setting : ClipSetting
        Where a user has chosen the face, none is looked for.
    """

    def __init__(self, setting: ClipSetting) -> None:
        self._setting = setting
        self._next, self._step = 0, max(1, round(DOUBTS.look_apart * setting.rate))
        self._looks = 0
        self._seen, self._unseen = Sightings(), Sightings()

    def add(self, image: Image, result: FrameResult) -> None:
        """Look at the next frame (H, W, 3) RGB, or leave it out."""
        if not self._setting.others or result.index < self._next:
            return
        self._looks += 1
        if self._looks % DOUBTS.looks == 0:  # a long clip is looked at less often
            self._step *= 2
        self._next = result.index + self._step
        faces = by_size(find_faces(image, in_parts=False))
        if result.pose is None:
            self._unseen.add(result.index, self._step, faces[:1])
        else:
            self._seen.add(result.index, self._step, self._larger(faces[:1], result.pose))

    def _larger(self, faces: list[Face], pose: Pose) -> list[Face]:
        """Those that are larger than the face at a pose, and another."""
        mouth, side = face_at(self._setting, pose)
        least = DOUBTS.larger_face * side
        return [
            face for face in faces
            if face.size > least and np.linalg.norm(face.mouth - mouth) > 0.5 * face.size
        ]  # fmt: skip

    def warnings(self) -> list[str]:
        """Those of faces that are seen in more than one look, and in enough of the frames."""
        return [*self._seen.warnings(LARGER), *self._unseen.warnings(ANOTHER)]
