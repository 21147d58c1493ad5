"""A mouth that is seen is told from one behind a hand or a microphone."""

from __future__ import annotations

from functools import cache
from types import SimpleNamespace

import cv2
import numpy as np
import pytest
from drawn import drawn, network_sees

from abs_engine.core.camera import Window
from abs_engine.face.appearance.chroma import sampled
from abs_engine.face.appearance.colours_by_head import learn_placed
from abs_engine.tracking.detection.landmarks import INNER_RING, OUTER_RING, Landmarks
from abs_engine.tracking.detection.light import SkinLight
from abs_engine.tracking.frame.blob_visibility import BRIGHT, COVERED, DARK
from abs_engine.tracking.frame.frame_state import HeadFrame, SeenFace
from abs_engine.tracking.frame.landmark_calibration import PosedFrame
from abs_engine.tracking.frame.mouth_visibility import ByLook, MouthLook
from abs_engine.tracking.frame.placed_mouths import PlacedFrame
from abs_engine.tracking.start import person_fit
from abs_engine.tracking.start.person_fit import FittedPerson

PERSON = "clara"
POSTURES = ({}, {"jawOpen": 0.15}, {"jawOpen": 0.35}, {"mouthPucker": 0.6, "jawOpen": 0.1})


@cache
def clip():
    """Pictures of somebody who talks, and the landmarks."""
    images = [drawn(PERSON, **units) for units in POSTURES]
    return [(image, network_sees(image)) for image in images]


def disc(image, seen, colour, times):
    """The picture with a disc over the mouth, `times` as wide as it."""
    ring = seen.pixels[OUTER_RING]
    centre, wide = ring.mean(axis=0), 0.5 * times * np.ptp(ring[:, 0])
    out = image.copy()
    cv2.circle(out, tuple(np.rint(centre).astype(int).tolist()), round(wide), colour, -1)
    return out


@cache
def colours():
    """Classes by what lies within the landmarks' rings."""
    patches, places = [], []
    for image, seen in clip():
        ring = seen.pixels[OUTER_RING]
        low, high = ring.min(axis=0) - 12, ring.max(axis=0) + 12
        window = Window(*low.round().tolist(), *(high - low).round().tolist(), 2.0)
        width, height = window.drawn
        masks = []
        for points in (ring, seen.pixels[INNER_RING]):
            mask = np.zeros((height, width), np.uint8)
            cv2.fillPoly(mask, [np.rint(window.to_drawn(points)).astype(np.int32)], 1)
            masks.append(mask > 0)
        below = np.arange(height)[:, None] > window.to_drawn(ring.mean(axis=0))[1]
        lips = masks[0] & ~masks[1]
        planes = [~masks[0], lips & ~below, lips & below, masks[1] & masks[0]]
        places.append(0.95 * np.stack(planes))
        patches.append(sampled(window, image))
    return learn_placed(patches, places, chromatic=True)


def look(image, seen):
    return MouthLook.of(colours(), image, seen)


@cache
def usual():
    return MouthLook.usual([look(image, seen) for image, seen in clip()])


def test_a_mouth_that_talks_is_seen_in_every_posture():
    for image, seen in clip():
        now = look(image, seen)
        assert 0 <= now.inside <= 1
        assert 0 <= now.around <= 1
        assert not usual().hidden(now)
    assert usual().inside > 0.5
    assert usual().around > 0.6


def test_a_hand_of_the_skins_colour_hides_it():
    image, seen = clip()[1]
    skin = image[tuple(np.rint(seen.pixels[50]).astype(int)[::-1])].tolist()  # of the cheek
    now = look(disc(image, seen, skin, 1.4), seen)
    assert now.inside < 0.45 * usual().inside
    assert usual().hidden(now)


@pytest.mark.parametrize("colour", [(20, 20, 22), (20, 60, 190)])
def test_a_microphone_hides_it(colour):
    image, seen = clip()[1]
    now = look(disc(image, seen, colour, 2.0), seen)
    assert now.around < 0.5 * usual().around
    assert usual().hidden(now)


def test_a_mouth_outside_of_the_picture_has_no_look():
    image, seen = clip()[0]
    assert look(image, Landmarks(seen.points + np.array([1000.0, 0, 0]), 1.0)) is None
    ring = seen.pixels[OUTER_RING]
    cut = image[: int(ring[:, 1].mean()) - 8]  # less than half of it is left
    assert look(cut, seen) is None
    through_the_lower_lip = image[: int(ring[:, 1].max()) - 2]
    assert look(through_the_lower_lip, seen) is None
    most = image[: int(ring[:, 1].max()) - 1]
    assert look(most, seen) is not None


def test_colours_do_not_hide_a_mouth_in_a_frame_without_any():
    image, seen = clip()[1]
    grey = np.repeat(image.mean(axis=2, keepdims=True).astype(np.uint8), 3, axis=2)
    look_of, face = ByLook(colours(), usual()), SeenFace(seen, None)
    assert look_of.hidden(HeadFrame(grey, None, face), None) == COVERED
    assert look_of.hidden(HeadFrame(grey, None, face, bright=True), None) == BRIGHT
    assert look_of.hidden(HeadFrame(grey, None, face, grey=True), None) == ""


def test_a_face_that_is_too_dark_shows_no_mouth():
    image, seen = clip()[1]
    frame = HeadFrame(image, None, SeenFace(seen, None), dark=True)
    assert ByLook(colours(), usual()).hidden(frame, None) == DARK
    assert ByLook(colours(), None).hidden(frame, None) == DARK


def test_a_tiny_mouth_has_a_look():
    image, seen = clip()[1]
    small = cv2.resize(image, None, fx=0.2, fy=0.2, interpolation=cv2.INTER_AREA)
    points = np.column_stack([0.2 * (seen.pixels + 0.5) - 0.5, 0.2 * seen.points[:, 2]])
    now = look(small, Landmarks(points, 1.0))
    assert np.isfinite([now.inside, now.around]).all()


def test_a_mouth_without_lips_is_hidden():
    """What covers a mouth of dark or teeth may have their colour, not the lips' too."""
    image, seen = clip()[2]
    ring = seen.pixels[OUTER_RING]
    covered = image.copy()
    cv2.fillPoly(covered, [np.rint(ring).astype(np.int32)], (30, 15, 14))
    now = look(covered, seen)
    assert now.inside > 0.45 * usual().inside
    assert now.around > 0.45 * usual().around
    assert now.lips < 0.2 * usual().lips
    assert usual().hidden(now)


def test_what_is_usual_is_the_lower_quartile():
    looks = [MouthLook(0.2, 0.9, 0.4), None, MouthLook(0.6, 0.7, 0.1), MouthLook(0.5, 0.6, 0.3)]
    found = MouthLook.usual(looks)
    assert (found.inside, found.around, found.lips) == pytest.approx((0.35, 0.65, 0.2))
    assert MouthLook.usual([None, None]) is None
    assert MouthLook.usual([]) is None
    assert not found.hidden(MouthLook(0.20, 0.65, 0.05))
    assert found.hidden(MouthLook(0.18, 0.65, 0.05))
    assert found.hidden(MouthLook(0.35, 0.34, 0.05))
    assert found.hidden(MouthLook(0.35, 0.65, 0.03))


@pytest.mark.parametrize("many", [1, 3, 4])
def test_what_hides_the_mouth_in_almost_half_of_the_frames_is_not_usual(many):
    hand, mouth = MouthLook(0.42, 0.56, 0.41), MouthLook(0.94, 0.73, 0.69)
    found = MouthLook.usual([hand] * many + [mouth] * (9 - many))
    assert (found.inside, found.around, found.lips) == pytest.approx((0.94, 0.73, 0.69))
    assert found.hidden(hand)
    assert not found.hidden(mouth)


def test_a_hand_with_as_much_skin_around_as_a_mouth_is_not_usual():
    hand, mouth = MouthLook(0.17, 0.853, 0.05), MouthLook(0.89, 0.857, 0.5)
    found = MouthLook.usual([hand] * 3 + [mouth] * 5)
    assert (found.inside, found.around, found.lips) == pytest.approx((0.89, 0.857, 0.5))
    assert found.hidden(hand)
    assert not found.hidden(mouth)


def test_a_hand_nearly_as_red_as_lips_hides_them():
    """It looks a little too much like skin within, and a little too much like lips around."""
    found = MouthLook(0.91, 0.93, 0.7)
    assert found.hidden(MouthLook(0.62, 0.60, 0.6))
    assert not found.hidden(MouthLook(0.62, 0.93, 0.6))
    assert not found.hidden(MouthLook(0.91, 0.60, 0.6))


def test_lips_of_the_skins_colour_are_not_covered_where_they_meet():
    """Without colour they look like a mouth where they part, less where they meet."""
    parted, closed = MouthLook(0.62, 0.93, 0.35), MouthLook(0.26, 0.95, 0.17)
    assert not MouthLook.usual([parted] * 5 + [closed] * 3).hidden(closed)
    assert MouthLook.usual([parted] * 8).hidden(closed)


def test_frames_with_a_hidden_mouth_are_not_learned_from(monkeypatch):
    """Of a person who is fitted to all frames first, those are left out that show no mouth."""
    (image, marks), microphone = clip()[0], (40, 40, 44)
    behind, asked = (disc(image, marks, microphone, 1.6), marks), []

    def fitted(_average, chosen, turned, *_more):
        asked.append((chosen, turned))
        usual = MouthLook.usual([look(*frame) for frame in clip()])
        nothing = [None] * 5
        return FittedPerson(*nothing, colours(), SkinLight.of(clip()), usual)

    monkeypatch.setattr(person_fit, "_fitted", fitted)
    monkeypatch.setattr(FittedPerson, "place", SimpleNamespace(whole=lambda _seen: True))
    chosen, turned = [*clip(), behind], [behind, *clip()[1:]]
    person_fit.fit_person(None, chosen, None, None, None, print, turned)
    assert [[id(f[0]) for f in frames] for frames in asked[1]] == [
        [id(f[0]) for f in clip()],
        [id(f[0]) for f in clip()[1:]],
    ]
    person_fit.fit_person(None, clip(), None, None, None, print)
    assert len(asked) == 3  # nothing is hidden: once


def test_shading_is_learned_from_frames_that_show_the_mouth_in_colour(monkeypatch):
    pictures = [np.full((2, 2, 3), k, np.uint8) for k in range(3)]
    seen = SimpleNamespace(landmarks=None)
    frames = [PlacedFrame(image, seen, grey=k == 1) for k, image in enumerate(pictures)]
    monkeypatch.setattr(FittedPerson, "shows", lambda _fitted, image, _marks: image[0, 0, 0] != 2)
    fitted = FittedPerson(*[None] * 5, colours(), SkinLight.of(clip()), usual())
    posed = fitted.posed_by(PosedFrame(frame, None, np.zeros(8)) for frame in frames).posed
    assert [id(image) for image, *_ in posed] == [id(pictures[0])]


def test_frames_are_chosen_anew_among_all_where_some_hide_the_mouth(monkeypatch):
    """What is learned with many hidden ones may hide most others, so it is done twice more."""
    (image, marks), microphone = clip()[0], (40, 40, 44)
    behind = (disc(image, marks, microphone, 1.6), marks)
    seen, asked = [*clip() * 3, *[behind] * 6], []

    def fitted(_average, chosen, turned, *_more):
        asked.append((chosen, turned))
        return FittedPerson(*[None] * 5, colours(), SkinLight.of(clip()), usual())

    def shows(_fitted, shown, _seen):
        return shown is not behind[0] and (len(asked) > 1 or shown is not image)

    monkeypatch.setattr(person_fit, "_fitted", fitted)
    monkeypatch.setattr(FittedPerson, "shows", shows)
    chosen = [behind] * 6 + list(clip()[:2])
    person_fit.fit_person(None, chosen, None, None, None, print, chosen, others=seen)
    assert len(asked) == 2
    for frames in asked[1]:
        assert len(frames) == 8
        assert {id(f[0]) for f in frames} == {id(f[0]) for f in clip()[1:]}
