"""Reads live frames in a thread; of those that nobody has taken, only the newest is kept."""

from __future__ import annotations

import threading
from collections.abc import Iterator

from abs_engine.core.errors import AbsEngineError, VideoError
from abs_engine.live.feed import Feed, size_of
from abs_engine.tracking.frame.frame_state import Shot


class Reader:
    """Reads a feed from now on.

    Attributes
    ----------
    count : int
        Frames so far.
    start : float
        When the first was taken, by `time.monotonic`: times of shots count from there.
    ended, stopped : bool
        Whether there are no more, the newest may still wait to be taken; and whether by `stop`.
    error : AbsEngineError or None
        Why, where the feed broke off or a fault stopped it.
    """

    def __init__(self, feed: Feed) -> None:
        self.count, self.start = 0, float("nan")
        self.ended = self.stopped = False
        self.error: AbsEngineError | None = None
        self._feed = feed
        self._changed = threading.Condition()
        self._newest: Shot | None = None
        self._kept: list[Shot] | None = []  # from the first on
        threading.Thread(target=self._run, name="reader", daemon=True).start()

    def collect(self, seconds: float) -> tuple[Shot, ...]:
        """All frames of the next seconds, at first of the first ones; fewer where they end."""

        def enough() -> bool:
            kept = self._kept or ()
            return self.ended or (len(kept) > 1 and kept[-1].time - kept[0].time >= seconds)

        with self._changed:
            self._kept = [] if self._kept is None else self._kept
            self._changed.wait_for(enough)
            kept, self._kept = self._kept, None
        return tuple(kept)

    def shots(self) -> Iterator[Shot]:
        """The newest frame, each time it is asked for one."""
        while True:
            with self._changed:
                self._changed.wait_for(lambda: self._newest is not None or self.ended)
                shot, self._newest = self._newest, None
            if shot is None:
                return
            yield shot

    def stop(self, why: AbsEngineError | None = None) -> None:
        """Take no more frames, for the reason of a fault if one is given."""
        with self._changed:
            self.error = self.error or why
            self.ended = self.stopped = True
            self._newest = None
            self._changed.notify_all()

    def _run(self) -> None:
        try:
            for image, taken in self._feed.frames():
                if size_of(image) != self._feed.size:
                    raise VideoError(f"{self._feed.name} has changed its size", "start again")
                self.start = taken if self.count == 0 else self.start
                shot = Shot(image, self.count, taken - self.start)
                with self._changed:
                    if self.ended:
                        return
                    self.count += 1
                    self._newest = shot
                    if self._kept is not None:
                        self._kept.append(shot)
                    self._changed.notify_all()
        except AbsEngineError as error:
            self.error = self.error if self.stopped else error
        except BaseException as error:
            if self.stopped:
                return
            self.error = VideoError(f"{self._feed.name} breaks off ({error!r})", "start again")
            raise
        finally:
            with self._changed:
                self.ended = True
                self._changed.notify_all()
