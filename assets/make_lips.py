"""Learned physics of lips from the bundled head's own speech: what ``--model shell`` moves by.

Usage: ``python assets/make_lips.py [OUTPUT_FOLDER]``: lets one of the bundled people speak some
forty seconds, observes sixteen dots on the lips with the errors of two cameras, and learns ten
modes (Basu, Oliver and Pentland 1998, sections 3 and 4). It writes ``lips.npz``. Nothing but this
repository is needed; it takes some ten seconds.
"""

from __future__ import annotations

import argparse
from pathlib import Path

from abs_engine.io.assets import load_speaker
from abs_engine.learn.training import train
from abs_engine.papers.basu1998.experiment import OBSERVED
from abs_engine.papers.basu1998.motion import observed_motion, spoken_motion

PERSON, SEED = "clara", 0


def main() -> None:
    """Write the file."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument(
        "output", nargs="?", type=Path, default=Path(__file__).resolve().parent / "lips"
    )
    folder = parser.parse_args().output
    folder.mkdir(parents=True, exist_ok=True)
    speaker = load_speaker()
    motion = spoken_motion(speaker, PERSON)
    dots = observed_motion(speaker, motion, noise=OBSERVED, seed=SEED)
    path = folder / "lips.npz"
    path.unlink(missing_ok=True)
    train(dots, speaker, PERSON, n_train=len(motion)).physics.save(path)


if __name__ == "__main__":
    main()
