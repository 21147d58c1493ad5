"""Epsilon(p) of local appearance (`la`; Odisio & Bailly, section 4): see `descriptor`."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from abs_engine.compare.descriptor import wrong_match
from abs_engine.compare.residual_rows import Rows
from abs_engine.compare.settings import COMPARISON
from abs_engine.core.arrays import BoolArray, FloatArray
from abs_engine.core.camera import Camera, Window
from abs_engine.core.scene import Candidates, Renderer, Scene
from abs_engine.face.appearance.descriptors import DescriptorMaps
from abs_engine.face.appearance.local import N_D, LocalModel
from abs_engine.face.appearance.patches import Patches
from abs_engine.face.appearance.visibility import in_sight
from abs_engine.face.appearance.windows import Windows

Whiten = Literal["no", "each", "all"]


@dataclass(frozen=True, eq=False)
class LocalError:
    """Epsilon of N points' local appearance (`la`). Made by `local_error`.

    N is the model's number of points and N_d is 8. A point that is hidden or turned away costs
    `wrong` in place of its difference.

    Parameters
    ----------
    maps : DescriptorMaps
        Of the window of the frame.
    inverse : (N, 8) float64
        What differences are multiplied by: 1 as printed.
    mixer : (8 N, 8 N) float64, optional
        What they are multiplied by then, all together; see `LocalModel.whitener`.
    wrong : (N,) float64
        What a wrong match costs of each point, times the share of the training frames that show
        it: one that is often hidden is no offence.
    """

    model: LocalModel
    windows: Windows
    maps: DescriptorMaps
    inverse: FloatArray
    renderer: Renderer
    scene: Scene
    camera: Camera
    window: Window
    wrong: FloatArray
    mixer: FloatArray | None = None

    @property
    def unit(self) -> float:
        """Cost of a wrong match, in units of epsilon: the scale of tolerances."""
        return float(np.mean(self.wrong))

    def rows(self, candidates: Candidates) -> Rows:
        """Epsilon of a batch, taken apart: eight rows for each point."""
        differ, shown = self.differences(candidates)
        wide, there = differ.reshape(len(differ), -1), np.repeat(shown, N_D, axis=1)
        data = self._epsilon(differ, shown)
        return Rows(wide / np.sqrt(wide.shape[1]), there, data, self.mixer)

    def mixed(self, differ: FloatArray) -> FloatArray:
        """Differences (B, N, 8) as rows (B, 8 N) whose squares count."""
        rows = differ.reshape(len(differ), -1)
        return rows if self.mixer is None else np.asarray(rows @ self.mixer.T)

    def epsilon(self, candidates: Candidates) -> FloatArray:
        """Epsilon (B,) of candidates, drawn in one call."""
        return self._epsilon(*self.differences(candidates))

    negative_log = epsilon

    def _epsilon(self, differ: FloatArray, shown: BoolArray) -> FloatArray:
        """Epsilon (B,) of `differences`."""
        data = (self.mixed(differ) ** 2).mean(axis=1)
        return np.asarray(data + np.where(shown, 0.0, self.wrong).mean(axis=1))

    def differences(self, candidates: Candidates) -> tuple[FloatArray, BoolArray]:
        """Differences of descriptors (B, N, 8), 0 where hidden; visibility (B, N)."""
        many, w = candidates, self.window
        coarse = Window(w.x, w.y, w.width, w.height, w.scale * COMPARISON.depth_scale)
        drawn = self.renderer.draw(self.scene, many, self.camera, coarse)
        found = np.empty((len(many), len(self.model), N_D))
        shown = np.empty(found.shape[:2], np.bool_)
        for i, buffers in enumerate(drawn):
            moved = self.windows.patches.placed(many, i)
            points, normals = self.windows.patches.surface(moved)
            found[i] = self.windows.read(self.maps, w.to_drawn(self.camera.project(moved)))
            shown[i] = in_sight(points, normals, buffers.depth, self.camera, coarse) > 0
        differ = (found - self.model.at(many.weights)) * self.inverse
        return differ * shown[..., None], shown


def local_error(
    model: LocalModel,
    scene: Scene,
    frame: NDArray[np.generic],
    camera: Camera,
    window: Window,
    renderer: Renderer,
    whiten: Whiten = "no",
    mixer: FloatArray | None = None,
) -> LocalError:
    """The local appearance error of a frame (H, W, 3), RGB 0 to 255, the whole picture.

    Parameters
    ----------
    scene : Scene
        The shape that hides and is hidden; the model's points are its vertices.
    window : Window
        Where points are looked for; of the scale that the model was learned at.
    whiten : {"no", "each", "all"}
        Divide differences by the spread that the model leaves unexplained, so that all components
        have a like weight, or whiten all of them together, so that what many points miss alike
        counts once; the paper compares them raw.
    mixer : (8 N, 8 N) float64, optional
        What whitens all of them together, by default the model's `whitener`.

    Raises
    ------
    PictureError
        If a pixel of the frame is not finite.
    ParameterError
        If the model's points are no vertices of the scene.
    """
    windows = Windows(Patches.around(scene, model.vertices), model.sigma, model.unit)
    maps = DescriptorMaps.of(window.sample(np.asarray(frame, np.float32)), windows.scales)
    inverse = np.ones_like(model.spread) if whiten == "no" else model.inverse
    if whiten != "all":
        mixer = None
    elif mixer is None:
        mixer = model.whitener
    factor = inverse if mixer is None else inverse * _own(mixer)
    cost = np.empty(len(model))
    for n, (scale, own) in enumerate(zip(windows.at_rest, factor, strict=True)):
        others = maps.maps[scale, ::4, ::4].reshape(-1, N_D) * own
        cost[n] = wrong_match(others, (model.base[n] * own)[None])[0]
    return LocalError(
        model, windows, maps, inverse, renderer, scene, camera, window, cost * model.seen, mixer
    )


def _own(mixer: FloatArray) -> FloatArray:
    """Lengths (N, 8) of what single components become."""
    return np.asarray(np.linalg.norm(mixer, axis=0).reshape(-1, N_D))
