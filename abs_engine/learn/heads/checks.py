"""Checks of a head before it is made: its units and the rings of its lips must be a face's.

Files that hold something else can be read, and would make a head that moves wrongly.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.arrays import FloatArray, IntArray
from abs_engine.core.errors import ParameterError
from abs_engine.face.schema import FACE_UNITS
from abs_engine.learn.heads.marks import Marks
from abs_engine.learn.heads.settings import HEAD_IMPORT
from abs_engine.learn.heads.table import EYES_MM


def check_marks(marks: Marks, vertices: FloatArray) -> None:
    """Raise `ParameterError` where the nose or the chin of a face (V, 3), mm, is on the lips."""
    lips, nose, chin = (vertices[at, 1] for at in (marks.outer_lip, marks.nose_tip, marks.chin))
    for name, far, where in (
        ("chin", lips.min() - chin[0], "below"), ("nose_tip", nose[0] - lips.max(), "above"),
    ):  # fmt: skip
        if far < HEAD_IMPORT.chin_below:
            raise ParameterError(
                f"landmark {name} does not lie {where} the lips ({far:.0f} mm)",
                f"give the vertex at the tip of the {name.removesuffix('_tip')}",
            )


def check_person(path: Path, places: FloatArray, vertices: FloatArray, marks: Marks) -> None:
    """Raise `ParameterError` where a person's places (V, 3), mm, are no face like the head's."""
    at = np.r_[
        marks.outer_lip, marks.inner_lip, marks.nose_tip[:1], marks.chin[:1], marks.eye_corners[:4]
    ]
    far = float(np.linalg.norm(places[at] - vertices[at], axis=1).max())
    right, left = places[marks.eye_corners[[0, 3]]]
    eyes, (_, least, most) = float(np.linalg.norm(left - right)), EYES_MM
    if not least < eyes < most:
        problem = f"its eyes' outer corners are {eyes:.4g} mm apart"
    elif far > HEAD_IMPORT.most_apart:
        problem = f"landmarks of its face lie up to {far:.0f} mm from the head's"
    else:
        try:
            check_marks(marks, places)
        except ParameterError as error:
            problem = error.problem
        else:
            return
    raise ParameterError(
        f"{path} is no face like the head's: {problem}",
        "scale it to the head's unit"
        if _in_another_unit(places, vertices)
        else "export it as the head was: the same vertices in their order, unit, axes and place",
    )


def check_units(units: NDArray[np.float32], vertices: FloatArray, marks: Marks) -> None:
    """Raise `ParameterError` where a face unit (V, 3) moves what no posture of a face moves."""
    fixed = np.r_[marks.eye_corners[:4], marks.nose_tip[:1]]
    far = np.linalg.norm(units[:, fixed], axis=2).max(axis=1)
    worst = int(far.argmax())
    if far[worst] > HEAD_IMPORT.most_fixed:
        raise ParameterError(
            f"{FACE_UNITS[worst]} moves the corners of the eyes or the tip of the nose by "
            f"{far[worst]:.0f} mm",
            _remedy(units[worst], vertices),
        )


def _remedy(moved: NDArray[np.float32], vertices: FloatArray) -> str:
    if _in_another_unit(moved + vertices, vertices):
        return "its file seems to be in another unit than the head: scale it to the head's"
    likeness = _likeness(moved, vertices)
    if likeness < -HEAD_IMPORT.alike:
        return "its file seems to hold differences from the neutral head: give whole heads"
    if likeness > HEAD_IMPORT.alike:
        return "its morph target seems to hold positions: give displacements from the neutral head"
    return "give the motion of the face alone, with the head at rest"


def _in_another_unit(places: FloatArray, vertices: FloatArray) -> bool:
    """Whether places (V, 3) are the head's, but much larger or smaller."""
    times = np.linalg.norm(places - places.mean(axis=0)) / np.linalg.norm(
        vertices - vertices.mean(axis=0)
    )
    alike = _likeness(places, vertices) > HEAD_IMPORT.alike
    return bool(alike and not 1 / HEAD_IMPORT.rescaled < times < HEAD_IMPORT.rescaled)


def _likeness(moved: NDArray[np.floating], vertices: FloatArray) -> float:
    """Correlation of displacements with places (V, 3)."""
    one, other = moved - moved.mean(axis=0), vertices - vertices.mean(axis=0)
    size = float(np.linalg.norm(one) * np.linalg.norm(other))
    return float((one * other).sum() / max(size, 1e-12))


def check_rings(marks: Marks, opened: FloatArray) -> None:
    """Raise `ParameterError` where the lips of an open mouth (V, 3) are listed in a wrong order."""
    for name, ring in (("outer_lip", marks.outer_lip), ("inner_lip", marks.inner_lip)):
        problem = _problem(ring, opened)
        if problem:
            raise ParameterError(
                f"{name} {problem}",
                "list it from the subject's right corner over the upper lip to the left, and back",
            )
    outer, inner = (np.ptp(opened[ring, 0]) for ring in (marks.outer_lip, marks.inner_lip))
    if inner > outer:
        raise ParameterError(
            "inner_lip is wider than outer_lip",
            "give the outline of the lips as outer_lip, and the line where they meet as inner_lip",
        )


def _problem(ring: IntArray, opened: FloatArray) -> str:
    across, up = opened[ring, 0], opened[ring, 1]
    wide, left = float(np.ptp(across)), int(across.argmax())
    if across[0] - across.min() > HEAD_IMPORT.ring_aside * wide:
        return "does not begin at the right corner of the mouth"
    upper, lower = up[1:left], up[left + 1 :]
    if not len(upper) or not len(lower):
        return "does not go round the mouth"
    if upper.mean() < lower.mean() - HEAD_IMPORT.ring_below * wide:
        return "goes over the lower lip first"
    return ""
