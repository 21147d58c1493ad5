"""How a recorded person moves the mouth: mean and covariance of ARKit's face units.

Usage: ``python assets/make_postures.py alex_rom_3.csv [OUTPUT_FOLDER]``, with the Live Link Face
recording that ``PROVENANCE.md`` names. Its first half is taken, and its mirror image; the second
half is left for tests. It writes ``recorded.json``.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import sys
from pathlib import Path

import numpy as np

from abs_engine.core.arrays import FloatArray
from abs_engine.face.shape.mouth import mouth_units
from abs_engine.face.shape.postures import FORMAT, RECORDED, VERSION, Postures
from abs_engine.studio.speech.livelink import read_livelink

SHA256 = "424bf902b436ee7bcb6dc5ef722e13348cd995e7f6d2e510abdebedfcf1b74f6"
DIGITS = 6


def main() -> int:
    """Write the file."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("recording", type=Path)
    parser.add_argument(
        "output", nargs="?", type=Path, default=Path(__file__).resolve().parent / "postures"
    )
    args = parser.parse_args()
    if hashlib.sha256(args.recording.read_bytes()).hexdigest() != SHA256:
        print(f"make_postures: {args.recording} is another recording", file=sys.stderr)
        return 2
    names = mouth_units()
    recording = read_livelink(args.recording)
    order = [recording.unit_names.index(name) for name in names]
    half = recording.weights[: len(recording.weights) // 2, order]
    found = Postures.of(np.concatenate([half, mirrored(half, names)]))
    args.output.mkdir(parents=True, exist_ok=True)
    content = {
        "format": FORMAT,
        "version": VERSION,
        "frames": len(half),
        "unit_names": list(names),
        "mean": found.mean.round(DIGITS).tolist(),
        "covariance": found.covariance.round(DIGITS).tolist(),
    }
    path = args.output / Path(RECORDED).name
    path.write_text(json.dumps(content) + "\n", encoding="utf-8")
    return 0


def mirrored(postures: FloatArray, names: tuple[str, ...]) -> FloatArray:
    """Postures (S, N) of the mirror image of a face."""
    return postures[:, [names.index(name) for name in twins(names)]]


def twins(names: tuple[str, ...]) -> list[str]:
    """The unit of the other side for each, or the unit itself."""
    sides = {"Left": "Right", "Right": "Left"}
    other = {n: n.removesuffix(a) + b for n in names for a, b in sides.items() if n.endswith(a)}
    return [other.get(name, name) for name in names]


if __name__ == "__main__":
    sys.exit(main())
