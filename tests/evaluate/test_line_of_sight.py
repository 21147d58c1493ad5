"""The head's position error along and across the line of sight, and how the demo explains it."""

from __future__ import annotations

import numpy as np
import pytest

from abs_engine.evaluate.metrics.pose import position_errors
from abs_engine.report.demo_page import camera_error, demo_page, head_given


def test_an_error_is_split_by_the_direction_in_which_the_head_is_seen():
    true = np.array([[0.0, 0, 500], [300, 0, 400], [0, 0, 600]])
    away = np.array(
        [[3.0, 0, 4], [0.6 * 5, 0, 0.8 * 5], [1, 2, 3]]
    )  # the second points straight on
    found = true + away
    found[2] = np.nan
    along, across = position_errors(found, true)
    assert along == pytest.approx(np.sqrt((4**2 + 5**2) / 2))
    assert across == pytest.approx(np.sqrt((3**2 + 0) / 2))


def test_nothing_tracked_has_no_error():
    assert np.isnan(position_errors(np.full((2, 3), np.nan), np.ones((2, 3)))).all()


def test_the_page_tells_what_was_given_once_and_why_camera_coordinates_are_worse():
    run = {
        "summary": {
            "frames": 2,
            "mean_evaluations": 300.0,
        },
        "renderer": "cpu",
    }
    remarks = (head_given("<clara>", person_known=True), camera_error(7.5, 1.25))
    sources = {"the run 'run'": {"commit": "a", "dirty": True}}
    rows = [("lip points", "1 mm")]
    page = demo_page("<clara>", "clip/a&b.mp4", run, rows, remarks, sources)
    top = page.split("<h1>")[0]
    assert "the run &#x27;run&#x27; had changes" in top
    assert "commit unknown" in page
    assert "only that video" not in page
    assert "7.50 mm along the line of sight, 1.25 mm across it" in page
    assert page.count("Head given to the tracker") == 1
    assert "<clara>" not in page
    assert 'href="clip/a&amp;b.mp4"' in page
