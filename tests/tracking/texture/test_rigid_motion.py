"""The head's motion: known turns and shifts of a drawn head come back."""

from __future__ import annotations

import numpy as np
import pytest
from heads import head_of, picture_of, seen_at

from abs_engine.core.camera import Camera
from abs_engine.render.cpu import CpuRenderer
from abs_engine.tracking.settings.registration import REGISTRATION
from abs_engine.tracking.texture.rigid_motion import follow, rigid_reference

CAMERA = Camera.ideal((400, 300))
START = seen_at([0, 0, 0], [5, 10, 650])


@pytest.fixture(scope="module")
def model():
    return head_of("clara")


def reference_of(model, image):
    return rigid_reference(image, START, model.head, model.rigid, CAMERA, CpuRenderer())


@pytest.fixture(scope="module")
def reference(model):
    return reference_of(model, picture_of(model.head, START, CAMERA))


def angle(one, two):
    """Degrees between two rotations."""
    return np.degrees(np.arccos(np.clip((np.trace(one.T @ two) - 1) / 2, -1, 1)))


def test_points_lie_on_the_rigid_face_where_their_pixels_are(model, reference):
    assert 30 < len(reference.points) <= 150
    projected = CAMERA.project(START.apply(reference.points))
    assert np.abs(projected - reference.pixels).max() < 0.75  # corners between pixel centres
    lowest = model.head.mean[model.speaker.lip_ring, 1].max()
    assert reference.points[:, 1].min() > lowest


def test_a_still_head_stays(reference, model):
    state = follow(reference, picture_of(model.head, START, CAMERA), CAMERA, None)
    assert angle(state.pose.rotation, START.rotation) < 0.1
    assert state.seen > 0.95


MOTIONS = {
    "yaw": ([0, 0.10, 0], [0, 0, 0]),
    "pitch": ([-0.08, 0, 0], [0, 0, 0]),
    "roll": ([0, 0, 0.12], [0, 0, 0]),
    "shift": ([0, 0, 0], [20, -12, 0]),
    "nearer": ([0, 0, 0], [0, 0, -50]),
    "all": ([0.05, -0.07, 0.06], [-10, 8, 25]),
}


@pytest.mark.parametrize("motion", MOTIONS)
def test_a_known_motion_is_recovered(model, reference, motion):
    """In six steps, each started from the one before, as a clip is followed."""
    turn, shift = (np.array(v, float) for v in MOTIONS[motion])
    state = None
    for part in np.linspace(0, 1, 7)[1:]:
        truth = seen_at(part * turn, START.translation + part * shift)
        state = follow(reference, picture_of(model.head, truth, CAMERA), CAMERA, state)
        assert state is not None
    mouth = model.pivot
    assert angle(state.pose.rotation, truth.rotation) < 0.7
    offset = state.pose.apply(mouth) - truth.apply(mouth)
    assert np.abs(offset[:2]).max() < 1.0  # mm
    assert abs(offset[2]) < 8.0  # of 650: depth is weak
    assert state.seen > 0.6


def test_points_that_moved_otherwise_are_not_seen_on_the_head(model, reference):
    """A tenth of them has gone 8 pixels up, the rest has stayed."""
    image = picture_of(model.head, START, CAMERA)
    edge = int(np.quantile(reference.pixels[:, 0], 0.9))
    share = (reference.pixels[:, 0] >= edge).mean()
    moved = image.copy()
    moved[:-8, edge:] = image[8:, edge:]
    state = follow(reference, moved, CAMERA, None)
    assert 0.8 < state.seen <= 1 - share
    assert angle(state.pose.rotation, START.rotation) < 1.0


def test_a_face_that_is_gone(model, reference):
    rng = np.random.default_rng(0)
    assert follow(reference, rng.integers(0, 256, (300, 400, 3), np.uint8), CAMERA, None) is None


def test_an_even_picture_has_no_points_to_follow(model):
    flat = np.full((300, 400, 3), 90, np.uint8)
    reference = reference_of(model, flat)
    assert len(reference.points) < REGISTRATION.least_points
    assert follow(reference, flat, CAMERA, None) is None
