"""Colours that ids, depths, normals and flow are shown in."""

from __future__ import annotations

from typing import cast

import matplotlib
import numpy as np
from numpy.typing import NDArray

from abs_engine.core.arrays import BoolArray, FloatArray, Image, IntArray

CLASS_COLOURS: Image = np.array(
    [(255, 255, 255), (236, 200, 176), (214, 39, 40), (255, 127, 14), (96, 44, 60),
     (31, 119, 180), (23, 190, 207), (227, 119, 194), (44, 160, 44)],
    np.uint8,
)  # fmt: skip
"""Background, then the classes of the bundled head."""

FACET_COLOURS: Image = np.array(
    [(230, 25, 75), (60, 180, 75), (255, 225, 25), (0, 100, 220), (245, 130, 48),
     (145, 30, 180), (70, 240, 240), (240, 50, 230), (190, 240, 70), (250, 190, 212),
     (0, 128, 128), (150, 90, 30), (128, 0, 0), (170, 255, 195), (110, 110, 0),
     (0, 0, 117), (150, 150, 150), (220, 190, 255)],
    np.uint8,
)  # fmt: skip
"""Colours that are told apart at a glance."""


def colours_of(name: str, count: int = 256) -> Image:
    """A colour scale of matplotlib as (count, 3) uint8, low to high."""
    rows = matplotlib.colormaps[name](np.linspace(0, 1, count))[:, :3]
    return np.asarray(np.rint(255 * rows), np.uint8)


def rounded_up(value: float) -> float:
    """The next number of one or two figures, such as 0.35 or 12; 1 for 0 and less."""
    if value <= 0:
        return 1.0
    step = 10.0 ** (np.floor(np.log10(value)) - 1) * 5
    return float(np.ceil(value / step - 1e-9) * step)


def facet_palette(faces: NDArray[np.integer], weld: NDArray[np.integer]) -> IntArray:
    """Colours of facets such that neighbours differ: (F,) int64, indices into `FACET_COLOURS`.

    Facets that share an edge always have different colours, and so have, wherever the colours
    suffice, facets that share a vertex. Greedy, in the order of the facets; of the free colours
    the one that was used least is taken.

    Parameters
    ----------
    faces : (F, 3) int
    weld : (V,) int
        Index of the geometric vertex, so that seams of the texture do not part neighbours.
    """
    corners = weld[faces]
    around: dict[int, list[int]] = {}
    for facet, row in enumerate(corners.tolist()):
        for vertex in row:
            around.setdefault(vertex, []).append(facet)
    chosen = np.full(len(faces), -1, np.int64)
    used = np.zeros(len(FACET_COLOURS), np.int64)
    for facet, row in enumerate(corners.tolist()):
        groups = [around[vertex] for vertex in row]
        touching = {int(chosen[f]) for group in groups for f in group}
        free = [c for c in range(len(used)) if c not in touching]
        if not free:
            one, two, three = map(set, groups)
            beside = ((one & two) | (two & three) | (three & one)) - {facet}  # share an edge
            free = [c for c in range(len(used)) if c not in {int(chosen[f]) for f in beside}]
        pick = min(free, key=lambda c: used[c])
        chosen[facet] = pick
        used[pick] += 1
    return chosen


def paint_ids(ids: NDArray[np.integer], colours: Image) -> Image:
    """Ids (H, W), index + 1 and 0 for the background, in the colours (N, 3) of the indices."""
    table = np.concatenate([np.full((1, 3), 255, np.uint8), colours])
    return np.asarray(table[ids], np.uint8)


def paint_values(
    values: NDArray[np.floating], limits: tuple[float, float], colours: Image, known: BoolArray
) -> Image:
    """Numbers (H, W) on a scale of colours (K, 3), white where they are not `known`."""
    share = np.clip((values - limits[0]) / (limits[1] - limits[0]), 0.0, 1.0)
    picture = colours[np.rint(np.where(known, share, 0) * (len(colours) - 1)).astype(int)]
    return np.where(known[..., None], picture, np.uint8(255))


def paint_normals(normals: NDArray[np.floating], known: BoolArray) -> Image:
    """Normals (H, W, 3), camera frame (x right, y down, z forward), in the usual colours.

    Red to the right, green upwards, blue towards the camera: (x, -y, -z) from -1..1 to 0..255.
    """
    coded = 127.5 * (normals * np.array([1.0, -1.0, -1.0]) + 1)
    return np.where(known[..., None], np.clip(np.rint(coded), 0, 255), 255).astype(np.uint8)


def paint_flow(flow: NDArray[np.floating], largest: float, known: BoolArray) -> Image:
    """Flow (H, W, 2), pixels: hue is the direction, saturation the length up to `largest`."""
    u, v = flow[..., 0], flow[..., 1]
    hue = (np.arctan2(v, u) / (2 * np.pi)) % 1.0
    length = np.clip(np.hypot(u, v) / largest, 0, 1)
    hsv = np.stack([hue, length, 1 - 0.15 * length], axis=-1)
    from matplotlib.colors import hsv_to_rgb

    coloured = np.rint(255 * cast("FloatArray", hsv_to_rgb(np.where(known[..., None], hsv, 0))))
    return np.where(known[..., None], coloured, 255).astype(np.uint8)
