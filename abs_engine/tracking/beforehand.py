"""What tracking loads that takes a while, and can be loaded beside the import of its modules."""

from __future__ import annotations

import cv2
import numpy as np

from abs_engine.core.errors import AbsEngineError
from abs_engine.io.assets import load_speaker


def load() -> None:
    """Load the bundled head, and have OpenCV make its tables for L*a*b*: 0.1 s each.

    Whoever needs the head says what is wrong with it.
    """
    cv2.cvtColor(np.zeros((1, 1, 3), np.uint8), cv2.COLOR_RGB2LAB)
    try:
        load_speaker()
    except AbsEngineError:
        return
