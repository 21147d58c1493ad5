"""How apertures tracked in strangers' clips agree with an independent landmark detector's.

Run it by hand: `python tests/people_agreement.py RUNS [RUNS2 ...] [--curves FILE]`, where RUNS
holds one run of `abs-engine track` for each clip of `people` in the data folder (`ABS_ENGINE_DATA`,
by default ../shared/data), named as the clip; or for each clip of FILE, which
`detector_curves.py` made. A detector is no truth: look at the pictures, too. Constants were chosen
on p01 to p08; p09 to p16 are for reporting.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from abs_engine.tracking.runs.record import load_run

DATA = Path(os.environ.get("ABS_ENGINE_DATA", "../shared/data")) / "people"
# Skin, and how plainly lips differ from it, by the data's own table
GROUPS = {
    "p01": ("dark", "low"),
    "p02": ("dark", "low"),
    "p03": ("medium", "low"),
    "p04": ("medium", "low"),
    "p05": ("medium", "high"),
    "p06": ("medium", "low"),
    "p07": ("light", "low"),
    "p08": ("light", "high"),
    "p09": ("light", "high"),
    "p10": ("medium", "low"),
    "p11": ("light", "low"),
    "p12": ("light", "high"),
    "p13": ("no colour", "low"),
    "p14": ("light", "low"),
    "p15": ("light", "low"),
    "p16": ("light", "high"),
}
PARTS = {"p01 to p08": list(GROUPS)[:8], "p09 to p16": list(GROUPS)[8:]} | {
    f"{kind} {group}": [name for name in GROUPS if GROUPS[name][k] == group]
    for k, kind in enumerate(("skin", "lips"))
    for group in dict.fromkeys(g[k] for g in GROUPS.values())
}
"""Clips of each half, of each skin and of each contrast of lips."""


@dataclass(frozen=True)
class Row:
    """A clip's figures; NaN where it was refused."""

    clip: str
    frames: int
    found: int
    aperture: float
    width: float
    landmarks: float
    off_mm: float
    held: int
    score: float
    warned: bool


def row_of(clip: str, told: Mapping[str, Any], runs: Path) -> Row:
    """The figures of one clip beside the detector's curves."""
    aperture, width = (np.array(told[k], float) for k in ("aperture", "width"))
    nan = float("nan")
    if not (runs / clip / "results.npz").is_file():
        return Row(clip, len(aperture), 0, nan, nan, nan, nan, 0, nan, False)
    run = load_run(runs / clip)
    found = np.asarray(run["found"], bool)
    by_landmarks = run.get("landmark_aperture", np.full(len(found), nan))
    off = run.get("landmark_distance", np.full(len(found), nan))
    return Row(
        clip,
        len(found),
        int(found.sum()),
        _correlation(run["aperture"], aperture),
        _correlation(run["width"], width),
        _correlation(by_landmarks, aperture),
        float(np.nanmedian(off)) if np.isfinite(off).any() else nan,
        int((run["status"] == "held to the landmarks").sum()),
        float(np.nanmean(run["score"])),
        bool(json.loads((runs / clip / "run.json").read_text())["summary"].get("warnings")),
    )


def _correlation(ours: np.ndarray, theirs: np.ndarray) -> float:
    seen = np.isfinite(ours) & np.isfinite(theirs)
    return float(np.corrcoef(ours[seen], theirs[seen])[0, 1]) if seen.sum() > 2 else float("nan")


def lines(curves: Mapping[str, Any], runs: Path) -> Iterator[str]:
    """A line for each clip, then the groups' of `people`."""
    of_people = set(curves) == set(GROUPS)
    rows = [row_of(clip, curves[clip], runs) for clip in (GROUPS if of_people else curves)]
    wide = max(map(len, curves))
    yield (
        f"{'clip':{wide}}  skin       lips   frames  found  aperture r  width r  landmarks r  "
        "off mm  held  score"
    )
    for r in rows:
        skin, lips = GROUPS.get(r.clip, ("", ""))
        yield (
            f"{r.clip:{wide}}  {skin:9}  {lips:5}  {r.frames:5}  {r.found:5}  {r.aperture:10.3f}  "
            f"{r.width:7.2f}  {r.landmarks:11.3f}  {r.off_mm:6.2f}  {r.held:4}  {r.score:5.2f}"
            f"{'  warned' if r.warned else ''}"
        )
    if of_people:
        yield from _groups(rows)


def _groups(rows: list[Row]) -> Iterator[str]:
    for name, half in (("p01 to p08", rows[:8]), ("p09 to p16", rows[8:])):
        good = sum(r.aperture >= 0.9 for r in half)
        yield f"{name}: 0.9 or more in {good} of {len(half)}, least {min_of(half):.2f}"
    for k, kind in enumerate(("skin", "lips")):
        for group in dict.fromkeys(g[k] for g in GROUPS.values()):
            part = [r for r in rows if GROUPS[r.clip][k] == group]
            share = sum(r.found for r in part) / sum(r.frames for r in part)
            values = [r.aperture for r in part]
            yield (
                f"{kind} {group}: {len(part)} clips, {share:.1%} found, aperture r "
                f"median {np.nanmedian(values):.2f}, least {min_of(part):.2f}"
            )


def min_of(rows: list[Row]) -> float:
    """The least correlation; NaN where a clip has none."""
    return float(np.min([r.aperture for r in rows]))


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("runs", nargs="+", type=Path)
    parser.add_argument("--curves", type=Path, default=DATA / "mediapipe.json")
    given = parser.parse_args()
    by_detector = json.loads(given.curves.read_text())["clips"]
    for folder in given.runs:
        sys.stdout.write("\n".join([str(folder), *lines(by_detector, folder)]) + "\n")
