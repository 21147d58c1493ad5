"""How drawn corners of the mouth agree with corners that were read off the pictures by eye.

Run it by hand: `python tests/corner_agreement.py RUNS`, where RUNS holds one run of
`abs-engine track` for each clip of `people` in the data folder (`ABS_ENGINE_DATA`, by default
../shared/data), named as the clip.

`data/lip_corners.csv` has the twelve frames of each clip in which `edge_agreement.py` compares
edges. In each, both corners of the mouth, left and right as seen in the picture, were read twice,
independently, without any outline in view: where the line between the lips ends and the red of both
meets, not where a shadow or a crease goes on into the cheek. Coordinates are pixels of the video,
NaN where a corner was turned away or too blurred; such frames are left out.

Widths are compared as if the face were not turned: one that was read is made longer by as much as
the pose shortens the drawn one. The detector's are its own, over the distance of the eyes.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from edge_agreement import DATA, FloatArray, correlation, labels, seen_lips
from people_agreement import GROUPS

from abs_engine.io.assets import load_speaker
from abs_engine.tracking.record import load_run

LABELS = Path(__file__).parent / "data" / "lip_corners.csv"


@dataclass(frozen=True)
class Frame:
    """Corners of a frame, mm.

    Parameters
    ----------
    inside : (2,) float64
        How far within the left and the right corner, as read, the outline ends.
    width, read, detector : float
        Of the run; as read, turned to the front; of the detector, in its own unit.
    differ : float
        By how much the widths of both readings differ.
    """

    inside: FloatArray
    width: float
    read: float
    detector: float
    differ: float


def frame_of(
    run: dict[str, Any], row: dict[str, float], ring: int, detector: float | None
) -> Frame | None:
    """A frame of a run beside the readings; None where either lacks a corner."""
    at = int(row["frame"])
    ends = [
        np.array([[row[f"{s}_{x}_{n}"] for x in "xy"] for s in ("left", "right")]) for n in "ab"
    ]
    left, right = 0.5 * (ends[0] + ends[1])
    lips, pixels, mm = seen_lips(run, at)
    if not np.isfinite([*left, *right, mm]).all():
        return None
    long = float(np.hypot(*(right - left)))
    axis = (right - left) / long
    along = pixels[:ring] @ axis
    first, last = np.argmin(along), np.argmax(along)
    facing = np.linalg.norm(lips[last] - lips[first]) / np.hypot(*(pixels[last] - pixels[first]))
    widths = [np.hypot(*(two - one)) for one, two in ends]
    return Frame(
        mm * np.array([along[first] - left @ axis, right @ axis - along[last]]),
        float(run["width"][at]),
        float(long * facing),
        np.nan if detector is None else detector,
        float(mm * (widths[0] - widths[1])),
    )


@dataclass(frozen=True)
class Clip:
    """A clip's frames that were read and found."""

    frames: list[Frame]

    def of(self, name: str) -> FloatArray:
        """A field of all frames."""
        return np.array([getattr(f, name) for f in self.frames], np.float64)

    @property
    def figures(self) -> FloatArray:
        """Mm inside, left and right; our width less that read; r of ours and the detector's."""
        read, off = self.of("read"), self.of("width") - self.of("read")
        rs = [correlation(self.of(name), read) for name in ("width", "detector")]
        return np.array([*self.of("inside").mean(axis=0), off.mean(), *rs])


def clips(runs: Path) -> dict[str, Clip]:
    """The compared frames of each clip."""
    curves = json.loads((DATA / "mediapipe.json").read_text())["clips"]
    ring, found = len(load_speaker().landmarks["outer_lip"]), {}
    for name, rows in labels(LABELS).items():
        run, seen = dict(load_run(runs / name)), curves[name]["width"]
        frames = [frame_of(run, row, ring, seen[int(row["frame"])]) for row in rows]
        found[name] = Clip([f for f in frames if f is not None])
    return found


def lines(runs: Path) -> Iterator[str]:
    """A line for each clip, then means of both halves and of groups."""
    found = clips(runs)
    yield "mm by which the outline ends within the corners; width less that read; r of widths"
    yield "clip  frames   left  right   width   r ours  detector   read sd  readings differ"
    for name, clip in found.items():
        left, right, off, ours, detector = clip.figures
        differ = np.sqrt(np.mean(clip.of("differ") ** 2))
        yield (
            f"{name}  {len(clip.frames):6} {left:+6.2f} {right:+6.2f}  {off:+6.2f}   {ours:6.3f}  "
            f"{detector:8.3f}   {clip.of('read').std():7.1f}  {differ:15.1f}"
        )
    halves = {"p01 to p08": list(GROUPS)[:8], "p09 to p16": list(GROUPS)[8:], "all": list(GROUPS)}
    for kind in (0, 1):
        for group in dict.fromkeys(g[kind] for g in GROUPS.values()):
            named = f"{('skin', 'lips')[kind]} {group}"
            halves[named] = [n for n in GROUPS if GROUPS[n][kind] == group]
    for title, names in halves.items():
        figures = np.array([found[n].figures for n in names])
        left, right, off = np.nanmean(figures[:, :3], axis=0)
        ours, detector = np.nanmedian(figures[:, 3:], axis=0)
        rs = f"r median: ours {ours:.3f}, detector {detector:.3f}"
        yield f"{title}: {left:+.2f} {right:+.2f} {off:+.2f}; {rs}"


if __name__ == "__main__":
    for folder in map(Path, sys.argv[1:]):
        sys.stdout.write("\n".join([str(folder), *lines(folder)]) + "\n")
