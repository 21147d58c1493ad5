"""The state of a frame before it is fitted, memory carried between frames, and head motions."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import NamedTuple, Protocol

from abs_engine.core.arrays import FloatArray, Image
from abs_engine.core.geometry import Pose
from abs_engine.fit.evidence import Term
from abs_engine.tracking.detection.landmarks import Landmarks
from abs_engine.tracking.detection.mouth_search import shifted
from abs_engine.tracking.frame.blobs import LipBlob
from abs_engine.tracking.landmark.landmark_fit import FrameLandmarks
from abs_engine.tracking.settings.frames import FRAME_LOOP


@dataclass(frozen=True, eq=False)
class SeenFace:
    """A face's landmarks, and what they say of the head."""

    landmarks: Landmarks
    fit: FrameLandmarks


@dataclass(frozen=True, eq=False)
class Shot:
    """A frame before anything is known of it.

    Parameters
    ----------
    image : (H, W, 3) uint8 RGB
    index : int
        Its number; numbers are left out where frames were dropped.
    time : float
        When it was taken, seconds; NaN in a clip whose frames are evenly spaced.
    """

    image: Image
    index: int
    time: float = float("nan")


class HeadFrame(NamedTuple):
    """A frame, and where its head is.

    Parameters
    ----------
    image : (H, W, 3) uint8 RGB
    pose : Pose or None
        None where the face was not found.
    face : SeenFace or None
        None where the landmark network was not asked.
    blob : LipBlob or None
        The lips as a blob, where they are followed as one.
    balanced : (H, W, 3) uint8 RGB, or None
        The frame in the clip's usual light, where it is known how that has changed.
    terms : mapping of str to Term, or None
        The evidence, where it was bound ahead of the fit.
    cut : bool
        Whether it begins another shot; False where cuts are not looked for.
    grey : bool
        Whether it has no colour, while the clip has.
    dark : bool
        Whether it is too dark to say anything of the lips, while others are not.
    bright : bool
        Whether the face is white, while in others it is not.
    """

    image: Image
    pose: Pose | None
    face: SeenFace | None = None
    blob: LipBlob | None = None
    balanced: Image | None = None
    terms: Mapping[str, Term] | None = None
    cut: bool = False
    grey: bool = False
    dark: bool = False
    bright: bool = False

    @property
    def in_usual_light(self) -> Image:
        """Picture from which its colours are taken."""
        return self.image if self.balanced is None else self.balanced


@dataclass(frozen=True, eq=False)
class Memory:
    """State that is carried from frame to frame.

    Parameters
    ----------
    vector : (6 + P,) float64 or None
        Correction of the pose, and posture, of the frame before; None where it was lost.
    pose : Pose or None
        Of the frame before.
    move : (6 + P,) float64 or None
        From where the frame before was started about to where it ended.
    values : tuple of float
        Values of the last frames.
    gap : float
        Time since the frame before, in frames: more than 1 where some were dropped.
    """

    vector: FloatArray | None = None
    pose: Pose | None = None
    move: FloatArray | None = None
    values: tuple[float, ...] = field(default=())
    gap: float = 1.0

    def after(self, pose: Pose, vector: FloatArray, move: FloatArray, value: float) -> Memory:
        """State after a frame that was fitted."""
        values = (*self.values, value)[-FRAME_LOOP.recent :]
        return replace(self, vector=vector, pose=pose, move=move, values=values)

    def lost(self) -> Memory:
        """State after a frame without a fit."""
        return replace(self, vector=None, move=None)


class Follower(Protocol):
    """Says where the head is, one frame after the other."""

    def step(self, image: Image, memory: Memory) -> HeadFrame:
        """The next frame (H, W, 3) uint8 RGB with the head's pose."""
        ...

    def finish(self) -> None:
        """Say that there are no more frames; by default any number will do.

        Raises
        ------
        ParameterError
            If there should have been.
        """
        return


class Motion(Protocol):
    """Motion of the head through a clip; a value, that can be followed any number of times."""

    def follower(self) -> Follower:
        """Follower of the head from the first frame on."""
        ...


@dataclass(frozen=True, eq=False)
class ShiftedMotion:
    """A motion whose poses are all off by the same.

    Parameters
    ----------
    shift : (6,) float64
        The correction, radians and mm.
    pivot : (3,) float64, mm, head frame
        What it turns about.
    """

    motion: Motion
    shift: FloatArray
    pivot: FloatArray

    @property
    def alone(self) -> bool:
        """Whether it may be followed in a thread of its own, ahead of the fits."""
        return bool(getattr(self.motion, "alone", False))

    def follower(self) -> ShiftedFollower:
        """Follower of the head from the first frame on."""
        return ShiftedFollower(self.motion.follower(), self.shift, self.pivot)


@dataclass(frozen=True, eq=False)
class ShiftedFollower:
    """Corrects what another follower finds."""

    own: Follower
    shift: FloatArray
    pivot: FloatArray

    def step(self, image: Image, memory: Memory) -> HeadFrame:
        """The next frame with the head's corrected pose."""
        found = self.own.step(image, memory)
        if found.pose is None:
            return found
        return found._replace(pose=shifted(found.pose, self.shift, self.pivot))

    def finish(self) -> None:
        """Say that there are no more frames."""
        self.own.finish()
