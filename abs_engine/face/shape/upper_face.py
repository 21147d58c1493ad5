"""Motion above the mouth, so that raised brows are not taken for a raised head."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from abs_engine.face.settings.shape import SHAPE
from abs_engine.io.assets import Speaker

_UNITS = (
    *("browDownLeft", "browDownRight", "browInnerUp", "browOuterUpLeft", "browOuterUpRight"),
    *("eyeBlinkLeft", "eyeBlinkRight", "eyeSquintLeft", "eyeSquintRight"),
    *("eyeWideLeft", "eyeWideRight", "cheekSquintLeft", "cheekSquintRight"),
    *("noseSneerLeft", "noseSneerRight", "cheekPuff"),
)


def upper_face_modes(speaker: Speaker) -> NDArray[np.float32]:
    """Displacements (U, V, 3), mm per standard deviation, of the units above the mouth."""
    names = tuple(name for name in _UNITS if name in speaker.unit_names)
    return np.asarray(SHAPE.usual_weight * speaker.unit_matrix(names), np.float32)
