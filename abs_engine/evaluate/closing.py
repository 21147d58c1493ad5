"""Closed lips of an estimate, and of the truth measured in the same way.

Lips that all but touch count as closed or not by a hair's breadth. So the truth is measured as the
estimate is, by the aperture in space or in the picture: perfect results are then perfect, whatever
they give, and nothing is won by noise, as the truth does not depend on the estimate.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.arrays import BoolArray, FloatArray
from abs_engine.dataset import Truth
from abs_engine.evaluate import metrics
from abs_engine.evaluate.estimate import Estimate
from abs_engine.evaluate.measures import true_pixels
from abs_engine.io.assets import CLOSED_APERTURE

_IN_PICTURE = 36, 45, 62, 66  # by which `closed_in_picture` measures

Closures = tuple[BoolArray, BoolArray]
"""Frames (T,) that are called closed, and those that are."""


def closures(
    said: Estimate, truth: Truth, aperture: FloatArray, landmark_68: NDArray[Any] | None
) -> Closures | None:
    """Closed frames of an estimate and of the truth, by the measure that `closed_by` names.

    None where the estimate does not say.

    Parameters
    ----------
    aperture : (T,) float64, mm
        Of the truth, measured as the estimate's.
    landmark_68 : (68,) int, optional
        The landmarks on the truth's mesh.
    """
    if said.closed is None:
        return None
    true: BoolArray | None = np.asarray(truth.closed, np.bool_)
    if said.closed_by == "aperture":
        true = narrow(aperture)
    elif said.closed_by == "picture" and landmark_68 is not None:
        marks = np.asarray(truth.neutral[landmark_68], np.float64)
        true = closed_in_picture(true_pixels(truth, landmark_68), marks)
    return None if true is None else (said.closed, true)


def unsaid(said: Estimate) -> BoolArray:
    """Frames (T,) that are lost, or lack the points by which lips are measured to be closed."""
    lacking = ~said.found
    if said.closed_by == "aperture" and "aperture" in said.curves:
        lacking = lacking | np.isnan(said.curves["aperture"])
    elif said.closed_by == "picture" and said.pixels is not None:
        lacking = lacking | np.isnan(said.pixels[:, _IN_PICTURE]).any(axis=(1, 2))
    return np.asarray(lacking)


def narrow(aperture: FloatArray) -> BoolArray:
    """Frames (T,) with an aperture below `CLOSED_APERTURE`; not those where it is NaN."""
    return np.asarray(aperture < CLOSED_APERTURE)


def closed_in_picture(pixels: FloatArray, rest: FloatArray) -> BoolArray | None:
    """Frames (T,) in which the inner lips are less than `CLOSED_APERTURE` apart in the picture.

    Point 62 above point 66, square to the line of the eyes. The distance of the outer corners of
    the eyes is the ruler; the person's own is known in mm. None without these points.

    Parameters
    ----------
    pixels : (T, 68, 2) float64
    rest : (68, 3) float64, mm
        The person's landmarks at rest.
    """
    eyes = metrics.interocular(pixels)
    along = (pixels[:, 45] - pixels[:, 36]) / eyes[:, None]
    up = np.stack([along[:, 1], -along[:, 0]], axis=1)  # y of the picture points down
    gap = ((pixels[:, 62] - pixels[:, 66]) * up).sum(axis=1) / eyes
    if not np.isfinite(gap).any():
        return None
    return narrow(gap * metrics.interocular(rest[None])[0])
