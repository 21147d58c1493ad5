"""Occluders: where they are at which time, and whether their meshes are solid and clear a face."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import trimesh
from scipy.spatial import cKDTree

from abs_engine.capture.board import Board
from abs_engine.core.errors import ParameterError
from abs_engine.io.assets import Speaker, load_speaker
from abs_engine.studio.prop_mesh import Prop
from abs_engine.studio.props import BOARD, Occluder, clear_of, mouth_of
from abs_engine.studio.scenefile import OccluderEntry
from abs_engine.studio.scenefile.values import OccluderKey


def occluder(kind: Any, start: float = 0.0, end: float = 2.0, **more: Any) -> Occluder:
    return changed(OccluderEntry("hand", start, end), kind=kind, **more)


def changed(entry: OccluderEntry, keyframes: Any = (), turns: Any = (), **more: Any) -> Occluder:
    """With other keys, turns in radians, and what else is to change."""
    keys = [OccluderKey(t, offset=place) for t, place in keyframes]
    keys += [OccluderKey(t, turn_degrees=tuple(np.degrees(turn).tolist())) for t, turn in turns]
    return Occluder(replace(entry, keys=tuple(keys), **more))


STILL = occluder(
    "microphone", 1.0, 3.0, travel=0.5, offset=(0, 0, 50), away=(0, -300, 50),
    turn_degrees=(0, 0, 0), sway=0.0,
)  # fmt: skip


@pytest.fixture(scope="module")
def speaker() -> Speaker:
    return load_speaker()


def test_it_comes_is_held_and_goes_along_the_minimum_jerk_curve() -> None:
    mouth = np.array([0.0, -30.0, 95.0])
    assert STILL.pose_at(0.99, mouth) is None
    assert STILL.pose_at(3.01, mouth) is None
    for seconds, offset in (
        (1.0, (0, -300, 50)),  # just arrived
        (1.25, (0, -150, 50)),  # half the time is half the way
        (1.125, (0, -300 * (1 - 53 / 512), 50)),  # 10/64 - 15/256 + 6/1024 = 53/512
        (1.5, (0, 0, 50)),
        (2.4, (0, 0, 50)),
        (2.75, (0, -150, 50)),
        (3.0, (0, -300, 50)),
    ):
        pose = STILL.pose_at(seconds, mouth)
        assert pose is not None
        assert pose.translation == pytest.approx(mouth + offset, abs=1e-9), seconds


def test_top_speed_is_that_of_the_minimum_jerk_curve() -> None:
    times = np.arange(1.0, 1.5, 1e-3)
    speed = np.diff([STILL.offset_at(t)[1] for t in times]) / 1e-3
    assert speed.max() == pytest.approx(1.875 * 300 / 0.5, rel=1e-3)
    assert np.abs(speed[[0, -1]]).max() < 0.01 * speed.max()


def test_keyframes_are_passed_through_and_never_overshot() -> None:
    moved = changed(STILL.entry, keyframes=((2.0, (20.0, 0, 50)), (2.4, (20.0, 10, 60))))
    assert moved.offset_at(2.0) == pytest.approx([20, 0, 50])
    assert moved.offset_at(2.4) == pytest.approx([20, 10, 60])
    assert moved.offset_at(2.5) == pytest.approx([20, 10, 60])  # until it leaves
    path = np.array([moved.offset_at(t) for t in np.arange(1.5, 2.5, 0.01)])
    assert np.all(np.diff(path[:, 0]) > -1e-9)
    assert path[:, 0].max() <= 20 + 1e-9


def test_keyed_turns_are_passed_through_and_stay_until_it_is_gone() -> None:
    turned = changed(STILL.entry, turns=((2.0, (0.0, 0.4, 0)), (2.4, (0.1, 0.4, 0))))
    for seconds, turn in (
        (1.2, (0, 0, 0)),  # on its way
        (1.5, (0, 0, 0)),
        (2.0, (0, 0.4, 0)),
        (2.4, (0.1, 0.4, 0)),
        (2.9, (0.1, 0.4, 0)),  # on its way back
    ):
        assert turned.turn_at(seconds) == pytest.approx(turn, abs=1e-12), seconds
    pose = turned.pose_at(2.4, np.zeros(3))
    assert pose is not None
    assert pose.rotation_vector == pytest.approx([0.1, 0.4, 0])


def test_sway_is_seeded_and_bounded() -> None:
    shaken = changed(STILL.entry, sway=2.0, seed=4)
    path = np.array([shaken.offset_at(t) for t in np.linspace(1.5, 2.5, 50)]) - [0, 0, 50]
    assert np.abs(path).max() <= 2.0
    assert np.abs(path).max() > 0.5
    assert np.array_equal(
        shaken.offset_at(2.0), changed(STILL.entry, sway=2.0, seed=4).offset_at(2.0)
    )
    assert not np.array_equal(
        shaken.offset_at(2.0), changed(STILL.entry, sway=2.0, seed=5).offset_at(2.0)
    )


def _solid(prop: Prop) -> trimesh.Trimesh:
    return trimesh.Trimesh(prop.vertices, prop.faces, process=False)


@pytest.mark.parametrize("kind", ["hand", "microphone"])
def test_meshes_are_closed_and_turned_outwards(kind: str) -> None:
    prop = occluder(kind).prop()
    solid = _solid(prop)
    assert solid.is_watertight
    assert solid.volume > 0
    assert np.linalg.norm(prop.normals, axis=1) == pytest.approx(1.0, abs=1e-4)
    towards = np.einsum("fc,fc->f", solid.face_normals, prop.normals[prop.faces].mean(axis=1))
    assert np.mean(towards > 0) > 0.99  # smoothed normals may fail in the creases of a hand
    assert prop.colours.shape == prop.vertices.shape


def test_sizes_are_those_of_the_real_things() -> None:
    microphone = occluder("microphone").prop().vertices
    assert np.ptp(microphone[:, 0]) == pytest.approx(50.0, abs=0.5)
    assert microphone[:, 1].min() == pytest.approx(-202.0)
    hand = occluder("hand").prop().vertices
    beyond_wrist = hand[hand[:, 0] > -92]
    assert 180 < np.ptp(beyond_wrist[:, 0]) < 215  # a grown person's hand
    assert 75 < np.ptp(beyond_wrist[beyond_wrist[:, 1] < 45][:, 1]) < 100


def test_skin_gives_the_hand_its_colour() -> None:
    dark = occluder("hand", colour=(80, 55, 42)).prop()
    light = occluder("hand", colour=(235, 200, 180)).prop()
    back_of_hand = (np.abs(dark.vertices[:, 0] + 50) < 20) & (dark.vertices[:, 2] > 5)
    assert np.median(dark.colours[back_of_hand], axis=0) == pytest.approx([80, 55, 42], abs=6)
    assert np.median(light.colours[back_of_hand], axis=0) == pytest.approx([235, 200, 180], abs=12)


def test_hand_hides_the_lips_and_keeps_off_the_face(speaker: Speaker) -> None:
    for person in ("clara", "kofi"):
        rest = speaker.named(person)
        held = clear_of(occluder("hand", sway=0.0), speaker, rest, gap=5.0)
        pose = held.pose_at(1.0, mouth_of(speaker, rest))
        assert pose is not None
        at = pose.apply(held.prop().vertices.astype(np.float64))
        for point in rest[speaker.lip_ring]:  # something of the hand before each point
            near = np.linalg.norm(at[:, :2] - point[:2], axis=1) < 3
            assert np.any(at[near, 2] > point[2])
        face = rest[rest[:, 2] > 60]
        for point in face[::7]:  # and all of it before the face
            near = np.linalg.norm(at[:, :2] - point[:2], axis=1) < 1.5
            assert np.all(at[near, 2] > point[2] + 3)


def _drawn(prop: Prop, scale: float) -> np.ndarray:
    """The print as seen from before the face, grey, `scale` pixels for a mm."""
    at = prop.vertices[:-4].astype(float)[:, :2]
    low, high = at.min(axis=0), at.max(axis=0)
    out = np.zeros(tuple(np.rint((high - low) * scale).astype(int)[::-1]), np.uint8)
    for corners, grey in zip(at.reshape(-1, 4, 2), prop.colours[:-4:4, 0], strict=True):
        x, y = (corners - [low[0], high[1]]).T * scale * [[1], [-1]]
        columns, rows = (slice(round(v.min()), round(v.max())) for v in (x, y))
        out[rows, columns] = grey
    return out


@pytest.mark.parametrize(
    "board",
    [
        BOARD,
        Board("charuco", 5, 4, 16.0, 10.0, "5X5_100"),  # cells of three widths
        Board("chessboard", 7, 6, 12.0),
    ],
    ids=lambda b: f"{b.kind}-{b.columns}x{b.rows}",
)
def test_a_board_has_its_corners_where_they_are_said_to_be(board: Board) -> None:
    prop = occluder("board", board=board).prop()
    grey, scale = _drawn(prop, 7.0), 7.0
    found = board.find(np.repeat(grey[..., None], 3, axis=2))
    assert found is not None
    assert len(found.ids) == len(board.places)
    there = (found.places[:, :2] + board.square / 2) * scale - 0.5  # the margin is half a square
    if board.kind == "chessboard" and found.pixels[0, 0] > found.pixels[-1, 0]:
        there = there[::-1]  # OpenCV may begin at either end
    assert np.abs(found.pixels - there).max() < 0.1


def test_a_board_is_printed_on_the_side_away_from_the_face() -> None:
    prop = occluder("board").prop()
    size = np.array([7, 5]) * 18.0 + 18
    assert np.ptp(prop.vertices, axis=0) == pytest.approx([*size, 2], abs=1e-4)
    a, b, c = (prop.vertices[prop.faces[:, k]] for k in range(3))
    across = np.cross(b - a, c - a)
    assert np.all(np.einsum("fc,fc->f", across, prop.normals[prop.faces[:, 0]]) > 0)
    area = np.linalg.norm(across, axis=1) / 2
    front = prop.normals[prop.faces[:, 0], 2] > 0
    assert area[front].sum() == pytest.approx(size.prod(), rel=1e-5)  # no gap, no overlap
    assert len(np.unique(prop.colours[prop.vertices[:, 2] < -1], axis=0)) == 1  # bare


def test_a_turned_board_keeps_off_the_face(speaker: Speaker) -> None:
    near = occluder(
        "board", offset=(0, 20, 60), sway=0.0,
        keyframes=((1.0, (0, 20, 20)),), turns=((1.0, (0, 0.6, 0)),),
    )  # fmt: skip
    rest = speaker.named("clara")
    held = clear_of(near, speaker, rest, gap=5.0)
    flat = clear_of(changed(near.entry, near.keyframes), speaker, rest, gap=5.0)
    assert 20 < flat.keyframes[0][1][2] < 40  # off the tip of the nose
    assert held.keyframes[0][1][2] != pytest.approx(flat.keyframes[0][1][2], abs=0.5)


@pytest.mark.parametrize(
    ("kind", "moved"),
    [
        ("hand", {"turns": ((1.0, (0.0, 1.2, 0.0)),)}),  # its fingers towards the cheek
        ("microphone", {"offset": (-70, -5, 10), "keyframes": ((1.0, (70, -5, 10)),)}),  # the nose
    ],
)
def test_what_is_moved_keeps_off_the_face_all_the_time(
    speaker: Speaker, kind: Any, moved: dict[str, Any]
) -> None:
    rest = speaker.named("clara")
    mouth, front = mouth_of(speaker, rest), rest[rest[:, 2] > 0]
    held = clear_of(occluder(kind, travel=0.2, sway=0.0, **moved), speaker, rest)
    vertices = held.prop().vertices.astype(np.float64)
    for seconds in np.linspace(0.2, 1.8, 50):
        pose = held.pose_at(seconds, mouth)
        assert pose is not None
        at = pose.apply(vertices)
        away, near = cKDTree(front[:, :2]).query(at[:, :2])
        assert np.all((at[:, 2] > front[near, 2] + 3) | (away > 2)), seconds


def test_clear_occluder_is_left_where_it_is(speaker: Speaker) -> None:
    far = occluder("hand", offset=(0, 0, 120))
    assert clear_of(far, speaker, speaker.named("mei")) is far


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"kind": "scarf"}, "no occluder 'scarf'"),
        ({"end": 1.2}, "needs 0.5 s"),
        ({"travel": 0.0}, "needs 0 s"),
        ({"keyframes": ((2.9, (0, 0, 0)),)}, "keyframes in order"),
        ({"keyframes": ((2.2, (0, 0, 0)), (2.0, (0, 0, 0)))}, "keyframes in order"),
        ({"offset": (0, np.nan, 0)}, "no finite place"),
        ({"turns": ((2.0, (0, np.inf, 0)),)}, "no finite place"),
        ({"turns": ((2.9, (0, 0, 0)),)}, "keyframes in order"),
        ({"board": BOARD}, "microphone is not a board"),
    ],
)
def test_impossible_occluders_are_refused(change: dict[str, Any], words: str) -> None:
    with pytest.raises(ParameterError, match=words):
        changed(STILL.entry, **change)
