"""Coarticulation, and contacts of lips and teeth on the mesh of every person."""

from __future__ import annotations

from functools import cache
from itertools import pairwise

import numpy as np
import pytest
from said import tooth_gap
from trimesh.triangles import closest_point

from abs_engine.core.errors import ParameterError
from abs_engine.dataset.card import card_text
from abs_engine.dataset.codec import CLOSED_BELOW
from abs_engine.io.assets import load_speaker
from abs_engine.studio.people import neutral as shape
from abs_engine.studio.people import random_person
from abs_engine.studio.people.lip_contact import widest_gap
from abs_engine.studio.sequence import deform
from abs_engine.studio.speech import articulate, parse_phonemes
from abs_engine.studio.speech.articulate import frame_times
from abs_engine.studio.speech.chart import IPA
from abs_engine.studio.speech.contact import ContactSolver
from abs_engine.studio.speech.dominance import Score, blend
from abs_engine.studio.speech.gestures import contacts
from abs_engine.studio.speech.lips import Lips
from abs_engine.studio.speech.targets import ARTICULATORS, goals

PEOPLE = ("clara", "kofi", "mei", "walter", "amara", "ravi")
SPEAKER = load_speaker()
UNIT = {name: index for index, name in enumerate(SPEAKER.unit_names)}
TOUCHING = 0.25
"""mm between the lower lip and the upper teeth, the median along them."""

OPEN_VOWELS = set("aɑɒæɐɔɛœ")

# Short and long closures, clusters, and rounded and spread neighbours; the phases of the frames
# differ with the first pause.
ENGLISH = '_({phase}) "b{{d m{{n fju: Op@n pul _ vamp(0.18) p(0.03) u b(0.02) i m(0.025) a _'
FRENCH = "_({phase}) bO~ fu pa~ py vi b9R mwE~ _"


@cache
def neutral(person):
    return SPEAKER.named(person)


@cache
def lips(person):
    return Lips.of(SPEAKER, neutral(person))


@cache
def said(person, text, rate):
    return articulate(SPEAKER, neutral(person), parse_phonemes(text), rate)


def contacts_of(text, rate):
    utterance = parse_phonemes(text)
    return contacts(utterance.segments, frame_times(utterance.seconds, rate))


def gap(person, weights):
    return widest_gap(SPEAKER, neutral(person) + deform(SPEAKER, weights))


def posture(symbol):
    weights = np.zeros(52)
    for name, goal in goals(IPA[symbol]).items():
        for unit in ARTICULATORS[name]:
            weights[UNIT[unit]] = goal.target
    return weights


def at(speech, seconds, unit):
    return speech.weights[round(seconds * speech.rate), UNIT[unit]]


def middle(speech, label, nth=0):
    start, end = [(a, b) for own, a, b in speech.intervals if own == label][nth]
    return (start + end) / 2


def two_segments(magnitude=(1.0, 1.0)):
    """Targets 0 and 1, whole until 0.1 s and from 0.3 s on, decaying in 0.1 s."""
    decay = np.full((2, 1), 0.1)
    return Score(
        np.array([0.0, 0.3]), np.array([0.1, 0.4]), np.array([[0.0], [1.0]]),
        np.array(magnitude)[:, None], decay, decay,
    )  # fmt: skip


def test_dominance_by_hand():
    curve = blend(two_segments(), np.array([0.05, 0.2, 0.25, 10.0]))[:, 0]
    # At 0.05 s the second's dominance is exp(-2.5^1.5) = 0.019200; halfway both are the same; at
    # 0.25 s they are exp(-1.5^1.5) = 0.159276 and exp(-0.5^1.5) = 0.702188.
    expected = [0.019200 / 1.019200, 0.5, 0.702188 / 0.861464, 1.0]
    np.testing.assert_allclose(curve, expected, atol=2e-6)


def test_magnitude_decides_who_yields():
    curve = blend(two_segments((3.0, 1.0)), np.array([0.2]))
    assert curve[0, 0] == pytest.approx(0.25)


def test_the_gap_is_the_one_that_labels_are_made_of():
    rng = np.random.default_rng(0)
    for person in PEOPLE:
        weights = np.zeros(52)
        weights[[i for n, i in UNIT.items() if "outh" in n or "jaw" in n]] = 0.3 * rng.random(27)
        full = neutral(person) + np.tensordot(weights, SPEAKER.units.astype(np.float64), 1)
        gaps, _ = lips(person).gaps(weights)
        assert gaps.max() == pytest.approx(widest_gap(SPEAKER, full), abs=1e-9)


def test_the_distance_to_the_teeth_against_points_strewn_over_the_lip():
    share = np.array([(i, j, 12 - i - j) for i in range(13) for j in range(13 - i)]) / 12
    for person in ("mei", "kofi"):
        weights = posture("f")
        model = lips(person)
        corner = model.points(weights)[model.lower_faces]
        strewn = np.einsum("sc,fcx->fsx", share, corner).reshape(-1, 3)
        away = np.linalg.norm(strewn - model.incisors[:, None], axis=2).min(axis=1)
        found, slopes = model.tooth_gaps(weights)
        np.testing.assert_allclose(found, away, atol=0.05)
        assert (found <= away + 1e-9).all()
        step = 1e-5 * np.random.default_rng(1).normal(size=52)
        change = model.tooth_gaps(weights + step)[0] - found
        np.testing.assert_allclose(change, slopes @ step, atol=1e-7)


def test_the_teeth_are_the_upper_front_ones():
    at_rest = tooth_gap(SPEAKER, neutral("clara"))
    assert 5.0 < at_rest < 9.0  # the lips lie in front of them
    inside = np.unique(SPEAKER.faces[SPEAKER.facet_class == SPEAKER.class_id("upper_teeth")])
    teeth = neutral("clara")[inside]
    points = lips("clara").incisors
    assert (points[:, 1] >= teeth[:, 1].min() - 1e-3).all()
    assert np.abs(points[:, 0]).max() == 5.0
    assert points[:, 2].min() > np.quantile(teeth[:, 2], 0.7)


@pytest.mark.parametrize("person", PEOPLE)
@pytest.mark.parametrize("vowel", ["a", "u", "i", "ɔ"])
def test_any_posture_can_be_closed_without_pressing_lip_into_lip(person, vowel):
    solver = ContactSolver(lips(person), SPEAKER.unit_names)
    weights = posture(vowel)
    assert gap(person, weights) > 2.5
    closed = solver.close(weights)
    assert gap(person, closed) < 0.0
    rest = lips(person).gaps(np.zeros(52))[0]
    gaps = lips(person).gaps(closed)[0]
    assert gaps.min() > rest.min() - 1.2
    assert 0 <= closed.min() <= closed.max() <= 1


@pytest.mark.parametrize("person", PEOPLE)
@pytest.mark.parametrize(
    ("text", "rate"),
    [(ENGLISH.format(phase=0.1), 25.0), (FRENCH.format(phase=0.0837), 30.0),
     ("_(0.1119) bO~ fu pa~ vE m p(0.01) i ba _", 50.0)],
)  # fmt: skip
def test_bilabials_close_and_labiodentals_touch_in_everybody(person, text, rate):
    speech = said(person, text, rate)
    times = np.arange(len(speech)) / rate
    gaps = np.array([gap(person, row) for row in speech.weights])
    spoken = [(a, b) for label, a, b in speech.intervals if label[0] in "pbm"]
    made = contacts_of(text, rate)
    closures = [c for c in made if c.kind == "lips"]
    assert len(closures) == len(spoken) >= 5
    for contact, (start, end) in zip(closures, spoken, strict=True):
        held = (times >= contact.start) & (times <= contact.end)
        own = (times >= start) & (times < end)
        assert held.any()
        assert (held & own).any() or not own.any()
        assert gaps[held].max() < CLOSED_BELOW
    for contact in (c for c in made if c.kind == "teeth"):
        held = np.flatnonzero((times >= contact.start) & (times <= contact.end))
        assert len(held)
        vertices = [neutral(person) + deform(SPEAKER, speech.weights[frame]) for frame in held]
        assert max(tooth_gap(SPEAKER, v) for v in vertices) < TOUCHING
        assert gaps[held].min() > 1.5
    long = [i for i in speech.intervals if i[0][0] in OPEN_VOWELS and i[2] - i[1] > 0.08]
    assert len(long) >= 2
    for label, start, end in long:
        frame = int(np.abs(times - (start + end) / 2).argmin())
        assert gaps[frame] > 3.0, (label, start, end)


@pytest.mark.parametrize("seed", range(12))
def test_labiodentals_touch_in_people_drawn_by_chance(seed):
    drawn = shape(SPEAKER, random_person(SPEAKER, np.random.default_rng(seed)))
    text = "_(0.1) fi vu aFa pOf mivO _"
    speech = articulate(SPEAKER, drawn, parse_phonemes(text), 25.0)
    times = np.arange(len(speech)) / 25
    seen = {"lips": 0, "teeth": 0}
    for contact in contacts_of(text, 25.0):
        held = np.flatnonzero((times >= contact.start) & (times <= contact.end))
        for frame in held:
            vertices = drawn + deform(SPEAKER, speech.weights[frame])
            seen[contact.kind] += 1
            if contact.kind == "lips":
                assert widest_gap(SPEAKER, vertices) < CLOSED_BELOW
                continue
            assert tooth_gap(SPEAKER, vertices) < TOUCHING
            assert frame != held[0] or depth_in_teeth(vertices) < 0.3
    assert seen["teeth"] >= 5
    assert seen["lips"] >= 2


@pytest.mark.parametrize("person", PEOPLE)
def test_the_lip_does_not_go_through_the_teeth(person):
    solver = ContactSolver(lips(person), SPEAKER.unit_names)
    for symbol in "fvɱ":
        weights = solver.bite(posture(symbol))
        assert depth_in_teeth(neutral(person) + deform(SPEAKER, weights)) < 0.3
        off = lips(person).tooth_gaps(weights)[0]
        assert off.max() < 0.5  # neither end of the teeth stands deep in the lip


def test_depth_in_teeth_by_hand():
    moved, edge = neutral("clara").astype(np.float64), lips("clara").incisors[5]
    assert depth_in_teeth(moved) == 0.0
    red = np.unique(SPEAKER.faces[SPEAKER.facet_class == SPEAKER.class_id("lower_lip")])
    middle = red[np.linalg.norm(moved[red] - edge, axis=1).argmin()]
    # The teeth are 1.4 mm thick there.
    moved[red] += edge - moved[middle] + np.array([0, 1.5, -0.4])
    assert depth_in_teeth(moved) > 0.3


def cross(one, other):
    """Of vectors (..., 2)."""
    return one[..., 0] * other[..., 1] - one[..., 1] * other[..., 0]


def depth_in_teeth(vertices):
    """How deep (mm) a point of the lower lip's red is between the teeth's front and their back."""
    vertices = vertices.astype(np.float64)
    teeth, lip = (
        vertices[SPEAKER.faces[SPEAKER.facet_class == SPEAKER.class_id(name)]]
        for name in ("upper_teeth", "lower_lip")
    )
    share = np.array([(i, j, 4 - i - j) for i in range(5) for j in range(5 - i)]) / 4
    points = np.einsum("sc,fcx->fsx", share, lip).reshape(-1, 3)
    points = points[(np.abs(points[:, 0]) < 6) & (points[:, 1] > teeth[..., 1].min())]
    (a, b, c), z = (teeth[:, k, :2] for k in range(3)), teeth[..., 2]
    flat = np.abs(cross(b - a, c - a)) > 1e-9
    a, b, c, z = a[flat], b[flat] - a[flat], c[flat] - a[flat], z[flat]
    away = points[:, None, :2] - a
    u, w = cross(away, c) / cross(b, c), cross(b, away) / cross(b, c)
    met = (u >= 0) & (w >= 0) & (u + w <= 1)
    ahead = z[:, 0] + u * (z[:, 1] - z[:, 0]) + w * (z[:, 2] - z[:, 0])
    deepest = 0.0
    for point, at in zip(points, map(np.extract, met, ahead), strict=True):
        if len(at) and at.min() < point[2] < at.max():
            place = closest_point(teeth, np.broadcast_to(point, (len(teeth), 3)))
            deepest = max(deepest, np.linalg.norm(place - point, axis=1).min())
    return deepest


@pytest.mark.parametrize("person", PEOPLE)
def test_only_closing_sounds_close_the_lips(person):
    for symbol, phoneme in IPA.items():
        if not phoneme.closes_lips:
            assert gap(person, posture(symbol)) > 0.6, symbol


def test_targets_follow_the_features():
    falling = {"jawOpen": "aɛei", "mouthPucker": "uoɔi", "mouthSmileLeft": "ieɛu"}
    for unit, symbols in falling.items():
        weights = [posture(symbol)[UNIT[unit]] for symbol in symbols]
        assert all(one > other for one, other in pairwise(weights)), unit
    for front, back in ("yu", "øo", "œɔ"):
        assert posture(front)[UNIT["mouthPucker"]] == posture(back)[UNIT["mouthPucker"]]
    assert posture("w")[UNIT["mouthPucker"]] > posture("u")[UNIT["mouthPucker"]]
    assert posture("ʃ")[UNIT["mouthFunnel"]] > 0.3 > posture("s")[UNIT["mouthFunnel"]]


def test_rounding_spreads_and_more_so_ahead():
    rate = 200.0
    ahead, spread = (said("clara", f"_ i s t {v} _", rate) for v in "ui")
    assert at(ahead, middle(ahead, "t"), "mouthPucker") > 0.25
    assert at(spread, middle(spread, "t"), "mouthPucker") < 0.01
    back = said("clara", "_ u s t i _", rate)
    before = at(ahead, middle(ahead, "t"), "mouthPucker")  # 0.09 s or so before the vowel's middle
    after = at(back, middle(back, "s"), "mouthPucker")
    assert before > after > 0.05
    rounded, plain = (said("clara", f"_ {v} p {v} _", rate) for v in "ui")
    assert at(rounded, middle(rounded, "p"), "mouthPucker") > 0.2
    assert at(plain, middle(plain, "p"), "mouthPucker") < 0.02


@pytest.mark.parametrize("person", ["walter", "amara"])
def test_movements_are_continuous(person):
    text = "_ bO pu fivam _"
    speech = said(person, text, 200.0)
    assert np.abs(np.diff(speech.weights, axis=0)).max() < 0.15  # in 5 ms
    times = np.arange(len(speech)) / speech.rate
    for contact in contacts_of(text, 200.0):  # solved anew for each frame, and yet smooth
        held = speech.weights[(times >= contact.start) & (times <= contact.end)]
        assert np.abs(np.diff(held, 2, axis=0)).max() < 0.03
    assert speech.weights.min() >= 0
    assert speech.weights.max() <= 1


def test_labels_and_intervals():
    speech = said("clara", "_(0.1) a(0.1) p(0.1) _(0.11)", 25.0)
    assert speech.phonemes == ("_", "_", "_", "a", "a", "p", "p", "p", "_", "_", "_")
    assert speech.intervals[1] == ("a", 0.1, 0.2)
    assert speech.weights.shape == (11, 52)
    assert speech.head is None


def test_it_is_the_same_again_and_differs_with_the_person():
    text = "_ apufi _"
    first = said("clara", text, 25.0)
    again = articulate(SPEAKER, neutral("clara"), parse_phonemes(text), 25.0)
    np.testing.assert_array_equal(first.weights, again.weights)
    assert np.abs(first.weights - said("kofi", text, 25.0).weights).max() > 0.05


@pytest.mark.parametrize("rate", [0.0, -25.0, float("nan")])
def test_a_bad_rate_is_refused(rate):
    with pytest.raises(ParameterError, match="frame rate"):
        articulate(SPEAKER, neutral("clara"), parse_phonemes("a"), rate)


def test_a_closure_shorter_than_a_frame_takes_a_frame_from_its_neighbours():
    text = "_(0.05) a(0.1) f(0.03) p(0.01) v(0.03) a(0.1) _"
    speech = said("ravi", text, 25.0)
    times = np.arange(len(speech)) / 25
    (closure,) = [c for c in contacts_of(text, 25.0) if c.kind == "lips"]
    held = (times >= closure.start) & (times <= closure.end)
    assert held.sum() == 1
    assert "p" not in speech.phonemes
    assert gap("ravi", speech.weights[held][0]) < CLOSED_BELOW


def test_the_card_says_what_is_measured():
    card = card_text({"clips": [], "command": "", "seed": 0, "engine": "", "labels": ()})
    assert f"gap along them is below {TOUCHING:g} mm" in card
    assert "need not touch" not in card
    assert "the lips meet at some time of each interval" in card
