"""Brings a head into the head frame: mm, x to the subject's left, y up, z out of the face."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import permutations, product

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from abs_engine.core.arrays import FloatArray
from abs_engine.core.errors import ParameterError
from abs_engine.learn.heads.marks import Marks
from abs_engine.learn.heads.settings import HEAD_IMPORT
from abs_engine.learn.heads.table import EYES_MM, UNITS

_USUAL = np.array(
    [[-41, 37, 79], [-19, 36, 85], [19, 36, 85], [41, 37, 79], [0, 2, 116], [0, -64, 92]],
    np.float64,
)
"""Corners of the eyes, tip of the nose and chin of a usual head, mm, head frame."""


@dataclass(frozen=True, eq=False)
class HeadFrame:
    """Similarity from places of a file to places in the head frame.

    A turn, times the millimetres of the file's unit, (3, 3), and the origin (3,), mm, once turned.
    """

    matrix: FloatArray
    origin: FloatArray

    def places(self, vertices: FloatArray) -> FloatArray:
        """Places (..., 3), mm."""
        return np.asarray(vertices @ self.matrix.T - self.origin)

    def moves(self, displacements: NDArray[np.floating]) -> NDArray[np.float32]:
        """Displacements (..., 3), mm."""
        return np.asarray(displacements @ self.matrix.T.astype(np.float32), np.float32)


def head_frame(vertices: FloatArray, marks: Marks, length: str | None) -> HeadFrame:
    """The frame of a head (V, 3) by its landmarks, and by its unit of length if that is given.

    A head that lies in the head frame but for right angles and its unit is left as it lies there.
    Raises `ParameterError` if the landmarks are not a face's, an eye's are listed in the wrong
    order, or it is of no human size.
    """
    _check_eyes(vertices[marks.eye_corners])
    at = vertices[np.r_[marks.eye_corners[:4], marks.nose_tip[:1], marks.chin[:1]]]
    own, usual = at - at.mean(axis=0), _USUAL - _USUAL.mean(axis=0)
    eyes, extent = float(np.linalg.norm(at[3] - at[0])), float(np.linalg.norm(own))
    if extent * max(UNITS.values()) < HEAD_IMPORT.small * np.linalg.norm(usual):
        _millimetres(eyes, length)  # refuses it, before rounded places pass for a wrong order
    whole = Rotation.align_vectors(usual, own)[0].as_matrix()
    turned, size = own @ whole.T, np.linalg.norm(own) * np.linalg.norm(usual)
    likeness = float((turned * usual).sum() / max(size, 1e-12))
    if likeness < HEAD_IMPORT.face_like or turned[4, 2] < turned[:4, 2].max():
        raise ParameterError(
            "the landmarks do not lie as a face's do",
            "check their order: the subject's right eye comes first, outer corner before inner; or "
            "the mesh may be mirrored, as by a scale of -1",
        )
    right = max(_turns(), key=lambda turn: float((turn * whole).sum()))
    upright = Rotation.from_matrix(whole @ right.T).magnitude() <= np.radians(HEAD_IMPORT.oblique)
    matrix = (right if upright else whole) * _millimetres(eyes, length)
    off = matrix @ vertices[marks.eye_corners].mean(axis=0) - _USUAL[:4].mean(axis=0)
    stays = upright and np.linalg.norm(off) <= HEAD_IMPORT.beside
    return HeadFrame(matrix, np.zeros(3) if stays else off)


def _check_eyes(corners: FloatArray) -> None:
    """Raise `ParameterError` where an eye's inner corner (4, 3) is listed before the outer one.

    The outer one lies farther from the other eye.
    """
    for outer, inner, other in ((0, 1, [2, 3]), (3, 2, [0, 1])):
        far = np.linalg.norm(corners[[outer, inner]] - corners[other].mean(axis=0), axis=1)
        if far[0] < far[1]:
            raise ParameterError(
                "eye_corners lists an inner corner of an eye where the outer one should stand",
                "list the right eye's outer and inner corner, then the left eye's inner and outer",
            )


def _turns() -> list[FloatArray]:
    """Rotations that permute axes and their directions."""
    signs = product((1.0, -1.0), repeat=3)
    all_ = [np.eye(3)[list(p)] * np.array(s) for s in signs for p in permutations(range(3))]
    return [turn for turn in all_ if np.linalg.det(turn) > 0]


def _millimetres(eyes: float, length: str | None) -> float:
    """Of the file's unit of length, in which the outer corners of the eyes are so far apart."""
    known = UNITS.values() if length is None else [UNITS[length]]
    usual, least, most = EYES_MM
    best = min(known, key=lambda mm: abs(np.log(max(eyes * mm, 1e-9) / usual)))
    if not least < eyes * best < most:
        raise ParameterError(
            f"the eyes' outer corners are {eyes:.4g} apart, which is {eyes * best:.4g} mm",
            'give the unit in the table, as in length = "cm", or scale the head to human size'
            if length is None
            else f'correct length = "{length}" in the table, or leave it out',
        )
    return best
