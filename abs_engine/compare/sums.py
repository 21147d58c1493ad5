"""Sums of a pixel term over drawings: fused into the drawing where a renderer can, else by buffers.

The buffers are the one to read and trust; the fused sums are an optimisation of it.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import cast

import numpy as np

from abs_engine.core.buffers import Buffers, Outlines, Sums
from abs_engine.core.camera import Camera, Window
from abs_engine.core.scene import (
    Candidates,
    ClassMaps,
    ColourError,
    FusedRenderer,
    PixelTerm,
    Renderer,
    Scene,
)


def pixel_sums(
    renderer: Renderer,
    scene: Scene,
    candidates: Candidates,
    camera: Camera,
    window: Window,
    term: PixelTerm,
) -> Sums:
    """Draw every candidate and sum `term` over its drawn pixels."""
    if hasattr(renderer, "measure"):  # far quicker than isinstance of a protocol
        return cast("FusedRenderer", renderer).measure(scene, candidates, camera, window, term)
    return buffer_sums(renderer.draw(scene, candidates, camera, window), term)


def outlined(
    renderer: Renderer, scene: Scene, candidates: Candidates, camera: Camera, window: Window
) -> list[Outlines]:
    """Draw every candidate for what shows where classes meet."""
    outlines = getattr(renderer, "outlines", None)  # of one that can leave out the colours
    if outlines is not None:
        return cast("list[Outlines]", outlines(scene, candidates, camera, window))
    return [Outlines.of(drawn) for drawn in renderer.draw(scene, candidates, camera, window)]


def buffer_sums(drawn: Sequence[Buffers], term: PixelTerm) -> Sums:
    """The same of drawings that are at hand."""
    each = [_facets(b, term) if isinstance(term, ClassMaps) else _colours(b, term) for b in drawn]
    pixels = [np.count_nonzero(b.facet_id) for b in drawn]
    return Sums(np.array(each, np.float64), np.array(pixels, np.int64))


def _facets(drawn: Buffers, term: ClassMaps) -> float:
    """The sum of eq. 9: each drawn pixel adds the map of its class."""
    rows, columns = np.nonzero(drawn.class_id)
    return float(term.maps[drawn.class_id[rows, columns], rows, columns].sum(dtype=np.float64))


def _colours(drawn: Buffers, term: ColourError) -> float:
    """Squared differences of luminance-normalised RGB."""
    where = drawn.covered
    rgb = drawn.rgb[where].astype(np.float64)
    ours = (rgb + 1) / (rgb.sum(axis=1, keepdims=True) + 3)
    return float(np.square(ours - term.normalised[where]).sum())
