"""The whole reproduction of the lips' paper on few frames, by the command line, without recordings.

What it is fast enough to show elsewhere is tested there; here, that the parts fit together.
"""

from __future__ import annotations

import json
import os
from pathlib import Path

import numpy as np
import pytest

from abs_engine.cli import main
from abs_engine.papers.basu1998.filmed import YAWS, camera_name

pytestmark = pytest.mark.skipif(
    not os.environ.get("ABS_ENGINE_SLOW"),
    reason="two minutes of filming and fitting; ABS_ENGINE_SLOW=1 runs it",
)


@pytest.fixture(scope="module")
def report(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A quick reproduction where no recording is at hand."""
    folder = tmp_path_factory.mktemp("reproduce")
    (folder / "data").mkdir()
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("ABS_ENGINE_DATA", str(folder / "data"))
        out = str(folder / "report")
        assert main(["reproduce", "000", "--quick", "--renderer", "cpu", "-o", out]) == 0
    return folder / "report"


@pytest.fixture(scope="module")
def results(report: Path) -> dict:
    return json.loads((report / "results.json").read_text())


def test_the_numbers_of_the_paper_are_there(results):
    assert 0.9 < results["variance_10_modes"] <= 1
    assert set(results["table1"]) == {"xyz8", "yz16", "xy16"}
    assert all(0 < value < 0.1 for value in results["table1"].values())
    assert 1 <= results["iterations_to_converge"] <= 15
    assert np.all(np.diff(results["variance"]) > 0)
    assert results["variance"][-1] == pytest.approx(results["variance_10_modes"])


@pytest.mark.parametrize("driver", ["forces", "gradient", "simplex"])
def test_every_driver_has_its_numbers(results, driver):
    found = results["drivers"][driver]
    assert 0 < found["mm"] < 1.5
    assert found["evaluations"] > 48  # typical shapes are compared first
    assert 0 <= found["converged"] <= 1


def test_the_table_of_drivers_says_how_the_posterior_was_integrated(results):
    rules = {name: of["posterior_rule"] for name, of in results["drivers"].items()}
    assert rules["forces_one_sample"] == rules["simplex_one_sample"] == "sample"
    assert rules["forces"] == rules["simplex"] == "exact"
    assert 0 < results["drivers"]["simplex_one_sample"]["mm"] < 1.5


def test_cameras_are_ranked(results):
    left = {int(yaw): of["beside_frontal_mm"] for yaw, of in results["cameras"]["yaw"].items()}
    assert max(left, key=left.get) == 0
    assert results["cameras"]["frontal_mm"] < results["cameras"]["without_mm"]


def test_lips_are_found_from_every_side_and_with_the_pose_unknown(results):
    (person,) = results["people"]
    assert set(results["yaw_mm"][person]) == {camera_name(yaw) for yaw in YAWS}
    assert max(results["yaw_mm"][person].values()) < 1.8
    assert results["pose"]["known"] < 1.3
    assert results["pose"]["known"] < results["pose"]["estimated"] < 3
    assert results["pose"]["blob"] < 1.6
    assert results["pose"]["frames"]["blob"] == results["pose"]["frames"]["blob_filmed"] == 40
    assert results["blob"]["found"] == 1
    assert results["blob"]["converged"] > 0.9
    assert results["further_training"]["after_mm"] < results["further_training"]["before_mm"]


def test_real_clips_are_left_out_by_quick_and_the_motion_is_authored(results, report):
    assert results["quick"] is True
    assert results["grid"]["closure_precision"] is None
    assert results["grid"]["closure_recall"] is None
    assert results["motion"] == "authored speech"
    page = (report / "index.html").read_text()
    assert "authored speech, as the recording is not there" in page
    assert "left out by --quick" in page


def test_every_figure_of_the_page_is_in_the_folder(report):
    page = (report / "index.html").read_text()
    for name in (
        "figure1.png",
        "figure2.png",
        "figure3.png",
        "figure5.png",
        "figure6.png",
        "errors.svg",
    ):
        assert name in page
        assert (report / name).stat().st_size > 1000
