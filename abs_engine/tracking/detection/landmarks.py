"""468 points of a face as a network sees them (`tracking.detection.attention_mesh`).

It says where to begin, and is one soft piece of evidence with a measured noise
(`tracking.landmark.landmark_correspondence`); what is reported comes from rendering and comparing.
"""

from __future__ import annotations

import json
from dataclasses import dataclass
from functools import cache, cached_property

import cv2
import numpy as np
from numpy.typing import NDArray

from abs_engine.core.arrays import FloatArray, Image
from abs_engine.core.camera import Camera
from abs_engine.core.geometry import nearest_rotation
from abs_engine.core.threads import in_threads
from abs_engine.face.appearance.one_tint import untinted
from abs_engine.io.assets import shipped
from abs_engine.tracking.detection.attention_mesh import SIDE, seen_mesh
from abs_engine.tracking.detection.face_detection import MARKS, Face
from abs_engine.tracking.detection.network import square_of
from abs_engine.tracking.settings.detection import DETECTION

COUNT = 468
OUTER_RING = np.array(
    [61, 146, 91, 181, 84, 17, 314, 405, 321, 375, 291, 409, 270, 269, 267, 0, 37, 39, 40, 185]
)
"""The outer edge of the lips: from the subject's right corner along the lower lip and back."""
INNER_RING = np.array(
    [78, 95, 88, 178, 87, 14, 317, 402, 318, 324, 308, 415, 310, 311, 312, 13, 82, 81, 80, 191]
)
"""Where the lips meet, in the same order."""
INNER_PAIRS, OUTER_PAIRS = (np.stack([r[:10:-1], r[1:10]]) for r in (INNER_RING, OUTER_RING))
"""Nine of the upper lip (2, 9), and below them the lower lip's, from the subject's right."""
LIPS = np.concatenate([OUTER_RING, INNER_RING])
MIDDLES = (13, 14)
"""Of the inner lips, the upper one and the lower."""
EYES = (np.array([33, 133]), np.array([263, 362]))
"""Corners of the subject's right and left eye, the outer one first."""
_AROUND = 1.5  # times a face's size: what it looks at (as MediaPipe does)


@dataclass(frozen=True, eq=False)
class Landmarks:
    """A face's points as the network sees them.

    Parameters
    ----------
    points : (468, 3) float64, px
        Column, row, and depth: towards the camera it is less; its zero is arbitrary.
    presence : float
        How probably a face was looked at, 0 to 1.
    unlike : float
        How far the network puts the points elsewhere in the mirror image (RMS), in sizes of the
        face; 0 where it was not asked. About 0.01 of a face that lies where it looks.
    """

    points: FloatArray
    presence: float
    unlike: float = 0.0

    @property
    def pixels(self) -> FloatArray:
        """Columns and rows (468, 2)."""
        return self.points[:, :2]

    @cached_property
    def axes(self) -> tuple[FloatArray, FloatArray]:
        """Unit vectors (2,) in the picture: from the right to the left eye, and down the face."""
        return _axes(*(self.pixels[pair].mean(axis=0) for pair in EYES))

    @cached_property
    def size(self) -> float:
        """Longer side of the upright box about the points, px."""
        return float(max(np.ptp(self.pixels @ axis) for axis in self.axes))

    @property
    def quarters(self) -> int:
        """Quarter turns of the picture, against the clock, after which the face is upright."""
        (x, y), _ = self.axes
        return round(float(np.arctan2(y, x)) / (np.pi / 2)) % 4

    @property
    def openness(self) -> float:
        """Height between the inner lips' middles over the distance of the eyes' outer corners."""
        upper, lower, right, left = self.pixels[[*MIDDLES, 33, 263]]
        across = float(np.linalg.norm(left - right))
        return float(np.linalg.norm(upper - lower)) / max(across, 1e-9)

    def turn_to(self, other: Landmarks) -> FloatArray:
        """Rotation vector (3,), radians, camera axes, that lays the points best on other ones."""
        mine, theirs = (p.points - p.points.mean(axis=0) for p in (self, other))
        turn = nearest_rotation(theirs.T @ mine)
        return np.asarray(cv2.Rodrigues(turn)[0][:, 0], np.float64)


@dataclass(frozen=True, eq=False)
class SeenRays:
    """Landmarks as rays of a camera.

    Parameters
    ----------
    rays : (468, 2) float64
        At depth 1.
    depth : (468,) float64
        Over the focal length.
    axes : (2, 2) float64
        Of the face, see `Landmarks.axes`.
    trust : (468,) float64
        Weight of each, 0 to 1.
    pixel : float
        Width of a pixel at depth 1.
    """

    rays: FloatArray
    depth: FloatArray
    axes: FloatArray
    trust: FloatArray
    pixel: float

    @classmethod
    def of(cls, landmarks: Landmarks, camera: Camera, trust: FloatArray | None = None) -> SeenRays:
        """The rays of landmarks in a camera's picture; by default all are trusted."""
        pixel = 1.0 / float(camera.matrix[0, 0])
        depth = landmarks.points[:, 2] * pixel
        weights = np.ones(len(depth)) if trust is None else trust
        rays = camera.undistort(landmarks.pixels)
        return cls(rays, depth, np.stack(landmarks.axes), weights, pixel)


def landmarks_of(image: Image, face: Face, both: bool = True) -> Landmarks | None:
    """The points of a face that was detected; None where the network sees no face there.

    With `both` the network looks at the mirrored face, too.
    """
    right, left = (face.points[MARKS.index(name)] for name in ("right_eye", "left_eye"))
    first = _looked_at(image, face.centre, face.size, _axes(right, left), both=False)
    return None if first is None else landmarks_again(image, first, both)


def landmarks_at(image: Image, centre: FloatArray, size: float) -> Landmarks | None:
    """The points of an upright face of this size (px) about a place (2,), seen there or not.

    None where place or size are no numbers, or the size is at most `DETECTION.least_face`.
    """
    return _looked_at(image, centre, size, tuple(np.eye(2)), both=True, least=0.0)


def landmarks_again(image: Image, last: Landmarks, both: bool = True) -> Landmarks | None:
    """The points of a face that was at `last`, in the frame before or by a first look."""
    along, down = last.axes
    ends = [0.5 * (v.min() + v.max()) for v in (last.pixels @ along, last.pixels @ down)]
    return _looked_at(image, ends[0] * along + ends[1] * down, last.size, last.axes, both)


def _axes(right: FloatArray, left: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Unit vectors from the right to the left eye, and down the face."""
    along = (left - right) / max(float(np.linalg.norm(left - right)), 1e-9)
    return along, np.array([-along[1], along[0]])


def _looked_at(
    image: Image,
    centre: FloatArray,
    size: float,
    axes: tuple[FloatArray, ...],
    both: bool,
    least: float = DETECTION.present,
) -> Landmarks | None:
    """The network's square, upright along a face's axes, about it; black lies around the picture.

    In `both` the square and its mirror image it errs in different ways: the mean errs less.
    """
    if not (np.isfinite(centre).all() and size > DETECTION.least_face):
        return None
    step = _AROUND * size / SIDE  # image pixels for one of the network's
    matrix = np.column_stack([step * np.stack(axes, axis=1), np.zeros(2)])
    matrix[:, 2] = centre - matrix[:, :2] @ np.full(2, 0.5 * (SIDE - 1))
    patch = _cut(image, matrix, step)
    (found, presence), *more = in_threads(seen_mesh, [patch, patch[:, ::-1]] if both else [patch])
    if presence < least:
        return None
    unlike = 0.0
    if both:
        other = more[0][0][mirrored()]
        other = np.column_stack([SIDE - other[:, 0], other[:, 1:]])
        away = ((found - other)[:, :2] ** 2).sum(axis=1)
        unlike = float(np.sqrt(away.mean())) * _AROUND / SIDE
        found = 0.5 * (found + other)
    there = (found[:, :2] - 0.5) @ matrix[:, :2].T + matrix[:, 2]
    return Landmarks(np.column_stack([there, step * found[:, 2]]), presence, unlike)


@cache
def mirrored() -> NDArray[np.int_]:
    """Counterpart of each landmark (468,) in a mirror image (`assets/make_landmarks.py`)."""
    return np.array(json.loads(shipped("detector/landmark_mirror.json").read_text()), np.int_)


def _cut(image: Image, matrix: FloatArray, step: float) -> Image:
    """The square of `SIDE` pixels that `matrix` (2, 3) maps to the image."""
    low, high = _bounds(matrix, image.shape)
    if (high <= low).any():
        return np.zeros((SIDE, SIDE, 3), np.uint8)
    part = untinted(image[low[1] : high[1], low[0] : high[0]])
    return square_of(part, matrix, low, step, SIDE, cv2.BORDER_CONSTANT)


def _bounds(
    matrix: FloatArray, shape: tuple[int, ...]
) -> tuple[NDArray[np.int_], NDArray[np.int_]]:
    """The first and last column and row of the image that the square reaches."""
    ends = np.array([[0, 0], [SIDE, 0], [0, SIDE], [SIDE, SIDE]]) - 0.5
    corners = ends @ matrix[:, :2].T + matrix[:, 2]
    limits = np.array([shape[1], shape[0]])
    low = np.clip(np.floor(corners.min(axis=0)).astype(int) - 2, 0, limits)
    return low, np.clip(np.ceil(corners.max(axis=0)).astype(int) + 3, 0, limits)
