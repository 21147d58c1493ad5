"""How drawn corners of the mouth agree with corners that were read off the pictures by eye.

Run it by hand: `python tests/corner_agreement.py RUNS`, where RUNS holds one run of
`abs-engine track` for each clip of `people` in the data folder (`ABS_ENGINE_DATA`, by default
../shared/data), named as the clip.

`data/lip_corners.csv` has the twelve frames of each clip in which `edge_agreement.py` compares
edges. In each, both corners of the mouth, left and right as seen in the picture, were read twice,
independently, without any outline in view: the end of the line or opening between the lips, not
of a shadow or a crease that goes on into the cheek. Coordinates are pixels of the video,
NaN where a corner was turned away or too blurred; such frames are left out.

A run's width is the distance between the points where upper and lower lip meet; the detector's is
that between the inner corners, divided by that between the eyes. Readers marked the outer ends, so
widths are above all compared by correlation. A width as read is scaled up by the factor by which
the pose foreshortens the drawn one. That pose, and the size of a pixel, are the run's own, which
favours its width; `flat` leaves the turn out, though not the size of a pixel.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from edge_agreement import WITHIN, FloatArray, correlation, labels, seen_lips
from people_agreement import DATA, PARTS

from abs_engine.io.assets import load_speaker
from abs_engine.tracking.runs.record import load_run

LABELS = Path(__file__).parent / "data" / "lip_corners.csv"


@dataclass(frozen=True)
class Frame:
    """Corners and widths of a frame.

    Parameters
    ----------
    inside : (2,) float64, mm
        How far within the left and the right corner the outline ends, in the picture, not turned.
    meeting : (2,) float64, mm
        How far within and below the corners the points lie where the lips meet, mean of both sides.
    width, outline, read, flat : float, mm
        The run's; between the ends of its outline; as read, turned to the front; and not turned.
    detector : float
        The detector's width, divided by its distance between the eyes.
    differ : float, mm
        Width of the first reading less that of the second, in the picture.
    deviation : float, mm
        Standard deviation of the width of the run.
    """

    inside: FloatArray
    meeting: FloatArray
    width: float
    outline: float
    read: float
    flat: float
    detector: float
    differ: float
    deviation: float


def frame_of(
    run: dict[str, Any], row: dict[str, float], marks: Mapping[str, Any], detector: float | None
) -> Frame | None:
    """A frame of a run beside the readings; None where either lacks a corner."""
    border = list(marks["outer_lip"])
    ring, meet = len(border), [border.index(v) for v in marks["mouth_corners"]]
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
    one, other = pixels[meet]
    within = 0.5 * ((one - left) - (other - right)) @ axis
    below = 0.5 * ((one - left) + (other - right)) @ [-axis[1], axis[0]]
    first, last = np.argmin(along), np.argmax(along)
    outline = np.linalg.norm(lips[last] - lips[first])
    facing = outline / np.hypot(*(pixels[last] - pixels[first]))
    widths = [np.hypot(*(two - one)) for one, two in ends]
    return Frame(
        mm * np.array([along[first] - left @ axis, right @ axis - along[last]]),
        mm * np.array([within, below]),
        float(run["width"][at]),
        float(outline),
        float(long * facing),
        float(long * mm),
        np.nan if detector is None else detector,
        float(mm * (widths[0] - widths[1])),
        float(run["width_sd"][at]),
    )


@dataclass(frozen=True)
class Clip:
    """A clip's frames that were read and found."""

    frames: list[Frame]

    def of(self, name: str) -> FloatArray:
        """A field of all frames."""
        return np.array([getattr(f, name) for f in self.frames], np.float64)

    @property
    def apart(self) -> FloatArray:
        """Mm inside, left and right; inside, below; our outline and width, less that read."""
        longer = [np.mean(self.of(name) - self.of("read")) for name in ("outline", "width")]
        ends = (self.of(name).mean(axis=0) for name in ("inside", "meeting"))
        return np.array([*np.concatenate(list(ends)), *longer])

    @property
    def held(self) -> FloatArray:
        """Whether 90 % intervals hold the width read: as it is, less the clip's mean (T, 2)."""
        off = self.of("width") - self.of("read")
        reach = WITHIN * self.of("deviation")
        return np.column_stack([np.abs(off) < reach, np.abs(off - off.mean()) < reach])

    @property
    def correlations(self) -> FloatArray:
        """Of our width and the detector's with that read; with that read and not turned."""
        pairs = [(read, name) for read in ("read", "flat") for name in ("width", "detector")]
        return np.array([correlation(self.of(name), self.of(read)) for read, name in pairs])


def clips(runs: Path) -> dict[str, Clip]:
    """The compared frames of each clip."""
    curves = json.loads((DATA / "mediapipe.json").read_text())["clips"]
    marks, found = load_speaker().landmarks, {}
    for name, rows in labels(LABELS).items():
        run, seen = dict(load_run(runs / name)), curves[name]["width"]
        frames = [frame_of(run, row, marks, seen[int(row["frame"])]) for row in rows]
        found[name] = Clip([f for f in frames if f is not None])
    return found


def lines(runs: Path) -> Iterator[str]:
    """A line for each clip, then means of both halves and of groups."""
    found = clips(runs)
    yield "mm: how far within the corners the outline ends; within and below them lie the points"
    yield "where the lips meet; outline and width less the width read"
    yield "r with the width read, ours and the detector's; with that read and not turned"
    yield "clip  frames; left, right; within, below; outline, width; r, r; r, r; sd read; differ"
    for name, clip in found.items():
        differ = np.sqrt(np.mean(clip.of("differ") ** 2))
        yield (
            f"{name}  {len(clip.frames):6} {_row(clip.apart, clip.correlations)}  "
            f"{clip.of('read').std():4.1f}  {differ:4.1f}"
        )
    yield "means of clips; of r, medians"
    for title, names in (PARTS | {"all": list(found)}).items():
        apart = np.mean([found[n].apart for n in names], axis=0)
        r = np.median([found[n].correlations for n in names], axis=0)
        held = np.mean(np.concatenate([found[n].held for n in names]), axis=0)
        yield (
            f"{title}: {_row(apart, r)}; 90 % intervals of the width hold {held[0]:.2f}, "
            f"less each clip's mean error {held[1]:.2f}"
        )


def _row(apart: FloatArray, correlations: FloatArray) -> str:
    return " ".join([f"{v:+6.2f}" for v in apart] + [f"{v:6.3f}" for v in correlations])


if __name__ == "__main__":
    for folder in map(Path, sys.argv[1:]):
        sys.stdout.write("\n".join([str(folder), *lines(folder)]) + "\n")
