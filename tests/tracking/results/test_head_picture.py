"""The picture of the whole head over a frame, and which frame it is."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from runs import lost_result, toy_result, toy_setting

from abs_engine.core.geometry import Pose
from abs_engine.tracking.results.run_pictures import HeadKeeper, head_picture

SETTING = toy_setting()
WALL = np.full((240, 320, 3), (40, 90, 60), np.uint8)


def halves(picture):
    middle = picture.shape[1] // 2
    return picture[:, :middle].astype(int), picture[:, middle:].astype(int)


def changed(picture):
    """Which pixels the head is drawn over."""
    plain, over = halves(picture)
    return np.abs(over - plain).max(axis=2) > 3


def test_the_frame_stands_beside_the_head_drawn_over_it():
    picture = head_picture(SETTING, WALL, toy_result(0))
    assert picture.dtype == np.uint8
    assert picture.shape[0] == 480
    plain, _ = halves(picture)
    shown = (plain == WALL[0, 0]).all(axis=2)
    assert shown.mean() > 0.5
    assert (plain[~shown] == 0).all()  # beyond the picture's edge
    head = changed(picture)
    assert 0.1 < head.mean() < 0.7
    rows, columns = np.nonzero(head)
    for ends, size in ((rows, head.shape[0]), (columns, head.shape[1])):  # all of it, ears and chin
        assert ends.min() > 0.1 * size
        assert ends.max() < 0.9 * size


def test_lips_are_drawn_red():
    _, over = halves(head_picture(SETTING, WALL, toy_result(0)))
    red = (over[..., 0] > over[..., 2] + 30) & (over[..., 0] > over[..., 1] + 30)
    assert 0.001 < red.mean() < 0.05
    rows = np.nonzero(red)[0]
    assert rows.mean() > over.shape[0] / 2  # the mouth is in the lower half


def test_an_open_mouth_is_drawn_open():
    closed, wide = (head_picture(SETTING, WALL, toy_result(0, k)) for k in (0, 4))
    assert np.abs(halves(closed)[1] - halves(wide)[1]).max() > 60


def test_a_head_at_the_pictures_edge_is_still_drawn():
    result = toy_result(0)
    aside = replace(result, pose=Pose(result.pose.rotation, [150.0, 40.0, 700.0]))
    assert changed(head_picture(SETTING, WALL, aside)).mean() > 0.1


def test_without_a_pose_it_is_the_frame():
    assert head_picture(SETTING, WALL, lost_result(0)) is WALL


@pytest.mark.parametrize(
    ("frames", "lost", "kept"),
    [(10, (), 5), (10, (5,), 6), (10, range(5, 10), 4), (0, (), 0), (10, (0, 1), 5)],
)
def test_the_frame_half_way_or_the_next_one_that_was_found(frames, lost, kept):
    keeper, images = HeadKeeper(SETTING, frames), []
    for k in range(10):
        images.append(np.full_like(WALL, 10 * k))
        keeper.add(images[k], lost_result(k) if k in lost else toy_result(k))
    plain, _ = halves(keeper.picture())
    assert plain.max() == 10 * kept


def test_where_nothing_was_found_there_is_no_picture():
    keeper = HeadKeeper(SETTING, 2)
    keeper.add(WALL, lost_result(0))
    assert keeper.picture() is None
