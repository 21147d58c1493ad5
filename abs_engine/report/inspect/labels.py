"""Label buffers - ids, classes, depth, normals, albedo, flow - as pictures with a legend."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.arrays import Image
from abs_engine.core.errors import ParameterError
from abs_engine.core.scene import Renderer
from abs_engine.io.assets import Speaker
from abs_engine.report.drawing import legend
from abs_engine.report.drawing.paint import drawn
from abs_engine.report.drawing.palette import (
    CLASS_COLOURS,
    FACET_COLOURS,
    colours_of,
    facet_palette,
    paint_flow,
    paint_ids,
    paint_normals,
    paint_values,
    rounded_up,
)
from abs_engine.report.drawing.view import View
from abs_engine.report.inspect.body import Body

MOST = 0.98
"""Share of the flow within its scale: a blink is long, and would leave all else pale."""
LEAST_FLOW = 0.1  # px, at the end of its scale

DEPTH_COLOURS = colours_of("viridis_r")


@dataclass(frozen=True, eq=False)
class LabelFrame:
    """Labels of each pixel of one picture.

    Parameters
    ----------
    ids : (H, W) int
        Facet index + 1; 0 where the head is not seen.
    others : mapping of str to callable
        What makes `depth` (H, W) mm, `normals` (H, W, 3) camera frame, `albedo` (H, W, 3) uint8
        and `flow` (H, W, 2) pixels, NaN where it is not known; read when they are shown.
    """

    caption: str
    ids: NDArray[np.integer]
    others: Mapping[str, Callable[[], NDArray[np.generic]]] = field(default_factory=dict)

    def read(self, kind: str) -> NDArray[np.generic]:
        """One of the others.

        Raises
        ------
        ParameterError
            If it is not known here.
        """
        if kind not in self.others:
            raise ParameterError(f"{kind} is not known here", "give a dataset with --truth")
        return self.others[kind]()


def drawn_labels(renderer: Renderer, body: Body, view: View, caption: str = "") -> LabelFrame:
    """The labels of a drawn head, one sample in the middle of each pixel."""
    buffers = drawn(renderer, body, view)

    def normals() -> NDArray[np.generic]:
        rotated = body.normals @ view.pose.rotation.T
        corners = rotated[body.speaker.faces[np.maximum(buffers.facet_id - 1, 0)]]
        mixed = (corners * buffers.barycentrics[..., None]).sum(axis=2)
        length = np.linalg.norm(mixed, axis=2, keepdims=True)
        return np.asarray(mixed / np.maximum(length, 1e-9))

    return LabelFrame(
        caption, buffers.facet_id, {"depth": lambda: buffers.depth, "normals": normals}
    )


@dataclass(frozen=True, eq=False)
class LabelPainter:
    """Paints one kind of label, always with the same colours.

    Parameters
    ----------
    kind : str
        One of `request.LABEL_KINDS`.
    limits : tuple of float
        Of depth, mm; of flow, 0 and the largest length in pixels.
    """

    kind: str
    speaker: Speaker
    limits: tuple[float, float] = (0.0, 1.0)

    @cached_property
    def _facet_colours(self) -> Image:
        """A colour for each facet, (F, 3)."""
        if self.kind == "classes":
            return CLASS_COLOURS[self.speaker.facet_class]
        return FACET_COLOURS[facet_palette(self.speaker.faces, self.speaker.weld)]

    def picture(self, frame: LabelFrame) -> Image:
        """The label as (H, W, 3) uint8 RGB, white where the head is not seen."""
        seen = frame.ids > 0
        if self.kind in ("ids", "classes"):
            return paint_ids(frame.ids, self._facet_colours)
        values = frame.read(self.kind)
        if self.kind == "depth":
            return paint_values(values.astype(np.float64), self.limits, DEPTH_COLOURS, seen)
        if self.kind == "normals":
            return paint_normals(values.astype(np.float64), seen)
        if self.kind == "flow":
            flow = values.astype(np.float64)
            return paint_flow(flow, self.limits[1], seen & np.isfinite(flow).all(axis=2))
        return np.where(seen[..., None], values.astype(np.uint8), np.uint8(255))

    def legend(self, height: int) -> Image | None:
        """Legend of the colours, (height, W, 3) uint8 RGB; None where nothing needs to be said."""
        if self.kind == "classes":
            names = self.speaker.class_names[1:]
            return legend.swatches(names, CLASS_COLOURS[1 : len(names) + 1], height)
        if self.kind == "depth":
            return legend.colour_bar(DEPTH_COLOURS, self.limits, "depth, mm", height)
        if self.kind == "normals":
            return legend.normals_ball(height)
        if self.kind == "flow":
            return legend.flow_wheel(self.limits[1], height)
        return None


def limits_of(kind: str, frames: Sequence[LabelFrame]) -> tuple[float, float]:
    """Limits that hold for all frames: of depth to whole 10 mm, of flow above `MOST` of it.

    Raises
    ------
    ParameterError
        If no frame shows the head.
    """
    if kind not in ("depth", "flow"):
        return 0.0, 1.0
    values = [frame.read(kind)[frame.ids > 0].astype(np.float64) for frame in frames]
    if kind == "flow":
        values = [np.linalg.norm(flow, axis=1) for flow in values]
    known = np.concatenate([own[np.isfinite(own)] for own in values])
    if kind == "flow":
        longest = float(np.quantile(known, MOST)) if known.size else 1.0
        return 0.0, rounded_up(max(longest, LEAST_FLOW))
    if not known.size:
        raise ParameterError("the head is in none of the frames", "choose others")
    low, high = 10 * np.floor(known.min() / 10), 10 * np.ceil(known.max() / 10)
    return float(low), float(max(high, low + 10))
