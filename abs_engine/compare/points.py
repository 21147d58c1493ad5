"""Epsilon(p) of local appearance (`la`; Odisio & Bailly, section 4): see `descriptor`."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from abs_engine.appearance.descriptors import DescriptorMaps
from abs_engine.appearance.local import N_D, LocalModel
from abs_engine.appearance.patches import Patches
from abs_engine.appearance.sight import in_sight
from abs_engine.appearance.windows import Windows
from abs_engine.camera import Camera, Window
from abs_engine.compare.descriptor import (
    Epsilon,
    ToCandidates,
    penalty_roots,
    with_penalty,
    wrong_match,
)
from abs_engine.compare.penalty import Penalty
from abs_engine.scene import Renderer, Scene

FloatArray = NDArray[np.float64]
DEPTH_SCALE = 0.5
"""Scale of the drawing that decides what is hidden, to that of the window."""


@dataclass(frozen=True, eq=False)
class LocalError(Epsilon):
    """Epsilon of N points' local appearance, as an objective (`la`). Made by `local_error`.

    N is the model's number of points and N_d is 8. A point that is hidden or turned away costs
    `wrong` in place of its difference.

    Parameters
    ----------
    model : LocalModel
    windows : Windows
        Of the model's points.
    maps : DescriptorMaps
        Of the window of the frame.
    inverse : (N, 8) float64
        What differences are multiplied by: 1 as printed.
    renderer : Renderer
    scene : Scene
    camera : Camera
    window : Window
    candidates : callable
        Parameter vectors (B, n) to candidates.
    wrong : (N,) float64
        What a wrong match costs of each point, times the share of the training frames that show
        it: one that is often hidden is no offence.
    penalty : Penalty, optional
        A(a), over the first weights of a candidate; times `PENALTY_SHARE`, times `wrong`'s mean.
    """

    model: LocalModel
    windows: Windows
    maps: DescriptorMaps
    inverse: FloatArray
    renderer: Renderer
    scene: Scene
    camera: Camera
    window: Window
    candidates: ToCandidates
    wrong: FloatArray
    penalty: Penalty | None = None

    def residuals(self, x: FloatArray) -> FloatArray:
        """What is squared and summed to epsilon at one parameter vector, (8 N + P,)."""
        found, shown, weights = self._found(x[None])
        differ = (found[0] - self.model.at(weights[0])) * self.inverse
        hidden = np.broadcast_to(np.sqrt(self.wrong)[:, None], differ.shape)
        data = np.where(shown[0][:, None], differ, hidden) / np.sqrt(differ.size)
        roots = penalty_roots(weights, self.penalty, float(self.wrong.mean()))[0]
        return np.asarray(np.append(data, roots), np.float64)

    def seen(self, x: FloatArray) -> NDArray[np.bool_]:
        """Which points (N,) a parameter vector (n,) shows."""
        shown: NDArray[np.bool_] = self._found(x[None])[1][0]
        return shown

    def _parts(self, vectors: FloatArray) -> tuple[FloatArray, FloatArray]:
        found, shown, weights = self._found(vectors)
        differ = (found - self.model.at(weights)) * self.inverse
        costs = np.where(shown, (differ**2).sum(axis=2) / N_D, self.wrong)
        wrong = float(self.wrong.mean())
        return with_penalty(costs.mean(axis=1), weights, self.penalty, wrong)

    def _found(self, vectors: FloatArray) -> tuple[FloatArray, NDArray[np.bool_], FloatArray]:
        """The frame's descriptors (B, N, 8), visibility (B, N) and weights (B, P)."""
        many = self.candidates(vectors)
        w = self.window
        coarse = Window(w.x, w.y, w.width, w.height, w.scale * DEPTH_SCALE)
        drawn = self.renderer.draw(self.scene, many, self.camera, coarse)
        found = np.empty((len(many), len(self.model), N_D))
        shown = np.empty(found.shape[:2], np.bool_)
        for i, buffers in enumerate(drawn):
            moved = self.windows.patches.placed(many, i)
            points, normals = self.windows.patches.surface(moved)
            found[i] = self.windows.read(self.maps, w.to_drawn(self.camera.project(moved)))
            shown[i] = in_sight(points, normals, buffers.depth, self.camera, coarse) > 0
        return found, shown, many.weights


def local_error(
    model: LocalModel,
    scene: Scene,
    frame: NDArray[np.generic],
    camera: Camera,
    window: Window,
    candidates: ToCandidates,
    renderer: Renderer,
    penalty: Penalty | None = None,
    whiten: bool = False,
) -> LocalError:
    """The local appearance error of a frame.

    Parameters
    ----------
    model : LocalModel
    scene : Scene
        The shape that hides and is hidden; the model's points are its vertices.
    frame : (H, W, 3), RGB 0 to 255
        The whole picture.
    camera : Camera
    window : Window
        Where points are looked for; of the scale that the model was learned at.
    candidates : callable
        Parameter vectors (B, n) to candidates.
    renderer : Renderer
    penalty : Penalty, optional
    whiten : bool
        Divide differences by the spread that the model leaves unexplained, so that all components
        have a like weight; the paper compares them raw.

    Raises
    ------
    PictureError
        If a pixel of the frame is not finite.
    ParameterError
        If the model's points are no vertices of the scene.
    """
    windows = Windows(Patches.around(scene, model.vertices), model.sigma, model.unit)
    maps = DescriptorMaps.of(window.sample(np.asarray(frame, np.float32)), windows.scales)
    inverse = model.inverse if whiten else np.ones_like(model.spread)
    cost = np.empty(len(model))
    for n, (scale, factor) in enumerate(zip(windows.at_rest, inverse, strict=True)):
        others = maps.maps[scale, ::4, ::4].reshape(-1, N_D) * factor
        cost[n] = wrong_match(others, (model.base[n] * factor)[None])[0]
    return LocalError(
        model, windows, maps, inverse, renderer, scene, camera, window, candidates,
        cost * model.seen, penalty,
    )  # fmt: skip
