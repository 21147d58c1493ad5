"""Clips in which the mouth never closes, and how far their runs agree with those of whole clips.

Of each clip those frames are kept, one after the other, in which its run's aperture is above the
median and above 3 mm; a clip with fewer than 14 of them is left out. Run it by hand, first to make
the clips, then to compare the runs that `abs-engine track` made of both:

    python tests/open_clips.py make CLIPS RUNS OPEN
    python tests/open_clips.py compare RUNS OPEN_RUNS
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from altered_clips import clips_in, rate_of, write
from numpy.typing import NDArray

from abs_engine.io.video import read_frames
from abs_engine.tracking.runs.record import load_run

LEAST_MM, FEWEST = 3.0, 14


def kept(run: Path) -> NDArray[np.intp]:
    """The frames of a run that are kept."""
    aperture = np.nan_to_num(load_run(run)["aperture"])
    return np.flatnonzero(aperture > max(LEAST_MM, float(np.median(aperture))))


def rewrite(source: Path, target: Path, frames: NDArray[np.intp]) -> None:
    """Write some frames of a video."""
    wanted = set(frames.tolist())
    images = [image for k, image in enumerate(read_frames(source)) if k in wanted]
    write(target, images, rate_of(source), crf=14)


def compared(runs: Path, opened: Path) -> Iterator[str]:
    """A line for each run, then one for each half of the strangers."""
    rows: dict[str, list[list[float]]] = {}
    for folder in sorted(p for p in opened.iterdir() if p.is_dir()):
        if not (runs / folder.name).is_dir():
            continue
        whole, other = load_run(runs / folder.name), load_run(folder)
        both = other["found"]
        off = (other["aperture"] - whole["aperture"][kept(runs / folder.name)])[both]
        sd = other["aperture_sd"][both]
        row = [
            off.mean(), np.sqrt(np.mean(off**2)), np.mean(other["closed"][both]),
            np.mean(np.abs(off) < 1.645 * sd),
        ]  # fmt: skip
        rows.setdefault("p01 to p08" if folder.name < "p09" else "others", []).append(row)
        yield f"{folder.name}: {_line(row)}"
    for half, each in sorted(rows.items()):
        yield f"{half}, {len(each)} clips: {_line(np.mean(each, axis=0).tolist())}"


def _line(row: list[float]) -> str:
    mean, rms, closed, held = row
    return (
        f"apertures {mean:+.2f} mm, {rms:.2f} RMS from those of the whole clip, {100 * closed:.0f} "
        f"% closed, {100 * held:.0f} % within the 90 % interval"
    )


def main(what: str, *folders: Path) -> None:
    """Do what the command says."""
    if what == "compare":
        sys.stdout.write("\n".join(compared(*folders)) + "\n")
        return
    clips, runs, target = folders
    target.mkdir(parents=True, exist_ok=True)
    for clip in clips_in(clips):
        if len(frames := kept(runs / clip.stem)) >= FEWEST:
            rewrite(clip, target / f"{clip.stem}.mp4", frames)


if __name__ == "__main__":
    main(sys.argv[1], *map(Path, sys.argv[2:]))
