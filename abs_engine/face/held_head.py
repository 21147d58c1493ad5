"""A head with its person held, as a face."""

from __future__ import annotations

import numpy as np

from abs_engine.core.arrays import FloatArray
from abs_engine.face.appearance.colour import ColourClasses
from abs_engine.face.base import RINGS, Body, Face
from abs_engine.face.head import MouthModel


def held_head(model: MouthModel, person: FloatArray, classes: ColourClasses | None = None) -> Face:
    """The face of a head model whose person (Q,) is known or was fitted, with a clip's colours."""
    speaker = model.speaker
    lips = np.concatenate([model.kept[model.rings[name]] for name in RINGS]).astype(np.int32)
    body = Body(
        model.whole(person), model.expression.modes.astype(np.float32), speaker.faces,
        model.head.facet_class, model.colour_classes, lips, model.at_rest(person),
    )  # fmt: skip
    return Face(
        "head", model.held(person), model.posture, model.pivot, model.rings,
        model.border(person), model.prototypes, model.colour_classes, body, person,
        {} if classes is None else {"colour": classes},
    )  # fmt: skip
