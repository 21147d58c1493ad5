"""Brings a head into the head frame: mm, x to the subject's left, y up, z out of the face."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import permutations, product

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.arrays import FloatArray
from abs_engine.core.errors import ParameterError
from abs_engine.learn.heads.marks import Marks
from abs_engine.learn.heads.table import UNITS

_EYES_MM = 88.0, 65.0, 115.0
"""Distance of the eyes' outer corners of adults, the least and the greatest that is believed."""
_USUAL = np.array(
    [[-41, 37, 79], [-19, 36, 85], [19, 36, 85], [41, 37, 79], [0, 2, 116], [0, -64, 92]],
    np.float64,
)
"""Corners of the eyes, tip of the nose and chin of a usual head, mm, head frame."""
_LIKE = 0.85  # least correlation of a face's landmarks with the usual ones
_FAR = 300.0  # mm from the origin; a head farther away is moved to it


@dataclass(frozen=True, eq=False)
class HeadFrame:
    """Similarity from places of a file to places in the head frame.

    Parameters
    ----------
    matrix : (3, 3) float64
        A turn by right angles, times the millimetres of the file's unit.
    origin : (3,) float64, mm
        Of the head frame, once turned.
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

    Raises
    ------
    ParameterError
        If the landmarks are not a face's, or it is of no human size.
    """
    at = vertices[np.r_[marks.eye_corners[:4], marks.nose_tip[:1], marks.chin[:1]]]
    own, usual = at - at.mean(axis=0), _USUAL - _USUAL.mean(axis=0)
    size = np.linalg.norm(own) * np.linalg.norm(usual)
    turns = [t for t in _turns() if np.linalg.det(t) > 0]
    likeness = [float((own @ t.T * usual).sum() / max(size, 1e-12)) for t in turns]
    turned = at @ turns[int(np.argmax(likeness))].T
    if max(likeness) < _LIKE or turned[4, 2] < turned[:4, 2].max():
        raise ParameterError(
            "the landmarks do not lie as a face's do",
            "check their order: the subject's right eye comes first, outer corner before inner",
        )
    eyes = float(np.linalg.norm(at[3] - at[0]))
    matrix = turns[int(np.argmax(likeness))] * _millimetres(eyes, length)
    middle = matrix @ vertices[marks.eye_corners].mean(axis=0)
    usual_middle = _USUAL[:4].mean(axis=0)
    far = np.linalg.norm(middle - usual_middle) > _FAR
    return HeadFrame(matrix, middle - usual_middle if far else np.zeros(3))


def _turns() -> list[FloatArray]:
    """Matrices that permute axes and their directions."""
    signs = product((1.0, -1.0), repeat=3)
    return [np.eye(3)[list(p)] * np.array(s) for s in signs for p in permutations(range(3))]


def _millimetres(eyes: float, length: str | None) -> float:
    """Of the file's unit of length, in which the outer corners of the eyes are so far apart."""
    known = UNITS.values() if length is None else [UNITS[length]]
    usual, least, most = _EYES_MM
    best = min(known, key=lambda mm: abs(np.log(max(eyes * mm, 1e-9) / usual)))
    if not least < eyes * best < most:
        raise ParameterError(
            f"the eyes' outer corners are {eyes:.4g} apart, which is {eyes * best:.4g} mm",
            'give the unit in the table, as in length = "cm", or scale the head to human size',
        )
    return best
