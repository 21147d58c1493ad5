"""Light that changes within a clip is followed by the skin of the cheeks."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import cv2
import numpy as np
import pytest
from drawn import drawn, lit, network_sees
from heads import seen_at
from runs import write_kind

from abs_engine.render.cpu import CpuRenderer
from abs_engine.tracking import loop
from abs_engine.tracking.detection.landmarks import OUTER_RING
from abs_engine.tracking.detection.light import SkinLight
from abs_engine.tracking.options import TrackOptions
from abs_engine.tracking.run import prepare
from abs_engine.tracking.settings.frames import FRAME_LOOP

POSTURES = ({}, {"jawOpen": 0.15}, {"jawOpen": 0.35})
OPEN = (0.0, 0.15, 0.3, 0.1, 0.35, 0.2)


@cache
def clip():
    """Pictures of somebody who talks, and the landmarks."""
    images = [drawn("clara", **units) for units in POSTURES]
    return [(image, network_sees(image)) for image in images]


def under(image, gains):
    """The picture under a light that shows red, green and blue so many times as bright."""
    return np.uint8(np.clip(image * np.asarray(gains, float), 0, 255))


def test_steady_light_leaves_every_frame_as_it_is():
    light = SkinLight.of(clip())
    for image, seen in clip():
        assert light.balanced(image, seen) is image
        assert light.balanced(under(image, [0.97, 0.98, 0.97]), seen).max() <= image.max()
        slight = under(image, [0.96, 0.96, 0.96])
        assert light.balanced(slight, seen) is slight


@pytest.mark.parametrize("gains", [(0.6, 0.6, 0.6), (0.5, 0.5, 0.5), (0.85, 1.0, 1.2)])
def test_changed_light_is_measured_and_undone(gains):
    light = SkinLight.of(clip())
    for image, seen in clip():
        other = under(image, gains)
        np.testing.assert_allclose(light.change(other, seen), np.log(gains), atol=0.05)
        mouth = seen.pixels[OUTER_RING].round().astype(int)
        inside = tuple(mouth.mean(axis=0).astype(int)[::-1])
        away = light.balanced(other, seen).astype(float) - image
        assert np.abs(away[inside]).max() < 12
        assert np.median(np.abs(away)) < 6


def test_a_flash_makes_a_face_too_bright_unless_it_is_always_white():
    light, white = SkinLight.of(clip()), [(under(image, [4, 4, 4]), seen) for image, seen in clip()]
    assert all(light.too_bright(*one) for one in white)
    assert not any(light.too_bright(*one) for one in clip())
    assert not any(SkinLight.of(white).too_bright(*one) for one in white)


def test_skin_keeps_its_hue_in_less_light_but_not_without_colour():
    light = SkinLight.of(clip())
    for image, seen in clip():
        grey = np.repeat(image.mean(axis=2, keepdims=True).astype(np.uint8), 3, axis=2)
        assert light.same_hue(under(image, [0.5] * 3), seen)
        assert not light.same_hue(grey, seen)
        assert not light.same_hue(under(image, [0.1] * 3), seen)  # less light than it can measure
        pale = np.uint8(0.4 * image + 0.6 * grey)
        assert not SkinLight.of([(pale, seen)]).same_hue(grey, seen)


def test_a_face_is_too_dark_where_the_film_fades_not_where_it_always_is():
    light = SkinLight.of(clip())
    for image, seen in clip():
        black = under(image, [0.03] * 3)
        assert light.too_dark(black, seen)
        assert not light.too_dark(under(image, [0.15] * 3), seen)
        assert not SkinLight.of([(black, seen)]).too_dark(black, seen)


def test_what_is_before_the_mouth_is_no_light():
    light = SkinLight.of(clip())
    image, seen = clip()[0]
    ring = seen.pixels[OUTER_RING]
    hidden = image.copy()
    middle = tuple(np.rint(ring.mean(axis=0)).astype(int).tolist())
    cv2.circle(hidden, middle, round(0.6 * np.ptp(ring[:, 0])), (20, 20, 20), -1)
    assert np.abs(light.change(hidden, seen)).max() < FRAME_LOOP.light_full


def test_cheeks_outside_of_the_picture_change_nothing():
    image, seen = clip()[0]
    beside = replace(seen, points=seen.points + np.array([10_000.0, 0, 0]))
    assert SkinLight.of(clip()).balanced(image, beside) is image
    assert SkinLight.of([(image, beside)]).balanced(image, seen) is image


@pytest.mark.usefixtures("soon_ready")
def test_a_film_whose_light_falls(tmp_path):
    """To a half, and redder: apertures stay those under steady light, as they would not else."""
    pictures = [
        lit("amara", seen_at([0, 0.02 * k - 0.08, 0], [0, 0, 500]), jawOpen=amount)
        for k, amount in enumerate(OPEN)
    ]
    video = write_kind(tmp_path / "film.mp4", "libx264", pictures)
    made = prepare(video, CpuRenderer(), TrackOptions(terms="colour"))
    darker = [under(one, (0.55, 0.45, 0.4)) for one in pictures]
    shift = made.setting.motion
    blind = replace(shift, motion=replace(shift.motion, light=None))
    steady, same, unfollowed = (
        np.array([one.aperture for _, one in loop.track(replace(made.setting, motion=m), film)])
        for m, film in ((shift, pictures), (shift, darker), (blind, darker))
    )
    assert np.sqrt(np.mean((same - steady) ** 2)) < 0.5  # mm
    away = np.nan_to_num(np.abs(unfollowed - steady), nan=np.inf)
    assert away.max() > 2 * np.abs(same - steady).max()
