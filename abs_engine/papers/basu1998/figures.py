"""Figures 1 and 2: dots, mean displacement and first modes of the shell, from front and side."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from abs_engine.core.arrays import FloatArray, Image
from abs_engine.core.scene import Renderer
from abs_engine.face.shape.lip_shell import LipShell
from abs_engine.face.shape.modal import LearnedPhysics
from abs_engine.learn.correspondence import Correspondence
from abs_engine.papers.basu1998.wireframe import ShellSurface
from abs_engine.report.drawing.layout import beside, captioned, label, stacked
from abs_engine.report.drawing.lines import draw_circles
from abs_engine.report.drawing.paint import facet_coat, paint
from abs_engine.report.drawing.view import View, views_of

SIZE = (240, 170)
TURNS = (0.0, -90.0)
"""Degrees by which the head turns to its left; at -90 its left side is seen."""
_INK = (28, 32, 74)
_COLOURS = np.array([(226, 190, 168), (196, 96, 92)], np.uint8)  # skin, lips
_AMBIENT = 0.35


def mode_postures(physics: LearnedPhysics, modes: int) -> dict[str, FloatArray]:
    """Nodes (N, 3), mm, by captions: at rest, displaced by the mean, and by each mode from it."""
    out = {"at rest": physics.rest, "mean displacement": physics.rest + physics.mean}
    for k in range(min(modes, len(physics.modes))):
        for sign, mark in ((-1, "\N{MINUS SIGN}"), (1, "+")):
            weights = np.zeros(len(physics.modes))
            weights[k] = sign * 2.0 * np.sqrt(physics.variances[k])
            out[f"mode {k + 1}, {mark}2 sd"] = physics.shape(weights)
    return out


def draw_postures(
    renderer: Renderer, shell: LipShell, postures: Mapping[str, FloatArray], columns: int = 4
) -> Image:
    """Shapes of a shell, (N, 3) mm by captions, at one scale, each from the front and the side."""
    views = views_of(np.concatenate(list(postures.values())), SIZE, TURNS)
    tiles = []
    for name, nodes in postures.items():
        pair = [_draw(renderer, shell, nodes, view) for view in views]
        tiles.append(captioned(beside(pair), name, 15))
    blank = label("", (tiles[0].shape[1], tiles[0].shape[0]))
    tiles += [blank] * (-len(tiles) % columns)
    return stacked([beside(tiles[k : k + columns]) for k in range(0, len(tiles), columns)])


def draw_modes(
    renderer: Renderer, shell: LipShell, physics: LearnedPhysics, modes: int = 5
) -> Image:
    """Figure 2, two postures of each mode, (H, W, 3) uint8 RGB."""
    return draw_postures(renderer, shell, mode_postures(physics, modes))


def draw_dots(renderer: Renderer, shell: LipShell, laid: Correspondence) -> Image:
    """Figure 1: the dots on the shell at rest, from the front and the side, (H, W, 3) uint8 RGB."""
    tiles = []
    for view in views_of(laid.rest, SIZE, TURNS):
        tile = _draw(renderer, shell, laid.rest, view)
        draw_circles(tile, view.pixels(laid.home), 3, _INK)
        tiles.append(tile)
    return captioned(beside(tiles), "dots on the lips, from the front and the side", 15)


def _draw(renderer: Renderer, shell: LipShell, nodes: FloatArray, view: View) -> Image:
    """One picture: lips and skin lit, before white."""
    look = facet_coat(_COLOURS, shell.lip.astype(int))
    return paint(renderer, ShellSurface(shell, nodes), look, view, ambient=_AMBIENT)
