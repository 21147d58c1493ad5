"""A person's neutral face: their own shape, lips that just meet, no expression."""

from __future__ import annotations

from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.arrays import FloatArray

_UPPER, _LOWER = [61, 62, 63], [67, 66, 65]  # the inner contours of the 68 landmarks, by pairs
_HEIGHT = 1


class Moving(Protocol):
    """A head that moves linearly: `face.base.Body`, `tracking.results.run_mesh.RunMesh`."""

    @property
    def mean(self) -> NDArray[np.float32]:
        """Posture 0, (V, 3) mm, head frame."""

    @property
    def modes(self) -> NDArray[np.float32]:
        """(P, V, 3) mm per unit of a posture's parameters."""

    @property
    def rest(self) -> NDArray[np.float32] | None:
        """The person without expression, (V, 3) mm, head frame; None where only `mean` is known."""


def neutral_face(head: Moving, marks: NDArray[np.integer[Any]]) -> FloatArray:
    """The face (V, 3), mm, head frame, that units and animations are measured from.

    It is the model's head without expression, after the most probable posture that makes its lips
    just meet: identity leaves them tenths of a millimetre apart or in each other. Where a model
    says nothing of a head without expression, it is closed from the mean, whose lips are those of
    average speech, 5 to 7 mm apart. `marks` (68,) are vertices of the landmarks.

    Notes
    -----
    Parameters of a posture have unit variance: the shortest change is the most probable.
    """
    rest = np.asarray(head.mean if head.rest is None else head.rest, np.float64)
    upper, lower = marks[_UPPER], marks[_LOWER]
    opened = (head.modes[:, upper, _HEIGHT] - head.modes[:, lower, _HEIGHT]).astype(np.float64)
    gaps = rest[upper, _HEIGHT] - rest[lower, _HEIGHT]
    closing = np.linalg.lstsq(opened.T, -gaps)[0]
    return rest + np.tensordot(closing, head.modes, 1)
