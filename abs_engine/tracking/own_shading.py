"""A person's face with the shading of its skin, learned from a clip's first look at it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from abs_engine.core.camera import Camera
from abs_engine.core.pose import no_correction
from abs_engine.core.scene import Renderer
from abs_engine.core.threads import in_threads, workers
from abs_engine.face.base import Face
from abs_engine.fit.shading import with_shading
from abs_engine.tracking.frame_state import SeenFace
from abs_engine.tracking.head_pose import placed_fit
from abs_engine.tracking.person_fit import FittedPerson, Sighted
from abs_engine.tracking.placed_mouths import PlacedFrame, PlacedMouths


def shaded_person(
    fitted: FittedPerson, chosen: Sequence[Sighted], camera: Camera, renderer: Renderer
) -> Face:
    """A fitted person's face with the shading of its skin in the frames that show the mouth.

    Raises
    ------
    ParameterError
        If they show too little of it.
    """
    stand = _mouths(fitted, [one for one in chosen if fitted.shows(*one)], camera, renderer)
    if not stand.placed:
        return with_shading(fitted.face, camera, ())
    vectors = np.stack([frame.start(fitted.model.n_expression) for frame in stand.placed])
    vectors = stand.postures(stand.terms(fitted.classes, vectors), vectors)
    each = zip(stand.placed, vectors, strict=True)
    return with_shading(fitted.face, camera, ((f.image, f.pose, vector) for f, vector in each))


def _mouths(
    fitted: FittedPerson, chosen: Sequence[Sighted], camera: Camera, renderer: Renderer
) -> PlacedMouths:
    """The frames with the head where landmarks and its texture place it."""

    def placed(one: Sighted) -> PlacedFrame | None:
        image, marks = one
        fit = placed_fit(fitted.textured, fitted.shape, image, marks)
        if fit is None:
            return None
        return PlacedFrame(fitted.light.balanced(image, marks), SeenFace(marks, fit))

    found = in_threads(placed, chosen, workers(renderer))
    frames = [frame for frame in found if frame is not None]
    return PlacedMouths(fitted.model, frames, camera, renderer, no_correction(), fitted.person)
