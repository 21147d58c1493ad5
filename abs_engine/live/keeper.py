"""Keeps a live session as a run: a recording of what was tracked, and all that `track` writes."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

from abs_engine.core.threads import Behind
from abs_engine.io.video import VideoInfo, VideoWriter, read_frames
from abs_engine.live.release import Released
from abs_engine.tracking.frame.clip_setting import FrameResult
from abs_engine.tracking.frame.frame_state import Shot
from abs_engine.tracking.loop import NOTHING
from abs_engine.tracking.options import ClipTracker, TrackOptions
from abs_engine.tracking.results.frame_journal import FRAMES, FrameJournal
from abs_engine.tracking.run import settings_of
from abs_engine.tracking.runs.output import Progress, write_run

RECORDING = "recording.mkv"  # in the run: can be played however the session ends
_CODING = 18, "ultrafast"


class Keeper:
    """Records each result and its frame; their numbers and times count from the first.

    Parameters
    ----------
    folder : Path
        That is there, and empty.
    """

    def __init__(self, folder: Path, tracker: ClipTracker) -> None:
        self._folder, self._tracker = folder, tracker
        info = tracker.info
        self._video = VideoWriter(folder / RECORDING, info.size, info.rate, *_CODING, uneven=True)
        self._behind = Behind()
        self._times: list[float] = []
        self._frames = FrameJournal(folder / FRAMES, "")

    def add(self, released: Released) -> None:
        """Keep the next result and its frame; they are written beside other work."""
        shot, index = released.shot, len(self._times)
        self._times.append(shot.time)
        self._behind.call(self._append, shot, replace(released.result, index=index))

    def _append(self, shot: Shot, result: FrameResult) -> None:
        self._video.write(shot.image, shot.time - self._times[0])
        self._frames.add(result, NOTHING)

    def write(
        self, options: TrackOptions, facts: dict[str, Any], progress: Progress | None = None
    ) -> dict[str, Any]:
        """Write the run; see `tracking.runs.output.write_run`.

        Parameters
        ----------
        facts : dict
            What `run.json` says of the session, JSON values.
        """
        with self._frames, self._video, self._behind:
            pass
        path, count, old = self._folder / RECORDING, len(self._times), self._tracker
        first = self._times[0]
        times = tuple(time - first for time in self._times)
        rate = (count - 1) / times[-1] if times[-1] > 0 else old.info.rate
        made = replace(
            old,
            video=path,
            info=VideoInfo(old.info.size, rate, count, times),
            setting=replace(old.setting, rate=rate, times=times),
        )
        settings = {**settings_of(made, options), "video_path": RECORDING}
        settings["live"] = {**facts, "began": round(first, 6)}
        with FrameJournal(self._folder / FRAMES, "") as journal:
            found = (result for result, _ in iter(journal.earlier, None))
            results = zip(read_frames(path), found, strict=True)
            _, told = write_run(self._folder, made.setting, results, settings, count, progress)
        (self._folder / FRAMES).unlink()
        return told
