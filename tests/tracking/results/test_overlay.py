"""Overlay video and contact sheet: lines lie where the camera puts them, and can be seen."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from runs import SIZE, lost_result, toy_result, toy_setting
from scipy.spatial.transform import Rotation

from abs_engine.core.camera import Window
from abs_engine.core.geometry import Pose
from abs_engine.io.video import probe, read_frames
from abs_engine.tracking.results import run_pictures as sheets
from abs_engine.tracking.results.contours import LOST, LOWER, OUTER, UPPER, LipDrawing, cut
from abs_engine.tracking.results.overlay import STRIP_HEIGHT, Overlay, Painter
from abs_engine.tracking.results.run_pictures import ContactSheet

GREY = np.full((SIZE[1], SIZE[0], 3), 90, np.uint8)


@pytest.fixture
def drawing():
    return LipDrawing.of(toy_setting())


def painted(picture, colour):
    """Where a picture has a colour, (N, 2) x and y."""
    near = np.abs(picture.astype(int) - colour).max(axis=2) < 60
    return np.argwhere(near)[:, ::-1]


def test_contours_are_where_the_camera_projects_them(drawing):
    result = toy_result(0, prototype=4)
    window = drawing.view(result.pose, (480, 360), across=1.7).window
    picture = np.zeros((360, 480, 3), np.uint8)
    drawing.draw(picture, window, result)
    pixels = window.to_drawn(drawing.camera.project(result.pose.apply(result.lips)))
    bright = picture.max(axis=2)
    for x, y in np.rint(pixels).astype(int):
        assert bright[y - 2 : y + 3, x - 2 : x + 3].max() > 120  # where lips meet, halfway
    length = sum(
        np.linalg.norm(np.diff(c, axis=0), axis=1).sum() for c in lines_of(drawing, window)
    )
    assert (bright > 120).sum() < 2 * length  # thin
    for colour in (OUTER, UPPER, LOWER):
        assert len(painted(picture, colour)) > 100


@pytest.mark.parametrize("scale", [0.5, 1.0, 2.0])
def test_beyond_the_borders_a_cut_is_black(scale):
    window = Window(-10.0, SIZE[1] - 12.0, 40.0, 24.0, scale)
    picture = cut(window, GREY)
    assert (picture[: round(12 * scale), round(10 * scale) :] == 90).all()
    assert (picture[round(12 * scale) :] == 0).all()
    assert (picture[:, : round(10 * scale)] == 0).all()


@pytest.mark.parametrize("quarters", [1, 2, 3])
def test_a_mouth_on_its_side_is_shown_upright(drawing, quarters):
    result = toy_result(0, prototype=4)
    roll = Rotation.from_euler("z", 90 * quarters, degrees=True).as_matrix()
    turned = Pose(roll @ result.pose.rotation, roll @ result.pose.translation)
    black = np.zeros((SIZE[1], SIZE[0], 3), np.uint8)
    upright, rolled = (
        drawing.view(pose, (240, 176), 1.7).of(black, replace(result, pose=pose))[1]
        for pose in (result.pose, turned)
    )
    assert rolled.shape == upright.shape
    for colour in (OUTER, UPPER, LOWER):
        one, other = (painted(picture, colour).mean(axis=0) for picture in (upright, rolled))
        np.testing.assert_allclose(one, other, atol=1.5)


def test_a_head_that_sways_about_45_degrees_is_turned_once(drawing):
    pose, view, turns = toy_result(0).pose, None, []
    for degrees in (0, 44, 46, 44, 60, 46, 44, 30):
        roll = Rotation.from_euler("z", degrees, degrees=True).as_matrix()
        tilted = Pose(roll @ pose.rotation, roll @ pose.translation)
        view = drawing.view(tilted, (240, 176), 1.7, view)
        turns.append(abs(view.turns))
    assert turns == [0, 0, 0, 0, 1, 1, 1, 0]


def lines_of(drawing, window):
    return [window.to_drawn(points) for points, _, _ in drawing.contours(toy_result(0, 4))]


@pytest.mark.parametrize("order", [1, -1])
def test_lines_of_lips_that_reach_into_each_other_are_drawn_where_they_meet(drawing, order):
    result = toy_result(0, prototype=4)
    _, up, low = drawing.sizes
    outer, upper, lower = np.split(result.lips, np.cumsum(drawing.sizes)[:2])
    there = np.linspace(0, 1, up)[:, None], np.linspace(0, 1, low)[:, None]
    ends = np.array([[-20.0, 0, 0], [20.0, 0, 0]]) + upper.mean(axis=0)
    upper, lower = (ends[0] + s * (ends[1] - ends[0]) for s in there)
    lower[: low // 2, 1] -= 3.0
    lower[low // 2 :, 1] += 1.0
    crossing = replace(result, lips=np.concatenate([outer, upper[::order], lower[::order]]))
    (one, _, _), (other, _, _), _ = drawing.contours(crossing)
    one, other = one[::order], other[::order]
    below = np.interp(other[:, 0], one[:, 0], one[:, 1])
    assert (other[:, 1] >= below - 0.3).all()  # pixels; rows go down
    assert other[low // 4, 1] > below[low // 4] + 1


def test_the_mouth_fills_its_window_whatever_it_does(drawing):
    one = drawing.view(toy_result(0).pose, (240, 176), across=1.7).window
    for prototype in (1, 4, 5):
        result = toy_result(1, prototype)
        window = drawing.view(result.pose, (240, 176), across=1.7).window
        assert window == one
        assert window.drawn == (240, 176)
        outer = drawing.contours(result)[2][0]
        drawn = window.to_drawn(outer)
        assert (drawn > 0).all()
        assert (drawn < (240, 176)).all()
        assert np.ptp(drawn[:, 0]) > 80


def test_the_video_has_even_sizes_and_all_frames(tmp_path):
    with Overlay(tmp_path / "overlay.mp4", toy_setting()) as overlay:
        for result in (toy_result(0), toy_result(1, 4), lost_result(2)):
            overlay.add(GREY, result)
    info = probe(tmp_path / "overlay.mp4")
    frames = list(read_frames(tmp_path / "overlay.mp4"))
    assert len(frames) == 3
    assert info.size[1] >= 640
    assert not info.size[0] % 2
    assert not info.size[1] % 2
    red = painted(frames[2], LOST)
    assert len(red) > 500
    assert len(painted(frames[1], LOST)) < 50


def test_unevenly_spaced_frames_are_shown_at_their_times(tmp_path):
    times = (22.5, 22.533, 22.567, 24.0)
    with Overlay(tmp_path / "overlay.mp4", replace(toy_setting(), times=times)) as overlay:
        for index in range(4):
            overlay.add(GREY, toy_result(index))
    np.testing.assert_allclose(probe(tmp_path / "overlay.mp4").times, np.array(times) - times[0])


def test_a_clip_that_begins_without_a_face_is_painted():
    painter = Painter(toy_setting())
    for result in (lost_result(0), toy_result(1), lost_result(2)):
        assert painter.paint(GREY, result).shape == (painter.size[1], painter.size[0], 3)


def test_wide_openings_have_their_height_in_the_strip():
    painter = Painter(toy_setting())
    for index, aperture in enumerate((40.0, 45.0)):
        picture = painter.paint(GREY, replace(toy_result(index), aperture=aperture))
    strip = picture[-STRIP_HEIGHT:]
    rows = painted(strip[:, -200:], OUTER)[:, 1]
    assert rows.min() > 8 + 4  # 45 of 50 mm; a curve that is cut off lies along the top
    assert np.ptp(rows) > 4


def test_a_frame_between_lost_ones_is_seen_in_the_strip():
    painter = Painter(toy_setting())
    for result in (lost_result(0), replace(toy_result(1), aperture=12.5), lost_result(2)):
        strip = painter.paint(GREY, result)[-STRIP_HEIGHT:]
    assert len(painted(strip, OUTER)) >= 2


def test_the_enlarged_mouth_says_what_the_contours_are():
    painter = Painter(toy_setting())
    corner = [
        p[:60, -448:-250] for p in (painter.paint(GREY, r) for r in (toy_result(0), lost_result(1)))
    ]
    for colour in (OUTER, UPPER, LOWER):
        assert len(painted(corner[0], colour)) > 30
        assert not len(painted(corner[1], colour))


def test_large_video_is_not_enlarged():
    class Large:
        camera = type(toy_setting().camera).ideal((1921, 1081))
        face, rate, uneven_times = toy_setting().face, 25.0, ()

    painter = Painter(Large())
    assert painter.size == (1920 + 448, 1080 + 96)
    picture = painter.paint(np.zeros((1081, 1921, 3), np.uint8), lost_result(0))
    assert picture.shape == (1176, 2368, 3)


def test_frames_that_landmarks_contradict_are_red_on_the_sheet():
    image = np.zeros((SIZE[1], SIZE[0], 3), np.uint8)
    lowest = {}
    for disagreement in (0.0, 9.0):
        sheet = ContactSheet(toy_setting())
        tile = sheet.tile(image, replace(toy_result(0), disagreement=disagreement))
        caption = tile[-sheets.CAPTION :].reshape(-1, 3).astype(int)
        sheet._tiles, sheet._seen = [tile], 1
        legend = sheet.picture()[-sheets.CAPTION :]
        lowest[disagreement] = [
            bool((np.abs(pixels.reshape(-1, 3) - LOST).max(axis=1) < 40).any())
            for pixels in (caption, legend.astype(int))
        ]
    assert lowest == {0.0: [False, False], 9.0: [True, True]}


@pytest.mark.parametrize(("count", "tiles"), [(1, 1), (9, 9), (80, 80), (700, 80)])
def test_the_sheet_has_all_frames_or_evenly_spread_ones(count, tiles, monkeypatch):
    tile = np.zeros((sheets.TILE[1] + sheets.CAPTION, sheets.TILE[0], 3), np.uint8)

    class Marked(ContactSheet):
        def tile(self, image, result):
            marked = tile.copy()
            marked[0, 0] = result, result // 256, 255
            return marked

    sheet = Marked(toy_setting())
    for index in range(count):
        sheet.add(None, np.uint16(index))
    whole = sheet.picture()
    picture = whole[: -sheets.CAPTION].reshape(-1, 3).astype(int)
    low, high, _ = picture[picture[:, 2] == 255].T
    shown = low + 256 * high
    assert len(shown) == tiles
    assert shown[0] == 0
    assert shown[-1] >= count - 4
    steps = np.diff(shown)
    assert not len(steps) or steps.max() - steps.min() <= 4
    assert sheets.TILE[0] >= 200
    assert len(sheet._tiles) <= 4 * sheets.MOST_TILES
    for colour in (OUTER, UPPER, LOWER):
        assert len(painted(whole[-sheets.CAPTION :], colour)) > 20


def test_tiles_mark_closed_and_lost_frames():
    sheet = ContactSheet(toy_setting())
    closed, wide, lost = (
        sheet.tile(GREY, result)[sheets.TILE[1] :]
        for result in (toy_result(0), toy_result(1, 4), lost_result(2))
    )
    yellow = (255, 210, 90)
    assert len(painted(closed, yellow)) > 20
    assert len(painted(wide, yellow)) == 0
    assert len(painted(lost, LOST)) > 20


@pytest.mark.parametrize("count", [20, 400])
def test_tiles_of_frames_that_are_explained_less_are_framed(count):
    sheet = ContactSheet(toy_setting())
    tile = np.zeros((sheets.TILE[1] + sheets.CAPTION, sheets.TILE[0], 3), np.uint8)
    sheet.tile = lambda *_: tile.copy()
    for index in range(count):
        sheet.add(GREY, toy_result(index))
    less = np.arange(count) >= 3 * count // 4  # the last quarter
    plain, framed = sheet.picture(np.zeros(count, bool)), sheet.picture(less)
    assert len(painted(plain[: -sheets.CAPTION], sheets.LESS)) == 0
    assert (plain[-sheets.CAPTION :] != framed[-sheets.CAPTION :]).any()  # what they mean
    tiles = min(count, sheets.MOST_TILES)
    rows = -(-tiles // sheets.COLUMNS)
    high = (len(framed) - sheets.CAPTION) // rows
    part = [painted(row, sheets.LESS) for row in np.split(framed[: rows * high], rows)]
    assert len(part[0]) == 0
    assert len(part[-1]) > 0
    np.testing.assert_array_equal(sheet.picture(), plain)


def test_lines_of_a_head_seen_from_the_side_stay_as_they_are(drawing):
    result = toy_result(0, prototype=4)
    aside = Rotation.from_euler("y", 95, degrees=True).as_matrix()
    pose = Pose(result.pose.rotation @ aside, result.pose.translation)
    turned = replace(result, pose=pose)
    upper, lower, _ = (line for line, _, _ in drawing.contours(turned))
    pixels = drawing.camera.project(pose.apply(result.lips))
    _, one, other = np.split(pixels, np.cumsum(drawing.sizes)[:2])
    assert np.abs(upper - one).max() < 1.0
    assert np.abs(lower - other).max() < 1.0
