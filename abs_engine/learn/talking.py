"""A talking face's appearance, learned from pictures whose geometry is known."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from abs_engine.core.camera import Camera
from abs_engine.core.errors import ParameterError
from abs_engine.core.scene import Renderer
from abs_engine.face.appearance.atlas import fitting_size, lay_atlas
from abs_engine.face.appearance.information import choose_informative, information
from abs_engine.face.appearance.local import learn_local
from abs_engine.face.appearance.point_selection import N_POINTS
from abs_engine.face.appearance.texture import learn_texture
from abs_engine.face.appearance.visibility import Sighting
from abs_engine.face.articulated import FaceShape
from abs_engine.face.talking import TalkingFace
from abs_engine.learn.settings import LEARNING


def learn_face(
    shape: FaceShape,
    seen: Sequence[Sighting],
    camera: Camera,
    renderer: Renderer,
    *,
    count: int = N_POINTS,
) -> TalkingFace:
    """Learn the four appearance models from pictures of known geometry.

    Parameters
    ----------
    shape : FaceShape
    seen : sequence of Sighting
        Of ``face.shape.scene``; see `sightings`.
    camera : Camera
    renderer : Renderer
    count : int
        Points of local appearance; the paper's N is 63.

    Raises
    ------
    NothingSeenError
        If the pictures do not show the face.
    ParameterError
        If there are no pictures.
    """
    if not seen:
        raise ParameterError("there are no pictures to learn from", "give some")
    textured = shape.scene
    atlas = lay_atlas(textured, fitting_size(textured, camera, seen[0].pose), renderer)
    tex = learn_texture(seen, textured, atlas, camera, renderer)
    depth = float(seen[0].pose.apply(shape.pivot)[2])
    scale = min(1.0, LEARNING.finest * depth / float(camera.matrix[0, 0]))
    every = learn_local(seen, textured, shape.marks, camera, renderer, scale=scale)
    places = textured.mean[shape.marks].astype(np.float64)
    told = information(every, seen, textured, camera, renderer, shape.moved, scale)
    chosen = choose_informative(every, told, shape.about, count, places, LEARNING.spacing)
    local = every.only(chosen).within(shape.kept)
    return TalkingFace(shape, tex, tex.constant(), local, local.constant(), scale)
