"""The demo command, whole: its report is there, and its numbers hold."""

from __future__ import annotations

import html
import json
import re
from urllib.parse import unquote

import pytest

from abs_engine.cli import main
from abs_engine.cli.commands.demo import demo
from abs_engine.dataset import load_truth
from abs_engine.evaluate.metrics import spikes
from abs_engine.io.assets import read_image
from abs_engine.io.video import probe
from abs_engine.report.demo import DemoOptions
from abs_engine.report.demo_page import head_given
from abs_engine.tracking.runs.record import load_run

pytestmark = pytest.mark.slow
FRAMES, LIP_RMS_MM, SPIKE_MM = 25, 1.5, 3.0


@pytest.fixture(scope="module")
def report(tmp_path_factory):
    folder = tmp_path_factory.mktemp("demo") / "report"
    words = ["demo", "-o", str(folder), "--frames", str(FRAMES), "--renderer", "cpu"]
    assert main(words) == 0
    assert [p.name for p in folder.parent.iterdir()] == ["report"]
    return folder


@pytest.fixture(scope="module")
def scores(report):
    told = json.loads((report / "evaluation" / "scores.json").read_text())["systems"]["run"]
    return {name: one["value"] for name, one in told.items()}


def test_every_frame_is_tracked(scores):
    assert (scores["frames"], scores["frames_lost"]) == (FRAMES, 0)


def test_lips_are_near_the_truth(scores):
    assert scores["lip_points_rms_head_mm"] < LIP_RMS_MM, scores


def test_the_aperture_follows_the_truth(report, scores):
    assert scores["aperture_correlation"] > 0.9
    assert spikes(load_run(report / "run")["aperture"], SPIKE_MM) == 0


def test_the_page_shows_files_that_exist(report):
    page = (report / "index.html").read_text(encoding="utf-8")
    files = {unquote(name) for name in re.findall(r'(?:src|href)="([^"]+)"', page)}
    assert len(files) >= 5
    for name in files:
        assert (report / name).stat().st_size > 0
    assert read_image(report / "run" / "contact_sheet.png").shape[1] > 1000
    assert probe(report / "run" / "overlay.mp4").frames == FRAMES


def test_the_page_says_which_head_was_given(report):
    page = (report / "index.html").read_text(encoding="utf-8")
    assert html.escape(head_given("clara", person_known=True)) in page
    assert "clara's own (speaker-specific tracking)" in head_given("clara", person_known=True)
    assert json.loads((report / "run" / "run.json").read_text())["settings"]["person"] == "clara"


def test_with_the_average_head_the_unseen_offset_is_owned_up_to():
    said = head_given("clara", person_known=False)
    assert "average head, not clara's" in said
    assert "cannot be observed" in said
    assert "contains that constant offset" in said


def test_the_average_head_can_be_asked_for():
    assert demo.make_context("demo", ["--average-head"]).params["average_head"]
    assert not demo.make_context("demo", []).params["average_head"]


def test_the_usual_clip_is_that_of_a_webcam_and_a_known_head():
    options = DemoOptions()
    assert (options.person, options.size, options.frames) == ("clara", (640, 480), 50)
    assert options.person_known


def test_run_and_truth_can_be_evaluated_again(report, tmp_path, capsys):
    words = ["evaluate", str(report / "run"), "--truth", str(report / "clip")]
    assert main([*words, "-o", str(tmp_path / "again")]) == 0
    assert "lip points, head coordinates, RMS" in capsys.readouterr().out
    again, first = (json.loads((folder / "scores.json").read_text())
                    for folder in (tmp_path / "again", report / "evaluation"))  # fmt: skip
    assert again["systems"] == first["systems"]
    assert len(load_run(report / "run")["index"]) == len(load_truth(report / "clip", verify=True))
