"""How the tracked lips of films of ICT heads (`ict_films.py`) move, against the truth.

Run it by hand: `python tests/ict_motion.py RUNS FILMS`, with runs of the bundled head. Two heads
share no vertices: each film's lips are compared at nine shares of the length of four contours, from
corner to corner (the outer ones above and below, the inner ones), in the head's coordinates, less
each point's mean over the film. The true person's landmarks are laid on our average head's, as for
`own` in `ict_agreement.py`: what that leaves of a turn between the heads counts as error, too.
"""

from __future__ import annotations

import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from ict_agreement import convention
from numpy.typing import NDArray

from abs_engine.face.rings import lip_rings
from abs_engine.io.assets import Speaker, load_speaker
from abs_engine.tracking.runs.record import load_run

FloatArray = NDArray[np.float64]
SHARES = np.linspace(0.1, 0.9, 9)
NAMES = ("whole", "across the face", "front to back", "the truth's own")


def halves(ring: NDArray[np.integer], corners: NDArray[np.integer]) -> list[NDArray[np.integer]]:
    """A closed contour (N,) as its two ways from one corner (2,) to the other."""
    first = np.roll(ring, -int(np.flatnonzero(ring == corners[0])[0]))
    there = int(np.flatnonzero(first == corners[1])[0])
    return [first[: there + 1], np.r_[first[there:], first[:1]]]


def at_shares(path: FloatArray) -> FloatArray:
    """Points (T, 9, 3) at `SHARES` of the length of each contour (T, N, 3), from the left on."""
    ways = path if path[0, 0, 0] < path[0, -1, 0] else path[:, ::-1]
    lengths = np.linalg.norm(np.diff(ways, axis=1), axis=2).cumsum(axis=1)
    return np.stack(
        [
            np.stack([np.interp(SHARES, np.r_[0, s] / s[-1], p[:, d]) for d in range(3)], axis=1)
            for p, s in zip(ways, lengths, strict=True)
        ]
    )


def contours(
    points: FloatArray, vertex: NDArray[np.integer], rings: Mapping[str, NDArray[np.integer]]
) -> FloatArray:
    """The four contours of lips (T, N, 3) whose points are these vertices (N,): (T, 36, 3)."""
    place = {int(v): k for k, v in enumerate(vertex)}
    ways = [*halves(rings["outer"], rings["corners"]), rings["upper"], rings["lower"]]
    paths = [points[:, [place[int(v)] for v in way]] for way in ways]
    paths[:2] = sorted(paths[:2], key=lambda path: -path[..., 1].mean())
    return np.concatenate([at_shares(path) for path in paths], axis=1)


def lips_of(
    run: Mapping[str, Any], true: Mapping[str, Any], speaker: Speaker
) -> tuple[FloatArray, FloatArray]:
    """Contours (T, 36, 3) in the frames found, in their own head's frame: ours, and the truth's."""
    at = np.flatnonzero(run["found"])
    names = ("outer", "upper", "lower")
    rings = {k: true[f"{k}_vertex"] for k in (*names, "corners")}
    points = np.concatenate([true[k][at] for k in names], axis=1).astype(float)
    theirs = contours(points, np.concatenate([rings[k] for k in names]), rings)
    lips = run["lip_points"][at].astype(float)
    return contours(lips, run["lip_vertex"], lip_rings(speaker)), theirs


def errors(folder: Path, film: Path, speaker: Speaker) -> list[float]:
    """RMS, mm, of what `NAMES` say, in the frames found."""
    run, true = load_run(folder), np.load(film)
    ours, theirs = lips_of(run, true, speaker)
    person = true["neutral"][true["landmarks"]].astype(float)
    theirs = theirs @ convention(speaker, person).T
    ours, theirs = (lips - lips.mean(axis=0) for lips in (ours, theirs))
    parts = ours - theirs, (ours - theirs)[..., :2], (ours - theirs)[..., 2:], theirs
    return [float(np.sqrt((part**2).sum(axis=-1).mean())) for part in parts]


def main(runs: Path, films: Path) -> None:
    """Print each film's line, and their means."""
    speaker = load_speaker()
    names = sorted(p.stem for p in films.glob("film_*.npz") if (runs / p.stem).is_dir())
    if not names:
        sys.exit(f"{runs} holds no run of a film of {films}")
    found = {name: errors(runs / name, films / f"{name}.npz", speaker) for name in names}
    for name, row in {**found, "all": np.mean(list(found.values()), axis=0)}.items():
        told = ", ".join(f"{what} {mm:.2f}" for what, mm in zip(NAMES, row, strict=True))
        sys.stdout.write(f"{name:8} motion of the lips, RMS, mm: {told}\n")


if __name__ == "__main__":
    main(*map(Path, sys.argv[1:3]))
