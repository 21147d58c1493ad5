"""Where people's lips end on the bundled head: its vertices, moved along the spokes of its lips.

The artist's lips are as high beside the corners of the mouth as a little farther in; people's end
in a point. The head is laid on an average head of scans, and on each spoke of the lips' grid the
border moves to where that head's lies. Vertices on both sides of it move, too, along the edges of
the mesh; the surface stays, to the size of a facet.
"""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter1d

from abs_engine.core.arrays import FloatArray
from abs_engine.face.shape.population import Slide
from abs_engine.io.assets import Speaker, shipped

IntArray = NDArray[np.integer]

HELD = 7
"""First ring of the grid that stays, with all farther in: about where closed lips turn inwards."""
STEP = 0.05
"""Part of a ring: how finely the border is looked for."""
MESH = 2.0
"""Vertices along the other border over which the steps of its mesh are smoothed (deviation)."""
KEPT, FREE = 0.35, 0.55
"""Of half the mouth's width: nearer to its middle the border stays, farther out it moves wholly.

In between more and more. The other border, smoothed, has lost its Cupid's bow.
"""


def lip_grid() -> NDArray[np.int32]:
    """Vertices of the bundled head's lips (R, S): rings from outside to the seam, spokes around.

    Spokes begin at the right corner and go along the upper lip.
    """
    with np.load(shipped("speaker/head.npz")) as head:
        return np.asarray(head["lip_grid"], np.int32)


def slid_border(ours: Speaker, laid: FloatArray, other: Speaker, there: FloatArray) -> Slide:
    """How the bundled head's vertices slide, so that its border of the lips lies on another head's.

    Spokes of the grid and both borders begin at the right corner and go along the upper lip.

    Parameters
    ----------
    ours : Speaker
        The bundled head.
    laid : (V, 3) float64, mm
        Its vertices, laid on the other head.
    other : Speaker
        The other head.
    there : (W, 3) float64, mm
        Its vertices.
    """
    grid = lip_grid()
    now = (grid == ours.lip_ring).argmax(axis=0)
    outline = _smooth(there[other.lip_ring], _left(other))[:, :2].astype(np.float32)
    wanted = [_leaves(laid[grid[: HELD + 1, k], :2], outline) for k in range(grid.shape[1])]
    across = np.abs(laid[ours.lip_ring, 0])
    moves = np.clip((across / across[0] - KEPT) / (FREE - KEPT), 0.0, 1.0)
    return _moved(grid, now, _alike(now + moves * (wanted - now), now, _left(ours)))


def _left(head: Speaker) -> int:
    """Where along the border the left corner lies; the right one is its first vertex."""
    return int(np.flatnonzero(head.lip_ring == head.landmarks["mouth_corners"][1])[0])


def _smooth(border: FloatArray, left: int) -> FloatArray:
    """A border without the steps of its mesh; its corners, 0 and `left`, stay."""
    out = border.copy()
    for arc in (np.arange(left + 1), np.r_[left : len(border), 0]):
        soft = gaussian_filter1d(border[arc], MESH, axis=0, mode="nearest")
        soft[[0, -1]] = border[arc[[0, -1]]]
        out[arc] = soft
    return out


def _leaves(spoke: FloatArray, outline: NDArray[np.float32]) -> float:
    """At which ring a spoke (rings, 2), followed outwards, leaves an outline; 0 where it does not.

    Both are seen from the front.
    """
    at = np.arange(0.0, HELD + 0.5 * STEP, STEP)
    points = np.column_stack([np.interp(at, np.arange(len(spoke)), axis) for axis in spoke.T])
    inside = [cv2.pointPolygonTest(outline, (float(x), float(y)), False) for x, y in points]
    out = np.flatnonzero(np.less(inside, 0))
    return float(at[out[-1]]) if len(out) else 0.0


def _alike(wanted: FloatArray, now: IntArray, left: int) -> FloatArray:
    """Rings of the border (S,), both sides alike and smooth, between now and those of corners."""
    corners = [0, left]
    other = (left - np.arange(len(wanted))) % len(wanted)
    rings = np.clip(0.5 * (wanted + wanted[other]), now, now[corners].min())
    for _ in range(2):
        beside = 0.25 * (np.roll(rings, 1) + np.roll(rings, -1))
        rings = np.maximum(0.5 * rings + beside, now)
        rings[corners] = now[corners]
    return rings


def _moved(grid: IntArray, now: IntArray, wanted: FloatArray) -> Slide:
    """Vertices that move as their border does from `now` to `wanted` (S,), rings of each spoke."""
    rings = np.arange(HELD + 1.0)
    at = np.empty((len(rings), len(now)))
    for k, (before, after) in enumerate(zip(now, wanted, strict=True)):
        ends = np.array([[0.0, 0.0], [before, after], [HELD, HELD]])
        at[:, k] = np.interp(rings, *ends[1 if before == 0 else 0 :].T)
    ring, spoke = np.nonzero(np.abs(at - rings[:, None]) > 1e-9)
    place = at[ring, spoke]
    inner = np.minimum(place.astype(int), HELD - 1)
    between = np.column_stack([grid[inner, spoke], grid[inner + 1, spoke]])
    share = (place - inner).astype(np.float32)
    return Slide(grid[ring, spoke].astype(np.int32), between.astype(np.int32), share)
