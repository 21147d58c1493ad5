"""Numbers of vertices, to be painted on the face: errors in millimetres, say."""

from __future__ import annotations

import zipfile
from pathlib import Path

import numpy as np

from abs_engine.core.arrays import FloatArray
from abs_engine.core.errors import InputFileError, ParameterError
from abs_engine.io.inputs import MOST, check_file
from abs_engine.io.npz import BROKEN, read_arrays
from abs_engine.report.drawing.palette import rounded_up


def read_values(path: Path, vertices: int) -> FloatArray:
    """Read one number for each vertex, (V,) float64.

    Parameters
    ----------
    path : Path
        A ``.npy``, or a ``.npz`` that holds one array, or one of the name ``values``.

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
        raise ParameterError(
            f"the scale begins at {low:g} and ends at {high:g}", "give a greater --max"
        )
    return low, high
