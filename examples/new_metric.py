"""A new metric: the error of the mouth's height over its width, which depends on no scale.

Try it: abs-engine evaluate RUN --truth DIR --plugin examples/new_metric.py
"""

import numpy as np

from abs_engine import METRICS, Metric, Truth


def error(estimate, truth: Truth) -> np.ndarray:
    """The squared difference of the ratios in each frame; NaN where the system gives none."""
    if not {"aperture", "width"} <= set(estimate.curves):
        return np.full(len(truth), np.nan)
    found = estimate.curves["aperture"] / estimate.curves["width"]
    return (found - truth.aperture / truth.width) ** 2


METRICS.add(
    "openness_rms",
    Metric(
        "openness_rms", "aperture over width, RMS", "", "root mean square difference of the ratios",
        error, root=True,
    ),
)  # fmt: skip
