"""Paint the textures of all people and write them."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import paint_inside
import paint_skin
from paint_look import LOOKS
from paint_maps import texels, to_image

SIZE = 1024
QUALITY = 93


def paint_people(arrays: dict[str, np.ndarray], folder: Path) -> None:
    """Write one texture for each person."""
    at = texels(arrays, SIZE)
    marks = paint_skin.Marks.of(arrays)
    for number, name in enumerate(arrays["people_names"].tolist()):
        look, seed = LOOKS[name], 1000 * (number + 1)
        colour = paint_skin.paint(at, marks, look, seed)
        paint_inside.paint(colour, at, arrays, look, seed + 500)
        image = to_image(at, colour)
        flags = [
            cv2.IMWRITE_JPEG_QUALITY,
            QUALITY,
            cv2.IMWRITE_JPEG_SAMPLING_FACTOR,
            cv2.IMWRITE_JPEG_SAMPLING_FACTOR_444,
        ]
        cv2.imwrite(str(folder / f"texture_{name}.jpg"), image[:, :, ::-1], flags)
