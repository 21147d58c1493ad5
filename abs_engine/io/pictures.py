"""Pictures in files: refused by their stated size before memory is taken, then read."""

from __future__ import annotations

import io
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray
from PIL import Image as Pillow

from abs_engine.core.errors import InputFileError
from abs_engine.io.inputs import check_file

MOST_PIXELS = 1 << 26
"""Of a picture, or of a frame of a video."""
_PNG = b"\x89PNG\r\n\x1a\n"


def read_image(path: Path) -> NDArray[np.uint8]:
    """Read a picture as (H, W, 3) uint8 RGB.

    Raises
    ------
    InputFileError
        If it is missing, no picture, or larger than `MOST_PIXELS`.
    """
    check_file(path)
    image = decoded(path.read_bytes())
    if image is None:
        raise InputFileError(
            f"{path} is not a readable picture of at most {MOST_PIXELS / 1e6:.0f} megapixels",
            "give a PNG or JPEG file",
        )
    return image


def decoded(content: bytes) -> NDArray[np.uint8] | None:
    """A PNG or JPEG as (H, W, 3) uint8 RGB; None if it is none, or larger than `MOST_PIXELS`."""
    try:
        with Pillow.open(io.BytesIO(content)) as picture:
            fits = picture.width * picture.height <= MOST_PIXELS
    except (OSError, ValueError, Pillow.DecompressionBombError):
        return None
    if not fits or not is_whole(content):
        return None
    image = cv2.imdecode(np.frombuffer(content, np.uint8), cv2.IMREAD_COLOR)
    return None if image is None else np.asarray(cv2.cvtColor(image, cv2.COLOR_BGR2RGB), np.uint8)


def is_whole(data: bytes) -> bool:
    """Whether no chunk of a PNG is longer than the file; OpenCV takes what memory one states."""
    if not data.startswith(_PNG):
        return True
    at = len(_PNG)
    while at < len(data) and data[at + 4 : at + 8] != b"IEND":
        at += 12 + int.from_bytes(data[at : at + 4])  # length, kind and checksum beside the content
    return at < len(data)
