"""How much the heads of runs jitter: rotations off the middle of those of the frames beside them.

Run it by hand: `python tests/pose_jitter.py RUNS`, with a folder of runs. No truth is needed; a
head that really shakes counts as well, so only runs of the same clips can be compared.
"""

from __future__ import annotations

import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from abs_engine.tracking.record import load_run

FAR = 1.5
"""Degrees off that middle from which on a frame is counted."""


def off_middle(run: Mapping[str, Any]) -> NDArray[np.float64]:
    """Angles, degrees, of frames that were found, as were both beside them in the same shot."""
    found, cut = run["found"].astype(bool), run["cut"].astype(bool)
    at = np.flatnonzero(found[:-2] & found[1:-1] & found[2:] & ~cut[1:-1] & ~cut[2:]) + 1
    before, here, after = (Rotation.from_rotvec(run["rotation"][at + k]) for k in (-1, 0, 1))
    half = Rotation.from_rotvec(0.5 * (before.inv() * after).as_rotvec())
    return np.asarray(np.degrees(((before * half).inv() * here).magnitude()), np.float64)


def main(runs: Path) -> None:
    """Print a line for each run, and one for all."""
    names = sorted(p.parent.name for p in runs.glob("*/results.csv"))
    if not names:
        sys.exit(f"{runs} holds no runs")
    off = {name: off_middle(load_run(runs / name)) for name in names}
    for name, angles in {**off, "all": np.concatenate(list(off.values()))}.items():
        median, most = np.median(angles), np.percentile(angles, 95)
        sys.stdout.write(
            f"{name:8} off the middle: median {median:.2f}, 95 % {most:.2f} degrees; "
            f"{int((angles > FAR).sum())} of {len(angles)} frames beyond {FAR}\n"
        )


if __name__ == "__main__":
    main(Path(sys.argv[1]))
