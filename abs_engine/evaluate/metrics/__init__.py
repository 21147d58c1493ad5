"""Numbers that say how far a track is from the truth, each with its definition and source.

Lengths in mm. Points are (T, N, 3): T frames of N points. A point that is not finite was not given
in that frame, and each frame is scored by the points given. A frame without any was not tracked; it
is left out of every mean, and counted as a failure.
"""

from abs_engine.evaluate.metrics.bootstrap import Mean, block_length, confidence, value
from abs_engine.evaluate.metrics.closure import (
    closed_intervals,
    closure_events,
    match_events,
)
from abs_engine.evaluate.metrics.curves import correlation, lip_curves, spikes
from abs_engine.evaluate.metrics.failure import covered, failed
from abs_engine.evaluate.metrics.pixels import interocular, normalised_error, pixel_error
from abs_engine.evaluate.metrics.points import (
    acceleration_error,
    noise_level,
    squared_distance,
    to_camera,
    to_head,
    vertex_rms,
    without_constant_offset,
)
from abs_engine.evaluate.metrics.pose import head_angle, head_angle_without_offset, head_distance

__all__ = [
    "Mean", "acceleration_error", "block_length", "closed_intervals", "closure_events",
    "confidence", "correlation", "covered", "failed", "head_angle", "head_angle_without_offset",
    "head_distance", "interocular", "lip_curves", "match_events", "noise_level",
    "normalised_error", "pixel_error", "spikes", "squared_distance", "to_camera", "to_head",
    "value", "vertex_rms", "without_constant_offset",
]  # fmt: skip
