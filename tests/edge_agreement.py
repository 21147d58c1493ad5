"""How drawn lip edges agree with edges that were read off the pictures by eye.

Run it by hand: `python tests/edge_agreement.py RUNS`, where RUNS holds one run of
`abs-engine track` for each clip of `people` in the data folder (`ABS_ENGINE_DATA`, by default
../shared/data), named as the clip.

`data/lip_edges.csv` has twelve frames of each clip. In each, where a line through the middle of the
mouth and down the face meets the lips' four edges (upper and lower edge of each lip) was read
twice, independently, without any outline in view; at a blurred edge the middle of the transition.
Distances are in pixels of the video, down the line from (x, y); NaN where an edge was not in view.
No detector was asked, and no renderer of ours drew these edges, so that they say on real people
what films say on drawn ones.
"""

from __future__ import annotations

import csv
import json
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from people_agreement import DATA, PARTS
from scipy.spatial.transform import Rotation

from abs_engine.io.assets import load_speaker
from abs_engine.tracking.runs.record import load_run

FloatArray = NDArray[np.float64]
LABELS = Path(__file__).parent / "data" / "lip_edges.csv"
EDGES = ("top", "upper", "lower", "bottom")
PARTED = 1.5
"""Mm between the inner edges, from which on they are counted."""
WITHIN = 1.645
"""Standard deviations to either side of a 90 % interval."""
OPEN = (0.5, 5.0)
"""Mm, gaps as read between which lips are neither closed nor wide open."""


@dataclass(frozen=True)
class Clip:
    """Edges of a clip's frames, mm, down the line; frames that were not found are left out.

    Parameters
    ----------
    ours, first, second : (T, 4) float64
        As drawn, and as they were read twice.
    aperture, deviation, detector : (T,) float64
        Of the run, mm, and its standard deviation; of the detector, in its own units.
    mm : float
        Of a pixel.
    """

    ours: FloatArray
    first: FloatArray
    second: FloatArray
    aperture: FloatArray
    deviation: FloatArray
    detector: FloatArray
    mm: float

    @property
    def read(self) -> FloatArray:
        """The mean of both readings, (T, 4)."""
        return 0.5 * (self.first + self.second)

    @property
    def off(self) -> FloatArray:
        """How far below the read edges the drawn ones lie, (4,); inner ones of parted lips."""
        apart, parted = self.ours - self.read, _gap(self.read) > PARTED
        none = np.full(2, np.nan)
        inner = apart[parted, 1:3].mean(axis=0) if parted.any() else none
        return np.array([apart[:, 0].mean(), *inner, np.nanmean(apart[:, 3])])

    @property
    def gap_rms(self) -> float:
        """By how much the apertures differ from the gap as read, RMS, mm."""
        return float(np.sqrt(np.nanmean((self.aperture - _gap(self.read)) ** 2)))

    @property
    def held(self) -> FloatArray:
        """Whether 90 % intervals of the aperture hold the gap as read, 0 or 1 (T,)."""
        off = np.abs(self.aperture - _gap(self.read))
        return np.where(np.isfinite(off), off < WITHIN * self.deviation, np.nan)

    @property
    def correlations(self) -> FloatArray:
        """Correlation with the gap as read: of our aperture, the detector's, and both readings."""
        gap = _gap(self.read)
        pairs = ((self.aperture, gap), (self.detector, gap), (_gap(self.first), _gap(self.second)))
        return np.array([correlation(*pair) for pair in pairs])


def _gap(edges: FloatArray) -> FloatArray:
    return edges[:, 2] - edges[:, 1]


def correlation(one: FloatArray, other: FloatArray) -> float:
    """Pearson's r where both are finite; NaN of fewer than three, or where one is constant."""
    seen = np.isfinite(one) & np.isfinite(other)
    one, other = one[seen], other[seen]
    varied = len(one) > 2 and min(one.std(), other.std()) > 0
    return float(np.corrcoef(one, other)[0, 1]) if varied else float("nan")


def crossings(line: FloatArray, *, closed: bool) -> FloatArray:
    """Where a contour (N, 2) in coordinates along and across a line meets it, along it."""
    ends = np.vstack([line, line[:1]]) if closed else line
    one, other = ends[:-1], ends[1:]
    met = (one[:, 1] * other[:, 1] <= 0) & (one[:, 1] != other[:, 1])
    one, other = one[met], other[met]
    share = one[:, 1] / (one[:, 1] - other[:, 1])
    return np.asarray(one[:, 0] + share * (other[:, 0] - one[:, 0]), np.float64)


def seen_lips(run: dict[str, Any], at: int) -> tuple[FloatArray, FloatArray, float]:
    """A frame's lip points in mm before the camera (N, 3) and in px (N, 2); mm of a pixel there."""
    turned = Rotation.from_rotvec(run["rotation"][at]).as_matrix()
    seen = run["lip_points"][at] @ turned.T + run["translation"][at]
    pixels = (seen / seen[:, 2:]) @ run["camera_matrix"].T
    return seen, pixels[:, :2], float(seen[:, 2].mean() / run["camera_matrix"][0, 0])


def drawn(run: dict[str, Any], row: dict[str, float], sizes: list[int]) -> tuple[FloatArray, float]:
    """Our four edges along the line of a row, px, and mm of a pixel there; NaN where none is."""
    _, pixels, mm = seen_lips(run, int(row["frame"]))
    down = np.array([row["down_x"], row["down_y"]])
    axes = np.column_stack([down, [-down[1], down[0]]])
    along = (pixels - [row["x"], row["y"]]) @ axes
    outer, upper, lower = np.split(along, np.cumsum(sizes)[:2])
    ring = crossings(outer, closed=True)
    inner = [np.median(crossings(part, closed=False)) for part in (upper, lower)]
    return np.array([ring.min(), *inner, ring.max()]), mm


def clip_of(name: str, rows: list[dict[str, float]], runs: Path, detector: list[Any]) -> Clip:
    """A clip's edges beside those of its run."""
    run, marks = dict(load_run(runs / name)), load_speaker().landmarks
    sizes = [len(marks[k]) for k in ("outer_lip", "inner_lip_upper", "inner_lip_lower")]
    rows = [r for r in rows if np.isfinite(run["rotation"][int(r["frame"])]).all()]
    edges = [drawn(run, row, sizes) for row in rows]
    mm = np.array([size for _, size in edges])
    read = [np.array([[r[f"{e}_{n}"] for e in EDGES] for r in rows]) for n in "ab"]
    ours = np.array([edge for edge, _ in edges])
    at = [int(r["frame"]) for r in rows]
    given = np.array([np.nan if detector[k] is None else detector[k] for k in at], np.float64)
    first, second = (one * mm[:, None] for one in read)
    return Clip(
        ours * mm[:, None], first, second, run["aperture"][at], run["aperture_sd"][at], given,
        float(np.median(mm)),
    )  # fmt: skip


def labels(path: Path) -> dict[str, list[dict[str, float]]]:
    """The rows of each clip."""
    kept: dict[str, list[dict[str, float]]] = {}
    with path.open(encoding="utf-8") as file:
        for row in csv.DictReader(file):
            name = row.pop("clip")
            kept.setdefault(name, []).append({k: float(v) for k, v in row.items()})
    return kept


def lines(runs: Path) -> Iterator[str]:
    """A line for each clip, then means of both halves and of groups."""
    curves = json.loads((DATA / "mediapipe.json").read_text())["clips"]
    found = {n: clip_of(n, rows, runs, curves[n]["aperture"]) for n, rows in labels(LABELS).items()}
    yield "mm by which drawn edges lie below read ones; r of apertures with the gap as read"
    yield "clip  mm/px    top  upper  lower bottom    gap   r ours  detector  readings  differ"
    for name, clip in found.items():
        off, r = clip.off, clip.correlations
        differ = np.sqrt(np.nanmean((clip.first - clip.second) ** 2))
        yield (
            f"{name}  {clip.mm:5.2f} {_signed(off)} {off[2] - off[1]:+6.2f}  "
            f"{r[0]:7.3f}  {r[1]:8.3f}  {r[2]:8.3f}  {differ:5.1f}"
        )
    for title, names in PARTS.items():
        offs = np.array([found[n].off for n in names])
        r = np.nanmedian([found[n].correlations for n in names], axis=0)
        off = np.nanmean(offs, axis=0)
        rms = np.mean([found[n].gap_rms for n in names])
        yield (
            f"{title}: {_signed(off)}; r median: ours {r[0]:.3f}, detector {r[1]:.3f}; "
            f"apertures off by {rms:.2f} mm; {_held([found[n] for n in names])}"
        )


def _held(clips: list[Clip]) -> str:
    held = np.concatenate([clip.held for clip in clips])
    gap = np.concatenate([_gap(clip.read) for clip in clips])
    parts = {"closed": gap < OPEN[0], "wide open": gap >= OPEN[1]}
    parts["between"] = ~(parts["closed"] | parts["wide open"])
    shares = [
        f"{name} {np.nanmean(held[which]):.2f}" for name, which in parts.items() if which.any()
    ]
    return f"90 % intervals hold {np.nanmean(held):.2f} ({', '.join(shares)})"


def _signed(values: FloatArray) -> str:
    return " ".join(f"{v:+6.2f}" for v in values)


if __name__ == "__main__":
    for folder in map(Path, sys.argv[1:]):
        sys.stdout.write("\n".join([str(folder), *lines(folder)]) + "\n")
