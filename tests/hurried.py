"""A preparation in half the time, for tests of what comes after it."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace

import pytest

from abs_engine.tracking import frame_choice, identity_fit, multistart
from abs_engine.tracking.settings.preparation import PREPARATION


@contextmanager
def hurried() -> Iterator[None]:
    """Half the frames to learn from, half the rounds, and two starts."""
    few = replace(
        PREPARATION, learn_from=4, view_rounds=PREPARATION.view_rounds[::2], good_score=0.0,
        poor_score=0.0,
    )  # fmt: skip
    with pytest.MonkeyPatch.context() as patch:
        for module in (frame_choice, identity_fit, multistart):
            patch.setattr(module, "PREPARATION", few)
        yield
