"""Surfaces in a coat of colour, lit: textures, one colour for each facet, or numbers."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.arrays import FloatArray, Image
from abs_engine.core.buffers import Buffers
from abs_engine.core.scene import Candidates, Renderer, Scene
from abs_engine.report.drawing.smooth import smooth_picture
from abs_engine.report.drawing.view import View

WHITE = (255, 255, 255)
AMBIENT = 0.5
"""Light that every facet gets; the rest comes from the lamp."""
LAMP = np.array([-0.35, -0.45, -0.82])
"""Where the lamp is, camera frame: above the camera and to its left."""


class Surface(Protocol):
    """A triangle mesh to be drawn."""

    @property
    def vertices(self) -> FloatArray:
        """Vertices (V, 3), mm."""
        ...

    @property
    def faces(self) -> NDArray[np.integer]:
        """Vertices of each facet, (F, 3)."""
        ...

    @property
    def normals(self) -> FloatArray:
        """Unit vertex normals (V, 3)."""
        ...

    @property
    def two_sided(self) -> bool:
        """Whether it is open, so that its back is drawn and lit, too."""
        ...


@dataclass(frozen=True, eq=False)
class Coat:
    """Colour of a surface, as a texture and its coordinates.

    Parameters
    ----------
    uv : (V, 2) or (3 F, 2) float32
        For each vertex, or for each corner of each facet where facets have colours of their own.
    texture : (H, W, 3) uint8 RGB
    """

    uv: NDArray[np.float32]
    texture: Image


def facet_coat(colours: Image, facet_colour: NDArray[np.integer]) -> Coat:
    """Each facet in one of the colours (K, 3), given by its index (F,)."""
    u = (np.repeat(facet_colour, 3) + 0.5) / len(colours)
    return Coat(np.stack([u, np.full_like(u, 0.5)], axis=1).astype(np.float32), colours[None])


def value_coat(values: FloatArray, limits: tuple[float, float], colours: Image) -> Coat:
    """Numbers (V,) painted by a scale of colours (K, 3) that runs between two limits."""
    share = np.clip((values - limits[0]) / (limits[1] - limits[0]), 0.0, 1.0)
    u = (0.5 + share * (len(colours) - 1)) / len(colours)
    return Coat(np.stack([u, np.full_like(u, 0.5)], axis=1).astype(np.float32), colours[None])


def paint(
    renderer: Renderer,
    surface: Surface,
    look: Coat,
    view: View,
    *,
    ambient: float = AMBIENT,
    background: tuple[int, int, int] = WHITE,
) -> Image:
    """A surface before a plain background, smooth and lit, (H, W, 3) uint8 RGB.

    Parameters
    ----------
    ambient : float
        Share of the light that comes from everywhere, 0 to 1; at 1 nothing is shaded.
    """
    colour, cover = paint_layers(renderer, surface, look, view, ambient)
    picture = colour + (1 - cover) * np.array(background, np.float32)
    return np.asarray(np.clip(np.rint(picture), 0, 255), np.uint8)


def paint_layers(
    renderer: Renderer, surface: Surface, look: Coat, view: View, ambient: float = AMBIENT
) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """The lit colour (H, W, 3), times its coverage, and the coverage (H, W, 1), 0 to 1."""
    one = Candidates.one(np.zeros(0), view.pose)
    albedo, light = (
        smooth_picture(renderer, _scene(surface, coat), one, view.camera, view.window)
        for coat in (look, _light(surface, view, ambient))
    )
    cover = light[..., 1:2] / 255
    shade = light[..., :1] / np.maximum(light[..., 1:2], 1)
    return np.asarray(albedo * shade, np.float32), np.asarray(cover, np.float32)


def _light(surface: Surface, view: View, ambient: float) -> Coat:
    """Lambert's shading at each vertex in red, and full green, whose picture is the coverage."""
    towards = LAMP / np.linalg.norm(LAMP)
    facing = surface.normals @ view.pose.rotation.T @ towards
    facing = np.abs(facing) if surface.two_sided else np.maximum(facing, 0.0)
    ramp = np.zeros((256, 3), np.uint8)
    ramp[:, 0], ramp[:, 1] = np.arange(256), 255
    return value_coat(ambient + (1 - ambient) * facing, (0.0, 1.0), ramp)


def _scene(surface: Surface, look: Coat) -> Scene:
    """The surface in its coat, without modes."""
    vertices, faces = surface.vertices, surface.faces
    if len(look.uv) != len(vertices):
        vertices = vertices[faces.ravel()]
        faces = np.arange(faces.size).reshape(-1, 3)
    return Scene(
        vertices.astype(np.float32), np.zeros((0, *vertices.shape), np.float32),
        faces.astype(np.int32), look.uv, np.ones(len(faces), np.int32), look.texture,
        cull=not surface.two_sided,
    )  # fmt: skip


def drawn(renderer: Renderer, surface: Surface, view: View) -> Buffers:
    """Buffers of a surface, whose colour is of no account: one sample in each pixel's middle."""
    none = np.full((len(surface.vertices), 2), 0.5, np.float32)
    scene = _scene(surface, Coat(none, np.zeros((1, 1, 3), np.uint8)))
    one = Candidates.one(np.zeros(0), view.pose)
    return renderer.draw(scene, one, view.camera, view.window)[0]
