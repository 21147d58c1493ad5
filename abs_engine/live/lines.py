"""The line of a live frame, as values of JSON."""

from __future__ import annotations

import math
from typing import Any

from abs_engine.live.release import Released
from abs_engine.tracking.frame_rows import BELIEVED, believed
from abs_engine.tracking.measures import ANGLES, angles
from abs_engine.tracking.run_table import closed_frames

_DIGITS = 4


def told(released: Released) -> dict[str, Any]:
    """A frame's line: names and units as in ``results.csv``; null where a number is not known."""
    shot, result = released.shot, released.result
    numbers = {
        "score": result.score,
        **{name: getattr(result, name) for name in BELIEVED},
        **{f"{name}_sd": float(believed(result, f"{name}_sd")) for name in BELIEVED},
        "closed_probability": float(believed(result, "closed_probability")),
        **dict(zip(ANGLES, angles(result.pose), strict=True)),
    }
    return {
        "index": shot.index,
        "time": round(shot.time, _DIGITS),
        "found": result.found,
        "status": result.status,
        "closed": bool(closed_frames(result.aperture)) if result.found else None,
        **{name: _number(value) for name, value in numbers.items()},
        "delay_ms": round(1e3 * released.delay, 1),
        "dropped": released.dropped,
    }


def _number(value: float) -> float | None:
    return round(float(value), _DIGITS) if math.isfinite(value) else None
