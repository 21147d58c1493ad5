"""Shading of a person's skin, learned where it is to be compared and enough of it is seen."""

from __future__ import annotations

from collections.abc import Iterable

from abs_engine.core.arrays import FloatArray, Image
from abs_engine.core.camera import Camera
from abs_engine.core.geometry import Pose
from abs_engine.face.base import Face
from abs_engine.fit.shading import NAME as SHADED
from abs_engine.fit.shading import with_shading
from abs_engine.tracking.options import Leaves
from abs_engine.tracking.results.run_warnings import UNSEEN_SKIN


def with_shaded_skin(
    leaves: Leaves, face: Face, camera: Camera, posed: Iterable[tuple[Image, Pose, FloatArray]]
) -> tuple[Leaves, Face, tuple[str, ...]]:
    """The evidence, the face with the shading of its skin if that is compared, and warnings.

    Frames are `posed` as `with_shading` takes them. Where they show too little skin, shading is
    left out, with a warning.
    """
    if SHADED not in leaves.kinds:
        return leaves, face, ()
    lit = with_shading(face, camera, posed)
    return (leaves.without(SHADED), face, (UNSEEN_SKIN,)) if lit is None else (leaves, lit, ())
