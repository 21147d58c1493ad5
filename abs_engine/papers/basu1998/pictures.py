"""Figures 3 to 9: probability maps, the way from the first placement to the fit, and fits."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np

from abs_engine.core.arrays import FloatArray, Image
from abs_engine.core.blocks import POSTURE
from abs_engine.core.camera import Camera, Window
from abs_engine.core.geometry import Pose
from abs_engine.core.scene import Renderer
from abs_engine.face.appearance.chroma import sampled
from abs_engine.face.appearance.colour_features import CLASSES
from abs_engine.face.appearance.hamming import hamming
from abs_engine.fit.problem import Problem
from abs_engine.fit.settings import HEAD_FIT, SHELL_FIT
from abs_engine.fit.shell import shell_problem, shell_window
from abs_engine.optimise.ascent import Forces
from abs_engine.papers.basu1998.experiment import TrainedLips, lip_error
from abs_engine.papers.basu1998.figures import draw_postures
from abs_engine.papers.basu1998.single_frames import ITERATIONS, colours_of, fit_frame
from abs_engine.papers.basu1998.wireframe import CloseUp
from abs_engine.report.drawing.layout import beside, captioned, framed, sheet, stacked
from abs_engine.report.drawing.lines import draw_arrows

TILE = 250  # pixels across a tile
_TEXT = 15
_WIDER, _HIGHER = 1.15, 0.75  # than the fit's window; share of what is added above
_ARROW = 0.09  # of a tile's width: the longest one
_ARROWS = (255, 120, 40)
_HUES = {
    "skin": (226, 190, 168), "lips": (196, 70, 80), "teeth": (250, 250, 240), "dark": (50, 30, 40),
}  # fmt: skip
_UNLIKELY = (130, 130, 130)


def probability_figure(
    lips: TrainedLips, picture: Image, pose: Pose, camera: Camera, renderer: Renderer
) -> Image:
    """Figures 3 and 4: how probable each class is in each pixel around a mouth, raw and smoothed.

    Beyond the paper: teeth and the dark of the mouth, and the most probable class. The smoothed
    maps are those of which the forces are made. White is probable.
    """
    close = _close_up(lips, pose, camera, renderer)
    raw, smooth = _maps(lips, close, picture)
    pairs = {
        name: [_told(close.grey(raw[k]), f"{name}, PDF"),
               _told(close.grey(smooth[k]), f"{name}, smoothed PDF")]
        for k, name in enumerate(CLASSES)
    }  # fmt: skip
    classes = cv2.resize(_most_probable(raw), close.window.drawn, interpolation=cv2.INTER_NEAREST)
    image = _told(close.cut(picture), "image")
    most = _told(np.asarray(classes, np.uint8), "most probable class")
    tiles = [image, *pairs["lips"], *pairs["skin"], most, *pairs["teeth"], *pairs["dark"]]
    return sheet(tiles, 5)


def _close_up(lips: TrainedLips, pose: Pose, camera: Camera, renderer: Renderer) -> CloseUp:
    """The fit's window and a little more, or the shell's nodes on the nose would be cut off."""
    window = shell_window(lips.setting(camera, renderer), pose)
    width, height = _WIDER * np.array([window.width, window.height])
    x, y = window.x - (width - window.width) / 2, window.y - _HIGHER * (height - window.height)
    return CloseUp(camera, Window(x, y, width, height, TILE / width), window.scale)


def _maps(lips: TrainedLips, close: CloseUp, picture: Image) -> tuple[FloatArray, FloatArray]:
    """Probability maps (C, H, W) as the fit has them, and those of which it makes forces."""
    raw = lips.classes.probabilities(sampled(close.fitted, picture))
    return raw, hamming(raw, HEAD_FIT.pull * SHELL_FIT.drawn_mouth)


def _told(tile: Image, text: str) -> Image:
    return captioned(framed(tile), text, _TEXT)


def _most_probable(maps: FloatArray) -> Image:
    """Classes (C, H, W) as colours (H, W, 3); grey where none is likely."""
    hues = np.array([*(_HUES[name] for name in CLASSES), _UNLIKELY], np.uint8)
    return hues[np.where(maps.max(axis=0) > 0.5, maps.argmax(axis=0), len(CLASSES))]


def convergence_figure(
    lips: TrainedLips,
    picture: Image,
    pose: Pose,
    camera: Camera,
    renderer: Renderer,
    truth: FloatArray,
) -> Image:
    """Figure 5: from the first placement of the mean shape to the fit, by the forces.

    Parameters
    ----------
    pose : Pose
        Known, or placed by the blob; it is held.
    truth : (N, 3) float64, mm, head frame
        True nodes of the shell, by which the captions give the lips' error.

    Returns
    -------
    (H, W, 3) uint8 RGB
        The image; the placement; the smoothed lip map with the forces on the nodes; the shape
        after the first iteration; the converged fit; and, beyond the paper, what is found from
        the typical shapes instead of the mean.
    """
    setting = lips.setting(camera, renderer)
    problem = shell_problem(setting, picture, pose)
    close = _close_up(lips, pose, camera, renderer)
    image, start = close.cut(picture), np.zeros(len(problem.spec))
    one, last = (
        Forces(limit=limit).minimise(problem, start, problem.spec) for limit in (1, ITERATIONS)
    )
    how = "converged" if last.status == "converged" else "stopped"
    shown = [
        ("initial placement", start),
        ("after iteration 1", one.x),
        (f"{how} after {last.n_iterations}", last.x),
    ]

    def wired(nodes: FloatArray, name: str) -> Image:
        tile = close.wired(image, renderer, lips.model.shell, nodes, pose)
        return _told(tile, f"{name}: {lip_error(nodes, truth):.2f} mm")

    first, *further = [wired(_nodes(lips, problem, x), name) for name, x in shown]
    dark = close.grey(_maps(lips, close, picture)[1][CLASSES.index("lips")])
    pulled = _told(_forced(dark, close, lips, problem, start), "smoothed lip PDF, forces")
    fit = fit_frame(setting, picture, pose, lips.starts)
    ours = wired(fit.nodes, "from typical shapes")
    return sheet([_told(image, "image"), first, pulled, *further, ours], 3)


def _nodes(lips: TrainedLips, problem: Problem, x: FloatArray) -> FloatArray:
    vertices = colours_of(problem).scene.vertices(problem.part(x, POSTURE))
    return vertices[: len(lips.model.shell)]


def _forced(
    tile: Image, close: CloseUp, lips: TrainedLips, problem: Problem, x: FloatArray
) -> Image:
    """A tile with the forces on the shell's nodes at `x`, the strongest as long as is good."""
    drawn = problem.candidates(x[None])
    forces = colours_of(problem).forces(drawn)
    forces = forces[: len(lips.model.shell)]
    points = _nodes(lips, problem, x) @ drawn.rotations[0].T + drawn.translations[0]
    begin = close.pixels(points)
    strongest = max(float(np.linalg.norm(forces, axis=1).max()), 1e-12)
    step = close.pixels(points + forces / strongest) - begin
    longest = max(float(np.linalg.norm(step, axis=1).max()), 1e-12)
    out = tile.copy()
    draw_arrows(out, begin, begin + step * (_ARROW * TILE / longest), _ARROWS)
    return out


@dataclass(frozen=True, eq=False)
class ShownFit:
    """A fit to be drawn.

    Parameters
    ----------
    pose : Pose
        Head to camera.
    nodes : (N, 3) float64, mm, head frame
        Of the shell, as fitted.
    """

    name: str
    picture: Image
    camera: Camera
    pose: Pose
    nodes: FloatArray


def fits_figure(renderer: Renderer, lips: TrainedLips, fits: Sequence[ShownFit]) -> Image:
    """Figures 6 to 9, a row for each fit: image, fit, and the shape from the front and the side."""
    return stacked([_row(renderer, lips, fit) for fit in fits])


def _row(renderer: Renderer, lips: TrainedLips, fit: ShownFit) -> Image:
    shell = lips.model.shell
    close = _close_up(lips, fit.pose, fit.camera, renderer)
    image = close.cut(fit.picture)
    tiles = [
        _told(image, fit.name),
        _told(close.wired(image, renderer, shell, fit.nodes, fit.pose), "fit"),
    ]
    shape = {"shape from the front and the side": fit.nodes}
    return beside([sheet(tiles, 2), draw_postures(renderer, shell, shape, columns=1)])
