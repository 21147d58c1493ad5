"""The PNG files of a dataset: RGB order, exact dtype and size."""

from __future__ import annotations

import struct
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from abs_engine.core.errors import InputFileError, ModelFormatError
from abs_engine.dataset.codec import PICTURES
from abs_engine.io.pictures import is_whole

AGAIN = "make the dataset again, or copy the whole folder again"
_CHANNELS = {0: 1, 2: 3}  # PNG colour types: grey, RGB
# Trying all filters on every row takes twice as long, and files are no smaller
_QUICKLY = (*(cv2.IMWRITE_PNG_COMPRESSION, 1), *(cv2.IMWRITE_PNG_FILTER, cv2.IMWRITE_PNG_FILTER_UP))


def write_picture(path: Path, values: NDArray[Any]) -> None:
    """Write (H, W) or (H, W, 3) RGB, uint8 or uint16, as PNG."""
    ordered = values if values.ndim == 2 else values[..., ::-1]
    # not imwrite, which ends the process where a path is no UTF-8
    path.write_bytes(cv2.imencode(".png", np.ascontiguousarray(ordered), _QUICKLY)[1].tobytes())


def read_picture(path: Path, kind: str, size: tuple[int, int]) -> NDArray[Any]:
    """Read a PNG of a kind that `codec.PICTURES` names.

    Parameters
    ----------
    size : tuple of int
        Width and height that it must have.

    Returns
    -------
    (H, W) or (H, W, 3) RGB, uint8 or uint16

    Raises
    ------
    InputFileError
        If it is missing or cannot be read.
    ModelFormatError
        If it has another size, depth or number of channels.
    """
    dtype, channels = PICTURES[kind]
    if picture_header(path)[:2] != size:  # before memory is taken for it
        raise ModelFormatError(f"{path} is not {size[0]}x{size[1]}", AGAIN)
    held = np.fromfile(path, np.uint8)
    image = cv2.imdecode(held, cv2.IMREAD_UNCHANGED) if is_whole(held.tobytes()) else None
    if image is None:
        raise InputFileError(f"{path} is not a whole picture", AGAIN)
    shape = (size[1], size[0]) if channels == 1 else (size[1], size[0], channels)
    if image.dtype != dtype or image.shape != shape:
        raise ModelFormatError(
            f"{path} is {image.shape} {image.dtype}, wanted {shape} {np.dtype(dtype)}", AGAIN
        )
    return image if channels == 1 else np.ascontiguousarray(image[..., ::-1])


def picture_header(path: Path) -> tuple[int, int, int, int]:
    """Width, height, bits and channels of a PNG, from its first bytes.

    Raises
    ------
    InputFileError
        If it is missing or no PNG of these kinds.
    """
    if not path.is_file():
        raise InputFileError(f"{path} is missing", AGAIN)
    try:
        with path.open("rb") as file:
            head = file.read(26)
    except OSError as error:
        raise InputFileError(f"{path} cannot be read ({error.strerror})", AGAIN) from error
    if len(head) < 26 or head[:8] != b"\x89PNG\r\n\x1a\n" or head[25] not in _CHANNELS:
        raise InputFileError(f"{path} is not a PNG picture", AGAIN)
    width, height, bits, colour = struct.unpack(">IIBB", head[16:26])
    return int(width), int(height), int(bits), _CHANNELS[colour]
