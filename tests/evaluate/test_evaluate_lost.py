"""Lost frames in files of other systems, and what is scored around them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from results import (
    FRAMES,
    RATE,
    areas,
    arkit_rows,
    clip,
    reference_of,
    speaker,
    true_landmarks,
    wide_rows,
    write_csv,
)

from abs_engine.core.errors import InputFileError, ParameterError
from abs_engine.evaluate.arkit_csv import read_arkit
from abs_engine.evaluate.estimate import Estimate
from abs_engine.evaluate.landmark_csv import read_landmarks
from abs_engine.evaluate.metrics import closed_intervals
from abs_engine.evaluate.metrics.bootstrap import value
from abs_engine.evaluate.score import measure, summary


@pytest.fixture(scope="module")
def truth():
    return clip()


@pytest.fixture(scope="module")
def reference(truth):
    return reference_of(truth)


def arkit(path, reference):
    return read_arkit(path, reference, speaker().unit_names, speaker().units, areas())


def lost(estimate):
    return np.flatnonzero(~estimate.found).tolist()


def recorded(heading, count, rate):
    """Rows of a recorder at a rate of its own, whose jaw opens by 0.5 in a second."""
    rows = []
    for k in range(count):
        code = f"00:00:{k // rate:02d}:{k % rate:02d}.000"
        rows.append([code, 61, *[0.0] * (len(heading) - 2)])
        rows[-1][heading.index("JawOpen")] = 0.5 * k / rate
    return rows


def test_rows_that_a_face_unit_file_lacks_are_lost_frames(truth, reference, tmp_path):
    heading, rows = arkit_rows(truth)
    kept = [*rows[:20], *rows[35:50], *rows[51:]]
    found = arkit(write_csv(tmp_path / "a.csv", heading, kept), reference)
    assert lost(found) == [*range(20, 35), 50]
    weights = found.surface.weights[found.found]
    np.testing.assert_allclose(weights, truth.unit_weights[found.found], atol=1e-6)
    found = arkit(write_csv(tmp_path / "b.csv", heading, rows[:-1]), reference)
    assert lost(found) == [FRAMES - 1]


def test_rows_without_weights_are_lost_beside_rows_that_are_missing(truth, reference, tmp_path):
    heading, rows = arkit_rows(truth)
    for row in rows[10:12]:
        row[2:] = [""] * len(row[2:])
    kept = [*rows[:30], *rows[31:]]
    assert lost(arkit(write_csv(tmp_path / "a.csv", heading, kept), reference)) == [10, 11, 30]


def test_an_empty_line_of_a_face_unit_file_is_a_lost_frame(truth, reference, tmp_path):
    heading, rows = arkit_rows(truth)
    nothing = [""] * len(heading)
    holed = [*rows[:5], nothing, *rows[6:-1], nothing]
    found = arkit(write_csv(tmp_path / "a.csv", heading, holed), reference)
    assert lost(found) == [5, FRAMES - 1]
    found = arkit(write_csv(tmp_path / "b.csv", heading, [*rows, nothing, nothing]), reference)
    assert lost(found) == []  # as spreadsheets end
    found = arkit(
        write_csv(tmp_path / "c.csv", heading, [*rows[:5], nothing, *rows[7:]]), reference
    )
    assert lost(found) == [5, 6]
    slow = [[f"00:00:{k // 20:02d}:{k % 20:02d}", *row[1:]] for k, row in enumerate(rows)]
    slow[5] = nothing
    with pytest.raises(ParameterError, match=r"lasts 2\.79 s by its timecodes"):
        arkit(write_csv(tmp_path / "d.csv", heading, slow), reference)
    with pytest.raises(ParameterError, match="lasts 0"):
        arkit(write_csv(tmp_path / "e.csv", heading, [nothing, nothing]), reference)


@pytest.mark.parametrize(("rate", "first"), [(24, 14), (30, 13), (50, 13), (60, 13)])
def test_recorders_at_other_rates_lose_what_they_lack(truth, reference, tmp_path, rate, first):
    heading, _ = arkit_rows(truth)
    rows = recorded(heading, 1 + int((FRAMES - 1) / RATE * rate), rate)
    found = arkit(write_csv(tmp_path / "a.csv", heading, rows), reference)
    assert lost(found) == []
    unit = speaker().unit_names.index("jawOpen")
    wanted = np.minimum(0.5 * np.arange(FRAMES) / RATE, 0.5 * (len(rows) - 1) / rate)
    np.testing.assert_allclose(found.surface.weights[:, unit], wanted, atol=1e-9)
    holed = [*rows[: rate // 2 + 1], *rows[rate:]]  # nothing between 0.5 s and 1 s
    found = arkit(write_csv(tmp_path / "b.csv", heading, holed), reference)
    assert lost(found) == list(range(first, 25))


@pytest.mark.parametrize(("base", "rate"), [(60, 30), (60, 50), (30, 24), (60, 48), (50, 48)])
def test_whole_frames_of_a_faster_base_leave_no_gaps(truth, reference, tmp_path, base, rate):
    """As many numbers are left out as the base is faster; where rows are missing, more are."""
    heading, _ = arkit_rows(truth)
    rows = recorded(heading, 1 + int((FRAMES - 1) / RATE * rate), rate)
    for k, row in enumerate(rows):
        seconds, frames = divmod(k * base // rate, base)
        row[0] = f"00:00:{seconds:02d}:{frames:02d}.000"
    found = arkit(write_csv(tmp_path / "a.csv", heading, rows), reference)
    assert lost(found) == []
    unit = speaker().unit_names.index("jawOpen")
    wanted = np.minimum(0.5 * np.arange(FRAMES) / RATE, 0.5 * (len(rows) - 1) / rate)
    np.testing.assert_allclose(found.surface.weights[:, unit], wanted, atol=0.5 / base)
    holed = [*rows[: rate // 2 + 1], *rows[rate:]]  # nothing between 0.5 s and 1 s
    found = arkit(write_csv(tmp_path / "b.csv", heading, holed), reference)
    assert lost(found) == list(range(13 + (rate == 24), 25))


def test_single_rows_that_are_missing_are_lost_at_any_rate(truth, reference, tmp_path):
    heading, _ = arkit_rows(truth)
    for rate in (25, 50):
        rows = recorded(heading, 1 + int((FRAMES - 1) / RATE * rate), rate)
        gone = [rate // 5 * k for k in (1, 2, 5, 9)]
        kept = [row for k, row in enumerate(rows) if k not in gone]
        found = arkit(write_csv(tmp_path / f"{rate}.csv", heading, kept), reference)
        assert lost(found) == [5, 10, 25, 45]


def test_where_a_row_is_missing_its_neighbours_stand_for_half_a_step(truth, reference, tmp_path):
    """At 30 rows a second frame 3 lies 0.6 steps behind row 3, and frame 4 0.2 before row 5."""
    heading, _ = arkit_rows(truth)
    rows = recorded(heading, 1 + int((FRAMES - 1) / RATE * 30), 30)
    for missing, gone in ((4, [3]), (3, [])):  # around row 3 frames lie 0.4 steps from others
        kept = [row for k, row in enumerate(rows) if k != missing]
        found = arkit(write_csv(tmp_path / f"{missing}.csv", heading, kept), reference)
        assert lost(found) == gone


def test_timecodes_of_a_long_clip_may_count_30_frames_at_29_97(truth, reference, tmp_path):
    """They end 67 ms early after 67 s; a clip that is a second longer than they say is another."""
    heading, _ = arkit_rows(truth)
    ntsc = replace(reference, frames=2000, rate=30 / 1.001)
    given = speaker().unit_names, speaker().units, {}
    codes = [f"00:{k // 1800:02d}:{k // 30 % 60:02d}:{k % 30:02d}.000" for k in range(2000)]
    still = [61, *[0.0] * (len(heading) - 2)]
    path = write_csv(tmp_path / "a.csv", heading, [[code, *still] for code in codes])
    assert read_arkit(path, ntsc, *given).found.all()
    with pytest.raises(ParameterError, match=r"lasts 66\.63 s by its timecodes"):
        read_arkit(path, replace(ntsc, rate=29.5), *given)


def test_first_rows_that_are_missing_are_lost_by_the_timecode(truth, reference, tmp_path):
    heading, rows = arkit_rows(truth)
    for hours, begins, missing in (
        ("00:00", 1, [0]),
        ("00:00", 3, [0, 1, 2]),
        ("01:02", 1, [FRAMES - 1]),
    ):
        own = [[hours + row[0][5:], *row[1:]] for row in rows[begins:]]
        file = write_csv(tmp_path / f"{begins}-{missing[0]}.csv", heading, own)
        assert lost(arkit(file, reference)) == missing
    found = arkit(tmp_path / "1-0.csv", reference)
    weights = found.surface.weights[1:]
    np.testing.assert_allclose(weights, truth.unit_weights[1:], atol=1e-6)


def long_rows(truth, unit="mm"):
    pixels, points = true_landmarks(truth)
    places = {"mm": points, "px": np.dstack([pixels, np.zeros(pixels.shape[:2])])}[unit]
    heading = ["frame", "time", "point", "x", "y", "z", "unit", "space"]
    return heading, [
        [t, t / RATE, k, *places[t, k], unit, "camera"] for t in range(FRAMES) for k in range(68)
    ]


@pytest.mark.parametrize("kept", [("point",), ("point", "time", "unit"), ("point", "space"), ()])
def test_lost_frames_of_a_long_file_have_empty_cells(truth, reference, tmp_path, kept):
    heading, rows = long_rows(truth)
    for row in rows:
        if row[0] in (0, 7):
            row[:] = [
                cell if name in ("frame", *kept) else ""
                for name, cell in zip(heading, row, strict=True)
            ]
    found = read_landmarks(write_csv(tmp_path / "a.csv", heading, rows), reference)
    assert lost(found) == [0, 7]
    assert len(found.tracks["landmarks"].vertex) == 68


def test_points_with_a_place_still_need_unit_and_space(truth, reference, tmp_path):
    heading, rows = long_rows(truth)
    for name, said in (("unit", "the unit ''"), ("space", "has the spaces"), ("point", "0 to 67")):
        wrong = [list(row) for row in rows]
        wrong[100][heading.index(name)] = ""
        with pytest.raises(InputFileError, match=said):
            read_landmarks(write_csv(tmp_path / f"{name}.csv", heading, wrong), reference)


def test_lost_frames_of_a_wide_file_have_no_time(truth, reference, tmp_path):
    heading, rows = wide_rows(truth, *true_landmarks(truth))
    for t in (0, 9):
        rows[t][1:] = [""] * len(rows[t][1:])
    assert lost(read_landmarks(write_csv(tmp_path / "a.csv", heading, rows), reference)) == [0, 9]
    rows[20][1] += 0.1
    with pytest.raises(ParameterError, match="frame 20 at"):
        read_landmarks(write_csv(tmp_path / "b.csv", heading, rows), reference)


@pytest.mark.parametrize("unit", ["mm", "px"])
@pytest.mark.parametrize("points", [range(68), [62]])
def test_lost_frames_do_not_make_exact_closures_wrong(truth, reference, tmp_path, unit, points):
    """Nor do frames that lack a point by which lips are closed."""
    heading, rows = long_rows(truth, unit)
    marks = truth.landmarks["landmark_68"]
    found = read_landmarks(write_csv(tmp_path / "a.csv", heading, rows), reference)
    runs = [run for run in closed_intervals(found.closed) if run[0] > 0 and run[1] - run[0] > 2]
    (first, end), *_ = runs
    for gone in ({(first + end) // 2}, {first, first + 1}):
        at = heading.index("x")
        holed = [
            [*r[:at], "", "", "", *r[at + 3 :]] if r[0] in gone and r[2] in points else r
            for r in rows
        ]
        found = read_landmarks(write_csv(tmp_path / "b.csv", heading, holed), reference)
        assert lost(found) == (sorted(gone) if len(points) == 68 else [])
        scores = summary([measure(found, truth, marks)])
        assert scores["closure_precision_events"].value == 1
        assert scores["closure_recall_events"].value == 1
        assert scores["closure_onset_error_ms"].value == 0


def test_frames_with_points_in_the_picture_alone_are_not_lost(truth, reference, tmp_path):
    (heading, solid), (_, flat) = (long_rows(truth, unit) for unit in ("mm", "px"))
    path = write_csv(tmp_path / "a.csv", heading, flat + [row for row in solid if row[0] % 4])
    found = read_landmarks(path, reference)
    assert lost(found) == []
    scores = summary([measure(found, truth, truth.landmarks["landmark_68"])])
    assert scores["frames_lost"].value == 0
    assert scores["failure_share"].value == 0.25  # they lack landmarks that are given elsewhere
    assert scores["landmarks_given"].value == 0.75


@pytest.mark.parametrize("begins", [13, 33])
def test_a_closure_that_goes_on_out_of_the_picture_has_one_onset(truth, begins):
    """It is found 3 frames late, and again where the head comes back, at once or 3 frames late."""
    marks, far = truth.landmarks["landmark_68"], truth.translations.copy()
    far[15:30, 0] = 2000.0  # far to the right of the picture
    frames = np.arange(FRAMES)
    true = (frames >= 10) & (frames < 40)
    again = (frames >= begins) & (frames < 45)
    away = replace(truth, translations=far, closed=true)
    said = Estimate("n", np.ones(FRAMES, bool), closed=again | ((frames >= 13) & (frames < 15)))
    scores = measure(said, away, marks).means
    assert scores["closure_onset_error_ms"].weight.sum() == 1
    assert value([scores["closure_onset_bias_ms"]]) == pytest.approx(3000 / RATE)
