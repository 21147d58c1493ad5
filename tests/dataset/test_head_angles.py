"""The head's angles are those of Epic's plug-in, and of the app's own recording."""

from __future__ import annotations

import csv
import os
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from abs_engine.dataset.head_angles import live_link_angles, rotation_by

DATA = Path(os.environ.get("ABS_ENGINE_DATA", "nowhere")) / "livelink_rom" / "alex_rom_3.csv"


def rotator(rotation):
    """Yaw, pitch and roll that Unreal's FQuat::Rotator makes of ARKit's rotation."""
    qx, qy, qz, qw = rotation.as_quat()
    x, y, z, w = -qz, qx, qy, -qw  # to Unreal's axes
    yaw = np.arctan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))
    pitch = np.arcsin(2 * (z * x - w * y))
    roll = np.arctan2(-2 * (w * x + y * z), 1 - 2 * (x * x + y * y))
    return yaw, pitch, roll


@pytest.mark.parametrize(
    ("vector", "expected"),
    [
        ((0, 0.3, 0), (-0.3, 0, 0)),  # to the subject's left
        ((0.3, 0, 0), (0, 0.3, 0)),  # the chin down
        ((0, 0, 0.3), (0, 0, -0.3)),  # to the right shoulder
    ],
)
def test_turns_about_one_axis(vector, expected):
    rotation = Rotation.from_rotvec(vector)
    np.testing.assert_allclose(live_link_angles(rotation), expected, atol=1e-12)
    np.testing.assert_allclose(rotator(rotation), expected, atol=1e-12)


def test_any_rotation_has_the_angles_that_unreal_gives_it():
    rotations = Rotation.from_rotvec(np.random.default_rng(3).normal(0, 0.4, (50, 3)))
    angles = live_link_angles(rotations)
    np.testing.assert_allclose(angles, [rotator(one) for one in rotations], atol=1e-9)
    back = rotation_by(angles) * rotations.inv()
    assert back.magnitude().max() < 1e-9


@pytest.mark.skipif(not DATA.is_file(), reason="the recording livelink_rom is not here")
@pytest.mark.parametrize(("eye", "inwards"), [("Left", -1), ("Right", 1)])
def test_eyes_of_a_recording_turn_to_where_they_look(eye, inwards):
    """About the head frame's axes: y is up, and a turn about it leads to the subject's left."""
    with DATA.open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))

    def column(name):
        return np.array([float(row[name]) for row in rows])

    angles = np.stack([column(f"{eye}Eye{a}") for a in ("Yaw", "Pitch", "Roll")], axis=1)
    down, left, _ = rotation_by(angles).as_rotvec().T
    looks_in = column(f"EyeLookIn{eye}") - column(f"EyeLookOut{eye}")
    looks_down = column(f"EyeLookDown{eye}") - column(f"EyeLookUp{eye}")
    assert np.corrcoef(left, inwards * looks_in)[0, 1] > 0.99
    assert np.corrcoef(down, looks_down)[0, 1] > 0.99
