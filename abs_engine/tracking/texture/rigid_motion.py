"""The rigid motion of the head, from points of the upper face that do not take part in speech.

Seen from the lips alone, a raised head and a raised jaw look alike. Points on forehead, eyes and
nose tell them apart: they are followed from one reference frame by optical flow, and the pose
that explains them is the centre of the tracker's pose prior. For a head that turns there is a
reference for each way that it faces.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, cast

import cv2
import numpy as np
from numpy.typing import NDArray

from abs_engine.core.arrays import BoolArray, FloatArray, Image
from abs_engine.core.camera import Camera
from abs_engine.core.geometry import Pose
from abs_engine.core.scene import Candidates, Renderer, Scene
from abs_engine.tracking.settings.head import HEAD_POSE
from abs_engine.tracking.settings.registration import REGISTRATION


@dataclass(frozen=True, eq=False)
class RigidReference:
    """A frame with points of known place on the head.

    Parameters
    ----------
    gray : (H, W) uint8
    pixels : (N, 2) float32
    points : (N, 3) float64, mm, head frame
    pose : Pose
        The head's pose in this frame.
    """

    gray: Image
    pixels: NDArray[np.float32]
    points: FloatArray
    pose: Pose


@dataclass(frozen=True, eq=False)
class RigidState:
    """Current places of the points.

    Parameters
    ----------
    pixels : (N, 2) float32
    seen : float
        Share of the points that were followed, 0 to 1.
    """

    pose: Pose
    pixels: NDArray[np.float32]
    seen: float


def rigid_reference(
    image: NDArray[np.uint8],
    pose: Pose,
    scene: Scene,
    rigid: BoolArray,
    camera: Camera,
    renderer: Renderer,
) -> RigidReference:
    """Choose corners of an image (H, W, 3) RGB that lie on the rigid part of the face.

    `rigid` (F,) are the facets that move with the skull of a head whose weights are zero.
    """
    gray = cv2.cvtColor(image, cv2.COLOR_RGB2GRAY)
    still = Candidates.one(np.zeros(scene.n_modes), pose)
    buffers = renderer.draw(scene, still, camera, camera.whole)[0]
    on_face = buffers.covered & rigid[np.maximum(buffers.facet_id - 1, 0)]
    face = float(np.sqrt(buffers.covered.sum()))
    mask = cv2.erode(on_face.astype(np.uint8), np.ones((3, 3), np.uint8))
    apart = max(REGISTRATION.least_apart, face / REGISTRATION.corners_across)
    most, quality = REGISTRATION.most_corners, REGISTRATION.corner_quality
    pixels = corners_of(gray, most, quality, apart, mask)
    column, row = np.rint(pixels.astype(np.float64)).astype(int).T
    corners = scene.faces[buffers.facet_id[row, column] - 1]
    weights = buffers.barycentrics[row, column].astype(np.float64)
    points = np.einsum("nk,nkd->nd", weights, scene.mean.astype(np.float64)[corners])
    return RigidReference(np.asarray(gray, np.uint8), pixels, points, pose)


def corners_of(
    gray: NDArray[Any], most: int, quality: float, apart: float, mask: NDArray[Any], block: int = 3
) -> NDArray[np.float32]:
    """Corners (N, 2), px, of a grey picture (H, W), at most so many, where a mask is not 0."""
    found = cv2.goodFeaturesToTrack(gray, most, quality, apart, mask=mask, blockSize=block)
    some = cast("NDArray[np.float32] | None", found)  # OpenCV's types do not say so
    return np.zeros((0, 2), np.float32) if some is None else some.reshape(-1, 2)


def follow(
    reference: RigidReference, image: NDArray[np.uint8], camera: Camera, last: RigidState | None
) -> RigidState | None:
    """The head's pose in a new frame, or None where too few points can be followed.

    Points are always followed from the reference frame, so errors do not add up.
    """
    if len(reference.points) < REGISTRATION.least_points:
        return None
    gray = np.asarray(cv2.cvtColor(image, cv2.COLOR_RGB2GRAY), np.uint8)
    guess = reference.pixels if last is None else last.pixels
    there, ok = flow(reference.gray, gray, reference.pixels, guess)
    back, ok_back = flow(gray, reference.gray, there, reference.pixels)
    returns = np.linalg.norm(back - reference.pixels, axis=1) < HEAD_POSE.returns
    good = ok & ok_back & returns
    if good.sum() < REGISTRATION.least_points:
        return None
    start = reference.pose if last is None else last.pose
    pose, distance = _resect(reference.points[good], there[good], camera, start)
    stray = REGISTRATION.stray * float(np.median(distance))
    near = distance < max(REGISTRATION.least_stray, stray)
    if near.sum() < REGISTRATION.least_points:
        return None
    projected = camera.project(pose.apply(reference.points)).astype(np.float32)
    pixels = np.where(good[:, None], there, projected)
    return RigidState(pose, pixels, float(near.sum() / len(good)))


def flow(
    before: Image,
    after: Image,
    pixels: NDArray[np.float32],
    guess: NDArray[np.float32],
    levels: int = REGISTRATION.flow_levels,
) -> tuple[NDArray[np.float32], BoolArray]:
    """Places of one image's `pixels` (N, 2) in another, near `guess`; and a mask of those found."""
    there, found, _ = cv2.calcOpticalFlowPyrLK(
        before,
        after,
        pixels,
        guess.copy(),
        winSize=(REGISTRATION.flow_window, REGISTRATION.flow_window),
        maxLevel=levels,
        flags=cv2.OPTFLOW_USE_INITIAL_FLOW,
    )
    return np.asarray(there, np.float32), np.asarray(found).ravel() == 1


def _resect(
    points: FloatArray, pixels: NDArray[np.float32], camera: Camera, start: Pose
) -> tuple[Pose, FloatArray]:
    """Pose from points, robust to outliers, held weakly to where it was; and the distances.

    See `REGISTRATION.drift`.
    """
    from scipy.optimize import least_squares  # not for every clip: it takes a while to import

    centre = points.mean(axis=0)
    at = start.apply(centre)
    pull = 1 / np.array(REGISTRATION.drift)

    def pose_of(x: FloatArray) -> Pose:
        turned = Pose.from_vectors(x[:3], np.zeros(3)).rotation @ start.rotation
        return Pose(turned, at + x[3:] - turned @ centre)

    def residuals(x: FloatArray) -> FloatArray:
        offset = camera.project(pose_of(x).apply(points)) - pixels
        return np.concatenate([offset.ravel() / HEAD_POSE.match_noise, x * pull])

    fit = least_squares(
        residuals,
        np.zeros(6),
        loss="soft_l1",
        x_scale=1 / (REGISTRATION.steps_in_drift * pull),
        max_nfev=REGISTRATION.pose_limit,
    )
    pose = pose_of(fit.x)
    return pose, np.linalg.norm(camera.project(pose.apply(points)) - pixels, axis=1)


class Keyframes:
    """References of one head, and where it was last.

    Points of one are hidden when the head turns away from it. While the pose is still known, the
    frame then seen becomes a reference of its own.

    Parameters
    ----------
    make : callable
        A reference from an image and the head's pose in it.
    """

    def __init__(self, camera: Camera, make: Callable[[Image, Pose], RigidReference]) -> None:
        self._camera, self._make = camera, make
        self.references: list[RigidReference] = []
        self._current = 0
        self._state: RigidState | None = None

    @property
    def first(self) -> RigidReference | None:
        """The reference in use; None before there is one."""
        return self.references[self._current] if self.references else None

    def begin(self, reference: RigidReference) -> None:
        """Forget the others: the head was found anew."""
        self.references, self._current, self._state = [reference], 0, None

    def add(self, reference: RigidReference) -> None:
        """Go on with one more reference of the same head."""
        self.references = [*self.references[-REGISTRATION.most_references + 1 :], reference]
        self._current = len(self.references) - 1
        self._state = RigidState(reference.pose, reference.pixels, 1.0)

    @property
    def pose(self) -> Pose | None:
        """Last pose of the head; None before it was found."""
        if self._state is not None:
            return self._state.pose
        return None if self.first is None else self.first.pose

    def resume(self, state: RigidState) -> None:
        """Go on from a state of the reference in use."""
        self._state = state

    def step(self, image: Image) -> RigidState | None:
        """The head in the next frame; None where no reference is seen well enough."""
        if not self.references:
            return None
        for index in self._order()[: REGISTRATION.references_tried]:
            new = follow(self.references[index], image, self._camera, self._guess(index))
            if new is not None and new.seen >= REGISTRATION.least_seen:
                self._current, self._state = index, new
                self._extend(image, new)
                return self._state
        return None

    def _order(self) -> list[int]:
        """References, the one in use or a much nearer one first, then by how near they face."""
        if self._state is None:
            return [self._current]
        away = np.array([r.pose.angle_to(self._state.pose) for r in self.references])
        away[self._current] -= REGISTRATION.nearer
        return [int(k) for k in np.argsort(away, kind="stable")]

    def _guess(self, index: int) -> RigidState | None:
        if self._state is None or index == self._current:
            return self._state
        points = self._camera.project(self._state.pose.apply(self.references[index].points))
        return RigidState(self._state.pose, points.astype(np.float32), 1.0)

    def _extend(self, image: Image, state: RigidState) -> None:
        """Take this frame as a reference, too, if the head faces where none does."""
        apart = min(r.pose.angle_to(state.pose) for r in self.references)
        badly = state.seen < REGISTRATION.seen_badly
        least = REGISTRATION.apart_badly if badly else REGISTRATION.apart
        full = len(self.references) >= REGISTRATION.most_references
        if state.seen >= REGISTRATION.seen_well or apart < least or full:
            return
        new = self._make(image, state.pose)
        if len(new.points) >= REGISTRATION.least_reference:
            self.add(new)
