"""What is said: visemes, how they are joined, and what the lips then do."""

from __future__ import annotations

from functools import cache
from itertools import pairwise

import numpy as np
import pytest
from said import closed_in, say, tooth_gap

from abs_engine.core.camera import Camera
from abs_engine.core.errors import ParameterError
from abs_engine.dataset.codec import CLOSED_BELOW
from abs_engine.io.assets import load_speaker
from abs_engine.studio.people.lip_contact import widest_gap
from abs_engine.studio.sequence import articulate, deform
from abs_engine.studio.visemes import SENTENCES, VISEMES, parse

CAMERA = Camera.ideal((320, 240))
CLOSED = {"rest", "p", "m"}


@pytest.fixture(scope="module")
def speaker():
    return load_speaker()


@pytest.fixture(scope="module")
def spoken(speaker):
    """A sentence as a person says it, made once."""
    return cache(lambda sentence, person: say(sentence, speaker, person, CAMERA))


def gap(speaker, person, weights):
    return widest_gap(speaker, speaker.named(person) + deform(speaker, weights))


@pytest.mark.parametrize("name", VISEMES)
def test_each_viseme_closes_or_opens_the_lips_of_everybody(speaker, name):
    weights = VISEMES[name].weights(speaker.unit_names)
    gaps = [gap(speaker, person, weights) for person in speaker.people]
    if name in CLOSED:
        assert max(gaps) < CLOSED_BELOW
    else:
        assert min(gaps) > 0.8


def test_the_gap_is_the_one_that_was_measured_on_the_head(speaker):
    # PROVENANCE.md: overlap of 0.8 mm at rest; jawOpen adds 3.48 mm per 0.1 in the middle.
    jaw = np.zeros(52)
    neutral = gap(speaker, "walter", jaw)
    jaw[speaker.unit_names.index("jawOpen")] = 0.1
    assert neutral == pytest.approx(-0.8, abs=0.05)
    assert gap(speaker, "walter", jaw) - neutral == pytest.approx(3.48, abs=0.15)


def test_jaw_open_with_mouth_close_is_closed(speaker):
    weights = np.zeros(52)
    for name in ("jawOpen", "mouthClose"):
        weights[speaker.unit_names.index(name)] = 0.5
    assert gap(speaker, "clara", weights) < 0


@pytest.mark.parametrize("sentence", SENTENCES)
def test_labels_come_from_the_mesh(speaker, spoken, sentence):
    sequence = spoken(sentence, "mei")
    closed = closed_in(speaker, sequence)
    for frame, row in enumerate(sequence.weights):
        assert closed[frame] == (gap(speaker, "mei", row) < CLOSED_BELOW)
    assert 0.1 < closed.mean() < 0.8
    assert {sequence.visemes[i] for i in np.flatnonzero(closed)} & CLOSED


@pytest.mark.parametrize("person", ["clara", "kofi", "mei"])
def test_the_lower_lip_touches_the_teeth_in_every_f_and_v(speaker, person):
    sequence = say("_ a f o v i _", speaker, person, CAMERA)
    middles = [(start + end) / 2 for name, start, end in sequence.intervals if name == "f"]
    assert len(middles) == 2
    for middle in middles:
        weights = sequence.weights[round(middle * sequence.rate)]
        vertices = speaker.named(person) + deform(speaker, weights)
        assert tooth_gap(speaker, vertices) < 0.25


def test_every_closure_of_the_script_happens(speaker):
    sequence = say("closures", speaker, "kofi", CAMERA)
    closed = np.concatenate([[False], closed_in(speaker, sequence)])
    spells = int((closed[1:] & ~closed[:-1]).sum())
    vowels = sum(s in {"a", "o", "i", "u", "x"} for s in SENTENCES["closures"].split())
    assert spells == vowels + 1  # lips are closed before and after each vowel


def test_joints_are_smooth_and_stay_between_the_postures(speaker):
    visemes = parse("_ p a f i w _")
    step = 1e-4
    times = np.arange(0, sum(v.seconds for v in visemes), step)
    curves = articulate(visemes, times, speaker.unit_names)
    targets = np.array([v.weights(speaker.unit_names) for v in visemes])
    assert (curves >= targets.min(axis=0) - 1e-12).all()
    assert (curves <= targets.max(axis=0) + 1e-12).all()
    speed = np.diff(curves, axis=0) / step
    assert np.abs(np.diff(speed, axis=0)).max() < 0.3  # per second; a corner would be above 2


def test_every_posture_is_reached(speaker):
    visemes = parse("_ a i u _")
    middles = np.cumsum([v.seconds for v in visemes]) - [v.seconds / 2 for v in visemes]
    curves = articulate(visemes, middles, speaker.unit_names)
    for viseme, row in zip(visemes, curves, strict=True):
        np.testing.assert_allclose(row, viseme.weights(speaker.unit_names), atol=1e-12)


def test_the_face_fills_the_picture_and_stays_in_it(speaker, spoken):
    for person in speaker.people:
        sequence = spoken("wolves", person)
        neutral = speaker.named(person).astype(np.float64)
        face = neutral[[speaker.landmarks["chin"][0], neutral[:, 1].argmax()]]
        for frame in range(len(sequence)):
            pose = sequence.pose(frame)
            pixels = CAMERA.project(pose.apply(face))
            assert (pixels > 0).all()
            assert (pixels < [319, 239]).all()
            assert np.ptp(pixels[:, 1]) > 0.7 * 240
            tilt = np.degrees(np.arccos((np.trace(pose.rotation @ np.diag([1, -1, -1])) - 1) / 2))
            assert tilt < 11


def test_head_motion_is_small_and_smooth(spoken):
    sequence = spoken("wolves", "clara")
    step = np.diff(sequence.translations, axis=0)
    assert 0.05 < np.abs(step).max() < 3.0
    turns = [sequence.pose(i).rotation for i in range(len(sequence))]
    angles = [np.arccos((np.trace(a.T @ b) - 1) / 2) for a, b in pairwise(turns)]
    assert 0.001 < max(angles) < np.radians(2.5)


def test_the_seed_decides_the_motion_and_nothing_else(speaker):
    one, again, other = (say("demo", speaker, "clara", CAMERA, seed=s) for s in (3, 3, 4))
    np.testing.assert_array_equal(one.weights, again.weights)
    np.testing.assert_array_equal(one.rotations, again.rotations)
    assert np.abs(one.translations - other.translations).max() > 0.5
    mouth = [i for i, n in enumerate(speaker.unit_names) if n.startswith(("mouth", "jaw"))]
    np.testing.assert_array_equal(one.weights[:, mouth], other.weights[:, mouth])


def test_length_can_be_asked_for(speaker):
    assert len(say("demo", speaker, "clara", CAMERA, frames=50)) == 50
    seconds = sum(v.seconds for v in parse("wolves"))
    assert len(say("wolves", speaker, "clara", CAMERA, rate=30)) == round(seconds * 30)


@pytest.mark.parametrize(
    ("text", "named"), [("m a pp", "'p'"), ("wolvs", "'wolves'"), ("sch", "'sh'")]
)
def test_an_unknown_viseme_names_the_nearest(text, named):
    with pytest.raises(ParameterError, match=named):
        parse(text)


@pytest.mark.parametrize("text", ["", "  "])
def test_an_empty_sentence_is_refused(text):
    with pytest.raises(ParameterError, match="empty"):
        parse(text)


def test_bad_person_rate_or_length_are_refused(speaker):
    with pytest.raises(ParameterError, match="nobody"):
        say("demo", speaker, "nobody", CAMERA)
    with pytest.raises(ParameterError, match="positive"):
        say("demo", speaker, "clara", CAMERA, rate=0)
    with pytest.raises(ParameterError, match="positive"):
        say("demo", speaker, "clara", CAMERA, frames=0)
    with pytest.raises(ParameterError, match="too many; give 1000000 at most"):
        say("demo", speaker, "clara", CAMERA, frames=10**12)
