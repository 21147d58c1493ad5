"""Frames in which a tracker failed."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

LIMIT_MM = 5.0
"""RMS error of the lips, mm, above which a frame counts as failed."""

LIMIT_NORMALISED = 0.08
"""Mean point error over the distance of the eyes above which a frame counts as failed."""


def failed(error: ArrayLike, limit: float) -> NDArray[np.bool_]:
    """Frames (T,) that were lost (error not finite) or whose error is above the limit.

    The failure rate of 300-VW (Shen et al., The first facial landmark tracking in-the-wild
    challenge, ICCV workshops (2015)), whose limit is `LIMIT_NORMALISED`; `LIMIT_MM` is ours.
    """
    given = np.asarray(error, np.float64)
    return np.asarray(~np.isfinite(given) | (given > limit))
