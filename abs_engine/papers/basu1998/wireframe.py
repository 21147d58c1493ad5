"""The shell as a wireframe over the picture that it was fitted to, enlarged around the mouth."""

from __future__ import annotations

from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import NDArray

from abs_engine.core.arrays import FloatArray, Image
from abs_engine.core.camera import Camera, Window
from abs_engine.core.geometry import Pose, vertex_normals
from abs_engine.core.scene import Renderer
from abs_engine.face.shape.lip_shell import LipShell
from abs_engine.report.drawing.view import View
from abs_engine.report.drawing.wire import draw_wire

LINE = 1.1  # pixels of a tile
ON_LIPS, ON_SKIN = (60, 255, 120), (80, 190, 255)
"""Colours of the lines of lip facets and of skin facets."""


@dataclass(frozen=True, eq=False)
class CloseUp:
    """The part of a camera's picture around the mouth, as a tile of a figure.

    Parameters
    ----------
    window : Window
        Drawn pixels are those of the tile.
    scale : float
        Drawn pixels for each of the picture when a fit looks at it.
    """

    camera: Camera
    window: Window
    scale: float

    @property
    def fitted(self) -> Window:
        """The same part of the picture at the scale of a fit."""
        return replace(self.window, scale=self.scale)

    def cut(self, picture: Image) -> Image:
        """The tile of a whole picture (H, W, 3) RGB."""
        return np.asarray(self.window.sample(picture), np.uint8)

    def grey(self, drawn: FloatArray) -> Image:
        """The tile of a map (H, W), 0 to 1, of the same window drawn at another scale."""
        fitted = cv2.resize(drawn, self.window.drawn, interpolation=cv2.INTER_LINEAR)
        grey = np.asarray(np.clip(np.rint(255 * fitted), 0, 255), np.uint8)
        return np.repeat(grey[..., None], 3, axis=2)

    def pixels(self, points: FloatArray) -> FloatArray:
        """Places in the tile of points (..., 3), mm, camera frame, (..., 2)."""
        return self.window.to_drawn(self.camera.project(points))

    def wired(
        self, tile: Image, renderer: Renderer, shell: LipShell, nodes: FloatArray, pose: Pose
    ) -> Image:
        """A tile with the edges of the shell's visible facets drawn over it.

        Parameters
        ----------
        nodes : (N, 3) float64, mm, head frame
        """
        surface = ShellSurface(shell, nodes, two_sided=False)
        every = np.ones(shell.faces.shape, bool)
        colours = np.where(shell.lip[:, None], ON_LIPS, ON_SKIN)
        view = View(self.camera, pose, self.window)
        return draw_wire(tile, renderer, surface, view, every, LINE, colours)


@dataclass(frozen=True, eq=False)
class ShellSurface:
    """The shell of the lips in a posture, as it is drawn.

    Parameters
    ----------
    vertices : (N, 3) float64, mm, head frame
    two_sided : bool
        Whether the back is drawn, too.
    """

    shell: LipShell
    vertices: FloatArray
    two_sided: bool = True

    @property
    def faces(self) -> NDArray[np.integer]:
        """Vertices of each facet, (F, 3)."""
        return self.shell.faces

    @property
    def normals(self) -> FloatArray:
        """Unit vertex normals (N, 3), head frame."""
        return vertex_normals(self.vertices, self.shell.faces)
