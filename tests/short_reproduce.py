"""The `reproduce` command on as little film as it can do with, for what is run many times.

Run it by hand, in place of `abs-engine`:

    python tests/kill_runs.py 40 python tests/short_reproduce.py 000 -o {out} --renderer cpu --quiet

It does all that `reproduce PAPER --quick` does, in the same order and by the same files; only the
frames, the pictures' size and the searches are fewer.
"""

from __future__ import annotations

import sys
from dataclasses import replace

from abs_engine.cli import main
from abs_engine.papers.basu1998 import reproduce as lips
from abs_engine.papers.odisio2004 import gathered as faces

SYLLABLES = 6
LIPS = replace(lips.QUICK, test=2, colours=6, moving=4)
FACES = replace(
    faces.QUICK, size=(160, 120), searched=2, stopped=1, budgets=(300,), frames=6, worn=3, printed=1
)

if __name__ == "__main__":
    lips.QUICK, lips.QUICK_SYLLABLES, faces.QUICK = LIPS, SYLLABLES, FACES  # type: ignore[misc]
    sys.exit(main(["reproduce", *sys.argv[1:], "--quick"]))
