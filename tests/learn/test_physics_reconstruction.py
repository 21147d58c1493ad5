"""Table 1, which camera helps most, and the picture of the modes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from clara_lips import SEEN, SHELL, SPEAKER, TRAINED

from abs_engine.core.errors import ParameterError, TooFewPointsError
from abs_engine.face.shape.dots import ShellPoints
from abs_engine.face.shape.modal import LearnedPhysics
from abs_engine.learn.reconstruction import (
    TABLE_1,
    UNITS,
    rank_cameras,
    table_1,
    unit_scale,
)
from abs_engine.learn.training import train
from abs_engine.papers.basu1998.figures import SIZE, draw_modes, mode_postures
from abs_engine.render.cpu import CpuRenderer


def test_the_shell_has_the_papers_size_in_its_units():
    rest = TRAINED.physics.rest
    np.testing.assert_allclose(np.ptp(rest * unit_scale(rest), axis=0), UNITS)


def test_table_1_is_at_most_the_papers():
    rows = table_1(TRAINED)
    assert [row.part for row in rows] == list(TABLE_1)
    for row in rows:
        assert row.error <= row.part.paper
        assert 0.3 < row.rms / row.expected < 3


def test_without_test_frames_there_is_no_table():
    with pytest.raises(TooFewPointsError, match="no frame is left"):
        table_1(train(SEEN, SPEAKER, "clara", n_train=150, shell=SHELL))


def directional(x: float, y: float, z: float) -> LearnedPhysics:
    """Two nodes that move together along each axis, with these standard deviations, mm."""
    modes = np.zeros((3, 2, 3))
    modes[np.arange(3), :, np.arange(3)] = np.sqrt(0.5)
    variances = np.array([x, y, z]) ** 2
    rest = np.array([[0, 0, 0], [1.0, 0, 0]])
    return LearnedPhysics(rest, 0 * rest, modes, variances, float(variances.sum()), 0.1)


PLACES = {
    "front": np.array([0, 0, 1.0]),
    "profile": np.array([2.0, 0, 0]),
    "above": np.array([0, 1.0, 0]),
}


class TestCameras:
    POINTS = ShellPoints(np.array([[0] * 3, [1] * 3]), np.array([[1.0, 0, 0]] * 2))

    @pytest.mark.parametrize(
        ("spread", "order"),
        [
            ((3, 2, 1), ["front", "above", "profile"]),  # each misses what is along its direction
            ((1, 2, 3), ["profile", "above", "front"]),
            ((3, 1, 2), ["above", "front", "profile"]),
        ],
    )
    def test_the_best_sees_the_directions_that_vary_most(self, spread, order):
        gains = rank_cameras(directional(*spread), self.POINTS, PLACES)
        assert [gain.name for gain in gains] == order

    def test_the_variance_that_is_left_is_known(self):
        """A mode along the camera's direction stays; one across it has two looks at it."""
        (gain,) = rank_cameras(
            directional(3, 2, 1), self.POINTS, {"front": PLACES["front"]}, noise=0.5
        )
        left = 1 / (1 / 9 + 1 / 0.25) + 1 / (1 / 4 + 1 / 0.25) + 1
        assert gain.expected == pytest.approx(np.sqrt(left / 2))
        assert gain.before == pytest.approx(np.sqrt(14 / 2))

    def test_beside_a_frontal_camera_what_shows_depth_helps_most(self):
        physics, front = directional(3, 2, 1), PLACES["front"]
        gains = rank_cameras(physics, self.POINTS, PLACES, have=(front,))
        assert gains[-1].name == "front"
        assert gains[-1].expected > 0.9 * gains[-1].before
        assert gains[0].expected < 0.2 * gains[0].before

    def test_no_direction_and_no_camera_are_refused(self):
        with pytest.raises(ParameterError, match="not a direction"):
            rank_cameras(directional(1, 1, 1), self.POINTS, {"nowhere": np.zeros(3)})
        with pytest.raises(ParameterError, match="no camera"):
            rank_cameras(directional(1, 1, 1), self.POINTS, {})


class TestFigure:
    def test_postures_are_named_and_lie_two_deviations_from_the_mean(self):
        physics = TRAINED.physics
        postures = mode_postures(physics, 2)
        assert list(postures)[:3] == [
            "at rest", "mean displacement", "mode 1, \N{MINUS SIGN}2 sd",
        ]  # fmt: skip
        away = physics.coefficients(postures["mode 2, +2 sd"])
        np.testing.assert_allclose(away[1], 2 * np.sqrt(physics.variances[1]))

    def test_lips_and_skin_are_drawn_from_both_sides(self):
        page = draw_modes(CpuRenderer(), SHELL, TRAINED.physics, 1).astype(int)
        first = page[: SIZE[1], : 2 * SIZE[0]]
        red = (first[..., 0] - first[..., 1] > 40).reshape(SIZE[1], 2, SIZE[0])
        drawn = (first.min(axis=2) < 250).reshape(SIZE[1], 2, SIZE[0])
        for half in range(2):
            assert red[:, half].sum() > 300
            assert drawn[:, half].sum() > 2 * red[:, half].sum()
        assert red[:, 0].sum() > 2 * red[:, 1].sum()  # the front shows more of the lips


def test_modes_that_hold_all_the_variance_but_for_rounding_are_expected_to_miss_little():
    exact = replace(TRAINED.physics, total=TRAINED.physics.variances.sum() * (1 - 1e-15))
    rows = table_1(replace(TRAINED, physics=exact))
    assert all(0 < row.expected < 1 for row in rows)
