"""Of several calibrations the one is kept that makes the pictures' colours most probable."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from runs import toy_model, toy_setting

from abs_engine.core.camera import Window
from abs_engine.core.geometry import FACING, Pose
from abs_engine.core.pose import PoseFrame
from abs_engine.face.appearance.colour import ColourClasses
from abs_engine.face.appearance.colour_features import CLASSES, features
from abs_engine.face.appearance.mixture import Mixture
from abs_engine.tracking.detection.mouth_search import CalibrationFrame
from abs_engine.tracking.person.calibration_views import Stand
from abs_engine.tracking.person.identity_fit import Calibration
from abs_engine.tracking.person.multistart import log_evidence

SETTING = toy_setting()
MODEL, CAMERA, RENDERER = toy_model(), SETTING.camera, SETTING.renderer
POSE = Pose(FACING, [0.0, 30.0, 450.0])
PAINT = {"skin": (190, 140, 110), "lips": (160, 90, 85), "teeth": (200, 180, 160)}
PAINT["dark"] = (40, 20, 18)
REFERENCE = 150.0
NOBODY = np.zeros(MODEL.n_person)


def colour(*names):
    """A class with a component for each of these paints."""
    paints = np.array([PAINT[n] for n in names], np.float64)
    means = features(paints, REFERENCE)
    spread = np.tile(np.diag([1e-4, 1e-4, 1e-3]), (len(names), 1, 1))
    return Mixture(np.full(len(names), 1 / len(names)), means, spread)


def classes(**other):
    """The painted colours, some classes learned otherwise."""
    mixtures = {name: colour(*other.get(name, (name,))) for name in CLASSES}
    return ColourClasses(mixtures, np.array([1.0, 1.0, 0.5, 0.5]), REFERENCE)


@pytest.fixture(scope="module")
def frames():
    """A mouth that is open, painted with even colours and a little noise."""
    size = Window(0.0, 0.0, *map(float, CAMERA.size), 1.0)
    base = PoseFrame(POSE, MODEL.pivot)
    posture = np.r_[np.zeros(6), MODEL.prototypes[4]]
    drawn = RENDERER.draw(SETTING.face.scene, base.candidates(posture[None]), CAMERA, size)[0]
    picture = np.full((*drawn.class_id.shape, 3), PAINT["skin"], np.float64)
    for k, name in enumerate(MODEL.colour_classes):
        if name is not None:
            picture[drawn.class_id == k] = PAINT[name]
    picture += np.random.default_rng(0).normal(0, 3, picture.shape)
    return [CalibrationFrame(np.clip(picture, 0, 255).astype(np.uint8), POSE)]


def calibration(prototype, known, down=0.0):
    """The mouth in a posture, `down` mm below where it is, with these colours."""
    shift = np.array([0.0, 0.0, 0.0, 0.0, down, 0.0])
    posture = np.r_[np.zeros(6), MODEL.prototypes[prototype]][None]
    return Calibration(NOBODY, shift, known, posture)


def evidence(frames, *calibrations):
    stand = Stand(MODEL, frames, CAMERA, RENDERER, np.zeros(6), NOBODY)
    return log_evidence(stand, calibrations)


def test_the_right_posture_is_more_probable_than_others(frames):
    values = evidence(frames, *(calibration(k, classes()) for k in (4, 0, 2)))
    assert values.argmax() == 0


def test_classes_that_hold_several_colours_do_not_pay(frames):
    """Closed lips, and skin that was learned from the open mouth as well."""
    closed = calibration(0, classes(skin=("skin", "lips", "teeth", "dark")))
    right = calibration(4, classes())
    assert evidence(frames, right, closed).argmax() == 0


def test_a_mouth_on_the_chin_does_not_win_by_leaving_the_mouth_out(frames):
    """It explains its own window by its own colours, but not the pixels of the other."""
    chin = calibration(0, classes(lips=("skin",)), down=45.0)
    right = calibration(4, classes())
    assert evidence(frames, right, chin).argmax() == 0


def test_the_order_of_candidates_does_not_matter(frames):
    both = calibration(4, classes()), calibration(0, classes(), down=20.0)
    np.testing.assert_allclose(
        evidence(frames, *both), evidence(frames, *both[::-1])[::-1], rtol=0.01
    )


def test_a_share_of_strange_colours_costs_all_alike(frames):
    """Half of the picture in a colour of no class: the right posture still wins."""
    image = frames[0].image.copy()
    image[:, : image.shape[1] // 2] = (30, 60, 200)
    there = [replace(frames[0], image=image)]
    values = evidence(there, calibration(4, classes()), calibration(0, classes()))
    assert np.isfinite(values).all()
    assert values.argmax() == 0
