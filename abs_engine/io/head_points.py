"""The frozen vertex lists of a head, in a file beside it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.errors import InputFileError, ModelFormatError
from abs_engine.io.arrays import check_arrays, index, of_json
from abs_engine.io.inputs import check_file, read_json

POINTS, POINTS_FORMAT, POINTS_VERSIONS = "points.json", "abs_engine.points", (1, 2)


def load_points(path: Path, vertices: int, faces: int) -> dict[str, NDArray[np.int32]]:
    """Read the frozen vertex lists of a head with that many vertices and faces; empty without one.

    Raises
    ------
    InputFileError
        If the file is no JSON.
    ModelFormatError
        If it has another format or version, or belongs to another mesh.
    """
    if not path.is_file():
        return {}
    check_file(path)
    again = "make it again with assets/speaker_points.py"
    try:
        told = read_json(path)
        kind, version = (told["format"], told["vertices"], told["faces"]), told["version"]
        lists = {k: of_json(v["vertices"]) for k, v in told["lists"].items()}
    except (OSError, ValueError, KeyError, TypeError, AttributeError) as error:
        raise InputFileError(f"{path} is not a list of points", again) from error
    known = all(type(told[k]) is int for k in ("vertices", "faces", "version"))
    if not known or kind != (POINTS_FORMAT, vertices, faces) or version not in POINTS_VERSIONS:
        raise ModelFormatError(f"{path} has another format or belongs to another mesh", again)
    return check_arrays(path, lists, {k: index("V", k) for k in lists}, again, V=vertices)
