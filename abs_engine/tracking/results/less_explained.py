"""Frames that are explained less well than the rest of their clip, and the doubt that this throws.

What lies over the lips for a while, such as text, a cup or a hand, may look like teeth and a dark
mouth, to colours and landmarks alike. It explains less of the picture than the mouth did.
"""

from __future__ import annotations

from collections.abc import Mapping
from statistics import NormalDist
from typing import Any

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.arrays import BoolArray, FloatArray, IntArray
from abs_engine.fit.settings import BELIEF
from abs_engine.io.assets import CLOSED_APERTURE
from abs_engine.tracking.settings.doubts import DOUBTS

PARTLY = (
    "in {} of {} tracked frames, between frames {} and {}, the drawn mouth explains less of the "
    "picture than in most: text, a hand or the like may lie over the lips, or they are blurred, or "
    "open very wide; there aperture_sd is larger; less_explained in results.csv marks them, and a "
    "frame on the contact sheet: look at them in the overlay, which does not"
)
_NORMAL, _LEAST = NormalDist(), 1e-12


def shortfall(score: FloatArray) -> FloatArray:
    """By how much less of frames (T,) is explained than of the median one.

    The score is a share of the picture, NaN where it is not known: such frames fall short by 0.
    """
    known = np.isfinite(score)
    enough = known.sum() >= DOUBTS.fewest
    usual = float(np.median(score[known])) if enough else 0.0
    return np.where(known, np.maximum(usual - score, 0.0), 0.0)


def less_explained(short: FloatArray) -> BoolArray:
    """Whether frames (T,) fall so short that their apertures are doubtful."""
    return np.asarray(short > DOUBTS.less_explained)


def doubted(beliefs: Mapping[str, NDArray[Any]], short: FloatArray) -> dict[str, FloatArray]:
    """Deviations of apertures, mm, and probabilities of closed lips, where frames (T,) fall short.

    Both are taken from `beliefs`, where they are as the frames by themselves have them.
    """
    own, closed, aperture = (beliefs[k] for k in ("aperture_sd", "closed_probability", "aperture"))
    free, growth = BELIEF.unexplained
    wider = np.hypot(own, growth * np.maximum(short - free, 0.0))
    less = closed.copy()
    for k in np.flatnonzero(wider > own):  # the limit lies as far away, in fewer deviations
        off = CLOSED_APERTURE - float(aperture[k])
        if aperture[k] <= 0.0:  # how far lips press stands in the probability alone
            off = float(own[k]) * _NORMAL.inv_cdf(min(max(float(closed[k]), _LEAST), 1 - _LEAST))
        less[k] = _NORMAL.cdf(off / float(wider[k]))
    return {"aperture_sd": wider, "closed_probability": less}


def partly_explained(less: BoolArray, index: IntArray) -> list[str]:
    """Warning that some tracked frames are explained less than most, if more than a few are.

    `less` (N,) says which of them, `index` (N,) their numbers in the video.
    """
    if not less.any() or less.mean() <= DOUBTS.most_less_explained:
        return []
    first, last = index[less][[0, -1]]
    return [PARTLY.format(int(less.sum()), len(less), first, last)]
