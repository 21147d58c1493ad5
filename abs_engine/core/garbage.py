"""Garbage collection, done seldom: imports make many objects that stay, and hardly any cycles."""

from __future__ import annotations

import atexit
import gc

_SELDOM = 20_000, 20, 20


def collect_seldom() -> None:
    """Make Python collect garbage seldom from now on, and not as the process ends."""
    gc.set_threshold(*_SELDOM)
    atexit.register(gc.freeze)
