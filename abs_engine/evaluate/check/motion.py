"""Motion of a clip: as long as it is said to be, and one that a head can make."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.geometry import Pose
from abs_engine.dataset import Clip, Truth
from abs_engine.dataset.dataset import ClipEntry
from abs_engine.evaluate.check.finding import Finding

OFFSET = 80.0
"""No face unit moves a vertex farther than this, mm."""

TURN = 15.0
"""A head or a camera does not turn faster than this, radians per second: 0.6 in a frame of 1/25 s.

Where frames are so far apart that anything may happen between them, no turn is too far.
"""

NEAREST = 60.0
"""No camera is nearer to the middle of the head than this, mm."""


def length_findings(clip: Clip, entry: ClipEntry, name: str) -> Iterator[Finding]:
    """Frames or a rate that are not those of the list of clips."""
    if len(clip) != entry.frames:
        yield Finding(name, "holds another number of frames", f"{len(clip)}, not {entry.frames}")
    if entry.rate != clip.rate or not 0 < clip.rate <= 1000:
        yield Finding(name, "the rate makes no sense", f"{clip.rate:g} and {entry.rate:g} a second")


def offset_findings(clip: Clip, frame: int, name: str) -> Iterator[Finding]:
    """Offsets that no face can make."""
    far = np.abs(clip.offsets[frame].astype(np.float32)).max()
    if not far <= OFFSET:
        yield Finding(name, "vertices are far from where they rest", f"{far:.0f} mm", frame)


def pose_findings(clip: Clip, name: str) -> Iterator[Finding]:
    """Head poses that are not in radians, or jump."""
    poses = [clip.world_pose(frame) for frame in range(len(clip))]
    yield from vector_findings(clip.world_rotations, poses, clip.rate, name)


def camera_findings(truth: Truth, name: str) -> Iterator[Finding]:
    """Cameras whose pose is not in radians or jumps, or that are inside the head."""
    placed = truth.placed
    if placed is not None:
        poses = [placed.pose(frame) for frame in range(len(placed.rotations))]
        yield from vector_findings(placed.rotations, poses, truth.rate, name)
    near = np.linalg.norm(truth.translations, axis=1)
    if near.min() < NEAREST:
        at = int(near.argmin())
        yield Finding(name, "the camera is inside the head", f"{near[at]:.3g} mm", at)


def vector_findings(
    vectors: NDArray[np.float64], poses: list[Pose], rate: float, name: str
) -> Iterator[Finding]:
    """Rotation vectors (T, 3) that are no radians, and rotations that jump at a frame rate."""
    size = np.linalg.norm(vectors, axis=1)
    if size.max() > 2 * np.pi:
        at = int(size.argmax())
        yield Finding(
            name, "rotations are not in radians", f"a vector of length {size[at]:.1f}", at
        )
        return
    turns = [a.angle_to(b) for a, b in pairwise(poses)]
    if turns and max(turns) > TURN / rate:
        at = int(np.argmax(turns))
        how = f"{np.degrees(turns[at]):.3g} degrees from one frame to the next"
        yield Finding(name, "rotations jump", how, at)
