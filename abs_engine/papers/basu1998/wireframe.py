"""The shell as a wireframe over the picture that it was fitted to, enlarged around the mouth."""

from __future__ import annotations

from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import NDArray

from abs_engine.core.camera import Camera, Window
from abs_engine.core.geometry import Pose
from abs_engine.core.scene import Candidates, Renderer, Scene
from abs_engine.face.shape.lip_shell import LipShell
from abs_engine.report.inspect.layout import Image
from abs_engine.report.inspect.wire import line_cover

FloatArray = NDArray[np.float64]
FINER = 3
"""Drawn pixels a side for each pixel of a tile."""
LINE = 1.1  # pixels of a tile
ON_LIPS, ON_SKIN = (60, 255, 120), (80, 190, 255)
"""Colours of the lines of lip facets and of skin facets."""
_VISIBLE = 1.5  # pixels: shorter arrows are left out
_SHIFT = 4  # bits: OpenCV draws between pixels in these fractions


@dataclass(frozen=True, eq=False)
class CloseUp:
    """The part of a camera's picture around the mouth, as a tile of a figure.

    Parameters
    ----------
    camera : Camera
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
        tile : (H, W, 3) uint8 RGB
        renderer : Renderer
        shell : LipShell
        nodes : (N, 3) float64, mm, head frame
        pose : Pose
        """
        fine = replace(self.window, scale=self.window.scale * FINER)
        one = Candidates.one(np.zeros(0), pose)
        drawn = renderer.draw(_plain(shell, nodes), one, self.camera, fine)[0]
        seen = fine.to_drawn(self.camera.project(pose.apply(nodes)))
        every = np.ones(shell.faces.shape, bool)
        lines = line_cover(
            drawn.facet_id, drawn.barycentrics, seen, shell.faces, every, LINE * FINER
        )
        colours = np.where(shell.lip[:, None], ON_LIPS, ON_SKIN)
        ink = np.dstack([colours[drawn.facet_id - 1] * lines[..., None], 255 * lines])
        small = cv2.resize(ink.astype(np.float32), self.window.drawn, interpolation=cv2.INTER_AREA)
        mixed = tile * (1 - small[..., 3:] / 255) + small[..., :3]
        return np.asarray(np.clip(np.rint(mixed), 0, 255), np.uint8)


def arrows(tile: Image, begin: FloatArray, end: FloatArray, colour: tuple[int, int, int]) -> Image:
    """A tile with arrows from pixels `begin` (N, 2) to `end` (N, 2), which are dots."""
    out = np.ascontiguousarray(tile).copy()
    first, last = (np.rint(p * 2**_SHIFT).astype(int).tolist() for p in (begin, end))
    for a, b in zip(first, last, strict=True):
        length = float(np.hypot(b[0] - a[0], b[1] - a[1])) / 2**_SHIFT
        if length > _VISIBLE:
            cv2.arrowedLine(out, a, b, colour, 1, cv2.LINE_AA, _SHIFT, min(0.5, 4 / length))
        cv2.circle(out, a, round(1.2 * 2**_SHIFT), colour, -1, cv2.LINE_AA, _SHIFT)
    return out


def _plain(shell: LipShell, nodes: FloatArray) -> Scene:
    return Scene(
        nodes.astype(np.float32), np.zeros((0, *nodes.shape), np.float32), shell.faces,
        np.zeros((len(nodes), 2), np.float32), np.ones(len(shell.faces), np.int32),
        np.zeros((1, 1, 3), np.uint8),
    )  # fmt: skip
