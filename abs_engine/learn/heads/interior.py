"""Teeth, tongue and the inside of the mouth for heads that lack them: the bundled head's own.

They are laid into the mouth by its corners and the middles of its lips, and go with the face units
that the new head has as they do in the bundled one; those of the jaw, as far as its chin goes.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.arrays import FloatArray, IntArray
from abs_engine.face.schema import CLASS_NAMES, JAW, Unit
from abs_engine.io.assets import Speaker
from abs_engine.learn.heads.settings import HEAD_IMPORT

TEETH = ("upper_teeth", "lower_teeth", "tongue")


@dataclass(frozen=True, eq=False)
class Interior:
    """Addition to a head: N vertices.

    Parameters
    ----------
    vertices : (N, 3) float64, mm
    faces : (M, 3) int32
        Corners from 0.
    classes : (M,) uint8
    units : (52, N, 3) float32, mm
        In the bundled head's order.
    """

    vertices: FloatArray
    faces: NDArray[np.int32]
    classes: NDArray[np.uint8]
    units: NDArray[np.float32]


def mouth_interior(
    bundled: Speaker, names: tuple[str, ...], points: FloatArray, jaw: float
) -> Interior:
    """The bundled head's facets of some classes, laid into another mouth.

    By the lips' points (20, 3), mm, of the other head, and how far `jawOpen` moves its chin, mm.
    """
    own = bundled.facets_of(*names)
    kept, faces = np.unique(bundled.faces[own], return_inverse=True)
    marks = bundled.landmarks
    at = np.concatenate([marks["outer_lip_20"], marks["inner_lip_8"]])
    from_, to = _frame(bundled.vertices[at].astype(np.float64)), _frame(points)
    scale = to[1] / from_[1]
    place = (bundled.vertices[kept] - from_[0]) * scale + to[0] - [0.0, 0.0, HEAD_IMPORT.sunk]
    units = bundled.units[:, kept].astype(np.float32) * scale
    chin = bundled.landmarks["chin"][0]
    opened = bundled.unit_matrix((Unit.JAW_OPEN,))[0, chin]
    farther = np.clip(jaw / (scale * float(np.linalg.norm(opened))), 0.0, HEAD_IMPORT.most_jaw)
    of_jaw = [k for k, name in enumerate(bundled.unit_names) if name in JAW]
    units[of_jaw] *= farther
    classes = np.array([CLASS_NAMES.index(n) for n in bundled.class_names], np.uint8)
    return Interior(
        place, faces.reshape(-1, 3).astype(np.int32), classes[bundled.facet_class[own]], units
    )


def _frame(points: FloatArray) -> tuple[FloatArray, float]:
    """The middle of the inner lips, and the width of the mouth."""
    inner = points[[12, 14, 16, 18]]
    return inner.mean(axis=0), float(np.linalg.norm(inner[2] - inner[0]))


def has(classes: NDArray[np.uint8], name: str) -> bool:
    """Whether a head has facets of a class."""
    return bool((classes == CLASS_NAMES.index(name)).any())


def is_hollow(
    vertices: FloatArray, faces: NDArray[np.integer], classes: NDArray[np.uint8], points: IntArray
) -> bool:
    """Whether the inside of a mouth reaches farther back than the rims of its lips do."""
    inside = np.unique(faces[classes == CLASS_NAMES.index("inner_mouth")])
    front = vertices[points[12:], 2].mean()
    return bool((vertices[inside, 2] < front - HEAD_IMPORT.hollow).any())
