"""A talking face's appearance, learned from pictures whose geometry is known."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from abs_engine.core.camera import Camera, Window
from abs_engine.core.errors import ParameterError
from abs_engine.core.scene import Renderer
from abs_engine.face.appearance.atlas import SIZES, fitting_size, lay_atlas
from abs_engine.face.appearance.information import choose_informative, information
from abs_engine.face.appearance.local import LocalModel, learn_local
from abs_engine.face.appearance.point_selection import N_POINTS
from abs_engine.face.appearance.texture import learn_texture
from abs_engine.face.appearance.visibility import Sighting
from abs_engine.face.articulated import FaceShape
from abs_engine.face.compared import ComparedHead
from abs_engine.face.learned_appearance import Appearance
from abs_engine.face.scene_arrays import facets_of_part
from abs_engine.face.talking import TalkingFace

SPACING = 4.0
"""mm between the points of local appearance, at least."""
FINEST = 1.0
"""Drawn pixels per mm of local appearance, at most: its filters are to reach 2 mm and more, or a
fit that starts far away does not come home."""
LARGEST = 512
"""Side of a speaker's texture, texels, at most: a millimetre and less of the face."""


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
    scale = min(1.0, FINEST * depth / float(camera.matrix[0, 0]))
    local = _local(shape.compared, seen, camera, renderer, scale, count).within(shape.kept)
    return TalkingFace(shape, tex, tex.constant(), local, local.constant(), scale)


def learn_appearance(
    head: ComparedHead,
    seen: Sequence[Sighting],
    camera: Camera,
    renderer: Renderer,
    *,
    count: int = N_POINTS,
) -> Appearance:
    """Learn texture and local appearance of what is compared of a head.

    Pictures finer than `FINEST` are made as coarse.

    Parameters
    ----------
    head : ComparedHead
    seen : sequence of Sighting
        Of ``head.scene``.
    camera : Camera
    renderer : Renderer
    count : int
        Points of local appearance.

    Raises
    ------
    NothingSeenError
        If the pictures do not show the face.
    ParameterError
        If there are no pictures, or no point is seen squarely in most of them.
    """
    if not seen:
        raise ParameterError("there are no pictures to learn from", "give some")
    depth = float(np.median([one.pose.apply(head.pivot[None])[0, 2] for one in seen]))
    per_mm = min(FINEST, float(camera.matrix[0, 0]) / depth)
    scale = per_mm * depth / float(camera.matrix[0, 0])
    coarse, whole = camera.scaled(scale), Window(0, 0, *camera.size, scale)
    some = [replace(one, image=whole.sample(one.image)) for one in seen]
    side = min(LARGEST, fitting_size(head.surface, coarse, some[0].pose)[0])
    atlas = lay_atlas(head.scene, (max(side, SIZES[0]),) * 2, renderer)
    atlas = atlas.on(facets_of_part(head.scene, head.surface))
    texture = learn_texture(some, head.scene, atlas, coarse, renderer)
    local = _local(head, some, coarse, renderer, 1.0, count)
    return Appearance(texture, local, per_mm)


def _local(
    head: ComparedHead,
    seen: Sequence[Sighting],
    camera: Camera,
    renderer: Renderer,
    scale: float,
    count: int,
) -> LocalModel:
    """Local appearance of the points that say most of pose and posture together."""
    every = learn_local(seen, head.scene, head.marks, camera, renderer, scale=scale)
    places = head.scene.mean[head.marks].astype(np.float64)
    told = information(every, seen, head.scene, camera, renderer, head.moved, scale)
    return every.only(choose_informative(every, told, head.about, count, places, SPACING))
