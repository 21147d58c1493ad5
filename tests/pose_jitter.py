"""How much the heads of runs jitter: rotations off the middle of those of the frames beside them.

Run it by hand: `python tests/pose_jitter.py RUNS`, with a folder of runs. No truth is needed; a
head that really shakes counts as well, so only runs of the same clips can be compared. With FILMS
beside it, of heads that tremble (`python tests/ict_films.py FILMS --tremor`), it says how much of
that is found.
"""

from __future__ import annotations

import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from ict_films import TREMOR
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from abs_engine.tracking.runs.record import load_run

FAR = 1.5
"""Degrees off that middle from which on a frame is counted."""
SLOW = 6
"""Coefficients of the polynomial in time that stands for motion slower than a tremor."""


def off_middle(run: Mapping[str, Any]) -> NDArray[np.float64]:
    """Angles, degrees, of frames that were found, as were both beside them in the same shot."""
    found, cut = run["found"].astype(bool), run["cut"].astype(bool)
    at = np.flatnonzero(found[:-2] & found[1:-1] & found[2:] & ~cut[1:-1] & ~cut[2:]) + 1
    before, here, after = (Rotation.from_rotvec(run["rotation"][at + k]) for k in (-1, 0, 1))
    half = Rotation.from_rotvec(0.5 * (before.inv() * after).as_rotvec())
    return np.asarray(np.degrees(((before * half).inv() * here).magnitude()), np.float64)


def shaking(rotations: Rotation, time: NDArray[np.float64]) -> NDArray[np.complex128]:
    """Amplitude and phase of each part of `TREMOR` in rotations, beside a slow motion; radians."""
    turns = (rotations.mean().inv() * rotations).as_rotvec()
    slow, out = np.vander(2 * time / time[-1] - 1, SLOW), []
    for _, hertz, axis in TREMOR:
        waves = np.exp(2j * np.pi * hertz * time)
        fitted = np.linalg.lstsq(np.c_[waves.imag, waves.real, slow], turns[:, axis])[0]
        out.append(complex(fitted[0], fitted[1]))
    return np.array(out)


def tremor(run: Mapping[str, Any], film: Path) -> NDArray[np.complex128]:
    """Of each part of a film's tremor, the share that is found; its angle is the lag in phase."""
    true, at = np.load(film), np.flatnonzero(run["found"])
    ours = Rotation.from_rotvec(run["rotation"][at])
    theirs = Rotation.from_matrix(true["rotation"][at])
    time = at / float(true["rate"])
    return shaking(ours, time) / shaking(theirs, time)


def tell_tremor(runs: Path, films: Path, names: list[str]) -> None:
    """Print how much of the films' tremor is found."""
    parts = np.array([tremor(load_run(runs / n), films / f"{n}.npz") for n in names])
    share, late = np.abs(parts).mean(), np.degrees(-np.angle(parts)).mean()
    sys.stdout.write(f"of the tremor {share:.2f} is found, {late:.1f} degrees of phase late\n")


def main(runs: Path, films: Path | None = None) -> None:
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
    if films is not None:
        tell_tremor(runs, films, names)


if __name__ == "__main__":
    main(*map(Path, sys.argv[1:3]))
