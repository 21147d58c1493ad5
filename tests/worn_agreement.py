"""Agreement of mouths tracked in close-ups with labels by hand, each speaker by the others.

Run it by hand: `python tests/worn_agreement.py [SPEAKER ...] [--own] [--whole] [--frames]`. For
each speaker what a mouth looks like is learned from the labelled frames of all others, never from
their own; with `--own` from nobody's labels, but from the clip itself. The labelled frames are
tracked with the few before each, as tracking needs no more; with `--whole` all frames are. Nothing
is kept. Speakers whose file of labels is empty are named and left out.
"""

from __future__ import annotations

import argparse
import csv
import os
import re
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.camera import Camera
from abs_engine.core.threads import one_thread
from abs_engine.io.assets import load_speaker
from abs_engine.io.video import probe, read_frames
from abs_engine.learn.opening import LabelledMouth, disagreement, learn_opening, spot_of
from abs_engine.render.select import open_renderer
from abs_engine.tracking.frame.clip_setting import ClipSetting, FrameResult
from abs_engine.tracking.loop import track
from abs_engine.tracking.models.worn import fitted_clip, found_mouth, labelled_by_network
from abs_engine.tracking.options import Clip, ClipTracker, Leaves, TrackOptions

FloatArray = NDArray[np.float64]
FOLDER = Path(os.environ.get("ABS_ENGINE_DATA", "../shared/data")) / "tal_lips"
BEFORE = 3  # frames that are tracked before each labelled one
PARTED = 0.03  # of the mouth's width: lips farther apart are parted
OPTIONS = TrackOptions(worn=True, terms=("opening",), driver="newton")


@dataclass(frozen=True, eq=False)
class Labelled:
    """A speaker's clip and the labels of some of its frames, (8, 2) px each.

    Points are in the order of `learn.opening.POINTS`; pixel centres at integers.
    """

    video: Path
    points: dict[int, FloatArray]
    images: dict[int, NDArray[np.uint8]]

    @classmethod
    def of(cls, name: str) -> Labelled:
        """The labels that lie in the clip; frames beyond its end are left out."""
        video = FOLDER / "videos" / f"{name}.avi"
        with (FOLDER / "labelled" / f"{name}.csv").open(encoding="utf-8") as file:
            rows = list(csv.reader(file))[3:]
        points = {
            int(re.findall(r"img(\d+)", row[0])[0]): np.array(row[1:], float).reshape(8, 2) - 0.5
            for row in rows
        }
        wanted = {k - back for k in points for back in range(BEFORE + 1)}
        seen = {k: image for k, image in enumerate(read_frames(video)) if k in wanted}
        return cls(video, {k: p for k, p in points.items() if k in seen}, seen)

    def mouths(self) -> list[LabelledMouth]:
        """Frames to learn from."""
        spot = spot_of(list(self.points.values()))
        return [LabelledMouth(self.images[k], p, spot) for k, p in self.points.items()]


@dataclass(frozen=True)
class Errors:
    """Of one frame, in shares of the labelled mouth's width."""

    inner: FloatArray  # (6,): from each labelled inner point to the tracked contour below it
    points: FloatArray  # (6,): to a point of that contour at a fixed share of the mouth's width
    corners: FloatArray  # (2,)
    aperture: float  # tracked less labelled
    true: float  # aperture as labelled
    parted: tuple[bool, bool]  # labelled, tracked


SHARES = np.repeat([0.25, 0.5, 0.75], 2)


def errors(setting: ClipSetting, result: FrameResult, labels: FloatArray) -> Errors:
    """Errors of a tracked frame against its labels (8, 2)."""
    upper, lower = inner_contours(setting, result)
    width = float(np.linalg.norm(labels[1] - labels[0]))
    lines = [upper, lower] * 3
    heights = [np.interp(p[0], *line.T) for p, line in zip(labels[2:], lines, strict=True)]
    corners = np.stack([upper[0] + lower[0], upper[-1] + lower[-1]]) / 2
    at = corners[0, 0] + SHARES * (corners[1, 0] - corners[0, 0])
    drawn = np.array([[x, np.interp(x, *line.T)] for x, line in zip(at, lines, strict=True)])
    aperture = (max(heights[3] - heights[2], 0.0)) / width
    true = max(labels[5, 1] - labels[4, 1], 0.0) / width
    return Errors(
        np.abs(heights - labels[2:, 1]) / width,
        np.linalg.norm(drawn - labels[2:], axis=1) / width,
        np.linalg.norm(corners - labels[:2], axis=1) / width,
        aperture - true,
        true,
        (true > PARTED, aperture > PARTED),
    )


def inner_contours(setting: ClipSetting, result: FrameResult) -> tuple[FloatArray, FloatArray]:
    """The upper and lower inner lip as drawn, px, from the picture's left to its right."""
    seen = setting.camera.project(result.pose.apply(result.lips))
    outer, upper, _ = setting.face.ring_sizes
    lines = seen[outer : outer + upper], seen[outer + upper :]
    return tuple(line[np.argsort(line[:, 0])] for line in lines)


def tracked(tracker: ClipTracker, clip: Labelled, whole: bool) -> Iterator[tuple[int, FrameResult]]:
    """The labelled frames as they are tracked."""
    if whole:
        yield from ((r.index, r) for _, r in tracker.results() if r.index in clip.points)
        return
    for k in clip.points:
        some = [clip.images[i] for i in range(max(k - BEFORE, 0), k + 1)]
        *_, (_, last) = track(tracker.setting, some)
        yield k, last


def of_speaker(name: str, clips: dict[str, Labelled], own: bool, whole: bool) -> list[Errors]:
    """The errors of a speaker's frames, by what was learned from the others."""
    clip = clips[name]
    others = [m for other, c in clips.items() if other != name for m in c.mouths()]
    info = probe(clip.video)
    seen = Clip(clip.video, info, Camera.ideal(info.size), None)
    with open_renderer("cpu") as renderer, one_thread():
        looks = None if own else learn_opening(others)
        images, opening, more = found_mouth(seen, OPTIONS, looks, str)
        unlike = disagreement(opening.looks, labelled_by_network(more, opening.spot))
        sys.stdout.write(f"{name:<12}disagreement {unlike:.2f}\n")
        given = OPTIONS, Leaves.of(OPTIONS), renderer
        tracker = fitted_clip(seen, load_speaker(), opening, images, *given)
        return [
            errors(tracker.setting, r, clip.points[k]) for k, r in tracked(tracker, clip, whole)
        ]


def line(name: str, found: list[Errors]) -> str:
    """A line of the table."""
    agree = np.mean([e.parted[0] == e.parted[1] for e in found])
    shares = [
        100 * float(np.median(part))
        for part in (
            [e.inner for e in found], [e.points for e in found], [e.corners for e in found],
            [abs(e.aperture) for e in found],
        )
    ]  # fmt: skip
    bias = 100 * float(np.mean([e.aperture for e in found]))
    cells = "  ".join(f"{share:5.1f}" for share in [*shares, bias])
    return f"{name:<12}{len(found):>4}  {cells}  {agree:6.0%}"


def main() -> None:
    """Print the table."""
    take = argparse.ArgumentParser(description=__doc__)
    take.add_argument("speakers", nargs="*")
    take.add_argument("--own", action="store_true")
    take.add_argument("--whole", action="store_true")
    take.add_argument("--frames", action="store_true", help="list apertures, labelled and tracked")
    chosen = take.parse_args()
    files = sorted((FOLDER / "labelled").glob("*.csv"))
    empty = [file.stem for file in files if not file.stat().st_size]
    if not files or len(files) == len(empty):
        sys.exit(f"skipped: no labels in {FOLDER}")
    if empty:
        sys.stdout.write(f"without labels, left out: {' '.join(empty)}\n")
    clips = {file.stem: Labelled.of(file.stem) for file in files if file.stat().st_size}
    sys.stdout.write("speaker   frames  inner points corners aperture bias  parted (% of width)\n")
    found: dict[str, list[Errors]] = {}
    for name in chosen.speakers or clips:
        found[name] = of_speaker(name, clips, chosen.own, chosen.whole)
        sys.stdout.write(line(name, found[name]) + "\n")
        if chosen.frames:
            pairs = [f"{100 * e.true:.1f}>{100 * (e.true + e.aperture):.1f}" for e in found[name]]
            sys.stdout.write(f"    {'  '.join(pairs)}\n")
        sys.stdout.flush()
    first = list(clips)[: len(clips) // 2]
    for title, names in (
        ("first half", first), ("second half", [n for n in clips if n not in first]), ("all", clips)
    ):  # fmt: skip
        these = [e for n in names for e in found.get(n, [])]
        if these:
            sys.stdout.write(line(title, these) + "\n")


if __name__ == "__main__":
    main()
