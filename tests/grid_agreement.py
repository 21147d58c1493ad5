"""How the lips tracked in the GRID clips agree with frames labelled by eye.

Run it by hand: `python tests/grid_agreement.py RUNS`, where RUNS holds one run of
`abs-engine track` for each clip, named as the clip. The labels are in `data/grid_closures.json`.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from abs_engine.evaluate.metrics import spikes
from abs_engine.track.record import load_run

LABELS = Path(__file__).parent / "data" / "grid_closures.json"
SPIKE_MM = 4.0


def labelled(clip: str) -> tuple[NDArray[np.bool_], NDArray[np.bool_], list[list[int]]]:
    """Whether the lips are closed in each frame, whether that could be told, and the runs."""
    label = json.loads(LABELS.read_text())["clips"][clip]
    closed = np.zeros(label["n_frames"], bool)
    for first, last in label["closed"]:
        closed[first : last + 1] = True
    sure = np.ones(label["n_frames"], bool)
    sure[label["unsure"]] = False
    return closed, sure, label["closed"]


def agreement(clip: str, folder: Path) -> tuple[str, NDArray[np.int64]]:
    """A line for one clip, and its counts: hits, found, labelled, runs hit, runs."""
    run = load_run(folder)
    closed, sure, runs = labelled(clip)
    found, aperture = np.asarray(run["closed"]), np.asarray(run["aperture"])
    met = sum(bool(found[first : last + 1].any()) for first, last in runs)
    hits = int((found & closed & sure).sum())
    counts = np.array([hits, (found & sure).sum(), (closed & sure).sum(), met, len(runs)])
    line = (
        f"{clip}  precision {hits / max(1, counts[1]):.2f}  recall {hits / counts[2]:.2f}  "
        f"closures {met} of {len(runs)}  aperture closed {aperture[closed & sure].mean():.1f} mm, "
        f"open {np.median(aperture[~closed & sure]):.1f} mm  spikes {spikes(aperture, SPIKE_MM)}"
    )
    return line, counts


def table(folder: Path) -> str:
    """The lines of all clips whose runs are in `folder`, and their sum."""
    clips = [c for c in json.loads(LABELS.read_text())["clips"] if (folder / c).is_dir()]
    lines, counts = zip(*(agreement(c, folder / c) for c in clips), strict=True)
    hits, found, wanted, met, runs = np.sum(counts, axis=0)
    score = f"precision {hits / found:.2f}  recall {hits / wanted:.2f}"
    total = f"all     {score}  closures {met} of {runs}"
    return "\n".join([*lines, total]) + "\n"


if __name__ == "__main__":
    sys.stdout.write(table(Path(sys.argv[1])))
