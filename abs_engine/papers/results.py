"""Numbers of a reproduction's nested results, `results.json`."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

Results = Mapping[str, Any]


def number(results: Results, key: str) -> float | None:
    """A finite number of nested results by its dotted key, or None."""
    value: Any = results
    for part in key.split("."):
        value = value.get(part) if isinstance(value, Mapping) else None
    return finite(value)


def finite(value: object) -> float | None:
    """A value as a finite number, or None."""
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        return None
    return float(value)
