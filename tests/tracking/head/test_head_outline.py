"""A head's outline is found where its skin ends, and moves the head there."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from drawn import average_shape, lit, speaker, vertices_of
from heads import seen_at

from abs_engine.core.camera import Camera
from abs_engine.core.geometry import Pose
from abs_engine.face.identity import head_modes
from abs_engine.face.shape.upper_face import upper_face_modes
from abs_engine.render.cpu import CpuRenderer
from abs_engine.tracking.head.head_outline import outline, outline_equations
from abs_engine.tracking.texture.head_texture import HeadBody, HeadView, between, gray_of

CAMERA = Camera.ideal((320, 320))
PERSON = "walter"
POSE = seen_at([0.05, 0.2, 0], [5, -5, 620])
WALL = (70, 120, 90)


@cache
def picture():
    """The person before a green wall."""
    image = lit(PERSON, POSE, CAMERA).copy()
    image[~head_drawn()] = WALL
    return image


@cache
def head_drawn():
    drawn = body().scene.at(body().mean.astype(np.float32))
    from abs_engine.core.camera import Window
    from abs_engine.core.scene import Candidates

    whole = Window(0.0, 0.0, 320.0, 320.0, 1.0)
    one = Candidates.one(np.zeros(0), POSE)
    return CpuRenderer().draw(drawn, one, CAMERA, whole)[0].covered


@cache
def body():
    """The person's own head."""
    one, mouth = speaker(), average_shape()
    return HeadBody.of(
        one, vertices_of(PERSON), head_modes(one), mouth.modes, upper_face_modes(one)
    )


def view(pose=POSE, vertices=None, image=None):
    vertices = body().mean if vertices is None else vertices
    gray = gray_of(picture() if image is None else image)
    return HeadView.of(gray, pose, vertices, speaker().faces)


def looked_for(seen, image=None, one=None):
    shown = picture() if image is None else image
    return outline(one or body(), seen, shown, CAMERA, CpuRenderer())


def wider(mm):
    """The head with both sides farther out."""
    return body().mean + mm * np.tanh(body().mean[:, :1] / 20) * np.array([1.0, 0, 0])


def test_the_true_head_ends_where_its_skin_ends():
    found = looked_for(view())
    assert found is not None
    assert len(found.off) > 30
    assert np.abs(np.median(found.off)) <= 1.0
    assert np.mean(np.abs(found.off) < 2.0) > 0.6  # ears lie in their own shade


@pytest.mark.parametrize("mm", [-5.0, 5.0])
def test_a_head_too_wide_or_too_narrow_is_seen_as_such(mm):
    found = looked_for(view(vertices=wider(mm)))
    assert found is not None
    assert np.median(found.off) == pytest.approx(-mm, abs=1.5)


def test_steps_lay_the_head_on_its_outline():
    start = view(pose=Pose(POSE.rotation, POSE.translation + np.array([4.0, 0, 0])))
    found = looked_for(start)
    assert found is not None
    across, went = 3, 0.0
    for _ in range(8):
        there = view(
            pose=Pose(start.pose.rotation, start.pose.translation + np.array([went, 0, 0]))
        )
        told = outline_equations(body(), found, there, CAMERA)
        went -= told.gradient[across] / told.information[across, across]
    assert -4.8 < went < -2.6  # an ear in its own shade holds it back


@pytest.mark.parametrize("mode", [1, 4])
def test_a_step_along_a_mode_is_what_its_displacements_ask_for(mode):
    start = view()
    found = looked_for(start)
    assert found is not None
    step = np.zeros(6 + len(body().identity) + len(body().posture))
    step[6 + mode] = 0.1
    across = np.array([1.0, 0.0])
    who, still = step[6 : 6 + len(body().identity)], np.zeros(len(body().posture))
    moved = view(vertices=body().vertices(who, still))
    none = replace(found, off=np.zeros_like(found.off), normal=np.tile(across, (len(found.off), 1)))
    points = [between(found.corners, found.weights, v.vertices) for v in (start, moved)]
    here, there = (CAMERA.project(POSE.apply(p)) for p in points)
    scale = CAMERA.matrix[0, 0] / POSE.translation[2]
    asked = replace(none, off=(there - here) @ across / scale)
    told = outline_equations(body(), asked, start, CAMERA)
    left = told.gradient + told.information @ step
    assert np.abs(told.gradient).max() > 0
    assert np.linalg.norm(left) < 0.02 * np.linalg.norm(told.gradient)


def test_an_outline_that_would_have_to_shrink_is_believed_less():
    start = view()
    found = looked_for(start)
    assert found is not None
    grows, shrinks = (
        outline_equations(body(), replace(found, off=np.full_like(found.off, mm)), start, CAMERA)
        for mm in (1.5, -1.5)
    )
    assert np.trace(grows.information) > 1.5 * np.trace(shrinks.information)


def test_before_a_wall_of_the_skins_colour_nothing_is_found():
    skin = picture()[head_drawn()].mean(axis=0)
    even = np.full_like(picture(), skin.astype(np.uint8))
    assert looked_for(view(), even) is None


def test_a_head_without_named_landmarks_has_no_outline():
    nameless = replace(body(), speaker=replace(speaker(), points={}))
    assert looked_for(view(), one=nameless) is None


def test_a_head_out_of_the_picture_has_none():
    away = Pose(POSE.rotation, POSE.translation + np.array([4000.0, 0, 0]))
    assert looked_for(view(pose=away)) is None
