"""A person's mouth and the clip's colours, where landmarks have placed the head."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from types import SimpleNamespace

import cv2
import numpy as np
import pytest
from drawn import (
    average_shape,
    correspondence,
    network_sees,
    scene_of,
    speaker,
    texture_of,
    vertices_of,
)
from heads import lit_picture_of, seen_at

from abs_engine.core.camera import Camera
from abs_engine.core.errors import FaceNotFoundError
from abs_engine.core.pose import PoseFrame
from abs_engine.face.head import build_mouth_model
from abs_engine.render.cpu import CpuRenderer
from abs_engine.tracking.detection.mouth_search import shifted
from abs_engine.tracking.frame import landmark_calibration
from abs_engine.tracking.frame.landmark_calibration import PlacedHead, calibrate_placed, following
from abs_engine.tracking.head.head_fit import AverageHead, seen_in
from abs_engine.tracking.head.head_pose import TexturedHead, placed_fit
from abs_engine.tracking.landmark.landmark_fit import fit_frame
from abs_engine.tracking.person.scale import pupil_distance, pupil_scale
from abs_engine.tracking.settings.preparation import PREPARATION

PERSON = "amara"
CAMERA = Camera.ideal((240, 240))
POSTURES = (
    {},
    {"jawOpen": 0.3},
    {"jawOpen": 0.12, "mouthStretchLeft": 0.4, "mouthUpperUpLeft": 0.2},
)
POSES = [seen_at([0, yaw, 0], [0, 0, 620]) for yaw in (-0.15, 0.0, 0.15)]
LIPSTICK = np.array([120, 40, 130])  # what the model's own texture has nothing of


def painted():
    """The person's texture with lips of another colour."""
    one, texture = speaker(), texture_of(PERSON).copy()
    lips = np.isin(one.facet_class, [one.class_id(n) for n in ("upper_lip", "lower_lip")])
    height, width = texture.shape[:2]
    corners = np.rint(one.uv[one.faces[lips]] * [width, height]).astype(np.int32)
    mask = np.zeros((height, width), np.uint8)
    for triangle in corners:
        cv2.fillConvexPoly(mask, triangle, 1)
    shade = texture[mask > 0].mean(axis=1, keepdims=True) / texture[mask > 0].mean()
    texture[mask > 0] = np.clip(shade * LIPSTICK, 0, 255).astype(np.uint8)
    return texture


@cache
def clip():
    """Pictures of the person with painted lips, and what the network sees."""
    texture, out = painted(), []
    for pose, units in zip(POSES, POSTURES, strict=True):
        scene = replace(scene_of(PERSON, **units), texture=texture)
        image = lit_picture_of(scene, pose, CAMERA, (0.3, -0.5, -1.0), 0.0)
        out.append((image, network_sees(image)))
    return out


@cache
def placed():
    """The person as an unknown one, at the true pupil distance."""
    pupils = pupil_distance(speaker(), vertices_of(PERSON))
    frames = [seen_in(image, marks) for image, marks in clip()]
    scale = pupil_scale(pupils)
    average = AverageHead.of(speaker(), correspondence(), scale, average_shape())
    head = average.fitted(frames, CAMERA, CpuRenderer())
    model = build_mouth_model(
        head.speaker, head.neutral, texture_of("clara"), expression=head.expression,
        person_spread=PREPARATION.person_spread,
    )  # fmt: skip
    return PlacedHead(model, head.textured, correspondence(), CpuRenderer())


@cache
def calibrated():
    return calibrate_placed(placed(), clip())


def test_without_colour_skin_and_lips_are_not_mixed():
    assert calibrated()[0].classes.mixed > 0
    found, *_ = calibrate_placed(placed(), clip(), chromatic=False)
    assert not found.classes.chromatic
    assert found.classes.mixed == 0


@pytest.mark.parametrize(
    ("camera", "said"),
    [
        (Camera.ideal(CAMERA.size), "not those of a face; give a video with a face$"),
        (Camera.ideal(CAMERA.size, 5.0), "by the given camera; .* a face, and check --camera$"),
    ],
)
def test_a_camera_by_which_there_is_no_face_is_named(camera, said):
    head = SimpleNamespace(
        model=SimpleNamespace(n_person=0), textured=SimpleNamespace(camera=camera),
        renderer=CpuRenderer(), frames=lambda _: [],
    )  # fmt: skip
    with pytest.raises(FaceNotFoundError, match=said):
        calibrate_placed(head, clip())


def apart(k, pose, vertices, names=("outer", "upper", "lower")):
    """RMS distance of a frame's lips from the truth in the picture, mm at the mouth."""
    model = placed().model
    truth, off = vertices_of(PERSON, **POSTURES[k]), []
    pixel = POSES[k].apply(placed().model.pivot)[2] / CAMERA.matrix[0, 0]
    for name in names:
        ring = model.rings[name]
        there = CAMERA.project(POSES[k].apply(truth[model.kept[ring]]))
        off.append(CAMERA.project(pose.apply(vertices[ring])) - there)
    return float(np.sqrt((np.concatenate(off) ** 2).sum(axis=1).mean())) * pixel


@pytest.mark.parametrize("k", range(len(POSTURES)))
def test_the_lips_are_left_where_they_are_in_the_picture(k):
    found, shape, _ = calibrated()
    model, vector = placed().model, found.expressions[k]
    textured = replace(placed().textured, shift=found.shift)
    fit = placed_fit(textured, shape, *clip()[k])
    assert fit is not None
    pose = fit.pose
    vertices = model.held(found.person).vertices(vector[6:])
    assert apart(k, PoseFrame(pose, model.pivot).pose(vector[:6]), vertices) < 2.5


@pytest.mark.parametrize("k", range(len(POSTURES)))
def test_frames_are_handed_on_as_they_were_fitted(k):
    found, _, posed = calibrated()
    model, one = placed().model, posed[k]
    np.testing.assert_array_equal(one.vector, found.expressions[k])
    assert one.frame.face.landmarks is clip()[k][1]
    vertices = model.held(found.person).vertices(one.vector[6:])
    assert apart(k, PoseFrame(one.pose, model.pivot).pose(one.vector), vertices) < 2.5


def test_the_texture_is_looked_for_once_in_each_frame(monkeypatch):
    looked, pose = [], TexturedHead.pose
    monkeypatch.setattr(
        TexturedHead, "pose", lambda self, *given: looked.append(1) or pose(self, *given)
    )
    found, *_ = calibrate_placed(placed(), clip())
    assert len(looked) == len(clip())
    np.testing.assert_array_equal(found.shift, calibrated()[0].shift)


def test_frames_are_placed_again_as_they_would_be_anew():
    head, shift = placed(), np.array([0.004, -0.006, 0.003, 2.0, 0.0, 0.0])
    first = head.frames(clip())
    again = [head.again(frame, head.textured.shape, shift) for frame in first]
    corrected = replace(head, textured=replace(head.textured, shift=shift))
    pivot = head.textured.shape.pivot
    for before, after, anew in zip(first, again, corrected.frames(clip()), strict=True):
        expected = shifted(before.pose, shift, pivot)
        assert np.degrees(after.pose.angle_to(expected)) < 1e-4
        np.testing.assert_allclose(after.pose.apply(pivot), expected.apply(pivot), atol=1e-9)
        assert np.degrees(after.pose.angle_to(anew.pose)) < 0.6
        off = after.pose.apply(pivot) - anew.pose.apply(pivot)
        assert np.abs(off[:2]).max() < 0.5
        assert np.abs(off[2]) < 2.0  # depth is what pictures say least of
        other = anew.face.fit.posture
        np.testing.assert_allclose(after.face.fit.posture, other, atol=0.2)


def test_a_frame_that_leads_astray_stays_where_it_was(monkeypatch):
    def astray(*_):
        raise np.linalg.LinAlgError

    head = placed()
    first = head.frames(clip())
    monkeypatch.setattr(landmark_calibration, "fit_frame", astray)
    assert [head.again(one, head.textured.shape, np.ones(6)) for one in first] == first


def test_colours_are_those_that_were_painted():
    classes = calibrated()[0].classes
    patch = np.array([LIPSTICK, 0.5 * LIPSTICK, [200, 150, 125]], float)[None]
    skin, lips, _, _ = classes.probabilities(patch)[:, 0]
    assert lips[0] > 0.8
    assert skin[0] < 0.1
    assert min(classes.separability.values()) > 0.9


def test_apertures_by_colours_follow_the_landmarks():
    """So that these colours count in full."""
    classes = calibrated()[0].classes
    assert classes.agreement > 0.6
    assert classes.weight > 0.6


def test_the_mouth_is_fitted_and_the_head_hardly_moved():
    found, *_ = calibrated()
    assert np.abs(found.shift[:3]).max() < 0.01
    assert np.abs(found.shift[3:5]).max() < 3.0
    assert np.abs(found.person / placed().model.person_deviation).max() < 4.0
    assert np.abs(found.person).max() > 0.05


def test_the_landmarks_of_the_person_are_less_off_than_anybodys():
    _, shape, _ = calibrated()
    before = [fit_frame(placed().textured.shape, seen, CAMERA).misfit for _, seen in clip()]
    sure = replace(shape, deviation=placed().textured.shape.deviation)
    after = [fit_frame(sure, seen, CAMERA).misfit for _, seen in clip()]
    assert np.mean(after) < 0.8 * np.mean(before)


def test_apertures_are_told_apart():
    found, *_ = calibrated()
    model = placed().model
    gaps = []
    for vector in found.expressions:
        points = model.held(found.person).vertices(vector[6:])[model.rings["points"]]
        gaps.append(points[14, 1] - points[18, 1])
    assert gaps[1] - gaps[0] > 5.0
    assert gaps[0] < gaps[2] < gaps[1]


def test_known_colours_are_kept():
    classes = calibrated()[0].classes
    again, *_ = calibrate_placed(placed(), clip()[:1], classes)
    assert again.classes.mixtures is classes.mixtures
    assert again.classes.separability is classes.separability


@pytest.mark.parametrize(
    ("told", "seen", "agreement"),
    [
        ([0, 4, 8, 16], [0, 4, 8, 16], 1.0),
        ([0, 4, 8, 16], [0, 2, 4, 8], 0.5),
        ([0, 4, 5, 6, 20], [0, 0, 0, 0, 22], 0.0),  # the widest alone is seen
        ([0, 4, 5, 6, 20], [0, 6, 8, 9, 30], 1.5),  # more than landmarks see
        ([0, 1, 2, 4, 20], [0, 0, 0, 0, 20], 1.06),  # two frames are too few
        ([5.0, 5.5, 5.0, 5.5], [1.0, 1.0, 1.5, 1.2], 0.2),  # open, and hardly moving
        ([0.1, 0.2, 0.1, 0.2], [0.0, 0.0, 0.5, 0.0], 1.0),  # closed: nothing to judge by
    ],
)
def test_how_colours_follow_landmarks(told, seen, agreement):
    found = following(np.array(told, float), np.array(seen, float))
    assert found == pytest.approx(agreement, abs=0.02)
