"""Results of a reproduction: while they are collected, and numbers of `results.json`."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import KW_ONLY, dataclass, field
from pathlib import Path
from typing import Any

from abs_engine.core.scene import Renderer
from abs_engine.io.assets import Speaker

Results = Mapping[str, Any]
MISSING = "not measured"


@dataclass
class Reproduction:
    """A reproduction under way: what it is made with, and what was found.

    Parameters
    ----------
    kept : Path
        Gets what is finished, and the fits of what is under way, frame by frame; has those of an
        interrupted run.
    tell : callable
        Called with what is begun.
    figures : list of (str, str)
        Address and caption.
    """

    folder: Path
    kept: Path
    renderer: Renderer
    speaker: Speaker
    seed: int
    tell: Callable[[str], None]
    _: KW_ONLY
    results: dict[str, Any] = field(default_factory=dict)
    figures: list[tuple[str, str]] = field(default_factory=list)

    def figure(self, name: str, content: bytes, caption: str) -> None:
        """Write a figure."""
        (self.folder / name).write_bytes(content)
        self.figures.append((name, caption))


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
