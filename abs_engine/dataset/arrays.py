"""Writes the NPZ files of a dataset, each with its `format` and `version`."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.errors import ParameterError
from abs_engine.dataset import codec


def write_truth(folder: Path, **arrays: Any) -> None:
    """Write the ``truth.npz`` of a clip; its arrays are those of the dataset card."""
    _write(folder / codec.TRUTH, codec.FORMAT, arrays)


def write_points(folder: Path, **arrays: Any) -> None:
    """Write the ``points.npz`` of a camera; its arrays are those of the dataset card."""
    _write(folder / codec.POINTS, codec.POINTS_FORMAT, arrays)


def write_chunk(folder: Path, first: int, offsets: NDArray[np.float16]) -> Path:
    """Write the offsets (n, V, 3) of frames [first, first + n) of the clip in `folder`.

    Raises
    ------
    ParameterError
        If they are not the frames of one chunk.
    """
    if first % codec.CHUNK or not 0 < len(offsets) <= codec.CHUNK:
        raise ParameterError(
            f"frames {first} to {first + len(offsets) - 1} are not a chunk",
            f"write at most {codec.CHUNK} frames from a multiple of {codec.CHUNK} on",
        )
    path = folder / codec.VERTICES / codec.chunk_name(first)
    path.parent.mkdir(exist_ok=True)
    _write(path, codec.OFFSETS_FORMAT, {"offsets": np.asarray(offsets, np.float16)})
    return path


def _write(path: Path, kind: str, arrays: dict[str, Any]) -> None:
    np.savez_compressed(path, format=kind, version=codec.VERSION, **arrays)
