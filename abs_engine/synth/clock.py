"""What a frame costs, by part."""

from __future__ import annotations

import time
from collections import defaultdict
from collections.abc import Iterator
from contextlib import contextmanager


class Clock:
    """Sums of processor seconds, all threads of this process, by what they were spent on."""

    def __init__(self) -> None:
        self.seconds: defaultdict[str, float] = defaultdict(float)

    @contextmanager
    def part(self, name: str) -> Iterator[None]:
        """Count the processor time inside as that of `name`."""
        start = time.process_time()
        try:
            yield
        finally:
            self.seconds[name] += time.process_time() - start


def cost_lines(seconds: dict[str, float], frames: int) -> list[str]:
    """A table: milliseconds of one core that a frame took, by part, the dearest first."""
    total = sum(seconds.values())
    rows = sorted(seconds.items(), key=lambda item: -item[1])
    each = 1000 / max(frames, 1)
    lines = [f"{name:12} {value * each:7.1f} ms" for name, value in rows]
    return [*lines, f"{'all':12} {total * each:7.1f} ms of one core a frame, {frames} frames"]
