"""Search for garbage: seldom, as imports make many objects that stay, and hardly any cycles."""

from __future__ import annotations

import atexit
import gc

_SELDOM = 20_000, 20, 20


def collect_seldom() -> None:
    """Have this process look for cycles seldom, and not once more as it ends."""
    gc.set_threshold(*_SELDOM)
    atexit.register(gc.freeze)
