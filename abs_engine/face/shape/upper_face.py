"""Motion above the mouth, so that raised brows are not taken for a raised head."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from abs_engine.face.schema import BROWS, Pair, Unit, units_of
from abs_engine.face.settings.shape import SHAPE
from abs_engine.io.assets import Speaker

_UNITS = (
    *BROWS,
    *units_of(Pair.EYE_BLINK, Pair.EYE_SQUINT, Pair.EYE_WIDE),
    *units_of(Pair.CHEEK_SQUINT, Pair.NOSE_SNEER, Unit.CHEEK_PUFF),
)


def upper_face_modes(speaker: Speaker) -> NDArray[np.float32]:
    """Displacements (U, V, 3), mm per standard deviation, of the units above the mouth."""
    names = tuple(name for name in _UNITS if name in speaker.unit_names)
    return np.asarray(SHAPE.usual_weight * speaker.unit_matrix(names), np.float32)
