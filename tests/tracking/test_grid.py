"""Real video: the lips of a recorded speaker close when they were seen to close."""

from __future__ import annotations

import pytest

from abs_engine.cli import main
from abs_engine.papers.basu1998.real_clips import agreement, closure_labels
from abs_engine.tracking.record import load_run

pytestmark = pytest.mark.slow
CLIP = "bbaf2n"
LEAST_PRECISION = LEAST_RECALL = 0.8


def test_closures_agree_with_what_was_seen(data_dir, tmp_path):
    video = data_dir / "grid" / f"{CLIP}.mpg"
    if not video.is_file():
        pytest.skip(f"{video.name} is not among the data")
    assert main(["track", str(video), "-o", str(tmp_path / "run"), "--renderer", "cpu"]) == 0
    run = load_run(tmp_path / "run")
    labels = closure_labels()[CLIP]
    assert len(run["index"]) == len(labels.closed)
    assert run["found"].all()
    found = agreement(labels, run)
    assert found.precision >= LEAST_PRECISION
    assert found.recall >= LEAST_RECALL
