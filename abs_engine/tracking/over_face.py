"""Textures and local appearance compared over the face, in place of the mouth alone."""

from __future__ import annotations

from dataclasses import replace

from abs_engine.core.blocks import POSTURE
from abs_engine.core.scene import Scene
from abs_engine.face.base import Face
from abs_engine.fit.evidence import Term
from abs_engine.fit.talking import surface_window
from abs_engine.fit.terms import LOCAL, TEXTURE, Bind, pixels_per_mm
from abs_engine.fit.view import View


def over_face(surface: Scene, per_mm: float = 0.0) -> dict[str, Bind]:
    """Ways in which evidence is bound to the window of a face: see `face.base.Face.own_terms`.

    The surface is skin and lips; its weights are the posture. A texture is drawn `per_mm` pixels
    per mm at most; at 0, as finely as the picture is.
    """

    def wide(face: Face, view: View) -> View:
        weights = face.blocks.part(view.start, POSTURE)
        scale = min(1.0, per_mm / pixels_per_mm(face.pivot, view)) if per_mm else 1.0
        window = surface_window(surface, weights, view.frame.base, view.camera, scale)
        return replace(view, window=window)

    def texture(face: Face, view: View) -> Term:
        return TEXTURE.bind(face, wide(face, view))

    def local(face: Face, view: View) -> Term:
        return LOCAL.bind(face, wide(face, view))

    return {TEXTURE.name: texture, LOCAL.name: local}
