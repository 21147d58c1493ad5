"""A talking face's appearance, learned from pictures whose geometry is known."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.camera import Camera, Window
from abs_engine.core.errors import ParameterError
from abs_engine.core.scene import Renderer
from abs_engine.face.appearance.atlas import fitting_size, lay_atlas
from abs_engine.face.appearance.information import choose_informative, information
from abs_engine.face.appearance.local import LocalModel
from abs_engine.face.appearance.local_learning import FEWEST, learn_local_frames, own_share
from abs_engine.face.appearance.point_selection import N_POINTS
from abs_engine.face.appearance.texture import learn_shared_texture
from abs_engine.face.appearance.visibility import Sighting
from abs_engine.face.articulated import FaceShape
from abs_engine.face.compared import ComparedHead
from abs_engine.face.learned_appearance import Appearance
from abs_engine.face.scene_arrays import facets_of_part
from abs_engine.face.talking import Noises, TalkingFace
from abs_engine.learn.settings import LEARNING


def learn_face(
    shape: FaceShape,
    seen: Sequence[Sighting],
    camera: Camera,
    renderer: Renderer,
    *,
    count: int = N_POINTS,
) -> TalkingFace:
    """Learn the four appearance models from pictures of known geometry, of the shape's scene.

    Local appearance is of so many points; the paper's N is 63. Raises `NothingSeenError` if the
    pictures do not show the face, `ParameterError` if there are none.
    """
    if not seen:
        raise ParameterError("there are no pictures to learn from", "give some")
    textured = shape.scene
    atlas = lay_atlas(textured, fitting_size(textured, camera, seen[0].pose), renderer)
    tex, noise, worth = learn_shared_texture(seen, textured, atlas, camera, renderer)
    depth = float(seen[0].pose.apply(shape.pivot)[2])
    scale = min(1.0, LEARNING.finest * depth / float(camera.matrix[0, 0]))
    local, share = _local(shape, seen, camera, renderer, scale, count)
    local = local.within(shape.kept)
    few = len(seen) < FEWEST or not noise  # nothing is known of it
    noises = None if few else Noises(noise, worth, share)
    return TalkingFace(shape, tex, tex.constant(), local, local.constant(), scale, noises)


def learn_appearance(
    head: ComparedHead,
    seen: Sequence[Sighting],
    recordings: NDArray[np.int64],
    camera: Camera,
    renderer: Renderer,
) -> Appearance:
    """Learn texture and local appearance of what is compared of a head from several recordings.

    How far they depend on the posture, and how far off they are, is measured on recordings that are
    left out: the next frame of the same recording would be foretold too well. Pictures finer than
    the settings allow are made as coarse. `recordings` (T,) says which of the pictures, of the
    head's scene, were recorded together; two recordings at least.

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
    pixel = float(camera.matrix[0, 0]) / depth
    per_mm, texels = min(LEARNING.finest, pixel), min(LEARNING.coarse, pixel)
    some, own = _sampled(seen, camera, texels / pixel)
    atlas = lay_atlas(head.scene, fitting_size(head.surface, own, some[0].pose), renderer)
    atlas = atlas.on(facets_of_part(head.scene, head.surface))
    shared = learn_shared_texture(some, head.scene, atlas, own, renderer, recordings)
    some, own = _sampled(seen, camera, per_mm / pixel)
    local, share = _local(head, some, own, renderer, 1.0, N_POINTS, recordings)
    texture, noise, worth = shared
    return Appearance(texture, local, per_mm, texels, noise, worth, share)


def _sampled(
    seen: Sequence[Sighting], camera: Camera, scale: float
) -> tuple[list[Sighting], Camera]:
    """Frames and their camera with so many pixels for one."""
    whole = Window(0, 0, *camera.size, scale)
    some = [replace(one, image=whole.sample(one.image)) for one in seen]
    return some, camera.scaled(scale)


def _local(
    head: ComparedHead,
    seen: Sequence[Sighting],
    camera: Camera,
    renderer: Renderer,
    scale: float,
    count: int,
    recordings: NDArray[np.int64] | None = None,
) -> tuple[LocalModel, float]:
    """Local appearance of the points that say most of pose and posture together.

    And the share of their noise that is taken for their own.
    """
    given = seen, head.scene, head.marks, camera, renderer
    every, frames, ridge = learn_local_frames(*given, scale=scale, recordings=recordings)
    places = head.scene.mean[head.marks].astype(np.float64)
    told = information(every, seen, head.scene, camera, renderer, head.moved, scale)
    chosen = choose_informative(every, told, head.about, count, places, LEARNING.spacing)
    some = np.zeros(len(every), np.bool_)
    some[chosen] = True
    return every.only(chosen), own_share(frames.of(some), ridge)
