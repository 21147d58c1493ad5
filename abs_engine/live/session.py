"""A live session: learns the person from the first frames with a face, then tracks the newest."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from abs_engine.core.errors import FaceNotFoundError
from abs_engine.core.scene import Renderer
from abs_engine.core.threads import closed_after
from abs_engine.io.video import VideoInfo
from abs_engine.live.feed import Feed
from abs_engine.live.reader import Reader
from abs_engine.live.release import Release, Released
from abs_engine.tracking.loop import track_shots
from abs_engine.tracking.options import ClipTracker, Tell, TrackOptions
from abs_engine.tracking.run import clip_of, prepare_clip


@dataclass(frozen=True)
class Pace:
    """How long a live session may take.

    Parameters
    ----------
    learn : float
        Seconds of the first frames with a face, from which the person is learned.
    delay : float
        Seconds from a frame to its result.
    """

    learn: float = 2.0
    delay: float = 0.12


def learned(
    feed: Feed, reader: Reader, renderer: Renderer, options: TrackOptions, pace: Pace, tell: Tell
) -> ClipTracker:
    """What is known of the person once a face was seen; frames that come meanwhile are dropped.

    Raises
    ------
    FaceNotFoundError
        If the feed ends before a face is seen.
    AbsEngineError
        As `prepare_clip`.
    """
    info = VideoInfo(feed.size, feed.rate, 0)
    waiting = False
    while True:
        shown = tuple(shot.image for shot in reader.collect(pace.learn))
        if not shown:
            raise reader.error or FaceNotFoundError(
                f"{feed.name} has ended before a face was seen", "show a frontal face for longer"
            )
        try:
            said = _nothing if waiting else tell
            return prepare_clip(
                clip_of(Path(feed.name), info, options, shown), renderer, options, said
            )
        except FaceNotFoundError:
            if not waiting:
                tell("no face is seen; waiting for one")
            waiting = True


def _nothing(_stage: str) -> None:
    """Say nothing."""


def follow(
    tracker: ClipTracker, reader: Reader, delay: float, hand_on: Callable[[Released], None]
) -> int:
    """Track the newest frame until there are no more; the number of results handed on."""
    with Release(reader.start, delay, hand_on) as release:
        found = track_shots(tracker.setting, reader.shots(), tracker.memory, depth=1)
        with closed_after(found):
            for shot, result in found:
                release.add(shot, result)
    return release.count
