"""Sentences about scores that may mislead: of another clip, or of another person's head."""

from __future__ import annotations

from collections.abc import Mapping

from abs_engine.evaluate.metrics.failure import LIMIT_MM, LIMIT_NORMALISED
from abs_engine.evaluate.score import PRIMARY, Score

FAR_MM = 50.0
"""RMS error above which a file is most likely of another view."""
_MOST_FAILED = 0.5  # share of the frames; fewer are not explained


def doubts(scores: Mapping[str, Score]) -> tuple[str, ...]:
    """A question, if the numbers are such as those of another view would be.

    Results that fit the picture are of this view, however far off they are in space.
    """
    seen = [scores[key].value for key in ("landmarks_nme", "lips_nme") if key in scores]
    if any(error <= LIMIT_NORMALISED for error in seen):
        return ()
    failed = scores["failure_share"].value
    far = [s.value for key, s in scores.items() if key.endswith(("_rms_head_mm", "_rms_camera_mm"))]
    if failed == 1:
        return ("every frame failed: is this the clip and camera?",)
    if max(far, default=0.0) > FAR_MM:
        return (f"it is {max(far):.0f} mm (RMS) from the truth: is this the clip and camera?",)
    return ()


def offsets(scores: Mapping[str, Score]) -> tuple[str, ...]:
    """A sentence, if most frames failed by one constant offset, as with another person's head."""
    key = next((f"{name}_rms_head_mm" for name in PRIMARY if f"{name}_rms_head_mm" in scores), "")
    removed = key.replace("_mm", "_offset_removed_mm")
    if removed not in scores:
        return ()
    frames, lost = (scores[name].value for name in ("frames", "frames_lost"))
    tracked = scores["failure_share"].value - lost / max(frames, 1.0)
    off, rest = scores[key].value, scores[removed].value
    if tracked <= _MOST_FAILED or not rest <= min(LIMIT_MM, off / 2) or off <= LIMIT_MM:
        return ()
    return (
        f"frames failed by one constant offset: points are {off:.1f} mm off in head coordinates, "
        f"{rest:.1f} mm once it is removed; with a head that is not the filmed person's own, read "
        "the rows in which it is removed",
    )
