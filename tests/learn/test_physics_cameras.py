"""Which camera would help most: what each yaw sees, what remains, and where a user reads it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from clara_lips import SPEAKER, TRAINED

from abs_engine.capture.dot_annotations import LIPS16
from abs_engine.cli import main
from abs_engine.core.errors import ModelFormatError, ParameterError
from abs_engine.face.shape.lip_dots import lips17
from abs_engine.face.shape.lip_shell import cut_lip_shell
from abs_engine.learn import cameras
from abs_engine.learn.cameras import YAWS, camera_results, direction_of, rank_yaws
from abs_engine.papers.basu1998.page import reproduction_page

PHYSICS = TRAINED.physics


@pytest.fixture(scope="module")
def results():
    return camera_results(PHYSICS, SPEAKER)


@pytest.mark.parametrize(
    ("yaw", "up", "direction"),
    [(0, 0, [0, 0, 1]), (90, 0, [1, 0, 0]), (-90, 0, [-1, 0, 0]), (30, 0, [0.5, 0, 0.75**0.5]),
     (0, 30, [0, 0.5, 0.75**0.5])],
)  # fmt: skip
def test_directions_lead_from_the_head_to_the_camera(yaw, up, direction):
    np.testing.assert_allclose(direction_of(yaw, up), direction, atol=1e-12)


@pytest.mark.parametrize("place", [(91, 0), (0, 90), (float("nan"), 0)])
def test_a_camera_behind_the_head_is_refused(place):
    with pytest.raises(ParameterError, match="does not see the lips"):
        direction_of(*place)


def test_a_wall_hides_what_is_behind_it():
    wall = np.array([[[-9.0, -9, 5], [9, -9, 5], [0, 9, 5]]])
    for place, direction, hidden in (
        ([0, 0, 0], [0, 0, 1], True),
        ([0, 0, 0], [0, 0, -1], False),
        ([0, 0, 0], [1, 0, 0], False),
        ([0, 0, 6], [0, 0, 1], False),
        ([0, 0, 4.5], [0, 0, 1], False),  # its own surface, all but touched
        ([20, 0, 0], [0, 0, 1], False),
    ):
        assert cameras._hidden(np.array(place, float), np.array(direction, float), wall) == hidden


def test_a_frontal_camera_sees_all_dots_and_a_profile_its_own_side(results):
    dots = {int(yaw): of["dots"] for yaw, of in results["yaw"].items()}
    assert tuple(dots) == YAWS
    assert dots[0] == len(LIPS16)
    assert dots[90] < 12
    assert all(abs(dots[yaw] - dots[-yaw]) <= 1 for yaw in YAWS)
    head = SPEAKER.named("clara").astype(float)
    places = head[lips17(SPEAKER)[:-1]]
    triangles = head[SPEAKER.faces]
    left = [k for k, p in enumerate(places) if not cameras._hidden(p, direction_of(90), triangles)]
    assert places[left, 0].min() > -3  # none of the other side


def test_a_camera_at_an_angle_tells_most_and_another_front_least(results):
    """A frontal camera lacks depth and a profile half of the dots; between them neither is so."""
    alone = {int(yaw): of["alone_mm"] for yaw, of in results["yaw"].items()}
    assert 15 <= abs(min(alone, key=alone.get)) <= 60
    beside = {int(yaw): of["beside_frontal_mm"] for yaw, of in results["yaw"].items()}
    assert 30 <= abs(min(beside, key=beside.get)) <= 90
    assert max(beside, key=beside.get) == 0
    assert results["frontal_mm"] == alone[0] > beside[0]
    assert results["without_mm"] > 5 * max(alone.values())


def test_what_remains_is_what_remains():
    """Shapes drawn from the prior are as far from their reconstruction as was expected."""
    from abs_engine.face.shape.posterior import reconstruct
    from abs_engine.learn.correspondence import shell_points

    (gain,) = rank_yaws(PHYSICS, SPEAKER, [0], noise=0.4)
    rng = np.random.default_rng(3)
    truth = PHYSICS.shape(rng.normal(0, np.sqrt(PHYSICS.variances), (400, 10)))
    rows = shell_points(SPEAKER, cut_lip_shell(SPEAKER)).rows(len(PHYSICS.rest), "xy")
    told = (rows @ truth.reshape(400, -1).T).T
    found = reconstruct(PHYSICS, rows, told + rng.normal(0, 0.4, told.shape), 0.4).shapes
    rms = np.sqrt(((found - truth) ** 2).sum(axis=-1).mean())
    assert gain.expected == pytest.approx(rms, rel=0.05)


def test_more_noise_and_fewer_cameras_leave_more():
    (sure,), (unsure,) = (rank_yaws(PHYSICS, SPEAKER, [30], noise=n) for n in (0.1, 1.0))
    assert sure.expected < unsure.expected
    (third,) = rank_yaws(PHYSICS, SPEAKER, [30], have=[0, 60])
    assert third.before < rank_yaws(PHYSICS, SPEAKER, [30], have=[0])[0].before
    assert third.expected < third.before


def test_lips_of_another_head_are_refused():
    with pytest.raises(ModelFormatError, match="another speaker"):
        rank_yaws(replace(PHYSICS, speaker="0" * 16), SPEAKER)


def test_the_page_has_a_row_for_each_yaw_and_tells_the_best(results):
    page = reproduction_page({"cameras": results}, [], [])
    for yaw in YAWS:
        assert f"<td>{yaw}°</td>".replace("-", "\N{MINUS SIGN}") in page
    assert page.count("(best)") == 2
    assert "abs-engine cameras" in page
    for broken in ({"yaw": {"0": None}}, {"yaw": {}}, {"yaw": 3}, None):
        page = reproduction_page({"cameras": broken}, [], [])
        assert "Which camera" in page
        assert "nan" not in page


@pytest.fixture(scope="module")
def lips(tmp_path_factory):
    path = tmp_path_factory.mktemp("lips") / "lips.npz"
    PHYSICS.save(path)
    return path


def test_the_command_says_which_camera_helps_most(lips, capsys):
    assert main(["cameras", str(lips), "--yaw", "-30", "0", "60", "--have", "0"]) == 0
    first, _, *rows = capsys.readouterr().out.splitlines()
    assert "with cameras at 0" in first
    assert [row.split()[0] for row in rows] == ["-30", "0", "60"]
    assert [row.endswith("best") for row in rows] == [False, False, True]
    assert main(["cameras", str(lips), "--yaw", "-0.0", "--have", "-0.0"]) == 0
    first, _, row = capsys.readouterr().out.splitlines()
    assert "with cameras at 0," in first
    assert row.split()[0] == "0"
    assert main(["cameras", str(lips), "--yaw", "0"]) == 0
    assert "with no camera" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--yaw", "120"], "does not see the lips"),
        (["--yaw", "nan"], "does not see the lips"),
        (["--have", "inf"], "does not see the lips"),
        (["--noise", "0"], "above 0 mm"),
        (["--noise", "1e-160"], "a noise of 1e-160 mm is below the rounding of coordinates"),
        (["--noise", "inf"], "finite noise above 0 mm"),
        (["--noise", "nan"], "finite noise above 0 mm"),
    ],
)
def test_the_command_refuses_in_one_line(lips, capsys, words, said):
    assert main(["cameras", str(lips), *words]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert said in line
