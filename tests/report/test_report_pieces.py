"""The pieces of a report: strokes, arrays, motions, films. No page is made."""

from __future__ import annotations

import base64
import itertools
import json
import zlib
from pathlib import Path

import cv2
import numpy as np
import pytest
from reported import unpacked

from abs_engine.core.errors import VideoError
from abs_engine.evaluate.estimate import Estimate
from abs_engine.io.video import probe
from abs_engine.report.charts import lip_chart
from abs_engine.report.data import ReportData, Series
from abs_engine.report.document import document
from abs_engine.report.drawing.colours import (
    HEAT_COLOURS,
    clay_colours,
    scale_end,
    system_stroke,
    truth_stroke,
)
from abs_engine.report.embed import Store, deflated, json_bytes
from abs_engine.report.estimate_parts import system_of
from abs_engine.report.facts import run_facts
from abs_engine.report.film import mouth_picture, shorten, worst_frames
from abs_engine.report.gathering import _names
from abs_engine.report.motion import LARGEST_ERROR_MM, compress
from abs_engine.report.quantities import error_rows
from abs_engine.report.sections import _facts
from abs_engine.tracking.results.run_mesh import LinearSurface


def test_names_that_are_no_utf_8_can_stand_in_a_page():
    page = document("lat\udce4n.mp4: tracked", "").encode("utf-8")
    assert rb"<title>lat\udce4n.mp4: tracked" in page
    assert _names([Path("lat\udce4n.csv")]) == [r"lat\udce4n"]


def test_numbers_that_steer_results_are_folded():
    page = _facts("System: a", (("rate", "25"), ("tuning: frames: most lost", "0.5")))
    shown, folded = page.split("<details><summary>Numbers that steer results (1)</summary>")
    assert "rate" in shown
    assert "tuning" not in shown
    assert "tuning: frames: most lost" in folded
    assert "<details>" not in _facts("Clip", (("rate", "25"),))


def test_lists_and_lines_of_nothing_are_none(tmp_path):
    run = {"settings": {"remarks": ""}, "summary": {"cuts": [3, 5], "warnings": []}}
    (tmp_path / "run.json").write_text(json.dumps(run))
    assert run_facts(tmp_path)[1:] == (("remarks", "none"), ("cuts", "3, 5"), ("warnings", "none"))


def test_a_motion_comes_back_within_the_largest_error():
    rng = np.random.default_rng(1)
    paths = rng.normal(size=(20, 3)) @ rng.normal(size=(3, 120)) * 5
    frames = (50 + paths + rng.normal(size=paths.shape) * 0.01).reshape(20, 40, 3)
    motion = compress(lambda k: frames[k], 20)
    assert len(motion.modes) == 3  # what was put in; the noise is below the limit
    found = np.array([motion.vertices(k) for k in range(20)])
    assert np.abs(found - frames).max() < LARGEST_ERROR_MM


def test_lost_frames_of_a_motion_stay_lost():
    frames = np.random.default_rng(2).normal(size=(5, 4, 3))
    frames[3] = np.nan
    motion = compress(lambda k: frames[k], 5)
    assert np.isnan(motion.weights).all(axis=1).tolist() == [False, False, False, True, False]
    assert np.allclose(motion.vertices(4), frames[4], atol=LARGEST_ERROR_MM)


@pytest.mark.parametrize("value", [0.0, np.nan])
def test_a_motion_that_stands_still_or_is_never_seen(value):
    motion = compress(lambda _: np.full((4, 3), value), 3)
    assert motion.modes.shape == (1, 4, 3)
    assert np.isnan(motion.weights).all() == np.isnan(value)


def test_sixteen_bits_are_fine_enough_for_a_mesh():
    rng = np.random.default_rng(3)
    motion = LinearSurface(
        rng.normal(size=(9, 3)).astype("f4") * 100,
        rng.normal(size=(4, 9, 3)).astype("f4") * 10,
        rng.uniform(0, 1, (6, 4)).astype("f4"),
    )
    store = Store()
    told = store.add_motion(motion)
    parts = {name: unpacked(part, store.content) for name, part in told.items()}
    found = parts["mean"] + np.tensordot(parts["weights"].astype(float), parts["modes"], 1)
    assert np.abs(found - [motion.vertices(k) for k in range(6)]).max() < 0.02
    assert not parts["lost"].any()


@pytest.mark.parametrize("kind", ["uint8", "int16", "uint16", "uint32", "float32"])
def test_arrays_come_back_whatever_their_bytes(kind):
    store, whole = Store(), kind != "float32"
    values = (np.random.default_rng(4).normal(size=(7, 6)) * 1e4).astype(">f8").astype(kind)
    store.add(np.zeros(5, np.uint8))
    told = store.add(values, 6 if whole else 0)
    assert (unpacked(told, store.content) == values).all()


def test_steps_are_as_fine_as_the_numbers_are_large_and_keep_what_is_lost():
    store, values = Store(), np.array([[1.5, -40.0], [np.nan, 12.25], [0.0, np.inf]])
    found = unpacked(store.add_steps(values, 2), store.content)
    assert np.isnan(found).tolist() == [[False, False], [True, False], [False, True]]
    assert np.nanmax(np.abs(found - values)[np.isfinite(values)]) <= 40 / 32767 / 2
    nothing = store.add_steps(np.full((2, 2), np.nan), 0)
    assert np.isnan(unpacked(nothing, store.content)).all()


def test_an_array_is_kept_once():
    store, values = Store(), np.arange(100, dtype=np.uint32)
    assert store.add(values) == store.add(values.copy())
    assert len(store.content) == 400


def test_what_is_deflated_cannot_end_its_element():
    text = deflated(json_bytes({"a": "</script><!--"}))
    assert "<" not in text
    assert zlib.decompress(base64.b64decode(text)) == b'{"a":"</script><!--"}'
    with pytest.raises(ValueError, match="not JSON compliant"):
        json_bytes({"a": float("nan")})


def test_strokes_in_the_same_place_are_all_seen():
    """Each is narrower than what lies behind it, or has gaps."""
    strokes = [truth_stroke(), *(system_stroke(k) for k in range(6))]
    assert len({(s.colour, s.gaps) for s in strokes}) == 7
    for behind, before in itertools.pairwise(strokes):
        assert before.width <= behind.width - 2 or (before.gaps and before.gaps != behind.gaps)
        assert before.width <= behind.width
    assert system_stroke(0).dash == "solid"
    assert system_stroke(1).dash.endswith("px")


def test_a_band_ends_where_its_curve_does_and_is_drawn_at_the_times_of_the_run():
    aperture, lost = np.array([1.0, 2.0, np.nan, 4.0, 3.0]), [np.nan]
    estimate = Estimate(
        "one", np.isfinite(aperture), curves={"aperture": aperture},
        intervals={"aperture": (aperture - 1.5, aperture + 1.5)},
    )  # fmt: skip
    times, system = [22.5, 23.0, 23.25, 24.0, 25.0], system_of(estimate, None, {}, 5)
    faces, colours = np.zeros((0, 3), np.int32), np.zeros((0, 3), np.uint8)
    data = ReportData("", "", 2.0, np.array(times), (system,), faces, colours)
    figure = lip_chart(data)
    band, curve = figure.data
    assert band.fill == "toself"
    assert np.array_equal(curve.x, times)
    x = [22.5, 23, 23, 22.5, *lost, 24, 25, 25, 24, *lost]
    y = [0, 0.5, 3.5, 2.5, *lost, 2.5, 1.5, 4.5, 5.5, *lost]  # no aperture is below 0
    assert np.array_equal([band.x, band.y], [x, y], equal_nan=True)
    assert figure.layout.xaxis.range == (22.5 - 0.625 / 2, 25.625)


def test_a_frame_between_lost_ones_is_a_dot():
    aperture = np.array([1.0, 2.0, np.nan, 4.0, np.nan])
    system = system_of(
        Estimate("one", np.isfinite(aperture), curves={"aperture": aperture}), None, {}, 5
    )
    faces, colours = np.zeros((0, 3), np.int32), np.zeros((0, 3), np.uint8)
    curve, dots = lip_chart(ReportData("", "", 2.0, np.arange(5), (system,), faces, colours)).data
    assert (curve.mode, dots.mode) == ("lines", "markers")
    assert (*dots.x, *dots.y) == (3, 4)
    assert dots.marker.color == curve.line.color


def test_rows_of_the_error_chart():
    one = Series(np.zeros(2))
    rows = ("lip_landmarks_rms_head_mm", "lips_rms_head_mm", "lip_landmarks_coverage_95")
    csv = {"lip_landmarks_rms_camera_mm": one, "landmarks_rms_camera_mm": one}
    found = [q.key for q in error_rows([dict.fromkeys(rows, one), csv])]
    assert found == [
        rows[0],
        "lip_landmarks_rms_camera_mm",
        rows[1],
        "landmarks_rms_camera_mm",
        rows[2],
    ]


def test_worst_frames_keep_apart():
    errors = np.array([1, 9, 8.5, 2, np.nan, 3, 7, 0])
    assert worst_frames(errors, 3, 2) == [1, 6, 3]
    assert worst_frames(errors, 9, 1) == [1, 2, 6, 5, 3, 0, 7]
    assert worst_frames(np.full(3, np.nan), 2, 1) == []


def test_a_contour_is_drawn_where_it_lies():
    picture = np.zeros((200, 200, 3), np.uint8)
    square = np.array([[80.0, 90], [120, 90], [120, 110], [80, 110]])
    coded = np.frombuffer(mouth_picture(picture, [(square, "#ff0000")], square), np.uint8)
    drawn = cv2.imdecode(coded, cv2.IMREAD_COLOR)[..., ::-1]
    height, width = drawn.shape[:2]
    y, x = np.nonzero(drawn[..., 0] > 128)
    # the square lies in the middle and takes 1 / 1.7 of the width
    assert (x.min() + x.max()) / 2 == pytest.approx((width - 1) / 2, abs=1.5)
    assert (y.min() + y.max()) / 2 == pytest.approx((height - 1) / 2, abs=1.5)
    assert x.max() - x.min() == pytest.approx(width / 1.7, abs=4)
    assert drawn[..., 2].max() < 100


def test_a_film_is_cut_and_made_smaller():
    pictures = [np.full((600, 1280, 3), 10 * k, np.uint8) for k in range(6)]
    film, kept = shorten(iter(pictures), 25.0, 3, {4})
    assert film.size == (1280, 600)
    assert kept.keys() == {4}
    assert kept[4].max() == 40
    with pytest.raises(VideoError, match="the video has 6 frames"):
        shorten(iter(pictures), 25.0, 7, ())


def test_frames_of_the_film_have_their_own_times(tmp_path):
    pictures = [np.full((60, 80, 3), 10 * k, np.uint8) for k in range(6)]
    times = np.array([3.0, 3.04, 3.08, 4.1, 4.14, 4.18])
    film, _ = shorten(iter(pictures), 25.0, 5, (), times)
    (tmp_path / "film.mp4").write_bytes(film.content)
    assert probe(tmp_path / "film.mp4").times == pytest.approx([0, 0.04, 0.08, 1.1, 1.14])


def test_the_scale_of_errors_ends_at_a_round_number():
    assert scale_end([np.linspace(0, 3.1, 100)]) == 4.0
    assert scale_end([np.array([0.017, np.nan])]) == pytest.approx(0.02)
    assert scale_end([]) == 1.0
    assert HEAT_COLOURS.shape == (256, 3)


def test_lips_and_skin_have_their_colours():
    faces, classes = np.array([[0, 1, 2], [2, 3, 4]]), np.array([0, 1])
    found = clay_colours(faces, classes, ("skin", "upper_lip"), 5)
    assert (found[2] == found[3]).all()
    assert (found[0] != found[3]).any()
