"""Figures, error plot, page and scores of the reproduction of Basu, Oliver and Pentland."""

from __future__ import annotations

import copy
import xml.etree.ElementTree as ET
from dataclasses import dataclass
from html.parser import HTMLParser

import numpy as np
import pytest
from heads import SIZE, colours_of, head_of, picture_of, seen_at

from abs_engine.core.camera import Camera
from abs_engine.core.geometry import Pose
from abs_engine.fit.shell import shell_window
from abs_engine.io.assets import load_speaker
from abs_engine.papers.basu1998.collected import by_driver, error_plot
from abs_engine.papers.basu1998.experiment import FrameError, TrainedLips, learn_lips
from abs_engine.papers.basu1998.filmed import camera_name
from abs_engine.papers.basu1998.motion import authored_motion
from abs_engine.papers.basu1998.page import DRIVERS, reproduction_page
from abs_engine.papers.basu1998.pictures import (
    TILE,
    ShownFit,
    convergence_figure,
    fits_figure,
    probability_figure,
)
from abs_engine.papers.basu1998.scores import GOALS, Goal, score_lines
from abs_engine.papers.basu1998.summary import WAYS
from abs_engine.papers.basu1998.wireframe import ON_LIPS, ON_SKIN, CloseUp
from abs_engine.papers.results import number
from abs_engine.render.cpu import CpuRenderer
from abs_engine.report.drawing.figure import figure_bytes
from abs_engine.report.drawing.lines import draw_arrows

CAMERA = Camera.ideal(SIZE)
YAWS = (-45, 0, 45)


@dataclass(frozen=True, eq=False)
class Mouth:
    """A person's lips, their neutral head from three sides, and the true nodes."""

    lips: TrainedLips
    pictures: dict[int, np.ndarray]
    poses: dict[int, Pose]
    nodes: np.ndarray


@pytest.fixture(scope="module")
def mouth() -> Mouth:
    speaker, model = load_speaker(), head_of("clara")
    poses = {yaw: seen_at([0, np.radians(yaw), 0], [0, 0, 560]) for yaw in YAWS}
    pictures = {yaw: picture_of(model.head, pose, CAMERA) for yaw, pose in poses.items()}
    motion = authored_motion(speaker, "clara", frames=60)  # short: how they move is not seen here
    lips = learn_lips(speaker, "clara", colours_of(model, poses[0], CAMERA), 0, motion)
    nodes = lips.model.shell.nodes(speaker.named("clara"))
    return Mouth(lips, pictures, poses, nodes)


def close_up(mouth: Mouth, yaw: int) -> CloseUp:
    window = shell_window(mouth.lips.setting(CAMERA, CpuRenderer()), mouth.poses[yaw])
    return CloseUp(CAMERA, type(window)(window.x, window.y, 60, 50, 4.0), window.scale)


def test_probability_maps_are_white_where_the_class_is(mouth):
    figure = probability_figure(
        mouth.lips, mouth.pictures[0], mouth.poses[0], CAMERA, CpuRenderer()
    )
    assert figure.dtype == np.uint8
    assert figure.shape[1] == 5 * (TILE + 4) + 4
    high, wide = (figure.shape[0] - 4) // 2, TILE + 4
    lips, smooth, skin = (figure[4:high, 4 + k * wide : k * wide + TILE] for k in (1, 2, 3))
    rows = slice(0, high - 30)  # without the caption
    height, across = lips[rows].shape[:2]
    middle = slice(round(0.4 * height), round(0.55 * height))
    assert lips[middle, across // 2].max() > 230 > 25 > lips[height // 2, 10].max()
    assert skin[height // 2, 10].min() > 230
    steep = [
        np.quantile(np.abs(np.diff(t[rows].astype(int), axis=0)), 0.99) for t in (lips, smooth)
    ]
    assert steep[1] < 0.75 * steep[0]  # smoothed: boundaries are less steep


@pytest.mark.parametrize("yaw", YAWS)
def test_the_wireframe_lies_on_the_lips(mouth, yaw):
    close = close_up(mouth, yaw)
    tile = np.zeros((*close.window.drawn[::-1], 3), np.uint8)
    shell, pose = mouth.lips.model.shell, mouth.poses[yaw]
    wired = close.wired(tile, CpuRenderer(), shell, mouth.nodes, pose)
    green, blue = (
        np.argwhere((np.abs(wired.astype(int) - colour) < 25).all(axis=2))[:, ::-1]
        for colour in (ON_LIPS, ON_SKIN)
    )
    assert min(len(green), len(blue)) > 50
    at = close.pixels(pose.apply(mouth.nodes))
    outer = at[: 3 * 34]
    assert (green >= outer.min(axis=0) - 1.5).all()
    assert (green <= outer.max(axis=0) + 1.5).all()
    assert (blue >= at.min(axis=0) - 1.5).all()
    assert not tile.any()  # what was given is untouched


def test_short_arrows_are_dots():
    tile = np.zeros((40, 60, 3), np.uint8)
    begin = np.array([[10.0, 10.0], [10.0, 30.0]])
    draw_arrows(tile, begin, begin + np.array([[30.0, 0.0], [0.5, 0.0]]), (255, 0, 0))
    assert tile[10, 38, 0] > 100
    assert tile[30, 10, 0] > 100
    assert not tile[25:35, 16:].any()


def test_the_way_to_the_fit_has_six_tiles(mouth):
    figure = convergence_figure(
        mouth.lips, mouth.pictures[0], mouth.poses[0], CAMERA, CpuRenderer(), mouth.nodes
    )
    assert figure.shape[1] == 3 * (TILE + 4) + 4
    high, wide = (figure.shape[0] - 4) // 2, TILE + 4
    tiles = [
        figure[4 + r * high : high * (r + 1) - 30, 4 + c * wide : c * wide + TILE]
        for r in (0, 1)
        for c in (0, 1, 2)
    ]
    changed = [np.any(tile != tiles[0], axis=2).mean() for tile in tiles]
    assert changed[0] == 0
    assert min(changed[1:]) > 0.05
    assert np.any(tiles[1] != tiles[4])


def test_a_row_for_each_fit(mouth):
    fits = [
        ShownFit(f"{yaw}", mouth.pictures[yaw], CAMERA, mouth.poses[yaw], mouth.nodes)
        for yaw in YAWS
    ]
    one, three = (fits_figure(CpuRenderer(), mouth.lips, some) for some in (fits[:1], fits))
    assert three.shape[1] == one.shape[1]
    assert abs(three.shape[0] - 3 * one.shape[0]) < 12
    assert one[:, -300:].std() > 10  # the shape is there


# ---- error plot ----------------------------------------------------------------------------------


def test_an_error_plot_has_a_line_for_each_driver_and_gaps():
    plot = error_plot(
        {"forces": [1.0, float("nan"), 2.0, 1.0], "a < b": [0.5] * 4}, {0: "front", 2: "side"}
    )
    axes = plot.axes[0]
    first, second, goal = axes.lines[:3]
    assert np.isnan(first.get_ydata()).tolist() == [False, True, False, False]
    assert second.get_ydata().tolist() == [0.5] * 4
    assert goal.get_linestyle() == "--"
    (legend,) = plot.legends
    names = {text.get_text() for text in legend.get_texts()}
    assert names == {"forces, 1.41 mm RMS", "a < b, 0.50 mm RMS", "goal: 1 mm"}
    assert [text.get_text() for text in axes.texts] == ["front", "side"]


def test_errors_by_driver_are_one_persons_and_sides_are_named_in_degrees():
    told = [
        FrameError(person, camera_name(yaw), driver, frame, rms, rms, None)
        for person, rms in (("kofi", 9.0), ("mei", 1.0))
        for driver in ("forces", "gradient", "simplex")
        for yaw in (-45, 0)
        for frame in (0, 1)
    ]
    curves, breaks = by_driver(told, "mei")
    assert curves == dict.fromkeys(("forces", "gradient", "simplex"), [1.0] * 4)
    assert breaks == {0: "\N{MINUS SIGN}45°", 2: "0°"}


@pytest.mark.parametrize("series", [{}, {"forces": []}, {"forces": [float("nan")]}, {"f": [0.0]}])
def test_an_error_plot_of_hardly_anything(series):
    svg = figure_bytes(error_plot(series, {}), "svg")
    assert svg == figure_bytes(error_plot(series, {}), "svg")
    comments = {str(node) for node in ET.fromstring(svg).itertext()}
    assert not any("nan" in text for text in comments)


# ---- scores and page -----------------------------------------------------------------------------

RESULTS = {
    "variance_10_modes": 0.9961,
    "variance": [0.7, 0.8, 0.9, 0.95, 0.96, 0.97, 0.98, 0.985, 0.99, 0.9961],
    "table1": {"xyz8": 9.1e-4, "yz16": 8.2e-4, "xy16": 5.5e-3},
    "iterations_to_converge": 4.5,
    "blob": {"mm": 1.31, "iterations": 4.5, "converged": 0.92},
    "drivers": {
        "forces": {"mm": 0.93, "highest_mm": 0.94, "evaluations": 61.3, "iterations": 4.2,
                   "posterior": 812.4, "converged": 0.97,
                   "posterior_rule": "exact"},
        "forces_one_sample": {"mm": 0.95, "evaluations": 60},
        "gradient": {"mm": 0.9, "evaluations": 1420},
        "simplex": {"mm": 0.91, "evaluations": 500},
    },
    "yaw_mm": {"clara": {"yaw_45": 1.2, "yaw0": 0.7}, "kofi": {"yaw_45": 0.8, "yaw0": None}},
    "pose": {"known": 0.97, "frontal": 0.83, "blob": 1.31, "estimated": 1.7},
    "further_training": {"before_mm": 1.04, "after_mm": 0.86, "left": 0.86 / 1.04},
    "grid": {"closure_precision": None, "closure_recall": None},
    "motion": "authored speech", "people": ["clara", "kofi"], "command": "abs-engine <reproduce>",
    "seed": 7, "renderer": "CPU rasteriser", "engine_version": "0.1.0",
    "quick": True,
}  # fmt: skip


class Tables(HTMLParser):
    """The rows of a page's tables, its pictures, and whether every element is closed."""

    def __init__(self, page: str) -> None:
        super().__init__()
        self.rows: list[list[str]] = []
        self.pictures: list[str | None] = []
        self.open: list[str] = []
        self.feed(page)

    def handle_starttag(self, tag, attrs):
        if tag in ("img", "meta"):
            self.pictures += [dict(attrs).get("src")] if tag == "img" else []
            return
        self.open.append(tag)
        if tag == "tr":
            self.rows.append([])
        elif tag in ("td", "th"):
            self.rows[-1].append("")

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        if self.open and self.open[-1] in ("td", "th"):
            self.rows[-1][-1] += data


def test_the_page_sets_results_beside_the_papers():
    page = reproduction_page(RESULTS, [("figure5.png", "Figure 5: a <way>")], ["So & so."])
    read = Tables(page)
    assert not read.open
    assert read.pictures == ["figure5.png"]
    for row in (
        ["variance held by ten modes", "99.61%", "≥ 99.20% (paper)", "met, by 0.41 points"],
        ["reconstruction from yz (16 points)", "8.20e-04", "7.13e-04", "not met, by 1.07e-04"],
        ["lip error, pose estimated, moving head", "1.70 mm", "≤ 1.50 mm", "not met, by 0.20 mm"],
        ["lip error by forces, placed by the lip blob, all cameras", "1.31 mm", "none", ""],
        ["\N{MINUS SIGN}45°", "1.20 mm", "0.80 mm", "≤ 1.00 mm", "not met, by 0.20 mm"],
        ["0°", "0.70 mm", "not measured", "≤ 0.80 mm", "met, by 0.10 mm"],
        [
            "share of all frames that do within 15",
            "92.00%",
            "≥ 100.00%",
            "not met, by 8.00 points",
        ],
        ["five seconds of dots", "1.04 mm"],
        ["the same, variances of the modes cross-validated", "not measured"],
        [
            "lip error after further training, of that before",
            "82.69%",
            "≤ 75.00%",
            "not met, by 7.69 points",
        ],
        ["command", "abs-engine <reproduce>"],
        ["seed", "7"],
    ):
        assert row in read.rows
    forces = next(row for row in read.rows if row[0].startswith("forces at the borders"))
    assert forces[1:] == [
        "exact sum",
        "0.93 mm",
        "0.94 mm",
        "61.3",
        "4.2",
        "812.4",
        "97.00%",
    ]
    blob = next(row for row in read.rows if row[0].startswith("from the blob"))
    assert (blob[2], blob[5], blob[-1]) == ("1.31 mm", "4.5", "92.00%")
    assert set(DRIVERS) == {name for name, *_ in WAYS}
    assert "left out by --quick" in page
    assert "So &amp; so." in page


def without(key: str) -> list[dict]:
    """The results with a key missing, None, and not a number."""
    out = []
    for value in (..., None, float("nan"), "?"):
        results = copy.deepcopy(RESULTS)
        results.pop(key)
        out.append(results if value is ... else results | {key: value})
    return out


@pytest.mark.parametrize("key", list(RESULTS))
def test_the_page_survives_what_is_missing(key):
    for results in without(key):
        page = reproduction_page(results, [], [])
        assert not Tables(page).open
        assert ">nan" not in page
        score_lines(results)


def test_closures_that_are_missed_and_spikes_are_judged():
    grid = {"closure_precision": 0.95, "closure_recall": 0.94, "closures_missed": 1, "spikes": 0}
    rows = Tables(reproduction_page(RESULTS | {"grid": grid}, [], [])).rows
    assert ["GRID closures without a closed frame", "1", "≤ 0", "not met, by 1"] in rows
    assert ["GRID apertures, single-frame spikes", "0", "≤ 0", "met, by 0"] in rows


def test_a_page_of_nothing_says_so():
    page = reproduction_page({}, [], [])
    assert "recordings not there" in page
    read = Tables(page)
    assert all(row[1] == "not measured" for row in read.rows if row[0] == GOALS[0].name)


def test_verdicts():
    most, least = Goal("a.b", "", "mm", 1.0), Goal("a.b", "", "share", 0.9, True)
    assert most.verdict({"a": {"b": 1.0}}) == "met, by 0.00 mm"
    assert most.verdict({"a": {"b": 1.25}}) == "not met, by 0.25 mm"
    assert least.verdict({"a": {"b": 0.85}}) == "not met, by 5.00 points"
    assert least.verdict({"a": {"b": None}}) == ""
    assert number({"a": {"b": True}}, "a.b") is None
    assert number({"a": 2}, "a.b") is None


def test_the_terminal_gets_a_line_for_each_goal():
    lines = score_lines(RESULTS)
    assert len(lines) == 1 + len(GOALS)
    assert "99.61%" in lines[1]
    assert lines[1].endswith("met, by 0.41 points")
    assert lines[-1].endswith("left out by --quick")
