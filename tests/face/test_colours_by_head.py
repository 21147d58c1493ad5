"""Colours learned where a placed head shows them, of lips that differ from skin and that do not."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import cv2
import numpy as np
import pytest
from scipy.stats import norm

from abs_engine.core.errors import FaceNotFoundError
from abs_engine.face.appearance import colour_maps
from abs_engine.face.appearance.chroma import matched
from abs_engine.face.appearance.colour import ColourClasses
from abs_engine.face.appearance.colour_features import CLASSES, EACH_LIP, features
from abs_engine.face.appearance.colour_learning import mixed_with
from abs_engine.face.appearance.colour_prior import lit_share, with_shade
from abs_engine.face.appearance.colours_by_head import PLACES, learn_placed
from abs_engine.face.appearance.mixture import Mixture
from abs_engine.face.appearance.mouth_area import MouthPlace
from abs_engine.face.settings.colour import COLOURS

SKIN, LIPS, DARK, TEETH = (205, 155, 130), (165, 80, 85), (45, 22, 20), (190, 180, 165)
SHAPE = 72, 96
SKIN_ID, UPPER, LOWER, INSIDE = range(4)
LEAST = COLOURS.least_weight


def labels(large=1.0):
    """Which of `PLACES` each pixel (H, W) of a mouth that is a little open shows."""
    y, x = np.mgrid[: SHAPE[0], : SHAPE[1]].astype(float)
    x, y = (x - 48) / large, (y - 36) / large
    out = np.zeros(SHAPE, int)
    mouth = (x / 30) ** 2 + (y / 15) ** 2 < 1
    out[mouth & (y < 0)] = UPPER
    out[mouth & (y >= 0)] = LOWER
    out[(x / 22) ** 2 + (y / 4) ** 2 < 1] = INSIDE
    return out


def painted(upper=LIPS, lower=LIPS, inside=DARK, large=1.0, noise=5.0, seed=0):
    """A picture of it with grain."""
    colours = np.array([SKIN, upper, lower, inside], float)[labels(large)]
    grain = np.random.default_rng(seed).normal(0, noise, colours.shape)
    return np.uint8(np.clip(cv2.GaussianBlur(colours, (0, 0), 0.7) + grain, 0, 255))


def places(large=1.0, blur=2.0):
    """Where the drawn head has them, (4, H, W)."""
    planes = np.stack([labels(large) == k for k in range(len(PLACES))]).astype(float)
    return 0.95 * np.stack([cv2.GaussianBlur(p, (0, 0), blur) for p in planes])


def learned(*colours, large=1.0, **more):
    images = [painted(*colours, large=large, seed=k, **more) for k in range(3)]
    return learn_placed(images, [places(large)] * 3, chromatic=True)


@cache
def red():
    return learned()


@cache
def pale():
    """Lips of just the skin's colour."""
    return learned(SKIN, SKIN, SKIN)


def flat(colour):
    """A patch (1, 1, 3) of one colour."""
    return np.array(colour, float)[None, None]


def patch(colour, upper=0.5, within=0.0, beyond=0.0):
    """Probabilities by name of a colour where the mouth's place is known so far."""
    place = MouthPlace(*(np.full((1, 1), v) for v in (upper, within, beyond)))
    return dict(
        zip(CLASSES, red().compared(flat(colour)).probabilities(place=place)[:, 0, 0], strict=True)
    )


def seen(classes, colour):
    return dict(zip(CLASSES, classes.probabilities(flat(colour))[:, 0, 0], strict=True))


GUM = (215, 120, 135)


def shut_and_bared(shut):
    """Frames of which so many show closed lips, the others gums where the upper lip is expected."""
    where, y = labels(), np.mgrid[: SHAPE[0], : SHAPE[1]][0]
    closed = np.where(where == INSIDE, np.where(y < 36, UPPER, LOWER), where)
    bared = (where == UPPER) & (y > 27)
    images, priors = [], []
    for k in range(6):
        of = closed if k < shut else where
        colours = np.array([SKIN, LIPS, LIPS, DARK], float)[of]
        if k >= shut:
            colours[bared] = GUM
        grain = np.random.default_rng(k).normal(0, 5, colours.shape)
        images.append(np.uint8(np.clip(cv2.GaussianBlur(colours, (0, 0), 0.7) + grain, 0, 255)))
        planes = np.stack([of == place for place in range(len(PLACES))]).astype(float)
        priors.append(0.95 * np.stack([cv2.GaussianBlur(p, (0, 0), 2.0) for p in planes]))
    return learn_placed(images, priors, chromatic=True)


def soft(seed):
    """The mouth with edges as soft as a video's, its lips paler here and darker there."""
    where, rng = labels(), np.random.default_rng(seed)
    tones = 10 * cv2.GaussianBlur(rng.normal(0, 40, SHAPE), (0, 0), 3)
    colours = np.array([SKIN, LIPS, LIPS, DARK], float)[where]
    colours += (tones * np.isin(where, (UPPER, LOWER)))[..., None] * [0.3, 1.0, 1.0]
    grain = rng.normal(0, 3, colours.shape)
    return np.uint8(np.clip(cv2.GaussianBlur(colours, (0, 0), 2.5) + grain, 0, 255))


def test_the_soft_edge_of_lips_that_vary_is_a_little_inside_of_its_middle():
    images = [soft(seed) for seed in range(18)]
    classes = learn_placed(images, [places()] * 18, chromatic=True)
    skin, lips, _, _ = np.mean([classes.probabilities(image) for image in images], axis=0)
    bottom = [np.flatnonzero(column)[-1] for column in (lips > skin)[:, 44:53].T]
    true = [np.flatnonzero(column)[-1] for column in (labels() == LOWER)[:, 44:53].T]
    inside = 2.5 * norm.ppf(COLOURS.mixed_until)  # of an edge as blurred as `soft` has it
    assert abs(np.mean(bottom) - (np.mean(true) - inside)) < 0.5


def test_without_colour_what_is_between_skin_and_lips_may_be_lit_lips():
    images, given = [soft(seed) for seed in range(3)], [places()] * 3
    plain, mixed = (learn_placed(images, given, chromatic=c) for c in (False, True))
    assert not plain.chromatic
    assert plain.mixed == 0 < mixed.mixed
    lips = [np.mean([m.probabilities(i)[1] for i in images], axis=0) for m in (plain, mixed)]
    lower = labels() == LOWER
    assert lips[0][lower].mean() > lips[1][lower].mean() + 0.1


def one_colour(mean, sd):
    return Mixture(np.ones(1), np.array([mean]), np.diag(np.square(sd))[None])


def test_skin_is_as_dense_as_lips_a_part_of_the_way_to_them_and_else_as_before():
    skin = one_colour([0.42, 0.31, 0.0], [0.004, 0.004, 0.03])
    lips = with_shade(one_colour([0.50, 0.25, -0.1], [0.02, 0.015, 0.06]))
    mixed, often = mixed_with(skin, [lips])
    border = skin.means + COLOURS.mixed_until * (lips.means[:1] - skin.means)
    assert skin.density(border) < 0.01 * lips.density(border)
    assert often * mixed.density(border) == pytest.approx(lips.density(border), rel=1e-6)
    assert mixed.weights.sum() == pytest.approx(1)
    assert often * mixed.density(skin.means) == pytest.approx(skin.density(skin.means), rel=0.05)


@pytest.mark.parametrize(
    ("skin_sd", "lip_mean"),
    [([0.05, 0.05, 0.15], [0.58, 0.19, -0.2]), ([0.004, 0.004, 0.03], [0.421, 0.309, -0.2])],
    ids=["skin that varies more", "lips without a colour of their own"],
)
def test_skin_that_lacks_nothing_is_left_as_it_is(skin_sd, lip_mean):
    skin = one_colour([0.42, 0.31, 0.0], skin_sd)
    mixed, often = mixed_with(skin, [with_shade(one_colour(lip_mean, [0.02, 0.015, 0.06]))])
    assert often == 1
    assert np.array_equal(mixed.means, skin.means)


def test_teeth_in_light_differ_from_those_in_shade():
    reddish = [(tooth + lip) // 4 for tooth, lip in zip(TEETH, LIPS, strict=True)]  # lips' light
    row = np.array([[TEETH, reddish]])
    lit, dim = red().compared(row).teeth_in_shade()[0]
    assert lit < 0.1
    assert dim > 0.9


def test_frames_without_the_mouth_show_it_neither_shut_nor_parted():
    images, priors = [painted(seed=k) for k in range(3)], [places()] * 3
    nowhere = np.zeros_like(places())
    without, with_them = (
        learn_placed([*images, *[painted(seed=9)] * n], [*priors, *[nowhere] * n], chromatic=True)
        for n in (0, 2)
    )
    for name, lip in without.mixtures.items():
        np.testing.assert_array_equal(lip.means, with_them.mixtures[name].means)


def test_gums_are_not_learned_for_the_lip_that_bares_them():
    """Where the clip shows the mouth shut, too: then it is known what is lip."""
    told, fooled = (
        np.divide(
            *(
                classes.mixtures["upper_lip"].density(features(flat(colour), classes.reference)[0])
                for colour in (GUM, LIPS)
            )
        ).item()
        for classes in (shut_and_bared(3), shut_and_bared(1))
    )
    assert told < 0.1
    assert fooled > 1


def test_lips_that_differ_are_told_apart():
    assert set(EACH_LIP) <= set(red().mixtures)
    assert set(red().separability) == set(EACH_LIP)
    assert min(red().separability.values()) > 0.9
    assert red().weight == 1.0
    for name, colour in {"skin": SKIN, "lips": LIPS, "dark": DARK}.items():
        assert seen(red(), colour)[name] > 0.8, name


def test_classes_lie_at_what_was_painted():
    for name, colour in {"upper_lip": LIPS, "lower_lip": LIPS, "skin": SKIN}.items():
        mixture = red().mixtures[name]
        centre = mixture.means[mixture.weights.argmax()]
        wanted = features(flat(colour), red().reference)[0, 0]
        np.testing.assert_allclose(centre, wanted, atol=0.04, err_msg=name)


def test_lips_of_the_skins_colour_are_not_refused_but_said_to_be_so():
    assert all(abs(told - 0.5) < 0.15 for told in pale().separability.values())
    assert pale().weight == pytest.approx(LEAST)


def test_separability_grows_with_the_difference():
    def between(share):
        return tuple(np.array(SKIN) + share * (np.array(LIPS) - np.array(SKIN)))

    told = [
        np.mean(list(learned(c, c, DARK, noise=8.0).separability.values()))
        for c in (between(0.1), between(0.4), between(1.0))
    ]
    assert told == sorted(told)
    assert told[-1] > told[0] + 0.2


@pytest.mark.parametrize("which", EACH_LIP)
def test_each_lip_is_measured_by_itself(which):
    """A lower lip in bright light may look like skin where the upper one does not."""
    other = EACH_LIP[1 - EACH_LIP.index(which)]
    colour = {which: LIPS, other: SKIN}
    told = learned(*(colour[name] for name in EACH_LIP)).separability
    assert told[which] > 0.85
    assert told[other] < 0.7


def test_each_lip_gets_its_own_colour():
    upper, lower = (150, 70, 100), (190, 95, 75)
    classes = learned(upper, lower)
    at = {"upper_lip": upper, "lower_lip": lower}
    for name, other in (EACH_LIP, EACH_LIP[::-1]):
        own = classes.mixtures[name].density(features(flat(at[name]), classes.reference)[0])
        apart = classes.mixtures[other].density(features(flat(at[name]), classes.reference)[0])
        assert own > 3 * apart, name


@pytest.mark.parametrize("large", [0.12, 0.2])
def test_a_few_pixels_of_lip_are_enough(large):
    few = [((labels(large) == k).sum()) for k in (UPPER, LOWER)]
    assert min(few) < 30
    classes = learn_placed([painted(large=large)], [places(large, 0.7)], chromatic=True)
    for mixture in classes.mixtures.values():
        assert np.isfinite(mixture.means).all()
        assert (np.linalg.eigvalsh(mixture.covariances) > 0).all()
    assert all(0.0 <= told <= 1.0 for told in classes.separability.values())
    # what is hardly seen is not sure of itself
    wide, narrow = (np.linalg.det(c.mixtures["lower_lip"].covariances[0]) for c in (classes, red()))
    assert wide > narrow


@pytest.mark.parametrize("lost", [[SKIN_ID], [UPPER, LOWER]])
def test_a_mouth_outside_of_the_picture_is_an_error(lost):
    given = places()
    given[lost] = 0.0
    with pytest.raises(FaceNotFoundError, match="outside of the picture"):
        learn_placed([painted()], [given], chromatic=True)
    with pytest.raises(FaceNotFoundError, match="outside of the picture"):
        learn_placed([painted()], [np.zeros((4, *SHAPE))], chromatic=True)


@pytest.mark.parametrize("lost", [UPPER, LOWER])
def test_a_lip_that_is_seen_nowhere_is_anybodys(lost):
    given = places()
    given[lost] = 0.0
    classes = learn_placed([painted()], [given], chromatic=True)
    assert all(np.isfinite(m.means).all() for m in classes.mixtures.values())


def test_skin_that_is_likely_nowhere_is_learned_where_it_is_likeliest():
    rare = places()
    rare[SKIN_ID] *= 0.4
    found = learn_placed([painted(seed=k) for k in range(3)], [rare] * 3, chromatic=True)
    skin, lips, _, _ = found.probabilities(flat(SKIN))[:, 0, 0]
    assert skin > 0.9 > 0.05 > lips


def test_a_black_and_white_picture_is_learned_from():
    grey = np.repeat(painted().mean(axis=2, keepdims=True).astype(np.uint8), 3, axis=2)
    classes = learn_placed([grey], [places()], chromatic=True)
    assert all(np.isfinite(m.means).all() for m in classes.mixtures.values())
    assert all(0.0 <= told <= 1.0 for told in classes.separability.values())


def test_it_learns_the_same_each_time():
    again = learned()
    for name, mixture in red().mixtures.items():
        np.testing.assert_array_equal(mixture.means, again.mixtures[name].means)


def test_saved_classes_keep_each_lip_and_what_was_measured(tmp_path):
    replace(red(), agreement=0.7).save(tmp_path / "colours.npz")
    again = ColourClasses.load(tmp_path / "colours.npz")
    assert set(again.mixtures) == set(CLASSES) | set(EACH_LIP)
    for name, mixture in red().mixtures.items():
        for part in ("weights", "means", "covariances"):
            np.testing.assert_array_equal(
                getattr(mixture, part), getattr(again.mixtures[name], part)
            )
    assert again.separability == red().separability
    assert again.agreement == 0.7
    assert again.mixed == red().mixed
    np.testing.assert_array_equal(again.priors, red().priors)


def test_how_many_components_are_mixed_is_checked_as_it_is_read():
    arrays = red().arrays()
    kept = {k: np.asarray(v) for k, v in arrays.items() if k != "mixed"}
    assert ColourClasses.of_arrays(kept).mixed == 0
    for wrong in (-1, len(red().mixtures["skin"].weights)):
        with pytest.raises(ValueError, match="fit together"):
            ColourClasses.of_arrays({**kept, "mixed": np.array(wrong)})


def test_classes_without_lips_of_their_own_still_load(tmp_path):
    whole = replace(red(), mixtures={c: red().mixtures[c] for c in CLASSES}, separability={})
    whole.save(tmp_path / "old.npz")
    again = ColourClasses.load(tmp_path / "old.npz")
    assert not set(EACH_LIP) & set(again.mixtures)
    assert again.separability == {}
    assert again.weight == 1.0


@pytest.mark.parametrize(("told", "weight"), [(0.5, LEAST), (0.75, 0.5), (0.9, 1.0), (1.0, 1.0)])
def test_the_weight_of_colours_by_their_separability(told, weight):
    classes = replace(red(), separability=dict.fromkeys(EACH_LIP, told))
    assert classes.weight == pytest.approx(weight)


@pytest.mark.parametrize(("told", "weight"), [(-0.5, LEAST), (0.6, LEAST), (0.75, 0.5), (1.2, 1.0)])
def test_the_weight_of_colours_by_how_apertures_follow(told, weight):
    classes = replace(red(), agreement=told)
    assert classes.weight == pytest.approx(weight)
    both = replace(classes, separability=dict.fromkeys(EACH_LIP, 0.75))
    assert both.weight == pytest.approx(0.5 * weight)


def test_skin_coloured_teeth_within_the_lips_are_no_skin():
    yellow = tuple(np.array(SKIN) * 0.97)
    assert patch(yellow)["skin"] > 0.8
    within = patch(yellow, within=1.0)
    assert within["skin"] == 0.0
    assert within["teeth"] > 0.9 > within["lips"]
    half = patch(yellow, within=0.5)["skin"]
    assert 0 < half <= patch(yellow)["skin"]


def test_the_edge_of_a_lip_is_no_tooth_within_the_outline():
    images = [soft(seed) for seed in range(3)]
    classes = learn_placed(images, [places()] * 3, chromatic=True)
    assert classes.mixed
    between = flat(0.5 * np.array(SKIN) + 0.5 * np.array(LIPS))
    place = MouthPlace(*(np.full((1, 1), v) for v in (0.5, 1.0, 0.0)))
    lips, teeth = classes.compared(between).probabilities(place=place)[1:3, 0, 0]
    taken, usual = replace(classes, mixed=0).compared(between).probabilities(place=place)[1:3, 0, 0]
    assert teeth < 0.5 * usual
    assert lips > taken


def test_a_lip_of_the_skins_colour_stays_a_lip_within_its_outline():
    place = MouthPlace(*(np.full((1, 1), v) for v in (0.5, 1.0, 0.0)))
    shown = pale().compared(flat(SKIN)).probabilities(place=place)[:, 0, 0]
    assert CLASSES[int(shown.argmax())] == "lips"


def test_a_lip_coloured_beard_beyond_is_no_lip():
    assert patch(LIPS)["lips"] > 0.8
    beyond = patch(LIPS, beyond=1.0)
    assert beyond["lips"] == beyond["teeth"] == beyond["dark"] == 0.0
    assert patch(LIPS, beyond=0.95)["lips"] < patch(LIPS)["lips"]


def test_what_is_darker_than_dark_is_dark():
    """Whatever its chroma, which says nothing there."""
    for black in ((0, 0, 0), (0, 0, 22), (0, 14, 0), (2, 6, 14)):
        assert patch(black, within=0.9)["dark"] > 0.9, black
    assert patch((0, 160, 0))["dark"] < 0.1  # a green that is no darker belongs to nobody


def test_a_place_of_no_opinion_changes_little():
    for colour in (SKIN, LIPS, TEETH):
        with_place, without = patch(colour), seen(red(), colour)
        for name in CLASSES:
            assert with_place[name] == pytest.approx(without[name], abs=0.15), (colour, name)


def test_each_lip_is_compared_with_its_own_colours():
    upper, lower = (150, 70, 100), (190, 95, 75)
    classes = learned(upper, lower)
    told = {
        (name, share): classes.compared(flat(colour)).probabilities(
            place=MouthPlace(*(np.full((1, 1), v) for v in (share, 0.0, 0.0)))
        )[CLASSES.index("lips"), 0, 0]
        for name, colour in (("upper", upper), ("lower", lower))
        for share in (0.0, 1.0)
    }
    assert told["upper", 1.0] > told["upper", 0.0]
    assert told["lower", 0.0] > told["lower", 1.0]


def test_maps_are_the_shares_of_the_densities_in_double_precision():
    picture, classes = painted(), red()
    samples = features(picture, classes.reference).reshape(-1, 3)
    own = np.stack([classes.mixtures[name].density(samples) for name in CLASSES])
    own *= classes.priors[:, None]
    skin, lips, *inside = (classes.mixtures[name].peak for name in CLASSES)
    floor = COLOURS.outlier * min(skin, lips, max(classes.priors[2:] * inside))
    maps = classes.probabilities(picture).reshape(4, -1)
    np.testing.assert_allclose(maps, own / (own.sum(axis=0) + floor), atol=1e-5)


def test_teeth_of_any_colour_lie_in_shade_as_double_precision_has_it():
    every = np.stack(np.meshgrid(*[np.arange(0, 256, 15)] * 3), axis=-1).reshape(1, -1, 3)
    samples = features(every, red().reference).reshape(-1, 3)
    lit = lit_share(red().mixtures["teeth"], samples)
    np.testing.assert_allclose(red().compared(every).teeth_in_shade()[0], 1 - lit, atol=1e-9)


def test_classes_of_which_the_mouth_has_none_leave_maps_finite():
    none = replace(red(), priors=np.array([1.0, 1.0, 0.0, 0.0]))
    assert np.isfinite(none.probabilities(flat((0, 255, 0)))).all()


def teeth_begin(edge, mixing=2.0):
    """Row, to a fraction, where teeth seem to begin below a dark lip.

    In a video that keeps one chroma for 2x2 pixels, with teeth from row `edge` on.
    """
    rows = np.array([SKIN] * 8 + [LIPS] * (edge - 11) + [(120, 56, 60)] * 3 + [TEETH] * 20, float)
    wide = cv2.GaussianBlur(np.tile(rows[:, None], (1, 16, 1)), (0, 0), 0.7)
    split = cv2.cvtColor(np.uint8(np.rint(wide)), cv2.COLOR_RGB2YCrCb)
    split = split[: len(split) // 2 * 2]
    coarse = cv2.resize(split[..., 1:], None, fx=0.5, fy=0.5, interpolation=cv2.INTER_AREA)
    split[..., 1:] = coarse.repeat(2, axis=0).repeat(2, axis=1)
    video = cv2.cvtColor(split, cv2.COLOR_YCrCb2RGB)
    place = MouthPlace(*(np.full(video.shape[:2], v) for v in (1.0, 1.0, 0.0)), mixing)
    lips = red().compared(matched(video)).probabilities(place=place)[CLASSES.index("lips")]
    return 8 + float(lips[8 : edge + 10, 8].sum())


def test_dark_lips_are_lips_beside_teeth_whose_chroma_they_take_on(monkeypatch):
    edges = range(24, 32)
    off = np.array([teeth_begin(edge) - edge for edge in edges])
    none = replace(colour_maps.COLOURS, beside_teeth_part=0.0)
    monkeypatch.setattr(colour_maps, "COLOURS", none)
    before = np.array([teeth_begin(edge) - edge for edge in edges])
    assert abs(off.mean()) < 0.5 * abs(before.mean())


@pytest.mark.parametrize(
    ("agreement", "times"), [(0.4, 1.0), (1.0, 1.0), (1.5, 1.5), (2.0, 2.0), (7.0, 1.0)]
)
def test_colours_that_open_the_mouth_farther_outdo_landmarks(agreement, times):
    assert replace(red(), agreement=agreement).outdoing == pytest.approx(times)


def test_colours_of_little_worth_outdo_little():
    assert replace(pale(), agreement=2.0).outdoing == pytest.approx(1 + LEAST)
