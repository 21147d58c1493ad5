"""The first pass over a clip: finds the face and follows its motion."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import cached_property

import cv2
import numpy as np
from numpy.typing import NDArray

from abs_engine.core.arrays import Image
from abs_engine.core.camera import Camera
from abs_engine.core.geometry import Pose
from abs_engine.core.scene import Renderer
from abs_engine.core.threads import workers
from abs_engine.face.appearance.colour import ColourClasses
from abs_engine.face.head import MouthModel
from abs_engine.tracking.detection.face_detection import faces_about, find_face
from abs_engine.tracking.detection.initial_pose import (
    FaceBox,
    face_marks,
    first_pose,
    pose_of_face,
    with_mouth_at,
)
from abs_engine.tracking.frame.blob_motion import LipFollower
from abs_engine.tracking.frame.blobs import LipBlob
from abs_engine.tracking.frame.frame_state import Follower, HeadFrame, Memory, Motion
from abs_engine.tracking.settings.detection import DETECTION
from abs_engine.tracking.settings.registration import REGISTRATION
from abs_engine.tracking.texture.rigid_motion import (
    Keyframes,
    RigidReference,
    RigidState,
    follow,
    rigid_reference,
)
from abs_engine.tracking.texture.texture_registration import KnownHead, face_motions


@dataclass(frozen=True, eq=False)
class HeadMotion:
    """Follows the rigid motion of the head; one frame after the other.

    Parameters
    ----------
    box : FaceBox or None
        Which face, and where its mouth is, in the first frame where one is looked for, if the user
        knows it.
    colours : ColourClasses, optional
        With them a lost face is looked for by its lips, too.
    rate : float, frames per second
    """

    model: MouthModel
    camera: Camera
    renderer: Renderer
    box: FaceBox | None = None
    colours: ColourClasses | None = None
    rate: float = 25.0

    @property
    def alone(self) -> bool:
        """Whether it may be followed in a thread of its own, ahead of the fits."""
        return workers(self.renderer) > 1

    def follower(self) -> HeadFollower:
        """Follower of the head from the first frame on."""
        return HeadFollower(self)

    def again(
        self, reference: RigidReference, image: Image, lips: LipBlob | None
    ) -> RigidState | None:
        """The old reference about the lips that were found; None where it is not seen there."""
        if lips is None:
            return None
        old, mouth = reference.pose, self.model.pivot
        pose = with_mouth_at(old, lips.centre, self.camera, mouth)
        move = lips.centre - self.camera.project(old.apply(mouth))
        pixels = reference.pixels + move.astype(np.float32)
        guess = RigidState(pose, pixels, 1.0)
        new = follow(reference, image, self.camera, guess)
        return new if new is not None and new.seen >= REGISTRATION.least_seen else None

    @cached_property
    def _known(self) -> KnownHead | None:
        """The head with its looks; None if they are another person's."""
        model = self.model
        if not model.known:
            return None
        motions = face_motions(model.speaker, model.rigid)
        return KnownHead(model.head, model.rigid, self.camera, self.renderer, motions)

    def turned(self, image: Image, last: Pose | None, error: float) -> RigidReference | None:
        """A known head that has turned too fast to be followed; None where it is not seen.

        `error` is that of its texture where it was found.
        """
        if last is None or self._known is None:
            return None
        pose = self._known.realign(image, last)
        if not self.explains(image, pose, error):
            return None
        found = self.taken(image, pose)
        return found if len(found.points) >= REGISTRATION.least_points else None

    def explains(self, image: Image, pose: Pose, error: float) -> bool:
        """Whether a known head that was found again looks about as it did at first.

        And better than an even picture would: in balanced colours, grey walls look like skin.
        """
        if error == 0:
            return True
        plain = REGISTRATION.plain * self.error(np.full_like(image, 128), pose)
        return self.error(image, pose) < min(
            REGISTRATION.worse * error, max(plain, REGISTRATION.alike * error)
        )

    def error(self, image: Image, pose: Pose) -> float:
        """Error with which a known head's texture explains the image."""
        return 0.0 if self._known is None else self._known.error(image, pose)

    def found(
        self, image: Image, box: FaceBox | None, before: tuple[Image, Pose] | None
    ) -> RigidReference | None:
        """A reference from the face in an image; None without a face, or one without texture.

        It is placed by the face, and by its texture where that is known. `before` is the frame
        before, and its pose in it, if it was seen there.
        """
        pose = self._seen(image, box)
        if pose is None:
            return None
        if before is not None:
            head = self.model.head
            points = head.mean[np.unique(head.faces[self.model.rigid])]
            pose = carried(*before, image, points, self.camera) or pose
        if self._known is not None:
            pose = self._known.align(image, pose)
        reference = self.taken(image, pose)
        return reference if len(reference.points) >= REGISTRATION.least_points else None

    def _seen(self, image: Image, box: FaceBox | None) -> Pose | None:
        """The head by the face that is found, or about the box that somebody told.

        Its mouth is then in the box; its lean and distance are by its face, if seen.
        """
        camera, pivot = self.camera, self.model.pivot
        if box is None:
            face = find_face(image)
        else:
            face = box.shown(faces_about(image, box.centre, box.size))
        if face is None:
            return None if box is None else first_pose(box, camera, pivot)
        pose = pose_of_face(face, camera, face_marks(self.model))
        return pose if box is None else with_mouth_at(pose, np.array(box.mouth), camera, pivot)

    def refined(self, image: Image, pose: Pose) -> RigidReference:
        """A reference of an image in which a known head's pose is nearly known."""
        return self.taken(image, pose if self._known is None else self._known.refine(image, pose))

    def settled(self, image: Image, pose: Pose) -> Pose:
        """The followed pose, freed from what the reference was off by and brows have moved."""
        return pose if self._known is None else self._known.settle(image, pose)

    def taken(self, image: Image, pose: Pose) -> RigidReference:
        """A reference of an image in which the head's pose is known."""
        model = self.model
        return rigid_reference(image, pose, model.head, model.rigid, self.camera, self.renderer)


class HeadFollower(Follower):
    """Follows the head by the points of a reference, one frame after the other.

    When these points are lost, they are looked for about the lips, if their colour is known: a face
    that comes back keeps its place and size by the old reference. Then the face is looked for again
    and a new reference is taken where it is found; or, as that wanders, where it has moved since
    the frame before if it was seen there (see `carried`). Where the detector finds none, as in a
    close-up, the old reference is tried again where it was.
    """

    def __init__(self, motion: HeadMotion) -> None:
        self._motion = motion
        self._known, self._error = Keyframes(motion.camera, motion.refined), 0.0
        self._box = motion.box
        self._before: tuple[Image, Pose] | None = None
        self._lips = self._lips_anywhere()

    def step(self, image: Image, _memory: Memory | None = None) -> HeadFrame:
        """The next frame with the head's pose, or None while no face is found."""
        motion, known = self._motion, self._known
        state = known.step(image)
        if state is not None:
            self._lips = self._lips_anywhere()  # where they were when it was last lost says nothing
        elif known.first is not None and self._lips is not None:
            state = motion.again(known.first, image, self._lips.step(image))
            if state is not None:
                known.resume(state)
        if state is not None:
            self._before = image, state.pose
            return HeadFrame(image, motion.settled(image, state.pose))
        return HeadFrame(image, self._looked_for(image))

    def _lips_anywhere(self) -> LipFollower | None:
        """Follower of lips that may be anywhere; None where their colour is not known."""
        colours = self._motion.colours
        return None if colours is None else LipFollower(colours, self._motion.rate)

    def _looked_for(self, image: Image) -> Pose | None:
        """The head where nothing could be followed; None where no face is found."""
        motion, known, error = self._motion, self._known, self._error
        found = motion.turned(image, known.pose, error)
        turned = found is not None
        found = found or motion.found(image, self._box, self._before)
        self._box = self._before = None
        if found is None or not (turned or motion.explains(image, found.pose, error)):
            return None
        self._before = image, found.pose
        if turned:
            known.add(found)
        else:
            known.begin(found)
            self._error = motion.error(image, found.pose)
        return found.pose


def followed(motion: Motion, images: Iterable[Image]) -> Iterator[tuple[Image, Pose | None]]:
    """Each frame with the head's pose, or None while no face is found."""
    follower, memory = motion.follower(), Memory()
    for image in images:
        yield image, follower.step(image, memory).pose
    follower.finish()


def carried(
    before: Image, pose: Pose, now: Image, points: NDArray[np.floating], camera: Camera
) -> Pose | None:
    """A head's pose, moved across the line of sight as its face moved from one frame to the next.

    Found by normalised correlation of the face as a whole, for which few details are enough.
    `points` (N, 3), mm, head frame, are of its rigid part. None where the next frame's face does
    not look as before: nearer, turned, or another one.
    """
    if before.shape != now.shape:
        return None
    there = pose.apply(points.astype(np.float64))
    pixels, depth = camera.project(there), float(there[:, 2].mean())
    focal = camera.matrix[0, 0]
    limits = np.array(before.shape[1::-1]) - 1
    low, high = (np.clip(np.rint(f(pixels, axis=0)), 0, limits) for f in (np.min, np.max))
    size = high - low
    if size.min() < DETECTION.least_template:
        return None
    scale = min(1.0, DETECTION.most_template / size.max())
    reach = DETECTION.reach * focal / depth
    first = np.maximum(low - reach, 0).astype(int)
    last = np.minimum(high + reach, limits).astype(int)
    face = _small(before, low.astype(int), high.astype(int), scale)
    around = _small(now, first, last, scale)
    if float(face.std()) < 1.0:
        return None
    match = cv2.matchTemplate(around, face, cv2.TM_CCOEFF_NORMED)
    _, best, _, at = cv2.minMaxLoc(match)
    if best < DETECTION.alike:
        return None
    move = (np.array(at) / scale + first - low) * depth / focal
    return Pose(pose.rotation, pose.translation + np.r_[move, 0.0])


def _small(image: Image, low: NDArray[np.int_], high: NDArray[np.int_], scale: float) -> Image:
    part = cv2.cvtColor(image[low[1] : high[1] + 1, low[0] : high[0] + 1], cv2.COLOR_RGB2GRAY)
    return np.asarray(
        cv2.resize(part, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA), np.uint8
    )
