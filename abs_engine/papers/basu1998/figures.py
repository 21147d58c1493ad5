"""Figures 1 and 2: dots, mean displacement and first modes of the shell, from front and side."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

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


@dataclass(frozen=True, eq=False)
class Posture:
    """A shape with its caption.

    Parameters
    ----------
    nodes : (N, 3) float64, mm
    """

    name: str
    nodes: FloatArray


def mode_postures(physics: LearnedPhysics, modes: int) -> list[Posture]:
    """The shell at rest, displaced by the mean, and displaced by each mode from the mean."""
    out = [
        Posture("at rest", physics.rest),
        Posture("mean displacement", physics.rest + physics.mean),
    ]
    for k in range(min(modes, len(physics.modes))):
        for sign, mark in ((-1, "\N{MINUS SIGN}"), (1, "+")):
            weights = np.zeros(len(physics.modes))
            weights[k] = sign * 2.0 * np.sqrt(physics.variances[k])
            name = f"mode {k + 1}, {mark}2 sd"
            out.append(Posture(name, physics.shape(weights)))
    return out


def draw_postures(
    renderer: Renderer, shell: LipShell, postures: Sequence[Posture], columns: int = 4
) -> Image:
    """Shapes of a shell at one scale, each from the front and from the side.

    Parameters
    ----------
    columns : int
        Of the page.
    """
    views = views_of(np.concatenate([p.nodes for p in postures]), SIZE, TURNS)
    tiles = []
    for posture in postures:
        pair = [_draw(renderer, shell, posture.nodes, view) for view in views]
        tiles.append(captioned(beside(pair), posture.name, 15))
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
