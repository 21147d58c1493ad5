"""Colour features of pixels, and the names of the classes that are learned from them.

Basu et al. (section 5.1) learn skin and lips in chromatic space (r, g). Lips that part are told
by neither class: teeth and the dark of the mouth are classes of their own here, and need
luminance; so all classes live in (r, g, y), y the logarithm of luminance relative to the skin.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.arrays import FloatArray
from abs_engine.face.appearance.luminance import luminance

CLASSES = ("skin", "lips", "teeth", "dark")
EACH_LIP = ("upper_lip", "lower_lip")


def features(image: NDArray[np.generic], reference: float) -> FloatArray:
    """Colour features (..., 3) of an image (..., 3), RGB 0 to 255.

    r, g (chromaticity; (R + 1) / (R + G + B + 3), which is 1/3 at black) and a third of the natural
    logarithm of luminance relative to `reference`, the skin's, so that the three have like spreads.
    """
    rgb = np.asarray(image, np.float64)
    red, green, blue = np.moveaxis(rgb, -1, 0)
    total = red + green + blue + 3
    relative = np.log((luminance(rgb) + 2) / (reference + 2)) / 3
    return np.stack([(red + 1) / total, (green + 1) / total, relative], axis=-1)
