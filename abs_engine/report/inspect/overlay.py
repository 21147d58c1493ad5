"""A tracked head drawn over its video: as a wireframe, as contours, or half transparent."""

from __future__ import annotations

from functools import cached_property

import cv2
import numpy as np
from numpy.typing import NDArray

from abs_engine.core.camera import Window
from abs_engine.core.errors import ParameterError
from abs_engine.core.geometry import FloatArray
from abs_engine.core.scene import Candidates, Renderer
from abs_engine.report.inspect.body import Body, unknown
from abs_engine.report.inspect.layout import captioned
from abs_engine.report.inspect.paint import coat, paint_layers, plain_scene
from abs_engine.report.inspect.runs import RunHead
from abs_engine.report.inspect.view import View
from abs_engine.report.inspect.wire import line_cover, quad_edges

Image = NDArray[np.uint8]
Colour = tuple[int, int, int]

STYLES = ("wireframe", "contour", "blend")
OUTER: Colour = (60, 255, 120)
UPPER: Colour = (255, 230, 0)
LOWER: Colour = (80, 190, 255)
OUTLINE: Colour = (255, 255, 255)
WIRE: Colour = (120, 255, 190)
LOST: Colour = (200, 30, 20)

WIRE_STRENGTH = 0.6
BLEND_STRENGTH = 0.6
LEAST_HEIGHT = 640
_FINER = 3
_FRACTION = 4  # bits of OpenCV's sub-pixel coordinates


class OverlayPainter:
    """Draws the head of a run over frames of its video.

    Parameters
    ----------
    renderer : Renderer
    run : RunHead
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
        caption = f"frame {frame}   {frame / self._run.rate:.2f} s"
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
        window = view.window
        finer = Window(window.x, window.y, window.width, window.height, _FINER * window.scale)
        one = Candidates.one(np.zeros(0), view.pose)
        buffers = self._renderer.draw(plain_scene(body), one, view.camera, finer)[0]
        lines = line_cover(
            buffers.facet_id,
            buffers.barycentrics,
            finer.to_drawn(_pixels(body, view)),
            body.speaker.faces,
            self._edges,
            _FINER * min(1.0, max(0.45, window.scale / 3)),  # thin where there is little room
        )
        cover = cv2.resize(lines.astype(np.float32), window.drawn, interpolation=cv2.INTER_AREA)[
            ..., None
        ]
        mixed = large + WIRE_STRENGTH * cover * (np.array(WIRE, np.float32) - large)
        return np.asarray(np.rint(mixed), np.uint8)

    @cached_property
    def _edges(self) -> NDArray[np.bool_]:
        speaker = self._run.speaker
        return quad_edges(speaker.vertices.astype(np.float64), speaker.faces, speaker.weld)

    def _contour(self, large: Image, body: Body, view: View) -> Image:
        picture = large.copy()
        self._outline(picture, body, view)
        marks, pixels = body.speaker.landmarks, view.window.to_drawn(_pixels(body, view))
        for name, closed, colour in (
            ("inner_lip_upper", False, UPPER),
            ("inner_lip_lower", False, LOWER),
            ("outer_lip", True, OUTER),
        ):
            _polyline(picture, pixels[marks[name]], closed, colour, self._edged)
        return picture

    @property
    def _edged(self) -> bool:
        """Whether there is room for dark edges of lines."""
        return self._scale > 1 or self._run.camera.size[1] >= LEAST_HEIGHT

    def _outline(self, picture: Image, body: Body, view: View) -> None:
        """The silhouette of the head, in place."""
        one = Candidates.one(np.zeros(0), view.pose)
        drawn = self._renderer.draw(plain_scene(body), one, view.camera, view.window)[0]
        covered = np.pad(drawn.covered.astype(np.uint8), 1)
        chain, _ = cv2.findContours(covered, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
        for contour in chain:
            points = contour[:, 0].astype(np.float64) - 1
            _polyline(picture, points, True, OUTLINE, self._edged)


def _pixels(body: Body, view: View) -> FloatArray:
    """Places of the vertices in the image, (V, 2)."""
    return view.camera.project(view.pose.apply(body.vertices))


def _polyline(
    picture: Image, points: FloatArray, closed: bool, colour: Colour, edged: bool
) -> None:
    """A smooth line, perhaps with a dark edge, in place."""
    fixed = [np.rint(points * 2**_FRACTION).astype(np.int32)]
    for ink, width in (((0, 0, 0), 3), (colour, 1)) if edged else ((colour, 1),):
        cv2.polylines(picture, fixed, closed, ink, width, cv2.LINE_AA, _FRACTION)
