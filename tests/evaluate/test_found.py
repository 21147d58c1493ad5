"""Frames that a run does not call found are not scored, whatever their arrays hold."""

from __future__ import annotations

import numpy as np
from runs import written_run

from abs_engine.evaluate.estimate import of_run
from abs_engine.tracking.runs.record import load_run


def test_a_frame_that_was_not_found_says_nothing(tmp_path):
    arrays = load_run(written_run(tmp_path / "run", (0, 3, 2)))
    arrays["found"] = np.array([True, False, True])
    estimate = of_run("run", arrays, None, {})
    assert estimate.found.tolist() == [True, False, True]
    assert np.isnan(estimate.curves["aperture"]).tolist() == [False, True, False]
    assert np.isnan(estimate.tracks["lip_points"].points[1]).all()
    assert np.isnan(estimate.rotations[1]).all()
    assert not estimate.closed[1]
