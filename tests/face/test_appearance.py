"""Mixtures that learn what samples were drawn from, and colour classes of a painted mouth."""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np
import pytest

from abs_engine.core.errors import (
    FaceNotFoundError,
    InputFileError,
    ModelFormatError,
    TooFewPixelsError,
)
from abs_engine.face.appearance import colour_learning
from abs_engine.face.appearance.colour import ColourClasses
from abs_engine.face.appearance.colour_features import CLASSES, features
from abs_engine.face.appearance.colour_learning import PLACES, learn_classes, typical_classes
from abs_engine.face.appearance.hamming import hamming
from abs_engine.face.appearance.labelled import train_classes
from abs_engine.face.appearance.mixture import Mixture, fit_mixture, single
from abs_engine.face.settings.colour import COLOURS as LEARNED

TRUE = Mixture(
    np.array([0.7, 0.3]),
    np.array([[0.0, 0.0], [1.0, 0.5]]),
    np.array([[[0.04, 0.01], [0.01, 0.02]], [[0.02, -0.01], [-0.01, 0.03]]]),
)


def draw(mixture: Mixture, count: int, seed: int = 0) -> np.ndarray:
    rng = np.random.default_rng(seed)
    which = rng.choice(len(mixture.weights), count, p=mixture.weights)
    roots = np.linalg.cholesky(mixture.covariances)
    return mixture.means[which] + np.einsum(
        "nij,nj->ni", roots[which], rng.normal(0, 1, (count, 2))
    )


def polluted(count: int = 4000) -> tuple[np.ndarray, np.ndarray]:
    """Samples of TRUE, and as many of something else that weigh nothing."""
    other = np.random.default_rng(9).normal(3, 0.3, (count, 2))
    return np.vstack([draw(TRUE, count), other]), np.r_[np.ones(count), np.zeros(count)]


def test_density_integrates_to_one():
    axis = np.linspace(-1.5, 2.5, 201)
    grid = np.stack(np.meshgrid(axis, axis), axis=-1).reshape(-1, 2)
    assert TRUE.density(grid).sum() * (axis[1] - axis[0]) ** 2 == pytest.approx(1, abs=1e-4)


def test_single_is_the_weighted_mean_and_covariance():
    rng = np.random.default_rng(1)
    samples, weight = rng.normal(0, 1, (300, 2)), rng.integers(0, 4, 300).astype(float)
    repeated = np.repeat(samples, weight.astype(int), axis=0)
    one = single(samples, weight)
    np.testing.assert_allclose(one.means[0], repeated.mean(axis=0))
    np.testing.assert_allclose(one.covariances[0], np.cov(repeated.T, bias=True), atol=2e-5)


def test_a_weighted_mixture_is_recovered():
    samples, weight = polluted()
    found = fit_mixture(samples, weight, most=2)
    order = np.argsort(-found.weights)
    np.testing.assert_allclose(found.weights[order], TRUE.weights, atol=0.03)
    np.testing.assert_allclose(found.means[order], TRUE.means, atol=0.03)
    np.testing.assert_allclose(found.covariances[order], TRUE.covariances, atol=0.005)


def test_no_more_components_than_the_samples_ask_for():
    samples, weight = polluted()
    assert len(fit_mixture(samples, weight, most=4).weights) == 2
    plain = np.random.default_rng(2).normal(0, 1, (3000, 2))
    assert len(fit_mixture(plain, np.ones(3000), most=3).weights) == 1


def test_a_step_of_expectation_maximisation_does_not_lower_the_likelihood():
    samples, weight = polluted()
    mixture = Mixture(TRUE.weights[::-1], TRUE.means + 0.3, 4 * TRUE.covariances)
    values = []
    for _ in range(15):
        values.append(weight @ np.log(mixture.density(samples) + 1e-300))
        mixture = mixture.updated(samples, weight)
    assert (np.diff(values) > -0.5).all()  # up to the variance floor
    assert mixture.weights.sum() == pytest.approx(1)


def test_without_data_an_anchored_step_stays_at_its_anchor():
    samples, _ = polluted(200)
    away = Mixture(TRUE.weights, TRUE.means + 0.2, TRUE.covariances)
    step = away.anchored(samples, np.zeros(len(samples)), TRUE, 50.0)
    np.testing.assert_allclose(step.weights, TRUE.weights)
    np.testing.assert_allclose(step.means, TRUE.means)
    np.testing.assert_allclose(step.covariances, TRUE.covariances, atol=2e-5)


def test_much_data_outweighs_the_anchor_and_strength_is_counted_in_samples():
    samples = draw(TRUE, 1000)
    anchor = Mixture(np.ones(1), np.array([[5.0, 5.0]]), np.eye(2)[None])
    step = anchor.anchored(samples, np.ones(1000), anchor, 1000.0)
    np.testing.assert_allclose(step.means[0], (samples.mean(axis=0) + 5) / 2)
    both = np.vstack([samples, draw(anchor, 1000, seed=5)])  # as if the anchor had been drawn from
    np.testing.assert_allclose(step.covariances[0], np.cov(both.T), rtol=0.05)
    step = anchor.anchored(samples, np.ones(1000), anchor, 1.0)
    np.testing.assert_allclose(step.means[0], samples.mean(axis=0), atol=0.01)


def test_features_of_black_and_of_the_reference():
    assert features(np.zeros((1, 3)), 120.0)[0, :2] == pytest.approx(1 / 3)
    assert np.isfinite(features(np.zeros((1, 3)), 120.0)).all()
    np.testing.assert_allclose(features(np.full((1, 3), 120), 120.0), [[1 / 3, 1 / 3, 0]])


SIZE = 120, 90
COLOURS = {
    "skin": (196, 148, 122),
    "lips": (168, 88, 88),
    "teeth": (176, 160, 140),
    "dark": (38, 16, 16),
}
TEETH, DARK = CLASSES.index("teeth"), CLASSES.index("dark")


def painted(seed: int) -> tuple[np.ndarray, np.ndarray]:
    """A mouth with shading and noise, and the class of every pixel, an index into CLASSES."""
    rng = np.random.default_rng(seed)
    label = np.zeros((SIZE[1], SIZE[0]), np.uint8)
    cv2.ellipse(label, (60, 46), (36, 18), 0, 0, 360, 1, -1)
    cv2.ellipse(label, (60, 46), (26, 7), 0, 0, 360, DARK, -1)
    cv2.ellipse(label, (60, 45), (22, 6), 0, 180, 360, TEETH, -1)
    colours = np.array([COLOURS[c] for c in CLASSES], float)[label]
    light = 0.9 + 0.2 * np.mgrid[: SIZE[1], : SIZE[0]][1] / SIZE[0]
    picture = colours * light[..., None] + rng.normal(0, 4, (*label.shape, 3))
    return np.uint8(np.clip(np.rint(picture), 0, 255)), label


def expected(label: np.ndarray, blur: float) -> np.ndarray:
    """Where skin, lips and the mouth's inside are expected: roughly, and three pixels off."""
    inside = np.minimum(label, len(PLACES) - 1)
    planes = [cv2.GaussianBlur((inside == k).astype(float), (0, 0), blur) for k in range(3)]
    return 0.95 * np.roll(np.stack(planes), 3, axis=2)


@pytest.fixture(scope="module")
def learned():
    pictures = [painted(k) for k in range(2)]
    return learn_classes([p for p, _ in pictures], [expected(label, 4.0) for _, label in pictures])


@pytest.mark.parametrize("other", [{"rounds": 1}, {"most_pixels": 600}])
def test_the_settings_that_a_run_reports_are_those_used(monkeypatch, other):
    picture, label = painted(3)
    usual = learn_classes([picture], [expected(label, 4.0)]).mixtures["lips"].means
    monkeypatch.setattr(colour_learning, "COLOURS", replace(LEARNED, **other))
    changed = learn_classes([picture], [expected(label, 4.0)]).mixtures["lips"].means
    assert not np.array_equal(usual, changed)


def test_the_classes_of_a_painted_mouth(learned):
    picture, label = painted(7)
    maps = learned.probabilities(picture)
    assert maps.shape == (len(CLASSES), *label.shape)
    assert maps.min() >= 0
    assert maps.sum(axis=0).max() <= 1 + 1e-9
    right = maps.argmax(axis=0) == label
    assert right.mean() > 0.95
    for k in range(len(CLASSES)):
        assert right[label == k].mean() > 0.9, CLASSES[k]
        assert maps[k][label == k].mean() > 0.8


def test_colours_of_nobody_belong_to_no_class(learned):
    green = np.full((4, 4, 3), (30, 220, 40), np.uint8)
    assert learned.probabilities(green).sum(axis=0).max() < 0.05


def test_black_belongs_to_the_mouths_inside(learned):
    black = np.full((4, 4, 3), (6, 3, 3), np.uint8)
    maps = learned.probabilities(black)
    assert np.isfinite(learned.probabilities(0 * black)).all()
    assert (maps.argmax(axis=0) == DARK).all()


def test_bic_chooses_the_components_of_each_class():
    """In even light one Gaussian does for each; two complexions of skin need two.

    Beside what is learned, lips have their shade, one component that is not.
    """
    label = painted(0)[1]
    noise = np.random.default_rng(3).normal(0, 4, (*label.shape, 3))
    even = np.array([COLOURS[c] for c in CLASSES], float)[label]
    two = even.copy()
    two[:, :60][label[:, :60] == 0] *= [1.12, 0.88, 0.82]
    counts = []
    for picture in (even, two):
        image = np.uint8(np.clip(np.rint(picture + noise), 0, 255))
        learned = learn_classes([image], [expected(label, 4.0)])
        counts.append([len(learned.mixtures[c].weights) for c in ("skin", "lips")])
    assert counts == [[1, 1 + 1], [2, 1 + 1]]
    assert LEARNED.skin_components == 3
    assert LEARNED.lip_components == 2


def test_teeth_and_dark_share_one_prior(learned):
    np.testing.assert_array_equal(learned.priors[:2], 1)
    assert learned.priors[2:].sum() == pytest.approx(1)
    assert learned.priors[2:].min() > 0.05


def test_too_few_pixels_of_a_class_are_an_error():
    picture, label = painted(1)
    few = np.flatnonzero(label == 1)[: LEARNED.least_pixels // 2]
    place = np.zeros((len(PLACES), label.size))
    place[0], place[1, few], place[0, few] = 0.95, 0.95, 0.0
    with pytest.raises(TooFewPixelsError, match="pixels show lips") as caught:
        learn_classes([picture], [place.reshape(-1, *label.shape)])
    assert "--colours" in caught.value.remedy


def test_places_without_lips_are_no_mouth():
    picture, label = painted(1)
    place = np.zeros((len(PLACES), *label.shape))
    place[0] = 0.95
    with pytest.raises(FaceNotFoundError):
        learn_classes([picture], [place])


def test_saved_classes_come_back(learned, tmp_path):
    learned.save(tmp_path / "colours.npz")
    back = ColourClasses.load(tmp_path / "colours.npz")
    picture, _ = painted(4)
    np.testing.assert_array_equal(back.probabilities(picture), learned.probabilities(picture))


def test_what_holds_no_classes_is_refused(learned, tmp_path):
    with pytest.raises(InputFileError):
        ColourClasses.load(tmp_path / "none.npz")
    (tmp_path / "text.npz").write_text("no archive")
    with pytest.raises(InputFileError):
        ColourClasses.load(tmp_path / "text.npz")
    learned.save(tmp_path / "whole.npz")
    whole = dict(np.load(tmp_path / "whole.npz"))
    broken = [
        {"version": 1},
        {"format": "abs_engine.run"},
        {"priors": np.ones(2)},
        {"reference": -1.0},
        {"lips_means": np.zeros((9, 3))},
        {"skin_covariances": -whole["skin_covariances"]},
        {"teeth_means": whole["teeth_means"] * np.nan},
        {"dark_weights": np.ones(0)},
    ]
    for change in broken:
        np.savez(tmp_path / "broken.npz", **(whole | change))
        with pytest.raises(ModelFormatError):
            ColourClasses.load(tmp_path / "broken.npz")
    del whole["lips_means"]
    np.savez(tmp_path / "broken.npz", **whole)
    with pytest.raises(ModelFormatError, match=r"colours\.npz of another run"):
        ColourClasses.load(tmp_path / "broken.npz")


def test_learning_is_repeatable():
    picture, label = painted(1)
    one, two = (learn_classes([picture], [expected(label, 4.0)]) for _ in range(2))
    np.testing.assert_array_equal(one.probabilities(picture), two.probabilities(picture))


@pytest.mark.parametrize("width", [2.0, 2.16, 5.0, 9.4])
def test_the_hamming_window_sums_to_one_and_is_symmetric(width):
    point = np.zeros((1, 41, 41))
    point[0, 20, 20] = 1
    spread = hamming(point, width)[0]
    assert spread.sum() == pytest.approx(1)
    np.testing.assert_allclose(spread, spread.T)
    np.testing.assert_allclose(spread, spread[::-1, ::-1])
    reach = np.abs(np.flatnonzero(spread[20] > 0) - 20).max()
    assert reach == int(width / 2)
    np.testing.assert_allclose(hamming(np.full((1, 9, 9), 0.3), width), 0.3)


def test_smoothing_is_the_hamming_window(learned):
    picture, _ = painted(3)
    plain = learned.probabilities(picture)
    np.testing.assert_allclose(learned.probabilities(picture, 5.0), hamming(plain, 5.0))


# ---- labelled pixels -----------------------------------------------------------------------------


def labelled(picture: np.ndarray, label: np.ndarray) -> dict[str, np.ndarray]:
    return {name: picture[label == k] for k, name in enumerate(CLASSES)}


def test_classes_of_labelled_pixels_come_back():
    """Learned from one picture, told in another."""
    taught = train_classes(labelled(*painted(0)))
    picture, label = painted(7)
    maps = taught.probabilities(picture)
    right = maps.argmax(axis=0) == label
    assert right.mean() > 0.95
    for k, name in enumerate(CLASSES):
        assert right[label == k].mean() > 0.9, name
    skin = painted(0)[0][painted(0)[1] == 0] @ [0.299, 0.587, 0.114]
    assert taught.reference == pytest.approx(np.median(skin), abs=1)  # of 6,000 of them
    green = np.full((4, 4, 3), (30, 220, 40), np.uint8)
    assert taught.probabilities(green).sum(axis=0).max() < 0.05


def test_many_labelled_pixels_are_thinned_out_alike():
    pixels = labelled(*painted(0))
    many = {name: np.repeat(found, 4, axis=0) for name, found in pixels.items()}
    assert len(many["skin"]) > 20_000
    picture = painted(3)[0]
    one, two, other = (train_classes(many, seed) for seed in (0, 0, 1))
    np.testing.assert_array_equal(one.probabilities(picture), two.probabilities(picture))
    assert np.abs(one.probabilities(picture) - other.probabilities(picture)).max() > 0
    plain = train_classes(pixels)
    apart = np.abs(one.probabilities(picture) - plain.probabilities(picture))
    assert apart.mean() < 0.01


@pytest.mark.parametrize("name", CLASSES)
def test_too_few_labelled_pixels_are_named(name):
    pixels = labelled(*painted(0))
    few = {**pixels, name: pixels[name][: LEARNED.least_pixels - 1]}
    with pytest.raises(
        TooFewPixelsError, match=f"only {LEARNED.least_pixels - 1} pixels show {name}"
    ):
        train_classes(few)
    del few[name]
    with pytest.raises(TooFewPixelsError, match=f"only 0 pixels show {name}"):
        train_classes(few)
    assert len(train_classes({**pixels, name: pixels[name][: LEARNED.least_pixels]}).mixtures) == 4


SMILE = {"skin": (196, 148, 122), "lips": (190, 112, 112), "teeth": (205, 178, 158)}


def smile(seed: int) -> tuple[np.ndarray, np.ndarray]:
    """A mouth that shows more teeth than lips, and the class of every pixel."""
    label = np.zeros((SIZE[1], SIZE[0]), np.uint8)
    cv2.ellipse(label, (60, 46), (40, 17), 0, 0, 360, 1, -1)
    cv2.ellipse(label, (60, 46), (36, 11), 0, 0, 360, TEETH, -1)
    colours = np.array([SMILE.get(c, (0, 0, 0)) for c in CLASSES], float)[label]
    noise = np.random.default_rng(seed).normal(0, 4, (*label.shape, 3))
    return np.uint8(np.clip(np.rint(colours + noise), 0, 255)), label


def test_teeth_are_not_learned_as_lips_where_a_closed_mouth_is_expected():
    picture, label = smile(2)
    closed = np.where(label == TEETH, 1, label)
    maps = learn_classes([picture], [expected(closed, 9.0)]).probabilities(picture)
    lips = CLASSES.index("lips")
    assert maps[lips][label == lips].mean() > 0.6
    assert maps[lips][label == TEETH].mean() < 0.2


BARED = [(216, 189, 163), (229, 200, 173)]
"""Log luminance 0.2 and 0.26 above the skin's."""


def bared(seed: int, teeth: tuple[int, int, int]) -> tuple[np.ndarray, np.ndarray]:
    """A mouth whose teeth are brighter than skin, and the class of every pixel."""
    label = np.zeros((SIZE[1], SIZE[0]), np.uint8)
    cv2.ellipse(label, (60, 46), (36, 18), 0, 0, 360, 1, -1)
    cv2.ellipse(label, (60, 46), (30, 12), 0, 0, 360, TEETH, -1)
    colours = np.array([{**COLOURS, "teeth": teeth}[c] for c in CLASSES], float)[label]
    noise = np.random.default_rng(seed).normal(0, 4, (*label.shape, 3))
    return np.uint8(np.clip(np.rint(colours + noise), 0, 255)), label


@pytest.mark.parametrize("teeth", BARED)
def test_teeth_brighter_than_skin_are_learned_as_teeth(teeth):
    """Though the mouth is hardly expected to be open: not as skin, which they are nearest to."""
    picture, label = bared(0, teeth)
    closed = np.minimum(label, 1)
    cv2.ellipse(closed, (60, 46), (30, 2), 0, 0, 360, 2, -1)
    maps = learn_classes([picture], [expected(closed, 6.0)]).probabilities(bared(1, teeth)[0])
    assert maps[TEETH][label == TEETH].mean() > 0.9
    assert maps[0][label == TEETH].mean() < 0.1
    assert maps[0][label == 0].mean() > 0.95


@pytest.mark.parametrize("teeth", BARED)
@pytest.mark.parametrize("learn", [learn_classes, typical_classes])
def test_teeth_are_not_learned_as_skin_where_it_is_expected(teeth, learn):
    """As where the lower lip of a smile is taken for both lips."""
    picture, label = bared(0, teeth)
    height = np.mgrid[: SIZE[1], : SIZE[0]][0]
    lower = np.where(height < 58, 0, label)
    skin = learn([picture], [expected(lower, 2.0)])
    maps = skin.probabilities(bared(1, teeth)[0])
    assert maps[0][label == TEETH].mean() < 0.3
    assert maps[0][label == 0].mean() > 0.95


@pytest.mark.parametrize("teeth", BARED)
def test_typical_teeth_may_be_brighter_than_skin(teeth):
    picture, label = bared(0, teeth)
    maps = typical_classes([picture], [expected(label, 4.0)]).probabilities(picture)
    assert maps[TEETH][label == TEETH].mean() > 0.8


@pytest.mark.parametrize("light", [(1.0, 1.0, 1.0), (1.1, 0.95, 0.7), (0.5, 0.45, 0.45)])
def test_typical_classes_find_lips_by_the_skin_alone(light):
    """In daylight, in warm light and in the dark; where the mouth is expected it is not."""
    picture, label = smile(3)
    picture = np.uint8(np.clip(picture * np.array(light), 0, 255))
    elsewhere = np.roll(expected(label, 6.0), (25, -20), axis=(1, 2))
    maps = typical_classes([picture], [elsewhere]).probabilities(picture)
    lips = CLASSES.index("lips")
    assert maps[lips][label == lips].mean() > 0.6
    assert maps[lips][label == 0].mean() < 0.1
    assert maps[lips][label == TEETH].mean() < 0.3


FULL = {"skin": (112, 82, 68), "lips": (150, 100, 92)}


def full(seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Closed full lips on dark skin, in their own shade where they meet; the class of a pixel."""
    label = np.zeros((SIZE[1], SIZE[0]), np.uint8)
    cv2.ellipse(label, (60, 46), (36, 22), 0, 0, 360, 1, -1)
    colours = np.array([FULL.get(c, (0, 0, 0)) for c in CLASSES], float)[label]
    height = np.mgrid[: SIZE[1], : SIZE[0]][0]
    light = 1 - 0.62 * np.exp(-(((height - 46) / 3.0) ** 2)) * (label == 1)
    noise = np.random.default_rng(seed).normal(0, 3, (*label.shape, 3))
    return np.uint8(np.clip(np.rint(colours * light[..., None] + noise), 0, 255)), label


def test_teeth_in_shade_are_not_learned_to_be_as_red_as_lips():
    """From where full lips meet, if that is taken for the mouth's inside."""
    picture, label = full(0)
    cv2.ellipse(label, (60, 46), (30, 4), 0, 0, 360, 2, -1)
    learned = learn_classes([picture], [expected(label, 4.0)]).mixtures
    redness = {c: m.means[:, 0] - m.means[:, 1] for c, m in learned.items()}
    own = learned["lips"].weights[:-1]  # without those in their own shade, which are not learned
    lips, (_, lit, shade) = own @ redness["lips"][:-1] / own.sum(), redness["teeth"]
    assert shade < lips - 0.28 * (lips - lit)


@pytest.mark.parametrize("paint", [(100, 80, 95), (118, 100, 128), (130, 110, 125)])
def test_teeth_in_shade_have_a_colour_beside_lips_that_are_no_redder_than_teeth(paint):
    picture, label = full(1)
    picture[label == 1] = np.clip(
        paint + np.random.default_rng(1).normal(0, 3, (int((label == 1).sum()), 3)), 0, 255
    )
    cv2.ellipse(label, (60, 46), (30, 4), 0, 0, 360, 2, -1)
    shade = learn_classes([picture], [expected(label, 4.0)]).mixtures["teeth"].means[2]
    assert 0.2 < shade[:2].min() < shade[:2].sum() < 0.85


def redder_full(seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Closed lips whose shade is as it is between lips in videos: darker, and redder, too."""
    picture, label = full(seed)
    height = np.mgrid[: SIZE[1], : SIZE[0]][0]
    shade = np.exp(-(((height - 46) / 3.0) ** 2)) * (label == 1)
    thrown_back = 1 - np.array([0.2, 0.42, 0.4]) * shade[..., None]
    lips = np.array(FULL["lips"]) * thrown_back
    noise = np.random.default_rng(seed).normal(0, 3, picture.shape)
    return np.uint8(np.clip(np.where(label[..., None] == 1, lips + noise, picture), 0, 255)), label


def test_the_shade_between_closed_lips_stays_lips():
    """Though the mouth's inside is expected there."""
    picture, label = redder_full(0)
    parted = label.copy()
    cv2.ellipse(parted, (60, 46), (30, 4), 0, 0, 360, 2, -1)
    maps = learn_classes([picture], [expected(parted, 4.0)]).probabilities(redder_full(1)[0])
    height = np.mgrid[: SIZE[1], : SIZE[0]][0]
    seam = (label == 1) & (abs(height - 46) <= 4)
    assert maps[CLASSES.index("lips")][seam].mean() > 0.7


def test_lips_learn_where_they_are_lit():
    """Their own shade has a component that is not learned, and leaves the others to lit lips."""
    picture, label = redder_full(0)
    learned = learn_classes([picture], [expected(label, 4.0)])
    bright = features(np.array(FULL["lips"]), learned.reference)[2]
    *own, shade = learned.mixtures["lips"].means[:, 2]
    assert np.abs(np.array(own) - bright).max() < 0.04
    assert shade < bright - 0.08


def test_plain_skin_keeps_full_lips_that_lie_where_it_is_expected():
    picture, label = full(0)
    elsewhere = np.roll(expected(label, 4.0), 20, axis=1)
    plain, usual = (
        typical_classes([picture], [elsewhere], plain=p).probabilities(picture)[1][label == 1]
        for p in (True, False)
    )
    assert plain.mean() > usual.mean() + 0.05


PAINTS = [(60, 60, 170), (235, 110, 40), (180, 20, 120), (120, 150, 40), (167, 113, 42)]


@pytest.mark.parametrize("paint", PAINTS, ids=["blue", "orange", "magenta", "green", "ochre"])
def test_lips_like_nobodys_are_learned_nevertheless(paint):
    picture, label = painted(5)
    picture[label == 1] = paint + np.random.default_rng(1).normal(
        0, 4, (int((label == 1).sum()), 3)
    )
    learned = learn_classes([picture], [expected(label, 4.0)])
    maps = learned.probabilities(picture)
    lips = CLASSES.index("lips")
    assert maps[lips][label == lips].mean() > 0.7
    assert maps[lips][label == 0].mean() < 0.1
    many = len(learned.mixtures["lips"].weights)
    assert many <= LEARNED.lip_components  # how paint looks in shade?
