"""The person who is expected: of the bundled head, people's average, and how the network errs."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from threading import Barrier
from types import SimpleNamespace

import numpy as np
import pytest

from abs_engine.face.shape.population import average_person
from abs_engine.io.assets import load_speaker
from abs_engine.tracking.landmark.landmark_correspondence import load_correspondence
from abs_engine.tracking.landmark.landmark_noise import LAYOUT
from abs_engine.tracking.models import heads
from abs_engine.tracking.options import TrackOptions
from abs_engine.tracking.person.expected_person import anybody, people_noise, save_noise


def test_of_the_bundled_head_it_is_people():
    speaker = load_speaker()
    known = load_correspondence(speaker)
    person, expected = anybody(speaker, known)
    assert person is average_person()
    assert expected.noise is people_noise()
    assert expected.corners is known.corners


def test_another_head_is_expected_as_it_is():
    speaker = replace(load_speaker(), vertices=1.1 * load_speaker().vertices)
    known = load_correspondence(load_speaker())
    assert anybody(speaker, known) == (speaker, known)


def test_the_network_errs_less_alike_on_people_than_on_an_artists_heads():
    """Its depths above all: it was trained on people."""
    artists = load_correspondence(load_speaker()).noise

    def nod(noise):
        """Slope of the depth's error down the face, as a head that nods has it."""
        height = load_correspondence(load_speaker()).of(load_speaker().vertices)[:, 1]
        return abs(np.polyfit(height, noise.bias[:, 2], 1)[0])

    assert nod(people_noise()) < 0.8 * nod(artists)


def test_a_noise_is_read_as_it_was_saved(tmp_path, monkeypatch):
    (tmp_path / "population").mkdir()
    save_noise(tmp_path / "population" / "landmark_noise.npz", people_noise())
    where = "abs_engine.tracking.person.expected_person.shipped"
    monkeypatch.setattr(where, lambda name: tmp_path / name)
    again = people_noise.__wrapped__.__wrapped__()
    for name in LAYOUT:
        own = name.removeprefix("noise_")
        np.testing.assert_array_equal(getattr(again, own), getattr(people_noise(), own))


class Stopped(Exception):
    """Nothing more is needed."""


@pytest.mark.parametrize("person", [None, "clara"])
def test_a_clip_begins_with_whom_it_is_expected_to_show(person, monkeypatch):
    """The expected person where nobody is named, and otherwise the one that is."""
    begun = []

    def stop(*_):
        raise Stopped

    monkeypatch.setattr(heads.AverageHead, "of", lambda *given, **_: begun.append(given))
    monkeypatch.setattr(heads, "candidate_frames", stop)
    monkeypatch.setattr(heads, "_numbered", lambda *_: ())
    speaker, clip = load_speaker(), SimpleNamespace(video="a.mp4")
    options, known = TrackOptions(person=person), load_correspondence(load_speaker())
    with pytest.raises(Stopped):
        heads.by_landmarks(clip, speaker, known, None, options, None, lambda _: None)
    ((head, expected, *_),) = begun
    assert (head is average_person()) == (person is None)
    assert (expected.noise is people_noise()) == (person is None)


def test_threads_that_ask_at_once_get_the_same_person():
    average_person.__wrapped__.cache_clear()
    together = Barrier(4)

    def asked(_):
        together.wait()
        return average_person()

    with ThreadPoolExecutor(4) as pool:
        first, *others = pool.map(asked, range(4))
    assert all(one is first for one in others)
    assert first is average_person()
