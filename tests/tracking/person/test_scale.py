"""What a result's millimetres rest on."""

from __future__ import annotations

from dataclasses import asdict, replace

import numpy as np
import pytest
from drawn import lit, network_sees, speaker, vertices_of
from heads import seen_at

from abs_engine.core.camera import Camera
from abs_engine.core.errors import ParameterError
from abs_engine.io.assets import load_speaker
from abs_engine.tracking.detection.pupils import pupils_of
from abs_engine.tracking.person.scale import (
    PUPILS_SPREAD,
    USUAL_PUPILS,
    known_scale,
    proportion,
    pupil_distance,
    pupil_scale,
    pupil_vertices,
    scale_line,
)
from abs_engine.tracking.results.run_warnings import NO_EYES, stretched
from abs_engine.tracking.settings.doubts import DOUBTS


def test_a_pupil_distance_that_is_given_is_taken_as_it_is():
    found = pupil_scale(58.0)
    assert found.pupils == 58.0
    assert found.source == "pupil distance"
    assert 0 < found.uncertainty < 0.01
    assert found.held < pupil_scale(None).held


def test_the_usual_one_says_how_far_people_differ():
    found = pupil_scale(None)
    assert found.pupils == USUAL_PUPILS
    assert found.uncertainty == pytest.approx(PUPILS_SPREAD / USUAL_PUPILS)
    assert 0.05 < found.uncertainty < 0.07


@pytest.mark.parametrize("given", [None, 58.0])
def test_without_eyes_it_is_less_sure_and_the_pupils_stay(given):
    scale = pupil_scale(given)
    unseen = scale.without_eyes
    assert (unseen.source, unseen.pupils, unseen.held) == (scale.source, scale.pupils, scale.held)
    assert unseen.uncertainty > scale.uncertainty + 0.03
    assert NO_EYES.format(unseen.uncertainty).count(f"{unseen.uncertainty:.0%}") == 1


@pytest.mark.parametrize("given", [5.0, 29.9, 90.1, -60.0, 6.3, np.nan, np.inf])
def test_what_is_no_pupil_distance_is_refused(given):
    with pytest.raises(
        ParameterError, match="is not a plausible pupil distance; give millimetres"
    ) as told:
        pupil_scale(given)
    assert "\n" not in str(told.value)


@pytest.mark.parametrize("given", [30.0, 90.0])
def test_the_ends_are_taken(given):
    assert pupil_scale(given).pupils == given


def test_the_scale_is_said_in_a_line():
    usual = scale_line(asdict(pupil_scale(None)))
    assert usual == "scale: usual pupil distance, pupils 63.4 mm apart, ± 6%"
    given = scale_line(asdict(pupil_scale(61.0)))
    assert given == "scale: pupil distance, pupils 61.0 mm apart, ± 1%"
    known = scale_line(asdict(known_scale(62.25, person=True, poses=False)))
    assert known == "scale: known head, pupils 62.2 mm apart"


def test_a_head_that_is_not_fitted_has_its_own_scale():
    assert known_scale(60.0, person=True, poses=True).source == "known head"
    assert known_scale(60.0, person=False, poses=True).source == "given poses"
    average = known_scale(60.0, person=False, poses=False)
    assert average.source == "average head"
    assert average.pupils == 60.0
    assert average.uncertainty == pytest.approx(0.085, abs=1e-3)  # 3.4 and 3.8 mm of 60


def test_pupils_are_the_foremost_of_the_eyes():
    one = speaker()
    right, left = pupil_vertices(one)
    for own, side in ((right, -1), (left, 1)):
        middle = one.vertices[own].mean(axis=0)
        assert 25 < side * middle[0] < 35
        corners = np.split(one.vertices[one.landmarks["eye_corners"]], 2)[side > 0]
        assert abs(middle[1] - corners[:, 1].mean()) < 4


def test_a_head_without_eyes_has_the_corners_of_its_lids():
    one = speaker()
    names = tuple("sockets" if n == "eyes" else n for n in one.class_names)
    blind = replace(one, class_names=names)
    right, left = np.split(one.vertices[one.landmarks["eye_corners"]].astype(float), 2)
    apart = np.linalg.norm(right.mean(axis=0) - left.mean(axis=0))
    assert pupil_distance(blind, one.vertices) == pytest.approx(apart)


@pytest.mark.parametrize("person", ["amara", "mei", "walter"])
@pytest.mark.parametrize("yaw", [-0.3, 0.0, 0.3])
def test_the_network_sees_pupils_where_they_are_drawn(person, yaw):
    camera, pose = Camera.ideal((480, 480)), seen_at([0.05, yaw, 0], [0, 0, 700])
    image = lit(person, pose, camera)
    seen = pupils_of(image, network_sees(image))
    assert seen is not None
    vertices = vertices_of(person)
    drawn = np.stack([vertices[v].mean(axis=0) for v in pupil_vertices(speaker())])
    there = camera.project(pose.apply(drawn))
    pixel = camera.matrix[0, 0] / 700
    assert np.linalg.norm(seen - there, axis=1).max() < 4.0 * pixel
    apart = [np.linalg.norm(p[1] - p[0]) for p in (seen, there)]
    assert apart[0] == pytest.approx(apart[1], rel=0.05)


def test_eyes_that_are_shut_have_no_pupils():
    image = lit("mei", seen_at([0, 0, 0], [0, 0, 700]), Camera.ideal((480, 480)))
    landmarks = network_sees(image)
    shut = landmarks.points.copy()
    shut[[145, 374]] = shut[[159, 386]]
    assert pupils_of(image, replace(landmarks, points=shut)) is None


def test_a_stretched_face_is_warned_of_and_no_persons():
    own = load_speaker()
    head, usual = own.vertices.astype(np.float64), proportion(own.vertices, own)
    assert usual == pytest.approx(DOUBTS.face_proportion, abs=1e-4)
    assert stretched(proportion(head, own)) == ()  # a person's, whatever head is fitted to it
    for across, word in ((1.3, "wider"), (0.75, "narrower")):
        (line,) = stretched(proportion(head * [across, 1.0, 1.0], own))
        assert f"much {word} for its height" in line
    assert proportion(2.0 * head, own) == pytest.approx(usual)
    assert stretched(proportion(head, replace(own, points={}))) == ()  # a head without landmarks
