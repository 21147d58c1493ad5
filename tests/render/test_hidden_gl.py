"""Without any OpenGL library, `track` follows a clip and says on one line what it runs on."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest
from drawn import lit
from heads import seen_at
from hurried import PROGRAM
from runs import write_kind

from abs_engine.tracking.runs.record import load_run

pytestmark = pytest.mark.slow
OPEN = (0.0, 0.2, 0.4)


def test_a_clip_is_followed_with_every_opengl_hidden(tmp_path):
    pictures = [lit("clara", seen_at([0, 0, 0], [0, 0, 700]), jawOpen=amount) for amount in OPEN]
    video = write_kind(tmp_path / "head.mp4", "libx264", pictures)
    words = "track", video, "-o", tmp_path / "run"
    root = str(Path(__file__).resolve().parents[2])
    done = subprocess.run(
        [sys.executable, "-c", PROGRAM, *map(str, words)],
        env=os.environ | {"ABS_ENGINE_HIDE_GL": "all", "PYTHONPATH": root},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    told = [line for line in done.stdout.splitlines() if line.startswith("renderer: ")]
    assert len(told) == 1
    assert "cpu" in told[0]
    assert "hidden by ABS_ENGINE_HIDE_GL" in told[0]
    assert len(told[0]) < 100
    assert "Traceback" not in done.stderr
    run = load_run(tmp_path / "run")
    assert len(run["index"]) == len(OPEN)
    assert run["found"].all()
    assert str(run["renderer"]).startswith("cpu")
    assert run["aperture"].max() > 5
