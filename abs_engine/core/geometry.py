"""Meshes and rigid poses. Lengths in millimetres, angles in radians."""

from __future__ import annotations

import math
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray

from abs_engine.core.arrays import FloatArray
from abs_engine.core.errors import MeshError, ParameterError

_ROUNDING = 1e-3  # of a rotation's elements, as where a file holds few digits


@dataclass(frozen=True, eq=False)
class Mesh:
    """A triangle mesh.

    Parameters
    ----------
    vertices : (V, 3) float64
        Positions in mm, head frame (x to the subject's left, y up, z out of the face).
    faces : (F, 3) int32
        Vertex indices, counter-clockwise seen from outside.

    Raises
    ------
    MeshError
        If a coordinate is not finite, an index is no whole number or out of range, or no facet has
        an area.
    """

    vertices: FloatArray
    faces: NDArray[np.int32]

    def __post_init__(self) -> None:
        try:
            vertices = np.asarray(self.vertices, np.float64)
        except (TypeError, ValueError) as error:
            raise MeshError("vertices are not three numbers each", "give (V, 3), in mm") from error
        object.__setattr__(self, "vertices", vertices)
        object.__setattr__(self, "faces", _indices(self.faces))
        check_mesh(vertices, self.faces)

    def areas(self) -> FloatArray:
        """Area of every facet, (F,) float64, mm^2."""
        return facet_areas(self.vertices, self.faces)

    def normals(self) -> FloatArray:
        """Area-weighted unit vertex normals, (V, 3) float64; zero where no facet has an area."""
        return vertex_normals(self.vertices, self.faces)


def check_mesh(vertices: FloatArray, faces: NDArray[np.int32]) -> None:
    """Raise `MeshError` unless the arrays make a mesh that can be drawn."""
    if vertices.ndim != 2 or vertices.shape[1] != 3 or faces.ndim != 2 or faces.shape[1] != 3:
        raise MeshError(
            f"mesh arrays have shapes {vertices.shape} and {faces.shape}",
            "give vertices (V, 3) and triangular faces (F, 3)",
        )
    if not np.isfinite(vertices).all():
        bad = int((~np.isfinite(vertices)).any(axis=1).sum())
        raise MeshError(
            f"{bad} mesh vertices are NaN or infinite", "repair the mesh file or the deformation"
        )
    if len(faces) == 0:
        raise _outside(vertices)
    _check_indices(vertices, faces)
    if not np.any(_facet_cross(vertices, faces)):
        raise MeshError("every facet of the mesh has zero area", "check the vertices' units")


def _indices(faces: ArrayLike) -> NDArray[np.integer]:
    """Indices as int32 where none is altered by it, and as they are where some are too large."""
    try:
        given = np.asarray(faces)
        whole = given if given.dtype.kind in "iu" else np.asarray(given, np.float64)
        if not np.isfinite(whole).all() or (whole != np.floor(whole)).any():
            raise ValueError("NaN or a fraction")
    except (TypeError, ValueError) as error:
        raise MeshError(
            "indices of facets are not whole numbers", "give triangular faces (F, 3)"
        ) from error
    fits = whole.min(initial=0) >= -(1 << 31) and whole.max(initial=0) < 1 << 31
    return whole.astype(np.int32 if fits else np.int64)


def _check_indices(vertices: FloatArray, faces: NDArray[np.integer]) -> None:
    """Raise `MeshError` if a facet has a corner that is none of the vertices."""
    if faces.min(initial=0) < 0 or faces.max(initial=-1) >= len(vertices):
        raise _outside(vertices)


def _outside(vertices: FloatArray) -> MeshError:
    return MeshError(
        f"faces point outside of the {len(vertices)} vertices",
        "check that indices start at 0 and belong to this mesh",
    )


def edges_of(faces: NDArray[np.integer]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Edges (E, 2) of facets (F, 3), each once, and how many facets (E,) each is an edge of.

    The smaller vertex is first; they are in the order of their vertices.
    """
    both = np.sort(np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]), axis=1)
    size = int(both.max(initial=0)) + 1
    # NumPy sorts numbers many times faster than rows
    found, count = np.unique(both[:, 0].astype(np.int64) * size + both[:, 1], return_counts=True)
    return np.column_stack(np.divmod(found, size)), count


def vertex_normals(vertices: FloatArray, faces: NDArray[np.int32]) -> FloatArray:
    """Area-weighted unit normals of vertices (V, 3); zero where no adjacent facet has an area.

    Raises `MeshError` if a facet (F, 3) has a corner that is none of the vertices.
    """
    from abs_engine.core.facet_loops import unit_normals  # numba takes a while to import

    faces = np.asarray(faces)
    _check_indices(vertices, faces)  # the compiled loop reads and writes wherever they point
    normals = unit_normals(np.asarray(vertices, np.float64), faces)
    return np.asarray(normals, np.float64)


def seamless_normals(
    vertices: FloatArray, faces: NDArray[np.integer], weld: NDArray[np.integer]
) -> FloatArray:
    """`vertex_normals` (V, 3) where vertices of one number in `weld` (V,) count as one."""
    points = np.zeros((int(weld.max()) + 1, 3))
    points[weld] = vertices
    return np.asarray(vertex_normals(points, weld[faces].astype(np.int32))[weld], np.float64)


def facet_areas(vertices: FloatArray, faces: NDArray[np.integer]) -> FloatArray:
    """Area of every facet (F, 3) of a mesh, (F,) float64, in the vertices' units squared."""
    return np.asarray(0.5 * np.linalg.norm(_facet_cross(vertices, faces), axis=1), np.float64)


def _facet_cross(vertices: FloatArray, faces: NDArray[np.integer]) -> FloatArray:
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    return np.cross(b - a, c - a)


@dataclass(frozen=True, eq=False)
class Pose:
    """A rigid motion from the head frame to the camera frame, x_cam = R x_head + t.

    Parameters
    ----------
    rotation : (3, 3) float64
    translation : (3,) float64, mm, camera frame (OpenCV: x right, y down, z forward)
    """

    rotation: FloatArray
    translation: FloatArray

    def __post_init__(self) -> None:
        turn, shift = _numbers(self.rotation, 3, 3), _numbers(self.translation, 3)
        object.__setattr__(self, "rotation", turn)
        object.__setattr__(self, "translation", shift)
        if not (np.isfinite(self.rotation).all() and np.isfinite(self.translation).all()):
            raise ParameterError("a pose holds NaN or infinity", "check the values it was made of")
        if not _turns(turn):
            raise ParameterError(
                "a pose's matrix is no rotation: its axes are mirrored, stretched or not at right "
                "angles",
                "give one of determinant 1 whose transpose is its inverse",
            )

    @classmethod
    def from_vectors(cls, rotation_vector: ArrayLike, translation: ArrayLike) -> Pose:
        """Pose from a rotation vector (radians, as `cv2.Rodrigues`) and a translation (mm)."""
        matrix, _ = cv2.Rodrigues(_numbers(rotation_vector, 3, 1))
        return cls(np.asarray(matrix), _numbers(translation, 3))

    @classmethod
    def facing(cls, distance: float) -> Pose:
        """A head at `distance` mm on the optical axis, looking into the camera, upright."""
        return cls(FACING, np.array([0.0, 0.0, distance]))

    @property
    def rotation_vector(self) -> FloatArray:
        """Rotation vector, (3,) float64, radians."""
        return np.asarray(cv2.Rodrigues(self.rotation)[0], np.float64).reshape(3)

    def apply(self, points: FloatArray) -> FloatArray:
        """Map head-frame points (..., 3) in mm to the camera frame."""
        return np.asarray(points @ self.rotation.T + self.translation)

    @property
    def inverse(self) -> Pose:
        """The motion back; its translation is where the camera stands, in the head frame."""
        return Pose(self.rotation.T, -self.rotation.T @ self.translation)

    def angle_to(self, other: Pose) -> float:
        """Angle between the two rotations, radians, 0 to pi."""
        cosine = (np.trace(self.rotation.T @ other.rotation) - 1) / 2
        return float(np.arccos(np.clip(cosine, -1.0, 1.0)))


def _turns(matrix: FloatArray) -> bool:
    """Whether a matrix (3, 3) is a rotation, to a thousandth; ten times as quick as by NumPy."""
    (a, b, c), (d, e, f), (g, h, i) = matrix.tolist()
    off = (
        a * a + b * b + c * c - 1, d * d + e * e + f * f - 1, a * d + b * e + c * f,
        b * f - c * e - g, c * d - a * f - h, a * e - b * d - i,
    )  # fmt: skip
    return bool(max(off) < _ROUNDING and min(off) > -_ROUNDING)


def _numbers(given: ArrayLike, *shape: int) -> FloatArray:
    """Numbers of a pose as an array of their own, as a caller may change its own."""
    try:
        return np.array(given, np.float64).reshape(shape)
    except (TypeError, ValueError) as error:
        raise ParameterError(
            "a pose is a 3x3 rotation matrix and a translation of 3 numbers",
            "give these, or a rotation vector to Pose.from_vectors",
        ) from error


def compose(outer: Pose, inner: Pose) -> Pose:
    """The pose that does `inner` first, then `outer`."""
    return Pose(outer.rotation @ inner.rotation, outer.apply(inner.translation))


def pose_vectors(poses: list[Pose]) -> tuple[FloatArray, FloatArray]:
    """Rotation vectors and translations (T, 3) of poses."""
    rotations = np.reshape([pose.rotation_vector for pose in poses], (-1, 3))
    return rotations, np.reshape([pose.translation for pose in poses], (-1, 3))


FACING: FloatArray = np.diag([1.0, -1.0, -1.0])
"""Head frame to camera frame for a face that looks into the camera: half a turn about x."""


def _rotation(x: float, y: float, z: float) -> FloatArray:
    """Rotation matrix (3, 3) of one rotation vector."""
    angle = math.sqrt(x * x + y * y + z * z)
    if angle > 0:
        x, y, z = x / angle, y / angle, z / angle
    s, c = math.sin(angle), math.cos(angle)
    v = 1 - c
    return np.array(
        [
            [c + v * x * x, v * x * y - s * z, v * x * z + s * y],
            [v * x * y + s * z, c + v * y * y, v * y * z - s * x],
            [v * x * z - s * y, v * y * z + s * x, c + v * z * z],
        ]
    )


def nearest_rotation(matrix: FloatArray) -> FloatArray:
    """The rotation nearest to a matrix (..., 3, 3) in the sum of squared elements, no mirror image.

    Of the matrix A^T B of centred points (N, 3), it is the R by which A R comes closest to B
    (Kabsch 1976).
    """
    u, _, vt = np.linalg.svd(matrix)
    u[..., 2] *= np.sign(np.linalg.det(u @ vt))[..., None]
    return np.asarray(u @ vt)


def rotations(vectors: FloatArray) -> FloatArray:
    """Rotation matrices (B, 3, 3) of rotation vectors (B, 3), radians (Rodrigues)."""
    if len(vectors) == 1:  # twenty times as quick, and what every evaluation of a fit asks for
        return _rotation(*vectors[0].tolist())[None]
    angle = np.linalg.norm(vectors, axis=1)
    x, y, z = (vectors / np.where(angle > 0, angle, 1.0)[:, None]).T
    zero = np.zeros_like(x)
    skew = np.stack([zero, -z, y, z, zero, -x, -y, x, zero], axis=1).reshape(-1, 3, 3)
    sine, versine = np.sin(angle)[:, None, None], (1 - np.cos(angle))[:, None, None]
    return np.asarray(np.eye(3) + sine * skew + versine * (skew @ skew))
