"""Sheets of pictures, with their captions, legends and scales."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from inspected import bodies, write_run

from abs_engine.core.errors import InputFileError, ParameterError
from abs_engine.core.pose import POSE_NAMES
from abs_engine.io.assets import load_speaker
from abs_engine.render.cpu import CpuRenderer
from abs_engine.report.drawing import layout, legend, palette
from abs_engine.report.inspect.body import person_body, posed
from abs_engine.report.inspect.heads import _directions, _units, person_of
from abs_engine.report.inspect.heat import heat_limits, read_values
from abs_engine.report.inspect.labels import LabelFrame, limits_of
from abs_engine.report.inspect.request import Request
from abs_engine.report.inspect.sheets import (
    Look,
    nomogram,
    posture_sheet,
    sweep_film,
    unit_rows,
    value_text,
)


def test_a_posture_sheet_shows_each_unit_where_it_says():
    rest = person_body(load_speaker(), "clara")
    look = Look(CpuRenderer(), (40, 48), "classes")
    names = ("jawOpen", "mouthPucker", "browInnerUp")
    page = posture_sheet(look, rest, unit_rows(rest, names), 1.0)
    view = look.view(rest)
    columns = layout.columns_of(4, look.size)
    high, wide = 48 + 22 + layout.GAP, 40 + layout.GAP
    for place, units in enumerate(({}, *({name: 1.0} for name in names))):
        y, x = layout.GAP + high * (place // columns), layout.GAP + wide * (place % columns)
        assert (page[y : y + 48, x : x + 40] == look.draw(posed(rest, units), view)).all(), units


def test_a_nomogram_goes_from_left_to_right():
    rest = person_body(load_speaker(), "clara")
    look = Look(CpuRenderer(), (40, 48), "classes")
    page = nomogram(look, rest, unit_rows(rest, ("jawOpen",)), (-1.0, 0.0, 1.0), "sd")
    tiles = [page[26:74, 126 + 44 * k : 166 + 44 * k] for k in range(3)]
    view = look.view(rest)
    for weight, tile in zip((-1.0, 0.0, 1.0), tiles, strict=True):
        assert (tile == look.draw(posed(rest, {"jawOpen": weight}), view)).all()
    assert (tiles[0] != tiles[1]).any()


@pytest.mark.parametrize("kind", ["postures", "nomogram"])
def test_a_row_goes_from_none_of_its_unit_also_where_the_posture_has_some(tmp_path, kind):
    """What stands below 0 shows a weight of 0, and what stands below 1 a weight of 1."""
    given = {"jawOpen": 0.5, "mouthPucker": 0.25}
    request = Request(kind, tmp_path / "made.png", units=given, rows=("jawOpen", "browInnerUp"))
    body = posed(person_of(request), given)
    jaw, brow = _units(body, request)
    for row, value, units in (
        (jaw, 0.0, {"mouthPucker": 0.25}), (jaw, 1.0, {"jawOpen": 1.0, "mouthPucker": 0.25}),
        (brow, 1.0, given | {"browInnerUp": 1.0}),
    ):  # fmt: skip
        wanted = posed(person_of(request), units).vertices
        assert np.allclose(row.moved(body, value).vertices, wanted, atol=1e-9)
    whole = next(r for r in _units(body, replace(request, rows=())) if "," in r.name)
    wanted = posed(
        person_of(request), {"jawOpen": 0.2, "mouthClose": 0.2, "mouthPucker": 0.25}
    ).vertices
    assert np.allclose(whole.moved(body, 0.2).vertices, wanted, atol=1e-9)


@pytest.mark.parametrize(
    ("names", "said"),
    [((*POSE_NAMES, "jaw1"), ["jaw1"]), (None, ["mode 1"]), ((*POSE_NAMES, "a", "b"), ["mode 1"])],
)
def test_rows_of_a_run_are_named_like_its_parameters(tmp_path, names, said):
    path = write_run(tmp_path / "run") / "results.npz"
    with np.load(path) as data:
        arrays = dict(data)
    if names is not None:
        arrays |= {"parameter_names": np.array(names), "parameters": np.zeros((3, len(names)))}
    np.savez(path, **arrays)
    rows = _directions(Request("nomogram", tmp_path / "made.png", run=path.parent))[1]
    assert [row.name for row in rows] == said


@pytest.mark.parametrize(("low", "extremes"), [(0.0, {13: 1.0}), (-1.0, {6: 0.993, 19: -0.993})])
def test_a_film_goes_to_both_ends_and_comes_back(low, extremes):
    rest = person_body(load_speaker(), "clara")
    look = Look(CpuRenderer(), (40, 48), "classes")
    shown = list(sweep_film(look, rest, unit_rows(rest, ("jawOpen",)), low, 1.0, ""))
    assert len(shown) == 26
    view = look.view(rest)
    for frame, weight in {0: 0.0, **extremes}.items():
        wanted = look.draw(posed(rest, {"jawOpen": weight}), view)
        assert np.abs(shown[frame][:48].astype(int) - wanted).mean() < 0.2, frame
    widest = max(extremes)
    assert np.abs(shown[widest][:48].astype(int) - shown[0][:48]).mean() > 0.5


@pytest.mark.parametrize(
    ("value", "unit", "text"),
    [(-3, "sd", "\N{MINUS SIGN}3 sd"), (2, "sd", "+2 sd"), (0, "sd", "0 sd"), (0.25, "", "0.25")],
)
def test_texts_of_values(value, unit, text):
    assert value_text(value, unit) == text


def test_a_colour_bar_runs_from_its_lower_to_its_upper_colour():
    bar = legend.colour_bar(palette.colours_of("viridis"), (0.0, 3.0), "mm", 200)
    low, high = palette.colours_of("viridis")[[0, -1]].astype(int)

    def middle(colour: np.ndarray) -> float:
        return float(np.nonzero(np.abs(bar.astype(int) - colour).sum(axis=2) < 16)[0].mean())

    assert bar.shape[0] == 200
    assert middle(low) > 150
    assert middle(high) < 50


def test_swatches_show_every_colour():
    colours = palette.CLASS_COLOURS[1:4]
    drawn = legend.swatches(("a", "b", "c"), colours, 120).reshape(-1, 3)
    for colour in colours:
        assert (np.abs(drawn.astype(int) - colour).max(axis=1) < 3).sum() > 50


def test_a_label_that_is_too_long_still_begins_with_its_first_letters():
    whole, cut = layout.label("WWWWWWWW", (400, 20)), layout.label("WWWWWWWW" * 9, (60, 20))
    assert cut.shape == (20, 60, 3)
    assert (cut[:, :2] == 255).all()
    assert (cut < 128).any()
    assert (whole < 128).any()


@pytest.mark.parametrize(
    ("values", "largest", "limits"),
    [([0.2, 3.21], None, (0, 3.5)), ([0.0, 0.0], None, (0, 1)), ([-2, 1], 4.0, (-2, 4))],
)
def test_limits_of_heat(values, largest, limits):
    assert heat_limits(np.array(values, float), largest) == pytest.approx(limits)


def test_arrays_that_do_not_fit_the_head(tmp_path):
    path = tmp_path / "values.npy"
    with pytest.raises(InputFileError, match="does not exist"):
        read_values(path, 3)
    np.save(path, np.zeros(4))
    with pytest.raises(ParameterError, match="holds 4 numbers, the head has 3 vertices"):
        read_values(path, 3)
    np.save(path, np.array([0, np.nan, 1]))
    with pytest.raises(ParameterError, match="NaN"):
        read_values(path, 3)
    path.write_bytes(b"no array")
    with pytest.raises(InputFileError, match="holds no numbers"):
        read_values(path, 3)
    np.savez(tmp_path / "two.npz", a=np.zeros(3), b=np.zeros(3))
    with pytest.raises(InputFileError, match="several arrays"):
        read_values(tmp_path / "two.npz", 3)
    np.savez(tmp_path / "named.npz", a=np.zeros(3), values=np.arange(3))
    assert read_values(tmp_path / "named.npz", 3).tolist() == [0, 1, 2]


def test_lips_are_not_closed_more_than_they_can_be():
    rows = {row.name: row.delta for row in _units(bodies()[0], Request("postures", Path("a.png")))}
    assert "mouthClose" not in rows
    alone = load_speaker().unit_matrix(("mouthClose", "jawOpen"))
    assert np.allclose(rows["mouthClose, jawOpen"], alone.sum(axis=0), atol=1e-5)
    named = Request("postures", Path("a.png"), rows=("mouthClose",))
    assert [row.name for row in _units(bodies()[0], named)] == ["mouthClose"]


def test_the_scale_of_flow_is_not_that_of_a_blink():
    ids, moved = np.ones((20, 20), int), np.full((20, 20, 2), [0.9, 1.2])
    moved[0, 0] = 40
    frame = LabelFrame("", ids, {"flow": lambda: moved})
    assert limits_of("flow", [frame]) == (0, pytest.approx(1.5))
    moved[:] = np.nan
    assert limits_of("flow", [frame]) == (0, 1)


def test_long_nomograms_repeat_their_heads():
    rest = person_body(load_speaker(), "clara")
    rows = unit_rows(rest)[:13]
    page = nomogram(Look(CpuRenderer(), (16, 20), "classes"), rest, rows, (0.0, 1.0), "")
    assert len(page) == 2 * 24 + 13 * 24
    assert (page[:24] == page[24 + 12 * 24 :][:24]).all()
