"""A live session: learns the person from the first frames with a face, then tracks the newest."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from abs_engine.core.errors import FaceNotFoundError, VideoError
from abs_engine.core.scene import Renderer
from abs_engine.core.threads import closed_after
from abs_engine.core.words import joined
from abs_engine.io.video import VideoInfo
from abs_engine.live.feed import Feed
from abs_engine.live.reader import Reader
from abs_engine.live.release import Release, Released
from abs_engine.tracking.loop import track_shots
from abs_engine.tracking.options import ClipTracker, Tell, TrackOptions
from abs_engine.tracking.run import clip_of, prepare_clip


def learned(
    feed: Feed,
    reader: Reader,
    renderer: Renderer,
    options: TrackOptions,
    seconds: float,
    tell: Tell,
) -> ClipTracker:
    """Learn the person once a face is seen; frames that come meanwhile are dropped.

    Parameters
    ----------
    options : TrackOptions
        Of a head that is found from landmarks.
    seconds : float
        How long what is learned from lasts.
    tell : callable
        Called with what is begun, in a few words.

    Raises
    ------
    FaceNotFoundError
        If the feed ends before a face is seen.
    AbsEngineError
        As `prepare`.
    """
    info, waiting = VideoInfo(feed.size, feed.rate, 0), False
    while True:
        shown = tuple(shot.image for shot in reader.collect(seconds))
        if not shown:
            remedy = "show a whole frontal face for some seconds"
            raise reader.error or FaceNotFoundError(f"{feed.name} showed no face", remedy)
        clip = clip_of(Path(feed.name), info, options, shown)
        try:
            return prepare_clip(clip, renderer, options, (lambda _stage: None) if waiting else tell)
        except FaceNotFoundError:
            if not waiting:
                tell("no face is seen; waiting for one")
            waiting = True


def follow(
    tracker: ClipTracker,
    reader: Reader,
    delay: float,
    hand_on: Callable[[Released], None],
    tell: Tell,
    *,
    known: bool,
) -> int:
    """Track the newest frame until there are no more; returns how many results were handed on.

    Parameters
    ----------
    delay : float
        Seconds from a frame to its result.
    hand_on : callable
        Given each result in its time, from another thread.
    tell : callable
        Called once if most results come too late.
    known : bool
        Whether the face was learned before, by `speaker`.

    Raises
    ------
    VideoError
        If there was none.
    """
    warned = False
    with Release(reader.start, delay, hand_on) as release:
        found = track_shots(tracker.setting, reader.shots(), depth=1)
        with closed_after(found):
            for shot, result in found:
                release.add(shot, result)
                if release.mostly_late and not warned:
                    warned = True
                    usual = 1e3 * sorted(release.took)[len(release.took) // 2]
                    tell(
                        f"most results take {usual:.0f} ms and are dropped: allow a longer --delay"
                    )
    if release.count == 0 and not reader.stopped:
        ways = ["play a file longer (--repeat)", "allow a longer --delay"]
        ways += [] if known else ["give a learned --model"]
        raise VideoError(
            f"all {reader.count} frames had gone by before one was tracked in time",
            joined(ways, "or"),
        )
    return release.count


def ending(feed: Feed, reader: Reader) -> tuple[str, bool]:
    """Reason for which there are no more frames, in a line, and if that is a fault."""
    if reader.error is not None:
        return str(reader.error), True
    if reader.stopped:
        return "stopped", False
    if feed.lost:
        return f"{feed.name} gives no more frames: is it unplugged?", True
    return f"{feed.name} has ended", False
