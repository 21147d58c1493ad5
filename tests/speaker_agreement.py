"""Runs of one speaker's sentences against the words that were said, trackers side by side.

Run it by hand: `python tests/speaker_agreement.py CLIPS RUNS [RUNS...]`, where CLIPS holds the word
times of GRID sentences (`NAME.align`) and each RUNS one run for each clip, named as the clip. A
word that begins with b or p, or the letter m, is a closure: lips are to be closed in a frame about
its beginning. In the middle of words with an open vowel they are to be open. How steady closed
lips are is measured in frames in which they are closed in all the runs of a clip.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from abs_engine.tracking.runs.record import load_run

ABOUT, LETTER = 3, 12  # frames about the beginning of a word, and after that of a letter
OPEN = {"at", "a", "now", "white", "red", "again", "i", "nine", "r", "h", "k", "j", "five", "eight"}


def words(path: Path) -> Iterator[tuple[int, int, str]]:
    """First and last frame of each word; its file has thousandths of frames."""
    for line in path.read_text().splitlines():
        first, last, word = line.split()
        yield int(first) // 1000, int(last) // 1000, word


def met(closed: np.ndarray, said: list[tuple[int, int, str]]) -> tuple[np.ndarray, np.ndarray]:
    """Closures found and looked for; middles of open vowels that are closed, and all of them."""
    found, vowels = [], []
    for first, last, word in said:
        if word[0] in "bp" or word == "m":
            start, end = (first, first + LETTER) if word == "m" else (first - ABOUT, first + ABOUT)
            found.append(closed[max(0, start) : end + 1].any())
        if word in OPEN:
            vowels.append(closed[(first + last) // 2])
    return np.array([sum(found), len(found)]), np.array([sum(vowels), len(vowels)])


def table(clips: Path, folders: list[Path]) -> list[str]:
    """A line for each folder of runs, over the clips that all of them have."""
    every = (path.stem for path in sorted(clips.glob("*.align")))
    names = [name for name in every if all((f / name).is_dir() for f in folders)]
    runs = {f: [load_run(f / name) for name in names] for f in folders}
    rest = [np.all([runs[f][k]["closed"] for f in folders], axis=0) for k in range(len(names))]
    lines = [f"{len(names)} clips, {sum(map(np.sum, rest))} frames closed in all runs"]
    for folder, own in runs.items():
        pairs = zip(own, names, strict=True)
        hits = [met(run["closed"], list(words(clips / f"{name}.align"))) for run, name in pairs]
        closures, vowels = np.sum(hits, axis=0)
        took = [json.loads((folder / name / "timing.json").read_text()) for name in names]
        still = np.concatenate([run["aperture"][k] for run, k in zip(own, rest, strict=True)])
        lines.append(
            f"{folder.name:12s} closures {closures[0]} of {closures[1]}  open vowels closed "
            f"{vowels[0]} of {vowels[1]}  aperture closed, sd {still.std():.3f} mm  "
            f"score {np.mean([np.nanmean(run['score']) for run in own]):.3f}  "
            f"contradicted {sum(int(run['contradicted'].sum()) for run in own)}  "
            f"{1e3 * np.median([s['seconds_per_frame'] for s in took]):.0f} ms a frame after "
            f"{np.median([s['preparation_seconds'] for s in took]):.1f} s"
        )
    return lines


if __name__ == "__main__":
    sys.stdout.write("\n".join(table(Path(sys.argv[1]), list(map(Path, sys.argv[2:])))) + "\n")
