"""A face that is burnt out, or too dark, is known from its frames, and said."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from drawn import drawn, network_sees
from test_colours_by_head import painted, places

from abs_engine.face.appearance.colour import ColourClasses
from abs_engine.face.appearance.colours_by_head import learn_placed
from abs_engine.face.appearance.exposure import USUAL, Exposure, colourless
from abs_engine.tracking.results.run_warnings import (
    BURNT_OUT,
    EXCHANGED,
    NO_COLOUR,
    TOO_DARK,
    doubts,
)

BURNT, DARK = Exposure(0.6, 240.0), Exposure(0.0, 20.0)
NONE = (np.zeros(20, bool), np.zeros(20, bool), {"upper_lip": 0.9})


def seen(name, gain, offset=0.0):
    image = drawn(name, jawOpen=0.15)
    outline = network_sees(image).pixels
    return np.uint8(np.clip(np.rint(gain * image + offset), 0, 255)), outline


@pytest.mark.parametrize("name", ["clara", "kofi", "mei"])
def test_a_face_as_it_is_is_neither_burnt_out_nor_dark(name):
    found = Exposure.of([seen(name, 1.0)])
    assert not found.burnt
    assert not found.dark


def test_a_brightened_face_is_burnt_out_and_a_dimmed_one_dark():
    assert Exposure.of([seen("clara", 3.0, 60)]).burnt
    assert Exposure.of([seen("clara", 0.1)]).dark


def test_red_alone_at_its_limit_is_light_skin():
    image, outline = seen("clara", 1.0)
    image[..., 0] = 255
    assert not Exposure.of([(image, outline)]).burnt


def test_most_frames_decide_and_a_face_beside_the_picture_says_nothing():
    usual, burnt = seen("clara", 1.0), seen("clara", 3.0, 60)
    assert not Exposure.of([usual, usual, burnt]).burnt
    assert Exposure.of([usual, burnt, burnt]).burnt
    image, outline = usual
    assert Exposure.of([(image, outline + 1e4)]) == USUAL


def test_classes_keep_the_exposure(tmp_path):
    made = learn_placed([painted(seed=k) for k in range(3)], [places()] * 3, chromatic=True)
    replace(made, exposure=BURNT).save(tmp_path / "colours.npz")
    assert ColourClasses.load(tmp_path / "colours.npz").exposure == BURNT


def test_older_classes_have_the_usual_exposure(tmp_path):
    made = learn_placed([painted(seed=k) for k in range(3)], [places()] * 3, chromatic=True)
    arrays = {k: v for k, v in made.arrays().items() if k not in ("saturated", "luminance")}
    assert ColourClasses.of_arrays({k: np.asarray(v) for k, v in arrays.items()}).exposure == USUAL


@pytest.mark.parametrize(
    "worse",
    [
        {"exposure": BURNT},
        {"chromatic": False},
        {"separability": {"upper_lip": 0.49, "lower_lip": 0.61}},
    ],
)
def test_what_makes_colours_poor(worse):
    made = learn_placed([painted(seed=k) for k in range(3)], [places()] * 3, chromatic=True)
    assert not made.poor
    assert not replace(made, separability={"upper_lip": 0.49, "lower_lip": 0.8}).poor
    assert replace(made, **worse).poor


def test_a_burnt_out_face_is_warned_of_by_name():
    assert doubts(*NONE) == []
    assert doubts(*NONE, exposure=BURNT) == [BURNT_OUT.format(0.6)]


def test_pictures_with_red_and_blue_exchanged_are_warned_of():
    red, blue = (
        learn_placed([painted(seed=k)[..., ::way] for k in range(3)], [places()] * 3, True)
        for way in (1, -1)
    )
    assert (red.blue, blue.blue) == (False, True)
    assert doubts(*NONE, blue=True) == [EXCHANGED]
    assert EXCHANGED not in doubts(*NONE, blue=True, chromatic=False)


def test_a_dark_face_is_not_called_a_video_without_colour():
    assert doubts(*NONE, chromatic=False, exposure=DARK) == [TOO_DARK]
    assert doubts(*NONE, chromatic=False) == [NO_COLOUR]
    assert "too dark" in colourless(Path("a.mp4"), DARK)
    assert colourless(Path("a.mp4"), USUAL) == "a.mp4 has no colour"
