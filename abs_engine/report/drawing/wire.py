"""Wireframes with hidden lines removed, from the buffers of a drawn head.

How far a pixel is from the edges of its facet follows from its barycentric weights and the
facet's heights in the picture (Baerentzen and others, "Single-pass wireframe rendering", 2006).
"""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np
from numpy.typing import NDArray

from abs_engine.core.arrays import BoolArray, FloatArray, Image
from abs_engine.core.scene import Renderer
from abs_engine.report.drawing.paint import Surface, drawn
from abs_engine.report.drawing.view import View

_FINER = 3  # drawn pixels a side for each pixel of the picture


def draw_wire(
    picture: Image,
    renderer: Renderer,
    surface: Surface,
    view: View,
    edges: BoolArray,
    width: float,
    colours: NDArray[np.integer],
    strength: float = 1.0,
) -> Image:
    """A picture with the edges of a surface's visible facets drawn over it.

    Parameters
    ----------
    picture : (H, W, 3) uint8 RGB
        Of the view's window.
    edges : (F, 3) bool
        Edges to draw, by the corner opposite to them.
    width : float
        Of the lines, pixels of the picture.
    colours : (F, 3) int RGB
        Of each facet's lines.
    strength : float
        Share of the lines in the pixels that they cover, 0 to 1.
    """
    fine = replace(view, window=replace(view.window, scale=view.window.scale * _FINER))
    buffers, seen = drawn(renderer, surface, fine), fine.pixels(surface.vertices)
    cover = line_cover(
        buffers.facet_id, buffers.barycentrics, seen, surface.faces, edges, width * _FINER
    )
    lines = cover[..., None]
    ink = np.dstack([colours[buffers.facet_id - 1] * lines, lines]).astype(np.float32)
    ink = strength * cv2.resize(ink, view.window.drawn, interpolation=cv2.INTER_AREA)
    mixed = picture * (1 - ink[..., 3:]) + ink[..., :3]
    return np.asarray(np.clip(np.rint(mixed), 0, 255), np.uint8)


def quad_edges(
    vertices: FloatArray, faces: NDArray[np.integer], weld: NDArray[np.integer]
) -> BoolArray:
    """Edges that are worth drawing: all but the diagonals of quads that were cut in two.

    An edge that is the longest of both of its facets is taken for such a diagonal.

    Parameters
    ----------
    vertices : (V, 3) float64
    faces : (F, 3) int
    weld : (V,) int

    Returns
    -------
    (F, 3) bool
        For the edges opposite to each facet's corners.
    """
    corners = vertices[faces]
    length = np.linalg.norm(np.roll(corners, -1, 1) - np.roll(corners, -2, 1), axis=2)
    longest = length >= length.max(axis=1, keepdims=True) * (1 - 1e-9)
    welded = weld[faces]
    ends = np.sort(np.stack([np.roll(welded, -1, 1), np.roll(welded, -2, 1)], axis=2), axis=2)
    keys = ends[..., 0].astype(np.int64) * (int(weld.max()) + 1) + ends[..., 1]
    _, edge, facets = np.unique(keys.ravel(), return_inverse=True, return_counts=True)
    votes = np.bincount(edge, weights=longest.ravel())
    diagonal = (facets == 2) & (votes == 2)
    return np.asarray(~diagonal[edge].reshape(faces.shape))


def line_cover(
    ids: NDArray[np.integer],
    barycentrics: NDArray[np.floating],
    pixels: FloatArray,
    faces: NDArray[np.integer],
    wanted: BoolArray,
    width: float,
) -> BoolArray:
    """Cover of lines, (H, W) bool.

    Parameters
    ----------
    ids : (H, W) int
        Facet index + 1; 0 is background.
    barycentrics : (H, W, 3) float
    pixels : (V, 2) float64
        Where the vertices lie in the picture.
    faces : (F, 3) int
    wanted : (F, 3) bool
        Edges to draw, by the corner opposite to them.
    width : float
        Of the lines, pixels.
    """
    corners = pixels[faces]
    edges = np.roll(corners, -2, 1) - np.roll(corners, -1, 1)
    doubled = np.abs(edges[:, 0, 0] * edges[:, 1, 1] - edges[:, 0, 1] * edges[:, 1, 0])
    heights = doubled[:, None] / np.maximum(np.linalg.norm(edges, axis=2), 1e-9)
    heights = np.where(wanted, heights, np.inf)
    lines = np.zeros(ids.shape, bool)
    seen = ids > 0
    # A weight of 0 times an endless height is the edge that is not drawn.
    distance = np.maximum(barycentrics[seen], 1e-6) * heights[ids[seen] - 1]
    lines[seen] = distance.min(axis=1) < 0.5 * width
    return lines
