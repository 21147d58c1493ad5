"""The `reproduce` command on as little film as it can do with, for what is run many times.

Run it by hand, in place of `abs-engine`:

    python tests/kill_runs.py 40 python tests/short_reproduce.py 000 -o {out} --renderer cpu --quiet

It does all that `reproduce PAPER --quick` does, in the same order and by the same files; only the
frames and visemes are fewer, and searches end sooner.
"""

from __future__ import annotations

import sys
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from abs_engine.cli import main
from abs_engine.papers.basu1998 import reproduce as lips
from abs_engine.papers.odisio2004 import gathered, sentences_parts, sentences_work, visemes
from abs_engine.papers.odisio2004 import reproduce as faces

SYLLABLES = 6
TESTED, EVALUATIONS = 2, 20
LIPS = replace(lips.QUICK, test=2, colours=6, moving=4)
FACES = replace(
    gathered.QUICK, searched=TESTED, stopped=1, budgets=(faces.REPORTED,), frames=27, worn=3,
    printed=1,
)  # fmt: skip
"""In 27 frames two vowels are said, and two consonants, which the trees need."""


def splits(count: int, seed: int, rounds: int) -> list[tuple[NDArray[np.int64], ...]]:
    """`visemes.splits`, of whose visemes few are tested."""
    return [(learned, tests[:TESTED]) for learned, tests in visemes.splits(count, seed, rounds)]


def shorten() -> None:
    """Leave most of the work out."""
    lips.QUICK, lips.QUICK_SYLLABLES = LIPS, SYLLABLES
    gathered.QUICK, faces.splits, visemes.LIMIT = FACES, splits, EVALUATIONS
    for room, name in (
        (sentences_work, "_OF_TEXTURES"),
        (sentences_work, "_OF_POINTS"),
        (sentences_parts, "AS_PRINTED"),
    ):
        setattr(room, name, replace(getattr(room, name), limit=EVALUATIONS))


if __name__ == "__main__":
    shorten()
    sys.exit(main(["reproduce", *sys.argv[1:], "--quick"]))
