"""A person's face with the shading of its skin, learned from a clip's first look at it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from abs_engine.core.camera import Camera
from abs_engine.core.pose import no_correction
from abs_engine.core.scene import Renderer
from abs_engine.face.base import Face
from abs_engine.fit.shading import with_shading
from abs_engine.tracking.landmark_calibration import placed_frames
from abs_engine.tracking.person_fit import FittedPerson, Sighted
from abs_engine.tracking.placed_mouths import PlacedMouths


def shaded_person(
    fitted: FittedPerson, chosen: Sequence[Sighted], camera: Camera, renderer: Renderer
) -> Face:
    """A fitted person's face with the shading of its skin in the frames that show the mouth.

    Raises
    ------
    ParameterError
        If they show too little of it.
    """
    shown = [one for one in chosen if fitted.shows(*one)]
    placed = placed_frames(fitted.textured, fitted.shape, shown, fitted.light)
    if not placed:
        return with_shading(fitted.face, camera, ())
    mouths = PlacedMouths(fitted.model, placed, camera, renderer, no_correction(), fitted.person)
    starts = np.stack([frame.start(fitted.model.n_expression) for frame in placed])
    vectors = mouths.postures(mouths.terms(fitted.classes, starts), starts)
    each = zip(placed, vectors, strict=True)
    return with_shading(fitted.face, camera, ((f.image, f.pose, vector) for f, vector in each))
