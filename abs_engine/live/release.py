"""Hands results on at a constant delay after their frames were taken; late ones are dropped.

Where a dropped frame begins another shot, the next one that is handed on does.
"""

from __future__ import annotations

import queue
import threading
import time
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, replace
from math import isfinite
from typing import Any

from abs_engine.tracking.frame.clip_setting import FrameResult
from abs_engine.tracking.frame.frame_state import Shot
from abs_engine.tracking.results.frame_rows import BELIEVED, believed
from abs_engine.tracking.results.measures import ANGLES, angles
from abs_engine.tracking.results.run_table import closed_frames

RECENT = 25  # results that `Release.took` remembers
_DIGITS = 4
_DEVIATIONS = tuple(f"{name}_sd" for name in BELIEVED)
_Waiting = tuple[Shot, FrameResult, bool]
"""A frame, its result, and whether that came in time."""


@dataclass(frozen=True, eq=False)
class Released:
    """A result as it is handed on.

    Parameters
    ----------
    delay : float
        Seconds since the frame was taken.
    dropped : int
        Frames before it that were not handed on.
    """

    shot: Shot
    result: FrameResult
    delay: float
    dropped: int

    def line(self) -> dict[str, Any]:
        """A line of JSON: names and units as in ``results.csv``; null where a number is unknown."""
        shot, result = self.shot, self.result
        numbers = {
            "score": result.score,
            **{name: getattr(result, name) for name in BELIEVED},
            **{name: believed(result, name) for name in (*_DEVIATIONS, "closed_probability")},
            **dict(zip(ANGLES, angles(result.pose), strict=True)),
        }
        return {
            "index": shot.index,
            "time": round(shot.time, _DIGITS),
            "found": result.found,
            "status": result.status,
            "closed": bool(closed_frames(result.aperture)) if result.found else None,
            **{k: round(float(v), _DIGITS) if isfinite(v) else None for k, v in numbers.items()},
            "delay_ms": round(1e3 * self.delay, 1),
            "dropped": self.dropped,
        }


class Release:
    """Hands results on from a thread of its own; a context manager that waits for the last.

    Parameters
    ----------
    start : float
        What times of shots count from, by `time.monotonic`.
    delay : float
        Seconds from a frame to its result. What is not there by then is dropped.
    hand_on : callable
        Given each result in its time.

    Attributes
    ----------
    count : int
        Results that were handed on.
    took : deque of float
        Seconds from frame to result, of the last ones; also of those that came too late.
    """

    def __init__(self, start: float, delay: float, hand_on: Callable[[Released], None]) -> None:
        self.count = 0
        self.took: deque[float] = deque(maxlen=RECENT)
        self._start, self._delay, self._hand_on = start, delay, hand_on
        self._waiting: queue.SimpleQueue[_Waiting | None] = queue.SimpleQueue()
        self._cut = False  # by a frame that was not handed on
        self._error: BaseException | None = None
        self._thread = threading.Thread(target=self._run, name="release", daemon=True)
        self._thread.start()

    def add(self, shot: Shot, result: FrameResult) -> None:
        """Take the next result.

        What handing on one before has raised is raised here.
        """
        if self._error is not None:
            raise self._error
        self.took.append(time.monotonic() - self._start - shot.time)
        self._waiting.put((shot, result, self.took[-1] <= self._delay))

    @property
    def mostly_late(self) -> bool:
        """True if most of the last results came too late."""
        late = sum(seconds > self._delay for seconds in self.took)
        return len(self.took) == RECENT and 2 * late > RECENT

    def _run(self) -> None:
        try:
            while (item := self._waiting.get()) is not None:
                self._release(*item)
        except BaseException as error:  # noqa: BLE001 - raised again by whoever adds
            self._error = error

    def _release(self, shot: Shot, result: FrameResult, in_time: bool) -> None:
        self._cut |= result.cut
        if not in_time:
            return
        taken = self._start + shot.time
        left = taken + self._delay - time.monotonic()
        if left > 0:
            time.sleep(left)
        delay = time.monotonic() - taken
        if delay > self._delay + _SLACK:
            return  # whoever takes them, or the machine, was too slow
        result = replace(result, cut=self._cut and self.count > 0)
        self._hand_on(Released(shot, result, delay, shot.index - self.count))
        self.count, self._cut = self.count + 1, False

    def __enter__(self) -> Release:
        return self

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        self._waiting.put(None)
        self._thread.join(None if kind is None else _PATIENCE)
        if kind is None and self._error is not None:
            raise self._error


_PATIENCE = 1.0  # seconds after an error, for whoever takes results
_SLACK = 0.025  # seconds by which a result may be handed on late
