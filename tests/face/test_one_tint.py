"""Pictures in one strong tint are known, however its colours change with luminance."""

from __future__ import annotations

from functools import cache

import cv2
import numpy as np
import pytest
from altered_clips import WAYS
from drawn import drawn, network_sees

from abs_engine.face.appearance.colourless import chroma_spread, grey_below, in_colour
from abs_engine.face.appearance.one_tint import in_one_tint, untinted
from abs_engine.face.settings.colour import COLOURS
from abs_engine.tracking.detection import face_detection
from abs_engine.tracking.detection.face_detection import find_face
from abs_engine.tracking.detection.landmarks import LIPS, Landmarks, landmarks_again

PEOPLE = ("clara", "kofi", "ravi")
TINTS = ("night", "duotone", "blued", "darkroom", "amber")


@cache
def face(person: str):
    """A picture of somebody before a plain wall, no more of it than networks see, and landmarks."""
    image = drawn(person, jawOpen=0.15)
    image = np.where((image == image[0, 0]).all(axis=2)[..., None], [120, 140, 165], image)
    seen = network_sees(image.astype(np.uint8))
    low, high = seen.pixels.min(axis=0), seen.pixels.max(axis=0)
    margin = 0.25 * (high - low)
    first = np.maximum(np.rint(low - margin), 0).astype(int)
    last = np.rint(high + margin).astype(int)
    part = np.uint8(image[first[1] : last[1], first[0] : last[0]])
    return part, Landmarks(seen.points - [*first, 0], seen.presence)


def coded(image):
    """The picture as a JPEG, its chroma at half the resolution."""
    ok, data = cv2.imencode(".jpg", image[..., ::-1], [cv2.IMWRITE_JPEG_QUALITY, 85])
    assert ok
    return cv2.imdecode(data, cv2.IMREAD_COLOR)[..., ::-1]


@pytest.mark.parametrize("tint", TINTS)
@pytest.mark.parametrize("person", PEOPLE)
def test_pictures_in_one_tint_have_no_colour(person, tint):
    image, seen = face(person)
    tinted = coded(WAYS[tint].change(image))
    assert in_one_tint(tinted)
    grey = untinted(tinted)
    assert np.ptp(grey, axis=2).max() == 0
    np.testing.assert_array_equal(grey[..., 0], cv2.cvtColor(tinted, cv2.COLOR_RGB2GRAY))
    faces = [(tinted, seen.pixels)] * 3
    assert chroma_spread(*faces[0]) == 0
    assert not in_colour(faces)
    assert grey_below(faces) == 0


@pytest.mark.parametrize("light", [None, "blue", "dim", "flat", "bright"])
@pytest.mark.parametrize("person", PEOPLE)
def test_pictures_in_colour_stay_as_they_are(person, light):
    image, seen = face(person)
    lit = coded(image if light is None else WAYS[light].change(image))
    assert untinted(lit) is lit
    assert chroma_spread(lit, seen.pixels) > 0


@pytest.mark.parametrize("person", ["clara", "kofi", "mei", "amara"])
def test_lips_in_warm_light_have_colour(person):
    """Drawn skin has little texture, so the skin alone could be in one tint."""
    image, seen = face(person)
    warm = coded(WAYS["warm"].change(image))
    assert chroma_spread(warm, seen.pixels) > COLOURS.least_spread


def test_weak_tints_and_grey_pictures_stay_as_they_are():
    image, _ = face("clara")
    weak = np.round(WAYS["grey"].change(image) * [1.0, 0.97, 1.0]).astype(np.uint8)
    for altered in (WAYS["grey"].change(image), weak, image):
        assert untinted(altered) is altered


def test_the_detector_sees_a_tinted_picture_in_grey(monkeypatch):
    image, _ = face("clara")
    seen = []
    monkeypatch.setattr(face_detection, "_guesses", lambda small, least: seen.append(small) or [])
    for altered in (WAYS["night"].change(image), image):
        find_face(altered)
    tinted, own = (np.ptp(seen[k].astype(int), axis=2).max() for k in (0, -1))
    assert tinted == 0
    assert own > 20


def test_a_caption_in_another_colour_does_not_count():
    image, _ = face("clara")
    tinted = WAYS["night"].change(image)
    tinted[-len(tinted) // 24 :, :40] = (230, 40, 30)
    assert in_one_tint(tinted)
    tinted[-len(tinted) // 5 :] = (230, 40, 30)
    assert not in_one_tint(tinted)


@pytest.mark.parametrize("person", PEOPLE)
def test_the_network_sees_a_face_in_green_as_it_does_in_grey(person):
    image, seen = face(person)
    tinted = WAYS["night"].change(image)
    again, plain = (landmarks_again(one, seen) for one in (tinted, WAYS["grey"].change(image)))
    assert again is not None
    assert plain is not None
    off = np.linalg.norm(again.pixels - plain.pixels, axis=1)[LIPS]
    assert off.max() < 0.03 * seen.size
