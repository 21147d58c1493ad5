"""Painted dots followed through pictures that are drawn here, without a camera."""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np
import pytest

from abs_engine.capture import dot_tracking
from abs_engine.capture.dot_tracking import DotFollower
from abs_engine.capture.settings import CAPTURE

SKIN, INK, MOLE = (206, 160, 140), (40, 40, 90), (128, 98, 112)
GRID = np.array([[40.0 + 30 * i, 40.0 + 30 * j] for j in range(3) for i in range(4)])
FADING, FRAMES, RADIUS = 5, 14, 3.0


def painted(size: tuple[int, int], places: np.ndarray, radius: float) -> np.ndarray:
    """Dots of ink on skin, without noise."""
    out = np.full((*size[::-1], 3), SKIN, np.uint8)
    for place in places:
        centre = tuple(int(c) for c in np.rint(place * 16))
        cv2.circle(out, centre, int(radius * 16), INK, -1, cv2.LINE_AA, 4)
    noisy = out + np.random.default_rng(0).normal(0, 3, out.shape)
    return np.uint8(np.clip(noisy, 0, 255))


def picture(frame: int) -> np.ndarray:
    """All dots move to the right by a pixel a frame; one is gone after two, and a mole wanders."""
    large, scale = np.full((130 * 4, 200 * 4, 3), SKIN, np.uint8), 4
    for i, place in enumerate(dots(frame)):
        ink, at = INK, place
        if i == FADING and frame >= 2:
            ink, at = MOLE, place + np.array([0.0, 1.6 * (frame - 1)])
        centre = tuple(int(c) for c in np.rint((at + 0.5) * scale * 16))
        cv2.circle(large, centre, int(RADIUS * scale * 16), ink, -1, cv2.LINE_AA, 4)
    small = cv2.resize(large, None, fx=0.25, fy=0.25, interpolation=cv2.INTER_AREA)
    noise = np.random.default_rng(frame).normal(0, 9, small.shape)
    return np.uint8(np.clip(small + noise, 0, 255))


def dots(frame: int) -> np.ndarray:
    """Where the dots are, (12, 2) px."""
    return GRID + np.array([1.0 * frame, 0.0])


@pytest.fixture
def unsure(monkeypatch: pytest.MonkeyPatch) -> None:
    """A mole is as round as ink, but not as dark: it is taken for a dot that is uncertain."""
    monkeypatch.setattr(dot_tracking, "CAPTURE", replace(CAPTURE, least=0.3, sure=0.96))


def followed() -> np.ndarray:
    """How far each dot is found from where it is, (T, 12) px; NaN where it is lost."""
    follower = DotFollower(picture(0), dots(0))
    places = [follower.start.places]
    places += [follower.step(picture(t)).places for t in range(1, FRAMES)]
    return np.linalg.norm(np.array(places) - [dots(t) for t in range(FRAMES)], axis=2)


def test_dots_are_followed_to_a_fraction_of_a_pixel():
    away = np.delete(followed(), FADING, axis=1)
    assert np.nanmax(away) < 0.5
    assert np.isfinite(away).all()


@pytest.mark.usefixtures("unsure")
def test_what_wanders_away_from_where_the_neighbours_went_is_no_dot(monkeypatch):
    held = followed()[:, FADING]
    monkeypatch.setattr(dot_tracking, "CAPTURE", replace(dot_tracking.CAPTURE, stray=100.0))
    wandering = followed()[:, FADING]
    assert np.nanmax(wandering) > 3 * RADIUS
    assert np.isnan(held[-3:]).all()
    assert np.nanmax(held) < 2.5 * RADIUS


@pytest.mark.usefixtures("unsure")
def test_a_dot_that_a_person_says_is_hidden_misleads_no_neighbour():
    """Its place is unknown, and so says nothing of where an uncertain dot beside it went."""
    follower, hidden = DotFollower(picture(0), dots(0)), {FADING - 1: None}
    seen = [follower.step(picture(t), hidden) for t in range(1, FRAMES)]
    assert not seen[-1].found[FADING]
    assert not seen[-1].found[FADING - 1]


@pytest.mark.parametrize("radius", [6.0, 10.0, 14.0, 20.0])
def test_large_dots_are_followed_too(radius):
    """As beads of 4 mm in a close-up are; those of usual sizes are tried first."""
    places = np.array([[120.0 + 130 * i, 120.0 + 130 * j] for j in range(2) for i in range(3)])
    follower = DotFollower(painted((500, 370), places, radius), places + 1.5)
    assert follower.model.radius == pytest.approx(radius, abs=0.5)
    seen = [follower.start, follower.step(painted((500, 370), places + 4, radius))]
    for moved, sighting in zip((0, 4), seen, strict=True):
        assert sighting.places == pytest.approx(places + moved, abs=0.2)
        assert sighting.scores.min() > 0.9


def test_overlapping_dots_keep_the_places_at_which_a_person_points():
    """Two whose discs meet make one peak between or beside them: the other stays where it is."""
    places = np.array([[100.0, 60], [40, 60], [100, 120], [40, 120], [104, 124.0]])
    start = DotFollower(painted((160, 180), places, 4.0), places).start
    apart = np.linalg.norm(start.places[2] - start.places[4])
    assert apart > 3
    assert np.linalg.norm(start.places - places, axis=1).max() < 3
