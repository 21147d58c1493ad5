"""How the frames that the tracker calls covered or lost agree with what was filmed.

Run it by hand: `python tests/covered_agreement.py RUNS DATASET`, where DATASET was filmed from
`data/covered.toml` and RUNS holds one run of `abs-engine track` for each clip, named as the clip.
A mouth counts as hidden where less than half of its 12 outer landmarks are seen.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from abs_engine import load_dataset, load_run

OUTER = 12


def agreement(folder: Path, visible: NDArray[np.bool_]) -> tuple[str, NDArray[np.int64]]:
    """A line for one run, and its counts: hits, flagged, hidden."""
    run = load_run(folder)
    flagged = ~np.asarray(run["found"])
    hidden = visible[:, :OUTER].mean(axis=1) < 0.5
    counts = np.array([(flagged & hidden).sum(), flagged.sum(), hidden.sum()])
    line = (
        f"{folder.name:8}  hidden {counts[2]}, flagged {counts[1]} "
        f"({int(np.asarray(run['covered']).sum())} as covered), both {counts[0]}; "
        f"flagged though seen: {np.flatnonzero(flagged & ~hidden).tolist()}, "
        f"missed: {np.flatnonzero(hidden & ~flagged).tolist()}"
    )
    return line, counts


def table(runs: Path, dataset: Path) -> str:
    """The lines of all clips, and their sum."""
    views = [v for v in load_dataset(dataset) if (runs / v.folder.parent.name).is_dir()]
    found = [
        agreement(runs / v.folder.parent.name, np.load(v.folder / "points.npz")["lip_visible"] > 0)
        for v in views
    ]
    hits, flagged, hidden = np.sum([counts for _, counts in found], axis=0)
    total = f"all       precision {hits / flagged:.2f}  recall {hits / hidden:.2f}"
    return "\n".join([*(line for line, _ in found), total]) + "\n"


if __name__ == "__main__":
    sys.stdout.write(table(Path(sys.argv[1]), Path(sys.argv[2])))
