"""A face without colour is known from its frames."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import cv2
import numpy as np
import pytest
from drawn import drawn, network_sees
from test_colours_by_head import painted, places

from abs_engine.face.appearance import colourless
from abs_engine.face.appearance.colour import ColourClasses
from abs_engine.face.appearance.colourless import chroma_spread, grey_below, in_colour, is_grey
from abs_engine.face.appearance.colours_by_head import learn_placed
from abs_engine.face.settings.colour import COLOURS
from abs_engine.tracking.results.run_warnings import NO_COLOUR, doubts

LUMA = np.array([0.299, 0.587, 0.114])
SEPIA = np.array([1.12, 1.0, 0.78])


@cache
def face():
    """A picture of somebody, and the outline of the face."""
    image = drawn("clara", jawOpen=0.15)
    return image, network_sees(image).pixels


def toned(image, tint=(1.0, 1.0, 1.0), noise=0.0, colour=0.0):
    """The picture with so much of its colour, in a tint, and with grain of each channel."""
    grey = (image @ LUMA)[..., None] * np.ones(3)
    grain = np.random.default_rng(0).normal(0, noise, image.shape) if noise else 0.0
    mixed = colour * image + (1 - colour) * grey * np.array(tint) + grain
    return np.uint8(np.clip(np.rint(mixed), 0, 255))


def coded(image):
    """The picture as a JPEG of low quality, its chroma at half the resolution."""
    ok, data = cv2.imencode(".jpg", image[..., ::-1], [cv2.IMWRITE_JPEG_QUALITY, 40])
    assert ok
    return cv2.imdecode(data, cv2.IMREAD_COLOR)[..., ::-1]


@pytest.mark.parametrize("tint", [(1.0, 1.0, 1.0), SEPIA, (0.9, 0.9, 1.2)])
@pytest.mark.parametrize("noise", [0.0, 4.0])
def test_grey_and_tinted_pictures_have_no_colour(tint, noise):
    image, outline = face()
    grey = coded(toned(image, tint, noise))
    assert chroma_spread(grey, outline) < COLOURS.least_spread
    assert not in_colour([(grey, outline)] * 3)


def test_frames_that_lose_their_colour_are_known_in_a_clip_that_has_some():
    image, outline = face()
    grey = toned(image, noise=2.0)
    for coloured in (3, 5, 10):
        below = grey_below([(image, outline)] * coloured + [(grey, outline)] * (10 - coloured))
        assert is_grey(grey, outline, below)
        assert not is_grey(image, outline, below)
        assert not is_grey(toned(image, colour=0.7), outline, below)
        assert not is_grey(image, outline + 5000.0, below)  # what is not seen is not said to be


def test_no_frame_is_grey_in_a_clip_without_colour():
    image, outline = face()
    grey = toned(image)
    assert grey_below([(grey, outline)] * 4) == 0.0
    assert grey_below([(grey, outline)] * 4 + [(image, outline)]) == 0.0
    assert grey_below([]) == 0.0
    assert not is_grey(grey, outline, 0.0)


def test_people_are_in_colour():
    for name in ("clara", "kofi", "mei"):
        image = drawn(name, jawOpen=0.15)
        outline = network_sees(image).pixels
        assert chroma_spread(coded(image), outline) > COLOURS.least_spread
        assert in_colour([(image, outline)])


@pytest.mark.parametrize(("name", "light"), [("clara", 0.35), ("kofi", 0.6), ("ravi", 0.45)])
def test_a_face_in_poor_light_is_in_colour_too(name, light, monkeypatch):
    image = drawn(name, jawOpen=0.15)
    outline = network_sees(image).pixels
    dim = np.uint8(light * image)
    assert in_colour([(dim, outline)])
    with monkeypatch.context() as as_it_is:
        as_it_is.setattr(colourless, "COLOURS", replace(COLOURS, light_face=1.0))
        assert not in_colour([(dim, outline)])
    assert not in_colour([(coded(toned(dim, SEPIA, noise=2.0)), outline)])


def test_most_frames_decide():
    image, outline = face()
    grey = toned(image)
    assert in_colour([(image, outline), (image, outline), (grey, outline)])
    assert not in_colour([(image, outline), (grey, outline), (grey, outline)])


def test_a_face_beside_the_picture_says_nothing():
    image, outline = face()
    assert chroma_spread(image, outline + 1e4) is None
    assert in_colour([(image, outline + 1e4)])


def test_classes_keep_whether_the_clip_was_in_colour(tmp_path):
    made = learn_placed([painted(seed=k) for k in range(3)], [places()] * 3, chromatic=True)
    assert made.chromatic
    replace(made, chromatic=False).save(tmp_path / "colours.npz")
    assert not ColourClasses.load(tmp_path / "colours.npz").chromatic


def test_a_video_without_colour_is_warned_of():
    told = doubts(np.zeros(20, bool), [False] * 20, {"upper_lip": 0.6}, chromatic=False)
    assert told[0] == NO_COLOUR
    assert NO_COLOUR not in doubts(np.zeros(20, bool), [False] * 20, {"upper_lip": 0.6})
