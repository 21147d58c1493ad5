"""A tracked head drawn over its video: as a wireframe, as contours, or half transparent."""

from __future__ import annotations

from functools import cached_property

import cv2
import numpy as np

from abs_engine.core.arrays import BoolArray, FloatArray, Image
from abs_engine.core.camera import Window
from abs_engine.core.errors import ParameterError
from abs_engine.core.scene import Renderer
from abs_engine.report.drawing.layout import captioned
from abs_engine.report.drawing.lines import Colour, draw_line
from abs_engine.report.drawing.paint import drawn, paint_layers
from abs_engine.report.drawing.view import View
from abs_engine.report.drawing.wire import draw_wire, quad_edges
from abs_engine.report.inspect.body import Body, coat, unknown
from abs_engine.report.inspect.runs import RunHead
from abs_engine.report.inspect.sources import frame_caption
from abs_engine.tracking.results.contours import LOWER, OUTER, UPPER

STYLES = ("wireframe", "contour", "blend")
OUTLINE: Colour = (255, 255, 255)
WIRE: Colour = (120, 255, 190)
LOST: Colour = (200, 30, 20)

WIRE_STRENGTH = 0.6
BLEND_STRENGTH = 0.6
LEAST_HEIGHT = 640


class OverlayPainter:
    """Draws the head of a run over frames of its video.

    Parameters
    ----------
    style : str
        One of `STYLES`.
    palette : str
        Of the head when it is blended: clay or classes.
    enlarged : bool
        Whether pictures of less height than `LEAST_HEIGHT` are enlarged by a whole number.

    Raises
    ------
    ParameterError
        If there is no such style.
    """

    def __init__(
        self,
        renderer: Renderer,
        run: RunHead,
        style: str,
        palette: str = "classes",
        enlarged: bool = True,
    ) -> None:
        if style not in STYLES:
            raise ParameterError(*unknown("style", style, STYLES))
        self._renderer, self._run, self._palette = renderer, run, palette
        self._draw = {"wireframe": self._wire, "contour": self._contour, "blend": self._blend}[
            style
        ]
        self._scale = float(-(-LEAST_HEIGHT // run.camera.size[1])) if enlarged else 1.0

    def paint(self, frame: int, image: Image) -> Image:
        """A frame with the head over it and its number below, (H, W, 3) uint8 RGB."""
        window = Window(0, 0, *self._run.camera.size, self._scale)
        large = np.ascontiguousarray(window.sample(image), np.uint8)
        caption = frame_caption(frame, float(self._run.times[frame]))
        if not self._run.found(frame):
            status = str(self._run.arrays["status"][frame])
            return captioned(large, f"{caption}   {status}", 15, LOST)
        body, view = self._run.body(frame), self._run.view(frame, self._scale)
        return captioned(self._draw(large, body, view), caption, 15)

    def _blend(self, large: Image, body: Body, view: View) -> Image:
        colour, cover = paint_layers(self._renderer, body, coat(body, self._palette), view)
        mixed = large * (1 - BLEND_STRENGTH * cover) + BLEND_STRENGTH * colour
        return np.asarray(np.rint(mixed), np.uint8)

    def _wire(self, large: Image, body: Body, view: View) -> Image:
        width = min(1.0, max(0.45, view.window.scale / 3))  # thin where there is little room
        colours = np.tile(WIRE, (len(body.faces), 1))
        return draw_wire(
            large, self._renderer, body, view, self._edges, width, colours, WIRE_STRENGTH
        )

    @cached_property
    def _edges(self) -> BoolArray:
        speaker = self._run.speaker
        return quad_edges(speaker.vertices.astype(np.float64), speaker.faces, speaker.weld)

    def _contour(self, large: Image, body: Body, view: View) -> Image:
        picture = large.copy()
        self._outline(picture, body, view)
        marks, pixels = body.speaker.landmarks, view.pixels(body.vertices)
        for name, closed, colour in (
            ("inner_lip_upper", False, UPPER),
            ("inner_lip_lower", False, LOWER),
            ("outer_lip", True, OUTER),
        ):
            self._line(picture, pixels[marks[name]], closed, colour)
        return picture

    def _outline(self, picture: Image, body: Body, view: View) -> None:
        """The silhouette of the head, in place."""
        covered = np.pad(drawn(self._renderer, body, view).covered.astype(np.uint8), 1)
        chain, _ = cv2.findContours(covered, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
        for contour in chain:
            points = contour[:, 0].astype(np.float64) - 1
            self._line(picture, points, True, OUTLINE)

    def _line(self, picture: Image, points: FloatArray, closed: bool, colour: Colour) -> None:
        """A smooth line, with a dark edge where there is room for one, in place."""
        if self._scale > 1 or self._run.camera.size[1] >= LEAST_HEIGHT:
            draw_line(picture, points, closed, (0, 0, 0), 3)
        draw_line(picture, points, closed, colour)
