"""Figures 1 and 2: dots, mean displacement and first modes of the shell, from front and side."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from abs_engine.core.camera import Camera
from abs_engine.core.geometry import FACING, Pose, vertex_normals
from abs_engine.core.scene import Candidates, Renderer, Scene
from abs_engine.face.shape.lip_shell import LipShell
from abs_engine.face.shape.modal import LearnedPhysics
from abs_engine.learn.correspondence import Correspondence
from abs_engine.report.inspect.layout import Image, beside, captioned, label, stacked
from abs_engine.report.inspect.smooth import smooth_picture

FloatArray = NDArray[np.float64]

SIZE = (240, 170)
TURNS = {"front": 0.0, "profile": -90.0}
"""Degrees by which the head turns to its left; at -90 its left side is seen."""
_DISTANCE, _FILLED = 1000.0, 0.9
_INK = (28, 32, 74)
_LIP, _SKIN = (196, 96, 92), (226, 190, 168)
_LAMP = np.array([-0.3, -0.45, -0.84])
_AMBIENT = 0.35


@dataclass(frozen=True, eq=False)
class Posture:
    """A shape with its caption.

    Parameters
    ----------
    name : str
    nodes : (N, 3) float64, mm
    """

    name: str
    nodes: FloatArray


def mode_postures(
    physics: LearnedPhysics, modes: int = 4, deviations: float = 2.0
) -> list[Posture]:
    """The shell at rest, displaced by the mean, and displaced by each mode from the mean."""
    out = [
        Posture("at rest", physics.rest),
        Posture("mean displacement", physics.rest + physics.mean),
    ]
    for k in range(min(modes, len(physics.modes))):
        for sign, mark in ((-1, "\N{MINUS SIGN}"), (1, "+")):
            weights = np.zeros(len(physics.modes))
            weights[k] = sign * deviations * np.sqrt(physics.variances[k])
            name = f"mode {k + 1}, {mark}{deviations:g} sd"
            out.append(Posture(name, physics.shape(weights)))
    return out


def draw_postures(
    renderer: Renderer, shell: LipShell, postures: Sequence[Posture], columns: int = 4
) -> Image:
    """Shapes of a shell at one scale, each from the front and from the side.

    Parameters
    ----------
    renderer : Renderer
    shell : LipShell
    postures : sequence of Posture
    columns : int
        Of the page.

    Returns
    -------
    (H, W, 3) uint8 RGB
    """
    centre, camera = _camera([p.nodes for p in postures])
    tiles = []
    for posture in postures:
        pair = [
            _draw(renderer, shell, posture.nodes, _turned(turn, centre), camera)
            for turn in TURNS.values()
        ]
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
    centre, camera = _camera([laid.rest])
    tiles = []
    for turn in TURNS.values():
        pose = _turned(turn, centre)
        tile = _draw(renderer, shell, laid.rest, pose, camera)
        for x, y in camera.project(pose.apply(laid.home)):
            cv2.circle(tile, (round(float(x)), round(float(y))), 3, _INK, -1, cv2.LINE_AA)
        tiles.append(tile)
    return captioned(beside(tiles), "dots on the lips, from the front and the side", 15)


def _turned(degrees: float, centre: FloatArray) -> Pose:
    turn = Pose.from_vectors([0.0, np.radians(degrees), 0.0], np.zeros(3)).rotation
    rotation = FACING @ turn
    return Pose(rotation, np.array([0.0, 0.0, _DISTANCE]) - rotation @ centre)


def _camera(shapes: Sequence[FloatArray]) -> tuple[FloatArray, Camera]:
    """The middle of all shapes, and a camera in whose picture they all are, from all sides."""
    points = np.concatenate(shapes)
    centre = 0.5 * (points.min(axis=0) + points.max(axis=0))
    seen = np.concatenate([_turned(turn, centre).apply(points) for turn in TURNS.values()])
    widest, highest = np.abs(seen[:, :2] / seen[:, 2:]).max(axis=0)
    focal = 0.5 * _FILLED * min(SIZE[0] / widest, SIZE[1] / highest)
    return centre, Camera.ideal(SIZE, float(focal))


def _draw(
    renderer: Renderer, shell: LipShell, nodes: FloatArray, pose: Pose, camera: Camera
) -> Image:
    """One picture: lips and skin lit, before white."""
    one = Candidates.one(np.zeros(0), pose)
    shade = _AMBIENT + (1 - _AMBIENT) * np.abs(
        vertex_normals(nodes, shell.faces) @ pose.rotation.T @ (_LAMP / np.linalg.norm(_LAMP))
    )
    ramp = np.linspace(0, 1, 256)[:, None]
    lit = np.stack([ramp * _SKIN, ramp * _LIP]).astype(np.uint8)
    colour, cover = (
        smooth_picture(renderer, _scene(shell, nodes, shade, coat), one, camera, camera.whole)
        for coat in (lit, np.full((1, 1, 3), 255, np.uint8))
    )
    return np.asarray(np.clip(np.rint(colour + (255 - cover)), 0, 255), np.uint8)


def _scene(
    shell: LipShell, nodes: FloatArray, shade: FloatArray, texture: NDArray[np.uint8]
) -> Scene:
    """The shell with its corners apart, so that lips and skin have colours of their own."""
    corners = shell.faces.ravel()
    row = np.repeat(np.where(shell.lip, 0.75, 0.25), 3)
    uv = np.stack([(0.5 + 255 * shade[corners]) / 256, row], axis=1)
    apart = np.arange(len(corners), dtype=np.int32).reshape(-1, 3)
    return Scene(
        nodes[corners].astype(np.float32), np.zeros((0, len(corners), 3), np.float32), apart,
        uv.astype(np.float32), np.ones(len(apart), np.int32), texture, cull=False,
    )  # fmt: skip
