"""Real video: the lips of a recorded speaker close when they were seen to close."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from abs_engine.cli import main
from abs_engine.track.record import load_run

pytestmark = pytest.mark.slow
CLIP = "bbaf2n"
LABELS = Path(__file__).parent / "data" / "grid_closures.json"
LEAST_PRECISION = LEAST_RECALL = 0.8


def labelled(clip: str) -> tuple[np.ndarray, np.ndarray]:
    """Whether the lips are closed in each frame, and whether that could be told."""
    label = json.loads(LABELS.read_text())["clips"][clip]
    closed = np.zeros(label["n_frames"], bool)
    for first, last in label["closed"]:
        closed[first : last + 1] = True
    sure = np.ones(label["n_frames"], bool)
    sure[label["unsure"]] = False
    return closed, sure


def test_closures_agree_with_what_was_seen(data_dir, tmp_path):
    video = data_dir / "grid" / f"{CLIP}.mpg"
    if not video.is_file():
        pytest.skip(f"{video.name} is not among the data")
    assert main(["track", str(video), "-o", str(tmp_path / "run"), "--renderer", "cpu"]) == 0
    run = load_run(tmp_path / "run")
    closed, sure = labelled(CLIP)
    assert len(run["index"]) == len(closed)
    assert run["found"].all()
    hits = (run["closed"] & closed & sure).sum()
    assert hits / (run["closed"] & sure).sum() >= LEAST_PRECISION
    assert hits / (closed & sure).sum() >= LEAST_RECALL
