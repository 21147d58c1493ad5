"""Landmarks to places on a head, and the network's error: by drawing and looking.

The network names its points, but not where on somebody's mesh they are, nor how well it sees
them. Both are measured: heads are drawn from several sides in several postures, the network looks
at the drawings, and each landmark is given the point of the surface that explains all of its
sightings best. What is left is its noise.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.arrays import FloatArray
from abs_engine.core.camera import Camera
from abs_engine.core.errors import FaceNotFoundError
from abs_engine.core.geometry import Pose, vertex_normals
from abs_engine.io.arrays import Layout, check_arrays, index, real
from abs_engine.io.assets import Speaker
from abs_engine.io.npz import read_npz
from abs_engine.tracking.detection.landmarks import (
    COUNT,
    INNER_PAIRS,
    INNER_RING,
    Landmarks,
    SeenRays,
)
from abs_engine.tracking.landmark.landmark_noise import LAYOUT as NOISE
from abs_engine.tracking.landmark.landmark_noise import LandmarkNoise, learn_noise, seen_off
from abs_engine.tracking.settings.landmarks import LANDMARK_EVIDENCE

FILE = "landmarks.npz"
FORMAT, VERSION = "abs_engine.landmarks", 2
_UPPER, _LOWER = INNER_PAIRS
_SEEN = ("skin", "upper_lip", "lower_lip", "eyes")  # facet classes that landmarks lie on
_LAYOUT: Layout = {
    "corners": index("V", COUNT, 3),
    "weights": real(COUNT, 3),
    "deviation": real(COUNT, 3, low=1e-9),
    **NOISE,
}
_AGAIN = "make it again with assets/make_landmarks.py"


@dataclass(frozen=True, eq=False)
class Correspondence:
    """Points of a head's surface that the landmarks show.

    Parameters
    ----------
    corners : (468, 3) int32
        Vertices of the facet that each lies on.
    weights : (468, 3) float64
        Barycentric.
    deviation : (468, 3) float64, mm
        Standard deviation of the network along the line of the eyes, down the face, and in depth.
    noise : LandmarkNoise
        The same error taken apart.
    """

    corners: NDArray[np.int32]
    weights: FloatArray
    deviation: FloatArray
    noise: LandmarkNoise

    def of(self, vertices: NDArray[np.floating]) -> FloatArray:
        """The points (..., 468, 3) of vertices (..., V, 3), which may be displacements."""
        taken = np.asarray(vertices[..., self.corners, :], np.float64)
        return np.ascontiguousarray(np.einsum("lk,...lkd->...ld", self.weights, taken))

    def arrays(self) -> dict[str, Any]:
        """As they are kept in a file."""
        return {
            "corners": self.corners, "weights": self.weights.astype(np.float32),
            "deviation": self.deviation.astype(np.float32), **self.noise.arrays(),
        }  # fmt: skip

    def save(self, path: Path) -> None:
        """Write an ``.npz`` that `load_correspondence` reads."""
        np.savez_compressed(path, format=FORMAT, version=VERSION, **self.arrays())


def load_correspondence(speaker: Speaker) -> Correspondence | None:
    """The correspondence that lies beside a speaker's file; None where there is none.

    Raises
    ------
    ModelFormatError
        If it belongs to another mesh.
    """
    path = speaker.folder / FILE
    if not (speaker.network if speaker.imported else path.is_file()):
        return None
    vertices = len(speaker.vertices)
    if speaker.imported:
        data = check_arrays(path, speaker.network, _LAYOUT, "import the head again", V=vertices)
    else:
        data = read_npz(path, FORMAT, VERSION, _LAYOUT, _AGAIN, V=vertices)
    noise = LandmarkNoise.of_arrays(data)
    return Correspondence(data["corners"], data["weights"], data["deviation"], noise)


@dataclass(frozen=True, eq=False)
class Sighting:
    """A head in a picture, and what the network saw of it.

    Parameters
    ----------
    vertices : (V, 3) float64, mm, head frame
    """

    vertices: FloatArray
    pose: Pose
    camera: Camera
    landmarks: Landmarks


def learn_correspondence(speaker: Speaker, sightings: Sequence[Sighting]) -> Correspondence:
    """The points of a speaker's mesh that sightings explain best, and what they leave.

    They are of heads with this mesh, from several sides.

    Raises
    ------
    FaceNotFoundError
        If there are fewer than `LANDMARK_EVIDENCE.least_sightings`.
    """
    if len(sightings) < LANDMARK_EVIDENCE.least_sightings:
        raise FaceNotFoundError(
            "the landmark network sees no face in drawings of this head",
            "give a head with a texture, or start from colours with --start blobs",
        )
    shapes = {id(s.vertices): s.vertices for s in sightings}.values()
    about = np.stack([_triangulated(s, sightings, speaker) for s in shapes]).mean(axis=0)
    nearest = _nearest(speaker.vertices, about)
    corners, weights = np.zeros((COUNT, 3), np.int32), np.zeros((COUNT, 3))
    deviation = np.zeros((COUNT, 3))
    views = [_View.of(s, speaker, nearest) for s in sightings]
    for k in range(COUNT):
        facets, bary = _candidates(speaker, k, about[k])
        best, left = _best(views, speaker.faces[facets], bary, k)
        corners[k], weights[k] = speaker.faces[facets[best]], bary[best]
        deviation[k] = left
    off = np.stack([off_of(corners, weights, s) for s in sightings])
    people = [id(s.vertices) for s in sightings]
    noise = learn_noise(off, np.array(people))
    return Correspondence(
        corners, weights, np.maximum(deviation, LANDMARK_EVIDENCE.least_deviation), noise
    )


def off_of(corners: NDArray[np.int32], weights: FloatArray, sighting: Sighting) -> FloatArray:
    """By how much (468, 3), mm, the network sees points of a head's surface off."""
    s = sighting
    points = np.einsum("lk,lkd->ld", weights, s.vertices[corners])
    return seen_off(s.pose.apply(points), SeenRays.of(s.landmarks, s.camera))


_BARYCENTRIC = np.vstack([np.eye(3), 0.5 * (1 - np.eye(3)), np.full((1, 3), 1 / 3)])


def _allowed(speaker: Speaker, landmark: int) -> NDArray[np.int_]:
    """Facets that a landmark may lie on: of the inner ring, those of its own lip."""
    names: tuple[str, ...] = _SEEN
    if landmark in _LOWER:
        names = ("lower_lip",)
    elif landmark in _UPPER:
        names = ("upper_lip",)
    return np.flatnonzero(speaker.facets_of(*(n for n in names if n in speaker.class_names)))


def _candidates(
    speaker: Speaker, landmark: int, about: FloatArray
) -> tuple[NDArray[np.int_], FloatArray]:
    """Facets (C,) and barycentric weights (C, 3) of the points that are tried for a landmark."""
    facets = _allowed(speaker, landmark)
    middles = speaker.vertices[speaker.faces[facets]].astype(np.float64).mean(axis=1)
    near = facets[np.argsort(np.linalg.norm(middles - about, axis=1))[: LANDMARK_EVIDENCE.tried]]
    return np.repeat(near, len(_BARYCENTRIC)), np.tile(_BARYCENTRIC, (len(near), 1))


def _triangulated(shape: FloatArray, sightings: Sequence[Sighting], speaker: Speaker) -> FloatArray:
    """Place of each landmark (468, 3) on the speaker's own vertices, by a shape's sightings."""
    matrix, sums = np.zeros((COUNT, 3, 3)), np.zeros((COUNT, 3))
    for s in (s for s in sightings if s.vertices is shape):
        k = s.camera.matrix
        rays = np.column_stack([(s.landmarks.pixels - k[:2, 2]) / np.diag(k)[:2], np.ones(COUNT)])
        rays = rays / np.linalg.norm(rays, axis=1, keepdims=True) @ s.pose.rotation
        across = np.eye(3) - rays[:, :, None] * rays[:, None]
        matrix += across
        sums += across @ (-s.pose.rotation.T @ s.pose.translation)
    places = np.linalg.solve(matrix, sums[..., None])[..., 0]
    about = np.zeros((COUNT, 3))
    for group in (np.setdiff1d(np.arange(COUNT), INNER_RING), _LOWER, _UPPER, INNER_RING[[0, 10]]):
        vertices = np.unique(speaker.faces[_allowed(speaker, int(group[0]))])
        nearest = vertices[_nearest(shape[vertices], places[group])]
        about[group] = speaker.vertices[nearest]
    return about


def _nearest(points: NDArray[np.floating], places: FloatArray) -> NDArray[np.int_]:
    """Index of the point (N, 3) that is nearest to each place (M, 3), (M,)."""
    from scipy.spatial import cKDTree  # not for every clip: it takes a while to import

    return np.asarray(cKDTree(points).query(places)[1], np.int_)


@dataclass(frozen=True, eq=False)
class _View:
    """A sighting, and which way its head's surface faces."""

    sighting: Sighting
    facing: FloatArray  # (V,) cosine between the surface and the line of sight
    scale: float  # mm for a pixel at the head
    zero: float  # mm from the camera, where the network's depth counts from
    axes: FloatArray  # (2, 2) along the eyes, down the face, in the picture

    @classmethod
    def of(cls, sighting: Sighting, speaker: Speaker, about: NDArray[np.int_]) -> _View:
        """The view of a sighting, in which the landmarks lie about some vertices (468,)."""
        s = sighting
        there = s.pose.apply(s.vertices)
        normals = vertex_normals(s.vertices, speaker.faces) @ s.pose.rotation.T
        sight = there / np.linalg.norm(there, axis=1, keepdims=True)
        along, down = s.landmarks.axes
        scale = float(there[:, 2].mean() / s.camera.matrix[0, 0])
        zero = float(np.median(there[about, 2] - scale * s.landmarks.points[:, 2]))
        return cls(s, -(normals * sight).sum(axis=1), scale, zero, np.stack([along, down]))

    def away(
        self, corners: NDArray[np.int32], weights: FloatArray, landmark: int
    ) -> tuple[FloatArray, FloatArray]:
        """By how much (C, 3), mm, the landmark is seen off points, and how well (C,) they show."""
        s = self.sighting
        there = s.pose.apply(np.einsum("ck,ckd->cd", weights, s.vertices[corners]))
        off = (s.landmarks.pixels[landmark] - s.camera.project(there)) @ self.axes.T * self.scale
        depth = s.landmarks.points[landmark, 2] * self.scale - (there[:, 2] - self.zero)
        shown = np.einsum("ck,ck->c", weights, self.facing[corners])
        return np.column_stack([off, depth]), np.clip(shown - LANDMARK_EVIDENCE.hidden, 0.0, None)


def _best(
    views: Sequence[_View], corners: NDArray[np.int32], weights: FloatArray, landmark: int
) -> tuple[int, FloatArray]:
    """Point that explains a landmark best, and the standard deviation (3,), mm, that it leaves."""
    seen = [view.away(corners, weights, landmark) for view in views]
    off, shown = np.stack([s[0] for s in seen]), np.stack([s[1] for s in seen])
    squared = np.minimum((off[..., :2] ** 2).sum(axis=2), LANDMARK_EVIDENCE.stray_sighting**2)
    mass = shown.sum(axis=0)
    cost = np.where(mass > 0, (shown * squared).sum(axis=0) / np.maximum(mass, 1e-9), np.inf)
    best = int(np.argmin(cost)) if np.isfinite(cost).any() else 0
    weight = shown[:, best] / max(float(mass[best]), 1e-9)
    return best, np.sqrt(weight @ off[:, best] ** 2)
