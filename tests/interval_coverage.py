"""How often the truth lies in a run's 90 % intervals, and how probable closed lips were.

Run it by hand: `python tests/interval_coverage.py RUNS TRUTHS`. RUNS/NAME is a run of the bundled
head, of a film TRUTHS/NAME.npz (`ict_films.py`) or of a clip in a dataset TRUTHS/NAME (`synth`).
Give `track` the camera and the pupil distance: no interval holds what is unknown of a head's size.

Of widths the mean difference of all films is left out, since ICT marks other corners. Lip points
of ICT heads are compared at shares of the contours' length, less each point's mean (see
`ict_motion.py`); those of a dataset, point by point, less the clip's mean offset.
"""

from __future__ import annotations

import sys
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from ict_agreement import convention
from ict_motion import lips_of
from numpy.typing import NDArray

from abs_engine.dataset import load_truth
from abs_engine.io.assets import CLOSED_APERTURE, Speaker, load_speaker
from abs_engine.tracking.runs.record import load_run

FloatArray = NDArray[np.float64]
WITHIN = 1.645  # standard deviations to either side: 90 %
SMALL = (1.0, 6.0)  # mm, openings as found


@dataclass(frozen=True, eq=False)
class Clip:
    """Errors of the frames found and their standard deviations, mm."""

    aperture: FloatArray  # (T,), as found
    off: FloatArray  # (T,), of the aperture
    off_sd: FloatArray  # (T,)
    width: FloatArray  # (T,), error
    width_sd: FloatArray  # (T,)
    points: FloatArray  # (T, N, 3), error
    points_sd: FloatArray  # (T, N, 3) or (T, 1, 3)
    probability: FloatArray  # (T,), of closed lips
    closed: NDArray[np.bool_]  # (T,), in truth


def clip_of(folder: Path, truths: Path, speaker: Speaker) -> Clip:
    """A run against the truth of the same name."""
    run = load_run(folder)
    film = truths / f"{folder.name}.npz"
    true = np.load(film) if film.is_file() else _of_dataset(truths / folder.name)
    at = np.flatnonzero(run["found"] & np.isfinite(run["aperture_sd"]))
    ours = {k: run[k][at].astype(float) for k in ("aperture", "width")}
    points = _by_contours if film.is_file() else _by_vertices
    off, off_sd = points(run, true, at, speaker)
    aperture = true["aperture"][at]
    return Clip(
        ours["aperture"], ours["aperture"] - aperture, run["aperture_sd"][at],
        ours["width"] - true["width"][at], run["width_sd"][at], off, off_sd,
        run["closed_probability"][at], aperture < CLOSED_APERTURE,
    )  # fmt: skip


def _of_dataset(folder: Path) -> dict[str, Any]:
    """Aperture, width and vertices of a dataset's only clip, frame by frame."""
    clip = load_truth(next(p for p in sorted(folder.iterdir()) if (p / "truth.npz").is_file()))
    vertices = np.stack([clip.vertices(k) for k in range(len(clip))])
    return {"aperture": clip.aperture, "width": clip.width, "vertices": vertices}


def _by_contours(
    run: Mapping[str, Any], true: Mapping[str, Any], at: NDArray[np.int_], speaker: Speaker
) -> tuple[FloatArray, FloatArray]:
    """Errors (T, 36, 3) of an ICT head's lips and their deviations (T, 1, 3)."""
    ours, theirs = lips_of(run, true, speaker)
    theirs = theirs @ convention(speaker, true["neutral"][true["landmarks"]].astype(float)).T
    off = (ours - ours.mean(axis=0)) - (theirs - theirs.mean(axis=0))
    known = np.isin(np.flatnonzero(run["found"]), at)
    return off[known], np.median(run["lip_points_sd"][at], axis=1)[:, None]


def _by_vertices(
    run: Mapping[str, Any], true: Mapping[str, Any], at: NDArray[np.int_], _: Speaker
) -> tuple[FloatArray, FloatArray]:
    """Errors (T, N, 3) of a bundled head's lips and their deviations, point by point."""
    off = run["lip_points"][at] - true["vertices"][at][:, run["lip_vertex"]]
    return off - off.mean(axis=(0, 1)), run["lip_points_sd"][at]


def held(error: FloatArray, deviation: FloatArray) -> NDArray[np.bool_]:
    """Which truths lie in their interval."""
    return np.asarray(np.abs(error) < WITHIN * deviation)


def lines(clips: Mapping[str, Clip]) -> list[str]:
    """A line for each clip, their means, and how probable closed lips were."""
    corners = float(np.mean([c.width.mean() for c in clips.values()]))
    rows = {
        name: np.r_[
            held(c.off, c.off_sd).mean(),
            held(c.width - corners, c.width_sd).mean(),
            held(c.points, c.points_sd).mean(axis=(0, 1)),
        ]
        for name, c in clips.items()
    }
    rows["all"] = np.mean(list(rows.values()), axis=0)
    out = [
        f"{name:8} aperture {r[0]:.2f}, width {r[1]:.2f}, "
        f"lip points along x, y, z {r[2]:.2f}, {r[3]:.2f}, {r[4]:.2f}"
        for name, r in rows.items()
    ]
    return [*out, f"mean difference of widths, left out: {corners:.1f} mm", *_of_all(clips)]


def _of_all(clips: Mapping[str, Clip]) -> list[str]:
    """What only all frames together can show."""
    found, off, deviation, p, closed = (
        np.concatenate([getattr(c, name) for c in clips.values()])
        for name in ("aperture", "off", "off_sd", "probability", "closed")
    )
    small = (found > SMALL[0]) & (found < SMALL[1])
    kept = np.clip(p, 1e-3, 1 - 1e-3)
    loss = -np.log(np.where(closed, kept, 1 - kept)).mean()
    shares = ", ".join(
        f"{closed[those].mean():.3f} of {those.sum()} with {what}"
        for what, those in (("less than 0.1", p < 0.1), ("more than 0.9", p > 0.9))
        if those.any()
    )
    return [
        f"openings found between {SMALL[0]:.0f} and {SMALL[1]:.0f} mm, {small.sum()} frames: "
        f"aperture {held(off, deviation)[small].mean():.2f}",
        f"closed lips: {shares}; log loss {loss:.3f}",
    ]


def main(runs: Path, truths: Path) -> None:
    """Print how often each clip's truths lie in their intervals."""
    speaker = load_speaker()
    folders = [p for p in sorted(runs.iterdir()) if (p / "results.npz").is_file()]
    if not folders:
        sys.exit(f"{runs} holds no run")
    clips = {folder.name: clip_of(folder, truths, speaker) for folder in folders}
    sys.stdout.write("\n".join(lines(clips)) + "\n")


if __name__ == "__main__":
    main(*map(Path, sys.argv[1:3]))
