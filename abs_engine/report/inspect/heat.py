"""Numbers painted on the face: errors in millimetres, say."""

from __future__ import annotations

import zipfile
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from abs_engine.core.arrays import FloatArray, Image
from abs_engine.core.errors import InputFileError, ParameterError
from abs_engine.core.scene import Renderer
from abs_engine.io.inputs import MOST, check_file
from abs_engine.io.npz import BROKEN, read_arrays
from abs_engine.report.drawing.colours import HEAT_COLOURS
from abs_engine.report.drawing.layout import beside
from abs_engine.report.drawing.legend import colour_bar
from abs_engine.report.drawing.paint import paint, value_coat
from abs_engine.report.drawing.palette import rounded_up
from abs_engine.report.drawing.view import View, views_of
from abs_engine.report.inspect.body import Body

HEAT_AMBIENT = 0.8
"""Much of the light comes from everywhere, so that colours can be compared with the bar."""
HEAT_TURNS = (-40.0, 0.0, 40.0)


def read_values(path: Path, vertices: int) -> FloatArray:
    """Read one number for each vertex, (V,) float64.

    Parameters
    ----------
    path : Path
        A ``.npy``, or a ``.npz`` that holds one array, or one of the name ``values``.
    vertices : int
        How many numbers there have to be.

    Raises
    ------
    InputFileError
        If the file is missing or is no such file.
    ParameterError
        If there are too few or too many numbers, or one is not finite.
    """
    path = Path(path)
    check_file(path)
    try:
        if zipfile.is_zipfile(path):
            arrays = read_arrays(path)
        else:  # its size is that of the file
            arrays = {"values": np.asarray(np.load(path, allow_pickle=False, mmap_mode="r"))}
    except (*BROKEN, InputFileError) as error:
        raise InputFileError(f"{path} holds no numbers", "give a .npy or .npz of floats") from error
    if len(arrays) > 1 and "values" not in arrays:
        raise InputFileError(f"{path} holds several arrays", "name the one to show 'values'")
    values = arrays.get("values", next(iter(arrays.values()), np.zeros(0)))
    if values.dtype.kind not in "fiu":
        raise InputFileError(f"{path} holds {values.dtype}", "give a .npy or .npz of floats")
    values = values.astype(np.float64)
    if values.shape != (vertices,):
        shape = "x".join(map(str, values.shape)) or "one"
        raise ParameterError(
            f"{path} holds {shape} numbers, the head has {vertices} vertices",
            "give one number for each vertex",
        )
    if not (np.abs(values) <= MOST).all():
        raise ParameterError(
            f"{path} holds NaN, infinity or numbers beyond {MOST:g}", "give finite numbers"
        )
    return values


def heat_limits(values: FloatArray, largest: float | None) -> tuple[float, float]:
    """From 0, or the least where it is negative, to `largest` or the greatest, rounded up."""
    low = min(0.0, float(values.min()))
    high = largest if largest is not None else rounded_up(float(values.max()))
    if not low < high < np.inf:
        raise ParameterError(f"the scale ends at {high:g}, where it begins", "give a greater --max")
    return low, high


def heat_pictures(
    renderer: Renderer,
    body: Body,
    values: FloatArray,
    views: Sequence[View],
    limits: tuple[float, float],
) -> list[Image]:
    """The head with numbers (V,) painted on it, in each view."""
    look = value_coat(values, limits, HEAT_COLOURS)
    return [paint(renderer, body, look, view, ambient=HEAT_AMBIENT) for view in views]


def heat_map(
    renderer: Renderer,
    body: Body,
    values: FloatArray,
    size: tuple[int, int],
    *,
    text: str = "error, mm",
    largest: float | None = None,
) -> Image:
    """Numbers on the face from several sides, with a colour bar, (H, W, 3) uint8 RGB.

    Parameters
    ----------
    values : (V,) float64
    size : tuple of int
        Width and height of each view, pixels.
    text : str
        What the numbers are, and their unit.
    largest : float, optional
        The end of the scale; by default the greatest value, rounded up.
    """
    limits = heat_limits(values, largest)
    views = views_of(body.vertices, size, HEAT_TURNS)
    pictures = heat_pictures(renderer, body, values, views, limits)
    return beside([*pictures, colour_bar(HEAT_COLOURS, limits, text, size[1])])
