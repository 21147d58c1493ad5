"""A preparation in half the time or less, for tests of what comes after it."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

import pytest

from abs_engine.tracking.person import frame_choice, identity_fit, multistart
from abs_engine.tracking.settings.preparation import PREPARATION

PROGRAM = f"""
import sys
sys.path.insert(0, {str(Path(__file__).parent)!r})
from hurried import hurried
from abs_engine.cli import main
with hurried(frames=2, rounds=1):
    sys.exit(main(sys.argv[1:]))"""
"""The program in a process of its own, by ``python -c``, with the shortest preparation."""


@contextmanager
def hurried(frames: int = 4, rounds: int = 2) -> Iterator[None]:
    """Few frames to learn from, few rounds, and two starts; in a single round one depth.

    Parameters
    ----------
    frames : int
        Of usually 8.
    rounds : int
        2 or 1 of usually 4.
    """
    every = len(PREPARATION.view_rounds) // rounds
    few = replace(
        PREPARATION, learn_from=frames, view_rounds=PREPARATION.view_rounds[::every],
        depths=PREPARATION.depths if rounds > 1 else ((0.0,),), good_score=0.0, poor_score=0.0,
    )  # fmt: skip
    with pytest.MonkeyPatch.context() as patch:
        for module in (frame_choice, identity_fit, multistart):
            patch.setattr(module, "PREPARATION", few)
        yield
