"""The error of appearance descriptors, epsilon(p) (Odisio & Bailly, section 4).

epsilon(p) = 1 / (N N_d) sum_i sum_j (D^a_ij(p) - D^s_ij(p))^2 + A(a)

What is turned away or hidden has no descriptor. So that a fit wins nothing by hiding, it is charged
what a wrong match costs: the mean squared difference between a model's descriptor and the frame's
at other places.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from abs_engine.compare.residual_rows import Rows
from abs_engine.compare.settings import COMPARISON
from abs_engine.compare.sums import pixel_sums
from abs_engine.compare.whiten import TextureNoise
from abs_engine.core.arrays import BoolArray, FloatArray, IntArray
from abs_engine.core.buffers import Buffers
from abs_engine.core.camera import Camera, Window
from abs_engine.core.errors import OutOfPictureError
from abs_engine.core.scene import Candidates, ColourError, Renderer, Scene
from abs_engine.face.appearance.residual_covariance import normalised
from abs_engine.face.appearance.texture import TextureModel
from abs_engine.face.appearance.visibility import check_picture
from abs_engine.face.settings.appearance import APPEARANCE

_STEEPEST = float(np.sqrt(1 - APPEARANCE.facing**2) / APPEARANCE.facing)
_AROUND = np.ones((3, 3), np.uint8)
_FAR = np.float32(1e6)  # mm: farther behind anything than a step of any surface


@dataclass(frozen=True, eq=False)
class TextureError:
    """Epsilon of luminance-normalised RGB over the drawn pixels S (`tex`).

    N = |S| and N_d = 3. Made by `texture_error`.

    Parameters
    ----------
    scene : Scene
        With the texture that is compared; see `TextureModel.dress`.
    term : ColourError
        The window of the frame.
    drawn : int
        Pixels that are to be explained. A candidate that draws fewer is charged `wrong` for the
        rest; one that draws more, or as many, has epsilon as printed.
    wrong : float
        What a wrong match costs, in units of epsilon.
    noise : TextureNoise, optional
        What differences are whitened by, pixels beside an outline left out; see `texture_error`.
        Without it they count as they are, as printed.
    """

    renderer: Renderer
    scene: Scene
    camera: Camera
    window: Window
    term: ColourError
    drawn: int
    wrong: float
    noise: TextureNoise | None = None

    @property
    def unit(self) -> float:
        """Cost of a wrong match, in units of epsilon: the scale of tolerances."""
        return float(np.mean(self.wrong))

    def rows(self, candidates: Candidates) -> Rows:
        """Epsilon of a batch, taken apart: three rows for each pixel of the window."""
        drawn = self.renderer.draw(self.scene, candidates, self.camera, self.window)
        frame = self.term.normalised
        rows = np.zeros((len(candidates), frame.size), np.float32)
        there = np.zeros(rows.shape, np.bool_)
        data = np.empty(len(candidates))
        for i, buffers in enumerate(drawn):
            covered, differ = self.differences(buffers)
            count = len(differ)
            lost = max(self.drawn - count, 0)
            data[i] = (float((differ**2).sum()) / 3 + self.wrong * lost) / (count + lost)
            rows[i].reshape(frame.shape)[covered] = differ / np.sqrt(3 * (count + lost))
            there[i].reshape(frame.shape)[covered] = True
        return Rows(rows, there, data)

    def differences(self, drawn: Buffers) -> tuple[BoolArray, NDArray[np.float32]]:
        """S of a drawing, (H, W), and D^s - D^a of its N pixels as they count, (N, 3)."""
        where = _compared(drawn, self.camera, self.window, self.noise)
        off = normalised(drawn.rgb[where]) - self.term.normalised[where]
        if self.noise is not None:
            off = self.noise.whitened(off, self.scene, drawn, where)
        return where, off

    def epsilon(self, candidates: Candidates) -> FloatArray:
        """Epsilon (B,) of candidates, drawn in one call."""
        sums = self._sums if self.noise is None else self._own_sums
        total, pixels = sums(candidates)
        lost = np.maximum(self.drawn - pixels, 0)
        return np.asarray((total / 3 + self.wrong * lost) / (pixels + lost))

    negative_log = epsilon

    def _sums(self, many: Candidates) -> tuple[FloatArray, IntArray]:
        """Squared differences (B,) and pixels (B,), by the renderer itself."""
        sums = pixel_sums(self.renderer, self.scene, many, self.camera, self.window, self.term)
        return sums.total, sums.pixels

    def _own_sums(self, many: Candidates) -> tuple[FloatArray, IntArray]:
        """The same of `differences`."""
        total, pixels = np.empty(len(many)), np.empty(len(many), np.int64)
        drawn = self.renderer.draw(self.scene, many, self.camera, self.window)
        for i, buffers in enumerate(drawn):
            off = self.differences(buffers)[1]
            total[i], pixels[i] = np.square(off).sum(dtype=np.float64), len(off)
        return total, pixels


def texture_error(
    model: TextureModel,
    scene: Scene,
    frame: NDArray[np.generic],
    camera: Camera,
    window: Window,
    start: Candidates,
    renderer: Renderer,
    dressed: Scene | None = None,
    whiten: bool = False,
) -> TextureError:
    """The texture error of a frame (H, W, 3), RGB 0 to 255, the whole picture.

    Parameters
    ----------
    scene : Scene
        The shape whose pixels are S; modes in the order of the model's parameters. The paper's
        mesh is skin and lips. What shows between the lips is dark, and luminance-normalised RGB
        is mostly noise there; see `region.part` for a scene without it.
    window : Window
        What is compared, and how finely.
    start : Candidates
        Where a fit starts, which says how many pixels there are to explain.
    dressed : Scene, optional
        ``model.dress(scene)``, where it is made once for many frames.
    whiten : bool
        Divide differences by the spread that the model leaves unexplained, so that texels have a
        like weight (what is dark is mostly noise), and count once what many miss alike. Pixels
        beside an outline are left out of S: a camera mixes there what the drawing does not, and a
        fit gains by moving the outline. The paper compares all rendered pixels, raw.

    Raises
    ------
    PictureError
        If a pixel of the frame is not finite.
    OutOfPictureError
        If nothing is drawn at the start.
    """
    check_picture(frame)
    clothed = model.dress(scene) if dressed is None else dressed
    term = ColourError(window.sample(np.asarray(frame, np.float32)).astype(np.float32))
    drawn = renderer.draw(clothed, start, camera, window)[0]
    noise = TextureNoise(model.leftover.layers) if whiten else None
    where = _compared(drawn, camera, window, noise)
    if not where.any():
        raise OutOfPictureError("nothing is drawn at the start", "start where the face is")
    ours = normalised(drawn.rgb[where].astype(np.float64))
    cost = wrong_match(term.normalised[where].astype(np.float64), ours)
    if noise is not None:
        cost = cost * noise.scales(clothed, drawn, where) ** 2
    count = max(1, int(COMPARISON.kept * where.sum()))
    return TextureError(renderer, clothed, camera, window, term, count, float(cost.mean()), noise)


def _compared(
    drawn: Buffers, camera: Camera, window: Window, noise: TextureNoise | None
) -> BoolArray:
    """S, (H, W)."""
    return drawn.covered if noise is None else off_outlines(drawn, camera, window)


def wrong_match(analysed: FloatArray, synthetic: FloatArray) -> FloatArray:
    """Cost of each model descriptor (N,) beside the frame's at all places, per component.

    The mean over j of |D^a_j - D^s_i|^2 / N_d, for descriptors (M, N_d) and (N, N_d): the spread
    of the frame's plus the distance from their mean.
    """
    mean = analysed.mean(axis=0)
    spread = ((analysed - mean) ** 2).mean()
    return np.asarray(spread + ((synthetic - mean) ** 2).mean(axis=1))


def off_outlines(buffers: Buffers, camera: Camera, window: Window) -> NDArray[np.bool_]:
    """Drawn pixels whose eight neighbours show the same surface, (H, W) bool.

    A neighbour does where it is drawn, and no farther before or behind than the next pixel of a
    surface is at `APPEARANCE.facing`, the flattest at which appearance is learned. Diagonal
    neighbours, which lie 1.4 times as far off, are held to the same: across them flatter surfaces
    are left out too. Pixels on the window's border are left out. `buffers` are of the window.
    """
    drawn = buffers.covered
    step = _STEEPEST / (float(camera.matrix[0, 0]) * window.scale) * buffers.depth
    depth = np.where(drawn, buffers.depth, -_FAR)
    inner = drawn & (buffers.depth - cv2.erode(depth, _AROUND) < step)
    inner &= cv2.dilate(depth, _AROUND) - buffers.depth < step
    inner[[0, -1]] = False
    inner[:, [0, -1]] = False
    return np.asarray(inner)
