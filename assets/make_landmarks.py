"""Where the landmark network sees its points on the bundled head, and how far it is off.

Usage: ``python assets/make_landmarks.py [OUTPUT_FOLDER]``: draws the six people in several postures
from several sides (the CPU rasteriser, a lamp above the camera), lets the network look, and writes
``landmarks.npz``. Nothing but this repository is needed; it takes a minute.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from abs_engine.assets import Speaker, load_speaker
from abs_engine.render.cpu import CpuRenderer
from abs_engine.track.correspondence import FILE, Sighting, learn_correspondence
from abs_engine.track.sightings import sightings_of

POSTURES: tuple[dict[str, float], ...] = (
    {},
    {"jawOpen": 0.35},
    {"jawOpen": 0.15, "mouthUpperUpLeft": 0.2, "mouthUpperUpRight": 0.2},
    {
        "mouthSmileLeft": 0.6,
        "mouthSmileRight": 0.6,
        "jawOpen": 0.1,
        "mouthUpperUpLeft": 0.3,
        "mouthUpperUpRight": 0.3,
    },
    {"mouthPucker": 0.6, "mouthFunnel": 0.3, "jawOpen": 0.1},
)


def all_sightings(speaker: Speaker) -> Iterator[Sighting]:
    """Every person in every posture from every side."""
    renderer = CpuRenderer()
    for name in speaker.people:
        neutral, texture = speaker.named(name).astype(np.float64), speaker.texture(name)
        for posture in POSTURES:
            units = speaker.unit_matrix(tuple(posture))
            moved = neutral + np.tensordot(np.array(list(posture.values())), units, 1)
            yield from sightings_of(speaker, moved, texture, renderer)


def main() -> int:
    """Learn from the drawings and write the file."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument(
        "output", nargs="?", type=Path, default=Path(__file__).resolve().parent / "speaker"
    )
    folder = parser.parse_args().output
    speaker = load_speaker()
    found = learn_correspondence(speaker, list(all_sightings(speaker)))
    found.save(folder / FILE)
    off = ", ".join(f"{mm:.1f}" for mm in np.median(found.deviation, axis=0))
    print(f"{FILE}: landmarks are off by {off} mm (median: across, down, in depth)")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
