"""The report of a run against its truth, on a truth made by hand."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace

import cv2
import numpy as np
import pytest
from matplotlib.figure import Figure

from abs_engine.core.camera import Camera
from abs_engine.core.errors import InputFileError, ParameterError
from abs_engine.dataset import Truth
from abs_engine.evaluate.catalogue import catalogue
from abs_engine.evaluate.estimate import of_run
from abs_engine.evaluate.score import measure, summary
from abs_engine.evaluate.score_table import as_values
from abs_engine.evaluate.truth_report import CURVES, draw, score
from abs_engine.io.assets import CLOSED_APERTURE

FRAMES = 40


@pytest.fixture
def truth():
    """Eight inner-lip points and two corners: the lips part by 0 to 10 mm, the corners by 44 mm."""
    rng = np.random.default_rng(3)
    neutral = rng.normal(size=(10, 3)).astype(np.float32) * 5
    neutral[2], neutral[6] = [0, 0, 90], [0, 0, 90]
    neutral[8], neutral[9] = [-22, 0, 80], [22, 0, 80]
    offsets = np.zeros((FRAMES, 10, 3), np.float16)
    opening = 10 * np.sin(np.linspace(0, 3 * np.pi, FRAMES)) ** 2
    offsets[:, 6, 1] = -np.round(opening * 8) / 8
    return Truth(
        folder=Path("nowhere"),
        camera=Camera.ideal((320, 240)),
        rate=25.0,
        person="clara",
        sentence="demo",
        command="",
        seed=0,
        unit_names=(),
        unit_weights=np.zeros((FRAMES, 0)),
        identity_weights=np.zeros(0, np.float32),
        neutral=neutral,
        offsets=offsets,
        faces=np.zeros((0, 3), np.int32),
        facet_class=np.zeros(0, np.uint8),
        class_names=("background",),
        rotations=np.tile([np.pi - 0.05, 0.02, 0.1], (FRAMES, 1)),
        translations=np.tile([3.0, 5, 600], (FRAMES, 1)),
        closed=-offsets[:, 6, 1] < 1.0,
        landmarks={"inner_lip_8": np.arange(8), "mouth_corners": np.array([8, 9])},
    )


@pytest.fixture
def run(truth):
    """A run that found the truth."""
    vertex = np.arange(10)
    return {
        "lip_points": truth.points(vertex),
        "lip_vertex": vertex,
        "rotation": truth.rotations,
        "translation": truth.translations,
        "aperture": truth.aperture,
        "width": truth.width,
    }


def values(run, truth):
    return {name: one.value for name, one in score(run, truth).items()}


def test_the_truth_scores_full_marks(truth, run):
    scores = values(run, truth)
    np.testing.assert_equal(
        values(SimpleNamespace(arrays=run), truth), scores
    )  # as `track` gives it
    assert scores["lip_points_rms_head_mm"] == 0
    assert scores["lip_points_rms_head_offset_removed_mm"] == pytest.approx(0, abs=1e-9)
    assert scores["lip_points_rms_camera_mm"] == scores["head_position_rms_mm"] == 0
    assert scores["head_angle_rms_deg"] == pytest.approx(0, abs=1e-5)
    assert scores["aperture_correlation"] == pytest.approx(1)
    assert scores["width_rms_mm"] == 0
    assert scores["closure_precision_frames"] == scores["closure_recall_frames"] == 1
    assert (scores["frames"], scores["frames_lost"]) == (FRAMES, 0)


def test_scores_have_the_names_and_the_numbers_of_evaluate(truth, run):
    scores = score(run, truth)
    clip = measure(of_run("run", run, None, {}), truth, None)
    np.testing.assert_equal(as_values(scores), as_values(summary([clip])))
    assert set(scores) <= {metric.key for metric in catalogue()}


def test_head_and_camera_errors_are_told_apart(truth, run):
    run["translation"] = run["translation"] + [0, 0, 2.0]
    scores = values(run, truth)
    assert scores["lip_points_rms_head_mm"] == 0
    assert scores["lip_points_rms_camera_mm"] == pytest.approx(2)
    assert scores["head_position_rms_mm"] == pytest.approx(2)
    run["lip_points"] = run["lip_points"] + [0, 1.5, 0]
    scores = values(run, truth)
    assert scores["lip_points_rms_head_mm"] == pytest.approx(1.5)
    assert scores["lip_points_rms_head_offset_removed_mm"] == pytest.approx(0, abs=1e-9)


def test_opposite_rotation_vectors_near_half_a_turn_are_near(truth, run):
    vectors = np.tile([np.pi - 0.01, 0, 0], (FRAMES, 1))
    scores = values(run | {"rotation": vectors - [2 * np.pi - 0.03, 0, 0]}, truth)
    direct = values(run | {"rotation": np.add(vectors, [0.03, 0, 0])}, truth)
    assert scores["head_angle_rms_deg"] == pytest.approx(direct["head_angle_rms_deg"], abs=1e-6)


def test_lost_frames_are_counted_and_left_out(truth, run):
    for name in ("lip_points", "aperture", "width"):
        run[name] = run[name].copy()
        run[name][7] = np.nan
    scores = values(run, truth)
    assert scores["frames_lost"] == 1
    assert scores["lip_points_rms_head_mm"] == 0
    assert scores["aperture_rms_mm"] == 0


def test_closures_of_a_run(truth, run):
    run["aperture"] = run["aperture"].copy()
    at = int(np.flatnonzero(truth.closed)[0]) + 1
    run["aperture"][at] = 30
    scores = values(run, truth)
    assert scores["closure_precision_frames"] == 1
    n = int(truth.closed.sum())
    missed = int(truth.closed[at])
    assert scores["closure_recall_frames"] == pytest.approx((n - missed) / n)
    always = np.ones(FRAMES, bool)
    said = values(run | {"closed": always}, truth)
    np.testing.assert_equal(said, scores)  # its own word does not count


def test_curves_are_drawn(truth, run, tmp_path):
    draw(run, truth, tmp_path)
    picture = cv2.imread(str(tmp_path / CURVES))
    assert min(picture.shape[:2]) > 500
    assert picture.std() > 5


def test_the_curves_say_by_what_lips_are_shaded_and_show_each_frame(
    truth, run, tmp_path, monkeypatch
):
    """The film's own `closed` is stricter, and shaded in a report; a frame alone has no line."""
    drawn = []
    monkeypatch.setattr(Figure, "savefig", lambda self, *_, **__: drawn.append(self))
    draw(run, truth, tmp_path)
    assert f"true aperture below {CLOSED_APERTURE:g} mm" in drawn[0].get_suptitle()
    lines = [line for axes in drawn[0].axes for line in axes.lines if line.get_label() != "truth"]
    assert [line.get_marker() for line in lines] == ["."] * 4


def test_a_run_of_lists_scores_as_one_of_arrays(truth, run):
    run |= {"aperture_sd": np.full(FRAMES, 0.5)}
    listed = {name: np.asarray(given).tolist() for name, given in run.items()}
    np.testing.assert_equal(values(listed, truth), values(run, truth))


@pytest.mark.parametrize(
    ("name", "change", "said"),
    [
        ("lip_vertex", lambda v: v.astype(float), "holds float64, not whole numbers"),
        ("rotation", lambda v: np.tile(np.eye(3), (len(v), 1, 1)), "has shape (40, 3, 3), not"),
        ("lip_points", lambda v: v[..., :2], "has shape (40, 10, 2), not"),
        ("lip_vertex", lambda v: v[:5], "'lip_vertex' of the run has shape (5,), not (10)"),
        ("aperture", lambda v: np.array(["wide"] * len(v)), "not real numbers"),
        ("aperture", lambda v: np.full(len(v), np.inf), "'aperture' of the run holds infinity"),
        ("aperture", lambda v: [[1.0]] + [[1.0, 2.0]] * (len(v) - 1), "'aperture' of the run"),
        ("width", lambda _v: 3.0, "'width' of the run has shape (), not (40)"),
    ],
)
def test_arrays_that_are_none_of_a_run_are_named(truth, run, name, change, said):
    with pytest.raises(ParameterError) as caught:
        score(run | {name: change(run[name])}, truth)
    assert said in str(caught.value)


def test_runs_of_something_else_are_refused(truth, run):
    with pytest.raises(InputFileError, match="lacks aperture, width"):
        score({k: v for k, v in run.items() if k not in ("aperture", "width")}, truth)
    with pytest.raises(ParameterError, match="the truth 40"):
        score({k: v if k == "lip_vertex" else v[:-1] for k, v in run.items()}, truth)
    with pytest.raises(ParameterError, match="not among"):
        score(run | {"lip_vertex": run["lip_vertex"] + 1}, truth)
    with pytest.raises(ParameterError, match="has tracked no frame"):
        score(run | {"lip_points": np.full_like(run["lip_points"], np.nan)}, truth)
    with pytest.raises(ParameterError, match="seed is 'x'; give a whole number"):
        score(run, truth, seed="x")
