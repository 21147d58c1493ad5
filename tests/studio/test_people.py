"""People who are made from the head's targets and painted when they are needed."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from abs_engine.core.errors import ParameterError
from abs_engine.dataset.codec import CLOSED_BELOW
from abs_engine.face.schema import DRAWN_TARGETS
from abs_engine.io.assets import Speaker, load_speaker
from abs_engine.studio.people import (
    SKIN_TONES,
    Person,
    dots,
    identity_vector,
    lip_colour,
    neutral,
    paint,
    random_person,
    skin_tone,
)
from abs_engine.studio.people.lip_contact import widest_gap
from abs_engine.studio.people.tones import tone_at

LUMA = np.array([0.299, 0.587, 0.114])


@pytest.fixture(scope="module")
def speaker() -> Speaker:
    return load_speaker()


def around(speaker: Speaker, texture: np.ndarray, place: tuple[float, float, float]) -> np.ndarray:
    """Median colour of the texture at the skin vertices within 14 mm of a place of the head."""
    skin = np.unique(speaker.faces[speaker.facet_class == speaker.class_id("skin")])
    skin = skin[np.linalg.norm(speaker.vertices[skin] - place, axis=1) < 14]
    assert len(skin) > 3
    return np.median(at_vertices(speaker, texture, skin), axis=0)


def at_vertices(speaker: Speaker, texture: np.ndarray, vertices: np.ndarray) -> np.ndarray:
    column, row = np.minimum(speaker.uv[vertices] * texture.shape[0], texture.shape[0] - 1).T
    return texture[row.astype(int), column.astype(int)].astype(float)


def classes(speaker: Speaker, *names: str) -> np.ndarray:
    """Vertices of facets of some classes, not of others."""
    own = np.isin(speaker.facet_class, [speaker.class_id(n) for n in names])
    return np.setdiff1d(speaker.faces[own], speaker.faces[~own])


CHEEK, FOREHEAD, JAW = (36.0, 8.0, 81.0), (0.0, 72.0, 95.0), (22.0, -56.0, 84.0)


def test_without_changes_the_base_is_what_is_filmed(speaker: Speaker) -> None:
    plain = Person("twin", "mei")
    assert np.array_equal(paint(speaker, plain), speaker.texture("mei"))
    assert np.array_equal(neutral(speaker, plain), speaker.named("mei"))


def test_identity_adds_to_the_base_and_a_macro_target_replaces_it(speaker: Speaker) -> None:
    wide = Person("wide", "mei", {"nose_scale_horiz_incr": 0.5})
    target = speaker.identity[speaker.identity_names.index("nose/nose-scale-horiz-incr")]
    moved = neutral(speaker, wide) - speaker.named("mei")
    assert moved == pytest.approx(0.5 * target.astype(float), abs=2e-4)
    other = Person("other", "mei", {"african_male_old": 1.0})
    assert identity_vector(speaker, other).nonzero()[0].tolist() == [
        speaker.identity_names.index("macro/african-male-old")
    ]


@pytest.mark.parametrize(("base", "tone"), [("kofi", "very_light"), ("clara", "very_dark")])
def test_skin_takes_the_tone_and_eyes_and_teeth_keep_theirs(
    speaker: Speaker, base: str, tone: str
) -> None:
    wanted = np.array(skin_tone(tone))
    before, after = speaker.texture(base), paint(speaker, Person("x", base, skin=skin_tone(tone)))
    for place in (CHEEK, FOREHEAD):
        found = around(speaker, after, place)
        assert np.abs(found / wanted - 1).max() < 0.15, (place, found)
    ids = [speaker.class_id(n) for n in ("eyes", "upper_teeth", "lower_teeth")]
    middles = speaker.uv[speaker.faces[np.isin(speaker.facet_class, ids)]].mean(axis=1)
    column, row = (middles * after.shape[0]).astype(int).T
    assert len(row) > 500
    assert np.array_equal(after[row, column], before[row, column])


def test_skin_keeps_its_contrast(speaker: Speaker) -> None:
    """A factor on all of the skin leaves the spread of logarithms as it was."""
    skin = np.unique(speaker.faces[speaker.facet_class == speaker.class_id("skin")])
    skin = skin[np.linalg.norm(speaker.vertices[skin] - CHEEK, axis=1) < 25]
    spreads = [
        np.log(at_vertices(speaker, texture, skin) @ LUMA).std()
        for texture in (
            speaker.texture("walter"),
            paint(speaker, Person("x", "walter", skin=(130, 92, 70))),
        )
    ]
    assert spreads[1] == pytest.approx(spreads[0], rel=0.1)


def test_lips_take_their_own_colour_or_follow_the_skin(speaker: Speaker) -> None:
    lips = classes(speaker, "upper_lip", "lower_lip")
    away = speaker.vertices[lips, None] - speaker.vertices[speaker.lip_ring]
    outside = np.linalg.norm(away, axis=2).min(axis=1)
    lips = lips[(outside > 0.8) & (outside < 4)]
    red = paint(speaker, Person("x", "ravi", lips=(190, 30, 50)))
    assert np.median(at_vertices(speaker, red, lips), 0) == pytest.approx([190, 30, 50], abs=9)
    assert around(speaker, red, CHEEK) == pytest.approx(
        around(speaker, speaker.texture("ravi"), CHEEK), abs=1
    )
    skin = SKIN_TONES["brown"]
    brown = paint(speaker, Person("x", "ravi", skin=skin))
    assert np.median(at_vertices(speaker, brown, lips), 0) == pytest.approx(lip_colour(skin), abs=9)


def test_hair_takes_its_colour_and_leaves_the_skin(speaker: Speaker) -> None:
    before = speaker.texture("amara")
    grey = paint(speaker, Person("x", "amara", hair=(140, 134, 128)))
    crown = (0.0, 145.0, 0.0)
    at = speaker.vertices[np.linalg.norm(speaker.vertices - crown, axis=1).argmin()]
    assert around(speaker, before, tuple(at)) @ LUMA < 60
    assert around(speaker, grey, tuple(at)) == pytest.approx([140, 134, 128], abs=25)
    assert around(speaker, grey, CHEEK) == pytest.approx(around(speaker, before, CHEEK), abs=1)


def test_stubble_darkens_the_jaw_only_and_more_of_it_more(speaker: Speaker) -> None:
    textures = [paint(speaker, Person("x", "clara", stubble=s)) for s in (0.0, 0.5, 1.0)]
    jaw = [around(speaker, t, JAW) @ LUMA for t in textures]
    assert jaw[0] - 8 > jaw[1] > jaw[2] + 8
    for place in (CHEEK, FOREHEAD):
        assert around(speaker, textures[2], place) == pytest.approx(
            around(speaker, textures[0], place), abs=1.0
        )


def test_freckles_are_dark_spots_on_the_cheeks(speaker: Speaker) -> None:
    before = speaker.texture("mei").astype(float) @ LUMA
    painted = paint(speaker, Person("x", "mei", freckles=1.0))
    after = painted.astype(float) @ LUMA
    column, row = (speaker.uv[np.linalg.norm(speaker.vertices - CHEEK, axis=1).argmin()] * 1024).T
    patch = slice(int(row) - 20, int(row) + 20), slice(int(column) - 20, int(column) + 20)
    darker = (after[patch] < 0.93 * before[patch]).mean()
    assert 0.02 < darker < 0.5
    scalp = np.flatnonzero(speaker.vertices[:, 1] > 110)
    assert np.array_equal(
        at_vertices(speaker, painted, scalp), at_vertices(speaker, speaker.texture("mei"), scalp)
    )


def test_same_person_same_pixels_and_another_seed_others(speaker: Speaker) -> None:
    marked = Person("x", "clara", stubble=0.5, freckles=1.0, seed=5)
    first = paint(speaker, marked)
    assert np.array_equal(first, paint(speaker, marked))
    assert not np.array_equal(first, paint(speaker, replace(marked, seed=6)))


def _painted_area(
    speaker: Speaker, person: Person, texture: np.ndarray, colour: np.ndarray
) -> float:
    """mm^2 of the person's skin that has a colour: texels times the area each of them shows."""
    texture = texture.astype(float)
    rest, uv = neutral(speaker, person), speaker.uv.astype(float) * texture.shape[0]
    near = np.abs(texture - colour).sum(axis=2) < 60
    total = 0.0
    for face in speaker.faces[np.isin(speaker.facet_class, [1, 2, 3])]:
        low, high = uv[face].min(axis=0), uv[face].max(axis=0)
        if not near[int(low[1]) : int(high[1]) + 1, int(low[0]) : int(high[0]) + 1].any():
            continue
        a, b, c = uv[face]
        flat = abs((b - a)[0] * (c - a)[1] - (b - a)[1] * (c - a)[0]) / 2
        solid = np.linalg.norm(np.cross(*(rest[face[1:]] - rest[face[0]]))) / 2
        steps = np.linspace(0, 1, 40)
        u, v = np.meshgrid(steps, steps)
        keep = u + v <= 1
        at = a + u[keep][:, None] * (b - a) + v[keep][:, None] * (c - a)
        hit = near[np.minimum(at[:, 1].astype(int), 1023), np.minimum(at[:, 0].astype(int), 1023)]
        total += solid * hit.mean() if flat > 0 else 0.0
    return total


def test_dots_lie_at_their_vertices_and_have_their_size(speaker: Speaker) -> None:
    person = Person("x", "clara", beads=8)
    marks = dots(speaker, person)
    texture = paint(speaker, person)
    assert np.abs(at_vertices(speaker, texture, marks.vertices) - marks.colours).max() < 25
    blue = marks.colours[0].astype(float)
    count = int((marks.colours == marks.colours[0]).all(axis=1).sum())
    area = _painted_area(speaker, person, texture, blue)
    assert area == pytest.approx(count * np.pi * marks.radius**2, rel=0.25)


def test_seventeen_dots_of_ink_sixteen_on_the_lips_and_one_on_the_nose(speaker: Speaker) -> None:
    marks = dots(speaker, Person("x", "clara", beads="lips17"))
    assert len(set(speaker.weld[marks.vertices].tolist())) == 17
    counts = {
        name: np.isin(
            marks.vertices, speaker.faces[speaker.facet_class == speaker.class_id(name)]
        ).sum()
        for name in ("upper_lip", "lower_lip")
    }
    assert counts == {"upper_lip": 7, "lower_lip": 9}  # the corners are dots of the lower lip
    assert marks.vertices[16] == speaker.landmarks["nose_tip"][0]
    place = speaker.named("clara")[marks.vertices]
    apart = np.linalg.norm(place[:, None] - place, axis=2) + 99 * np.eye(17)
    assert apart.min() > 2 * marks.radius  # no dot runs into another


def test_beads_are_spread_and_keep_off_the_lips(speaker: Speaker) -> None:
    marks = dots(speaker, Person("x", "kofi", beads=168))
    rest = speaker.named("kofi")
    place = rest[marks.vertices]
    apart = np.linalg.norm(place[:, None] - place, axis=2) + 99 * np.eye(168)
    assert apart.min() > 2 * marks.radius
    assert np.linalg.norm(place[:, None] - rest[speaker.lip_ring], axis=2).min() > 2.5
    assert np.array_equal(
        marks.vertices[:40], dots(speaker, Person("x", "kofi", beads=40)).vertices
    )


def test_random_people_differ_close_their_lips_and_stay_within_range(speaker: Speaker) -> None:
    rng = np.random.default_rng(11)
    cast = [random_person(speaker, rng) for _ in range(40)]
    assert cast[:2] == [random_person(speaker, np.random.default_rng(11)), cast[1]]
    shapes = [neutral(speaker, p) for p in cast]
    assert max(widest_gap(speaker, s) for s in shapes) < CLOSED_BELOW
    macros = [n.split("/")[1].replace("-", "_") for n in speaker.identity_names[:12]]
    for person in cast:
        weights = dict(person.identity)
        assert sum(weights.pop(m) for m in macros) == pytest.approx(1.0)
        assert max(weights.values()) <= 2 * max(DRAWN_TARGETS.values())
    faces = np.array(shapes)[:, speaker.vertices[:, 2] > 40]
    faces -= faces.mean(axis=1, keepdims=True)  # where the head stands is no feature
    spread = np.linalg.norm(faces - faces.mean(axis=0), axis=2).mean(axis=1)
    assert spread.min() > 1.0  # nobody is the average
    assert spread.max() < 12.0  # and nobody is a monster
    height = [np.ptp(s[:, 1]) for s in shapes]
    assert 200 < min(height) < max(height) < 340
    assert len({p.skin for p in cast}) > 20


def test_tones_run_from_light_to_dark() -> None:
    luma = [LUMA @ np.array(c) for c in SKIN_TONES.values()]
    assert np.all(np.diff(luma) < -10)
    assert tone_at(0.0) == SKIN_TONES["very_light"]
    assert tone_at(1.0) == SKIN_TONES["very_dark"]
    middle = (np.array(SKIN_TONES["medium"]) + SKIN_TONES["tan"]) / 2
    assert tone_at(3.5 / 7) == pytest.approx(middle, abs=0.51)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"base": "nobody"}, "no person 'nobody'"),
        ({"identity": {"nose_scale_horiz_inc": 1.0}}, "no shape target"),
        ({"identity": {"nose_hump_incr": np.nan}}, "weight of 'nose_hump_incr'"),
        ({"skin": (300, 0, 0)}, "colour of skin"),
        ({"stubble": 1.5}, "stubble is 1.5"),
        ({"beads": -1}, "-1 beads"),
        ({"beads": "lips18"}, "no set of dots 'lips18'"),
    ],
)
def test_impossible_people_are_refused(
    speaker: Speaker, change: dict[str, object], words: str
) -> None:
    def try_it() -> None:
        person = replace(Person("x", "clara"), **change)  # type: ignore[arg-type]
        neutral(speaker, person)
        paint(speaker, person)

    with pytest.raises(ParameterError, match=words):
        try_it()
