"""Frames in which something hides the mouth are left out before its colours are known."""

from __future__ import annotations

from functools import cache

import cv2
import numpy as np
import pytest
from drawn import drawn, network_sees

from abs_engine.face.appearance.colourless import grey_below
from abs_engine.tracking.detection.landmarks import OUTER_RING, Landmarks
from abs_engine.tracking.person.frame_choice import alike, mouth_colours, to_learn_from

POSTURES = ({}, {"jawOpen": 0.15}, {"jawOpen": 0.4}, {"mouthPucker": 0.6}, {"jawOpen": 0.25})


@cache
def clip(person):
    """Pictures of somebody who talks, and the landmarks."""
    images = [drawn(person, **units) for units in POSTURES]
    return [(image, network_sees(image)) for image in images]


def behind(shown, colour):
    """A picture with a disc over the mouth, and the landmarks of before."""
    image, seen = shown
    ring, out = seen.pixels[OUTER_RING], image.copy()
    centre = tuple(np.rint(ring.mean(axis=0)).astype(int).tolist())
    cv2.circle(out, centre, round(0.8 * np.ptp(ring[:, 0])), colour, -1)
    return out, seen


def numbers(kept, seen):
    """Places of frames in a list."""
    return [next(k for k, one in enumerate(seen) if one is frame) for frame in kept]


@pytest.mark.parametrize("person", ["clara", "kofi"])
@pytest.mark.parametrize("colour", [(32, 32, 36), (110, 160, 205)])
def test_a_mouth_behind_a_mask_or_a_microphone_is_not_learned_from(person, colour):
    shown = clip(person)
    assert alike(shown) == shown
    seen = [behind(shown[0], colour), *shown, behind(shown[1], colour), behind(shown[4], colour)]
    assert numbers(alike(seen), seen) == [1, 2, 3, 4, 5]


def test_the_light_of_a_frame_does_not_matter():
    dim = [(np.uint8(0.6 * image), seen) for image, seen in clip("clara")]
    seen = [*clip("clara"), *dim[:2]]
    assert len(alike(seen)) == 7
    np.testing.assert_allclose(mouth_colours(*dim[0]), mouth_colours(*seen[0]), atol=0.1)


def test_too_few_that_are_alike_are_all_kept():
    shown = clip("clara")
    seen = [shown[0], shown[1], behind(shown[2], (32, 32, 36))]
    assert alike(seen) == seen
    assert alike([]) == []


def test_a_frame_whose_mouth_is_not_in_the_picture_is_kept():
    image, marks = clip("clara")[0]
    away = image, Landmarks(marks.points + np.array([1000.0, 0, 0]), 1.0)
    assert mouth_colours(*away) is None
    seen = [*clip("clara"), away]
    assert alike(seen) == seen
    assert alike([away]) == [away]


def test_frames_with_colour_are_not_left_out_for_being_few():
    """Lips are learned from these alone, so they count even where most others are grey."""
    painted = []
    for image, marks in clip("clara"):
        red, lips = image.copy(), np.zeros(image.shape[:2], np.uint8)
        cv2.fillPoly(lips, [np.rint(marks.pixels[OUTER_RING]).astype(np.int32)], 1)
        red[lips > 0] = 0.5 * red[lips > 0] + [90, 0, 10]
        painted.append((red, marks))
    grey = [
        (np.repeat(i.mean(axis=2, keepdims=True).astype(np.uint8), 3, 2), m) for i, m in painted
    ]
    seen = [*grey, *grey, *painted]
    below = grey_below([(image, marks.pixels) for image, marks in seen])
    assert below > 0
    assert len(alike(seen)) == 10
    kept, found = to_learn_from(seen)
    assert (kept, found) == (seen, below)
    assert to_learn_from(grey) == (grey, 0.0)


def test_many_small_steps_are_one_group(monkeypatch):
    """What the mouth does changes it little by little, however far in all."""
    far = {id(shown[0]): float(k) for k, shown in enumerate(clip("clara"))}

    def stepped(image, _seen):
        return np.full(6, 0.15 * far[id(image)])  # 0.37 from one to the next

    monkeypatch.setattr("abs_engine.tracking.person.frame_choice.mouth_colours", stepped)
    assert alike(clip("clara")) == clip("clara")
    far[id(clip("clara")[4][0])] = 9.0
    assert alike(clip("clara")) == clip("clara")[:4]
