"""Pictures in files: refused by their stated size before memory is taken, then read."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray
from PIL import Image as Pillow

from abs_engine.core.errors import InputFileError

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
    try:
        with Pillow.open(path) as picture:
            fits = picture.width * picture.height <= MOST_PIXELS
        image = cv2.imread(str(path), cv2.IMREAD_COLOR) if fits and is_whole(path) else None
    except (OSError, ValueError, Pillow.DecompressionBombError) as error:
        raise InputFileError(
            f"{path} is not a readable picture", "give a PNG or JPEG file"
        ) from error
    if image is None:
        raise InputFileError(
            f"{path} is not a readable picture of at most {MOST_PIXELS / 1e6:.0f} megapixels",
            "give a PNG or JPEG file",
        )
    return np.asarray(cv2.cvtColor(image, cv2.COLOR_BGR2RGB), np.uint8)


def is_whole(path: Path) -> bool:
    """Whether no chunk of a PNG is longer than the file; OpenCV takes what memory one states."""
    data = path.read_bytes()
    if not data.startswith(_PNG):
        return True
    at = len(_PNG)
    while at < len(data) and data[at + 4 : at + 8] != b"IEND":
        at += 12 + int.from_bytes(data[at : at + 4])  # length, kind and checksum beside the content
    return at < len(data)
