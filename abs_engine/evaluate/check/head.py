"""The person at rest: a head in millimetres, the right way round, with landmarks in order."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.arrays import FloatArray
from abs_engine.core.geometry import vertex_normals
from abs_engine.dataset import Clip
from abs_engine.evaluate.check.finding import Finding

EYES_APART = (45.0, 80.0)
"""mm between the middles of the eyes: 99 % of adults lie within 50 and 75 mm (Dodgson 2004)."""

HEIGHT = (150.0, 450.0)
WIDTH = (110.0, 260.0)
STEP = 8.0
"""Neighbours on the ring of the outer lip are not farther apart, mm."""

_RIGHTWARD = {
    "the eyes": [36, 39, 42, 45],
    "the jaw line": range(17), "the brows": range(17, 27), "the nostrils": range(31, 36),
    "the right eye's upper lid": range(36, 40), "the left eye's upper lid": range(42, 46),
    "the upper lip": range(48, 55), "the upper inner lip": range(60, 65),
    "the lower lip": [48, *range(59, 53, -1)], "the lower inner lip": [60, 67, 66, 65, 64],
    "the right eye's lower lid": [36, 41, 40, 39], "the left eye's lower lid": [42, 47, 46, 45],
}  # fmt: skip
"""Landmarks whose x must grow one after the other."""

_ABOVE = (
    (37, 41), (38, 40), (43, 47), (44, 46), (50, 58), (51, 57), (52, 56), (27, 28), (28, 29),
    (19, 37), (24, 44), (39, 51), (42, 51), (33, 51), (57, 8),
)  # fmt: skip
"""Pairs of landmarks, the first of which must be above the second."""


def head_findings(clip: Clip, name: str) -> Iterator[Finding]:
    """Faults of the person at rest."""
    points = clip.neutral.astype(np.float64)
    yield from size_findings(points, clip.landmarks["landmark_68"], name)
    yield from frame_findings(points, clip, name)
    yield from order_findings(points[clip.landmarks["landmark_68"]], name)
    yield from ring_findings(points, clip, name)


def size_findings(points: FloatArray, marks: NDArray[np.int32], name: str) -> Iterator[Finding]:
    """A head that is not as large as heads are, in mm."""
    right, left = points[marks[36:42]].mean(axis=0), points[marks[42:48]].mean(axis=0)
    extent = np.ptp(points, axis=0)
    sizes = (
        ("the eyes are not as far apart as in mm", np.linalg.norm(left - right), EYES_APART),
        ("the head is not as wide as in mm", extent[0], WIDTH),
        ("the head is not as high as in mm", extent[1], HEIGHT),
    )
    for what, size, (low, high) in sizes:
        if not low <= size <= high:
            yield Finding(name, what, f"{size:.3g}, not {low:g} to {high:g}")


def frame_findings(points: FloatArray, clip: Clip, name: str) -> Iterator[Finding]:
    """Axes of the head frame that point elsewhere, and facets that are wound inwards."""
    marks = clip.landmarks["landmark_68"]
    face = points[marks]
    right, left, mouth = face[36:42].mean(axis=0), face[42:48].mean(axis=0), face[48:].mean(axis=0)
    if left[0] <= right[0]:
        yield Finding(name, "x does not point to the subject's left", "by the eyes")
    if (left + right)[1] / 2 <= mouth[1]:
        yield Finding(name, "y does not point up", "the eyes are not above the mouth")
    if face[30, 2] <= max(left[2], right[2]) or mouth[2] <= face[[0, 16], 2].max():
        yield Finding(name, "z does not point out of the face", "by nose, mouth and ears")
    nose = vertex_normals(points, clip.faces)[marks[30]]
    if nose[2] <= 0:
        yield Finding(name, "facets are wound inwards", f"the nose's normal has z {nose[2]:.2f}")


def order_findings(face: FloatArray, name: str) -> Iterator[Finding]:
    """Landmarks (68, 3) that are not in their order."""
    wrong = [part for part, row in _RIGHTWARD.items() if np.diff(face[list(row), 0]).min() <= 0]
    wrong += [f"points {a} and {b}" for a, b in _ABOVE if face[a, 1] <= face[b, 1]]
    if wrong:
        how = ", ".join(wrong[:3]) + (f" and {len(wrong) - 3} more" if len(wrong) > 3 else "")
        yield Finding(name, "landmark_68 is not in its order", how)


def ring_findings(points: FloatArray, clip: Clip, name: str) -> Iterator[Finding]:
    """Lists of the lips that do not agree with the 68 landmarks."""
    lists, marks = clip.landmarks, clip.landmarks["landmark_68"]
    for other, wanted in (("outer_lip_20", marks[48:60]), ("inner_lip_8", marks[60:])):
        if not np.array_equal(lists[other], wanted):
            yield Finding(name, f"{other} differs from the 68 landmarks")
    corners = points[lists["mouth_corners"]]
    if (
        corners.shape != (2, 3)
        or np.linalg.norm(corners - points[marks[[48, 54]]], axis=1).max() > 6
    ):
        yield Finding(name, "mouth_corners are not at landmarks 48 and 54")
    ring = points[lists["outer_lip"]]
    step = np.linalg.norm(ring - np.roll(ring, -1, axis=0), axis=1).max()
    if step > STEP:
        yield Finding(name, "outer_lip is not a ring of neighbours", f"a step of {step:.1f} mm")
