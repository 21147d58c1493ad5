"""Without any OpenGL library, `track` follows a clip and says on one line what it runs on."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from abs_engine.dataset import load_truth
from abs_engine.report.demo import film_clip
from abs_engine.tracking.record import load_run

pytestmark = pytest.mark.slow
FRAMES = 5
TRACK = "import sys; from abs_engine.cli import main; sys.exit(main(sys.argv[1:]))"


def test_a_clip_is_followed_with_every_opengl_hidden(tmp_path):
    clip = film_clip(
        tmp_path / "clip", "m a p", person="clara", size=(320, 240), frames=FRAMES, seed=3
    )
    video = load_truth(clip).video
    camera = video.with_name("camera.json")
    words = "track", video, "-o", tmp_path / "run", "--camera", camera
    root = str(Path(__file__).resolve().parents[2])
    done = subprocess.run(
        [sys.executable, "-c", TRACK, *map(str, words)],
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
    assert len(run["index"]) == FRAMES
    assert run["found"].all()
    assert str(run["renderer"]).startswith("cpu")
    assert run["aperture"].max() > 5
