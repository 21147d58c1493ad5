"""Real video: the lips of a recorded speaker close when they were seen to close."""

from __future__ import annotations

import pytest

import abs_engine
from abs_engine.papers.basu1998.real_clips import agreement, closure_labels

pytestmark = pytest.mark.slow
CLIP = "bbaf2n"
LEAST_PRECISION = LEAST_RECALL = 0.8


def test_closures_agree_with_what_was_seen(data_dir):
    video = data_dir / "grid" / f"{CLIP}.mpg"
    if not video.is_file():
        pytest.skip(f"{video.name} is not among the data")
    run = abs_engine.track(video, renderer="cpu")
    labels = closure_labels()[CLIP]
    assert len(run["index"]) == len(labels.closed)
    assert run["found"].all()
    found = agreement(labels, run)
    assert found.precision >= LEAST_PRECISION
    assert found.recall >= LEAST_RECALL
