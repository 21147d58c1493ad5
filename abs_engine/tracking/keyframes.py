"""Following a head that turns: a reference for each way that it faces.

Points of one reference frame are hidden when the head turns away from it. While the pose is still
known, the frame then seen becomes a reference of its own.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from abs_engine.core.arrays import Image
from abs_engine.core.camera import Camera
from abs_engine.core.geometry import Pose
from abs_engine.tracking.rigid_motion import RigidReference, RigidState, follow
from abs_engine.tracking.settings.registration import REGISTRATION


class Keyframes:
    """References of one head, and where it was last.

    Parameters
    ----------
    camera : Camera
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
        self._state = RigidState(reference.pose, reference.pixels, 0.0, 1.0)

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
        return RigidState(self._state.pose, points.astype(np.float32), 0.0, 1.0)

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
