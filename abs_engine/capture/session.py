"""A whole session: dots followed through two views of a face, and what a person should look at."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.ndimage import median_filter

from abs_engine.capture.dot_annotations import Mark, check_view, initial_places
from abs_engine.capture.dot_tracking import DotFollower, Sighting
from abs_engine.capture.observations import Observations
from abs_engine.capture.settings import CAPTURE
from abs_engine.core.arrays import BoolArray, FloatArray, Image
from abs_engine.core.errors import ParameterError, VideoError
from abs_engine.io.video import VideoInfo, probe, read_frames


@dataclass(frozen=True, eq=False)
class Moment:
    """A frame and what was found in it.

    Parameters
    ----------
    names : tuple of str
        Of the dots.
    images : sequence of (H, W, 3) uint8 RGB
        For each view; the same object twice where both views are in one picture.
    """

    frame: int
    names: tuple[str, ...]
    images: Sequence[Image]
    sightings: Sequence[Sighting]


@dataclass(frozen=True, eq=False)
class Tracks:
    """Dots in the pictures, V views, T frames, N dots.

    Parameters
    ----------
    pixels : (V, T, N, 2) float64; NaN where a dot is lost
    scores : (V, T, N) float64
    corrected : (V, T, N) bool
        A person said so after the dots had been followed; those of frame 0 are pointed at before.
    rate : float
        Frames per second.
    """

    names: tuple[str, ...]
    pixels: FloatArray
    scores: FloatArray
    corrected: BoolArray
    rate: float


def follow_videos(
    videos: Sequence[Path],
    points: Sequence[Mark],
    corrections: Sequence[Mark] = (),
    watch: Callable[[Moment], None] | None = None,
) -> Tracks:
    """Follow the dots of two views through two videos, or through one that shows both.

    Memory does not grow with the frames but for the places found.

    Parameters
    ----------
    videos : one path (a mirror: both views are in each picture) or two (one for each view)
    points : sequence of Mark
        Every dot in both views in frame 0.
    corrections : sequence of Mark
        What a person says of later frames; it replaces what was found, and is gone on from.
    watch : callable, optional
        Called with each frame as it is done.

    Raises
    ------
    VideoError
        If a video cannot be read, or two differ in rate, length, or times of their frames.
    TooFewPointsError
        If a dot is not given in a view.
    ModelFormatError, ParameterError
        If a mark names a view, a dot or a frame that there is not, or a place outside of it.
    """
    rate, frames = _rate_and_frames(videos)
    again = {(m.frame, m.view, m.point) for m in corrections}
    marks = [*(m for m in points if (m.frame, m.view, m.point) not in again), *corrections]
    names, places = initial_places(marks, 2)
    given = _by_frame([m for m in marks if m.frame], names)
    if given and max(given) >= frames:
        raise ParameterError(
            f"a correction is for frame {max(given)}", f"the video has frames 0 to {frames - 1}"
        )
    _check_inside(marks, videos)
    followers: list[DotFollower] = []
    seen: list[list[Sighting]] = []
    for frame, images in enumerate(_together(videos)):
        if frame == 0:
            followers = [DotFollower(i, p) for i, p in zip(images, places, strict=True)]
            now = [f.start for f in followers]
        else:
            told = given.pop(frame, ({}, {}))
            now = [f.step(i, t) for f, i, t in zip(followers, images, told, strict=True)]
        seen.append(now)
        if watch is not None:
            watch(Moment(frame, names, images, now))
    pixels, scores, corrected = (
        np.stack([[getattr(now[view], part) for now in seen] for view in range(2)])
        for part in ("places", "scores", "corrected")
    )
    corrected[:, 0] = [[(0, view, name) in again for name in names] for view in range(2)]
    return Tracks(names, pixels, scores, corrected, rate)


def _rate_and_frames(videos: Sequence[Path]) -> tuple[float, int]:
    """Frames per second and their number; raise if they differ or are not one or two."""
    if len(videos) not in (1, 2):
        raise ParameterError(f"{len(videos)} videos were given", "give one or two")
    infos = [probe(video) for video in videos]
    first, last = infos[0], infos[-1]
    if abs(first.rate / last.rate - 1) > CAPTURE.rates_apart:
        raise VideoError(
            f"the videos have {first.rate:g} and {last.rate:g} frames/s",
            "give two that were taken together",
        )
    if first.frames != last.frames:
        raise VideoError(
            f"the videos have {first.frames} and {last.frames} frames",
            "cut them to begin and end together",
        )
    check_together(first, last)
    return first.rate, first.frames


def check_together(one: VideoInfo, other: VideoInfo) -> None:
    """Refuse videos whose files say that frames of one number are of different moments."""
    if not (one.times and other.times):
        return
    first, second = np.array(one.times), np.array(other.times)
    second = second * (first[-1] / max(second[-1], 1e-9))  # clocks run differently fast
    limit, apart = CAPTURE.times_apart / one.rate, first - second
    wrong = np.flatnonzero(np.abs(median_filter(apart, 5, mode="nearest")) > limit)  # stamps jitter
    if len(wrong):
        k = int(wrong[0])
        while k and abs(apart[k - 1]) > limit:
            k -= 1
        raise VideoError(
            f"frame {k} comes {one.times[k]:.3f} s after the first in one video and "
            f"{other.times[k]:.3f} s in the other",
            "film so that no camera loses frames, or cut both to frames of the same moments",
        )


def review(tracks: Tracks, observed: Observations) -> Iterator[tuple[Mark, dict[str, object]]]:
    """Frames for a person to look at: places lost, uncertain, or on which views disagree.

    Written with `dot_annotations.write_marks` it is a file of corrections: edit x and y where they
    are wrong, leave them empty where the dot cannot be seen, delete the other lines.
    """
    for frame, view, point in np.ndindex(tracks.pixels.shape[1], 2, len(tracks.names)):
        score = float(tracks.scores[view, frame, point])
        if tracks.corrected[view, frame, point]:
            continue
        place = tracks.pixels[view, frame, point]
        error = float(observed.error[frame, point])
        if not np.isfinite(place).all():
            why = "lost"
        elif np.isfinite(error) and not observed.found[frame, point]:
            head = np.isfinite(observed.rotations[frame]).all()
            why = "views disagree" if head else "views disagree, or head not found"
        elif score < CAPTURE.sure:
            why = "uncertain"
        else:
            continue
        at = (float(place[0]), float(place[1])) if why != "lost" else None
        mark = Mark(frame, view, tracks.names[point], at)
        yield mark, {"score": f"{score:.2f}", "error_px": f"{error:.2f}", "why": why}


def _together(videos: Sequence[Path]) -> Iterator[tuple[Image, Image]]:
    if len(videos) == 1:
        for image in read_frames(videos[0]):
            yield image, image
        return
    yield from zip(*(read_frames(v) for v in videos), strict=True)


def _by_frame(
    marks: Sequence[Mark], names: tuple[str, ...]
) -> dict[int, tuple[dict[int, tuple[float, float] | None], ...]]:
    out: dict[int, tuple[dict[int, tuple[float, float] | None], ...]] = {}
    for mark in marks:
        check_view(mark, 2)
        if mark.point not in names:
            raise ParameterError(
                f"a correction is for the point '{mark.point}'", f"there are {', '.join(names)}"
            )
        here = out.setdefault(mark.frame, ({}, {}))[mark.view]
        here[names.index(mark.point)] = mark.place
    return out


def _check_inside(marks: Sequence[Mark], videos: Sequence[Path]) -> None:
    """Refuse marks outside of the pictures of their views."""
    sizes = [probe(video).size for video in videos]
    for mark in marks:
        if mark.place is None:
            continue
        limit = np.array(sizes[mark.view % len(sizes)]) - 0.5
        if (np.less(mark.place, -0.5) | (mark.place > limit)).any():
            raise ParameterError(
                f"point '{mark.point}' of view {mark.view + 1} is outside of the picture in frame "
                f"{mark.frame}",
                "give pixels, counted from 0 at the top left, or none where it cannot be seen",
            )
