"""Lay the islands of the chart out anew: the face upright and its mouth magnified.

The base mesh comes with a chart of the whole body in which the lips have 60 pixels of 2048.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Island:
    """One island of the source chart and the place it goes to.

    Attributes
    ----------
    box : (u0, u1, v0, v1)
        Where it lies in the source (v up); looser than the island itself.
    place : (left, top, right, bottom)
        Where it goes to, as fractions of the texture (v down).
    """

    box: tuple[float, float, float, float]
    place: tuple[float, float, float, float]


ISLANDS = {
    "face": Island((0.62, 1.0, 0.14, 0.83), (0.008, 0.008, 0.992, 0.700)),
    "inner_mouth": Island((0.75, 0.95, 0.0, 0.1395), (0.012, 0.722, 0.330, 0.988)),
    "left_eye": Island((0.755, 0.7867, 0.925, 0.96), (0.350, 0.722, 0.480, 0.852)),
    "right_eye": Island((0.7867, 0.82, 0.925, 0.96), (0.492, 0.722, 0.622, 0.852)),
    "neck": Island((0.25, 0.50, 0.89, 0.98), (0.350, 0.870, 0.700, 0.988)),
    "tongue": Island((0.62, 0.65, 0.925, 0.99), (0.640, 0.722, 0.700, 0.852)),
    "upper_teeth": Island((0.67, 0.745, 0.87, 0.8978), (0.722, 0.722, 0.988, 0.802)),
    "lower_teeth": Island((0.67, 0.745, 0.8978, 0.92), (0.722, 0.816, 0.988, 0.896)),
    "right_socket": Island((0.0, 0.081, 0.54, 0.64), (0.722, 0.910, 0.800, 0.988)),
    "left_socket": Island((0.081, 0.16, 0.54, 0.64), (0.816, 0.910, 0.894, 0.988)),
}


def magnify(t: np.ndarray, centre: float, width: float, gain: float) -> np.ndarray:
    """Map [0, 1] to itself, stretched by up to ``1 + gain`` (before scaling) around `centre`."""
    knots = np.linspace(0.0, 1.0, 2001)
    density = 1.0 + gain * np.exp(-(((knots - centre) / width) ** 2))
    total = np.concatenate([[0.0], np.cumsum((density[1:] + density[:-1]) / 2.0)])
    return np.interp(t, knots, total / total[-1])


def unit_square(uv: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Scale both columns to [0, 1]; return them apart."""
    low, high = uv.min(0), uv.max(0)
    scaled = (uv - low) / (high - low)
    return scaled[:, 0], scaled[:, 1]


def place_face(uv: np.ndarray) -> np.ndarray:
    """Turn the face upright and stretch it around the mouth and eyes."""
    down, right = unit_square(uv)
    right = magnify(right, 0.5, 0.13, 2.6)
    down = magnify(down, 0.745, 0.10, 1.5)
    return np.stack([right, down], 1)


def lay_out(uv: np.ndarray) -> np.ndarray:
    """Return the new texture positions.

    Parameters
    ----------
    uv : (T, 2) float64
        Positions in the source chart, v up; points in no island come out as NaN.

    Returns
    -------
    placed : (T, 2) float64
        Positions as fractions of the texture, v down from the top.
    """
    placed = np.full(uv.shape, np.nan)
    for name, island in ISLANDS.items():
        u0, u1, v0, v1 = island.box
        inside = (uv[:, 0] > u0) & (uv[:, 0] <= u1) & (uv[:, 1] > v0) & (uv[:, 1] <= v1)
        if name == "face":
            local = place_face(uv[inside])
        else:
            across, up = unit_square(uv[inside])
            local = np.stack([across, 1.0 - up], 1)
        left, top, right, bottom = island.place
        placed[inside] = local * [right - left, bottom - top] + [left, top]
    return placed
