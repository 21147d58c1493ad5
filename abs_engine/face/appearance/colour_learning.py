"""Learning the colour classes of a clip, given where each of them is expected.

Between skin and lips chromaticity is to decide, as in the paper: their luminance, which shading
below the lip and at the corners changes, is taken as less certain than it was in the samples.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.arrays import BoolArray, FloatArray, IntArray
from abs_engine.core.errors import FaceNotFoundError, TooFewPixelsError
from abs_engine.face.appearance.colour import ColourClasses
from abs_engine.face.appearance.colour_features import CLASSES, features
from abs_engine.face.appearance.colour_prior import (
    DARK,
    TEETH,
    inside_guess,
    less_red,
    lit_share,
    typical_lips,
    with_shade,
    without_teeth,
)
from abs_engine.face.appearance.luminance import luminance
from abs_engine.face.appearance.mixture import Mixture, fit_mixture, single
from abs_engine.face.settings.colour import COLOURS

PLACES = ("skin", "lips", "inside")
"""What is expected where: which of teeth and dark shows inside a mouth is told by colour alone."""


def learn_classes(
    images: Sequence[NDArray[np.generic]], places: Sequence[FloatArray]
) -> ColourClasses:
    """Learn the classes from a clip, given where each class is expected.

    Expectation maximisation in which a pixel's prior over the classes comes from its place. Lips
    learn only where lips are surely expected, skin where it is likelier than not. Lips are held to
    what is beside such skin in anybody, else a smile's teeth would be learned for them, unless
    hardly anything is like that: painted lips are what is reddest there. Others have one more
    component, the last, that is not learned: lips in their own shade. Teeth and dark, which may
    hardly show in the clip, are held near what their colours are like in anybody.

    Parameters
    ----------
    images : sequence of (H, W, 3), RGB
    places : sequence of (3, H, W) float64
        Prior probability of each of `PLACES` at each pixel; the rest to 1 is "none of them".

    Returns
    -------
    ColourClasses

    Raises
    ------
    FaceNotFoundError
        If the places hold no skin or no lips.
    TooFewPixelsError
        If fewer than `COLOURS.least_pixels` are left for skin or lips.
    """
    prior, pixels = _chosen(images, places)
    samples, reference, certain = sampled(prior, pixels)
    around, core = prior[0] > 0.5, prior[1] > COLOURS.core * prior[1].max()
    _enough("skin", prior[0] * around)
    _enough("lips", prior[1] * core)
    skin = skin_of(samples[certain])
    typical = typical_lips(skin)
    found = _separated(samples, prior, skin, typical, typical)
    usual = found.own.sum() >= COLOURS.unusual * (prior[1] @ core)
    if not usual:
        found = _separated(samples, prior, skin, _reddest(samples, prior[1], skin), None)
    _enough("skin", found.bare)
    _enough("lips", found.own)
    lips = fit_mixture(samples, found.own, COLOURS.lip_components)
    lips = shaded(_likely(lips, found.skin) if usual else lips, COLOURS.lip_shading)
    skin = sound(fit_mixture(samples, found.bare, COLOURS.skin_components))
    return assembled(skin, with_shade(lips) if usual else lips, found.inside, reference)


@dataclass(frozen=True, eq=False)
class _Separated:
    """Skin and what is inside the mouth, and which pixels the classes learn from, (N,) each.

    `bare` and `own` are how probably a pixel shows skin, and the lips that are learned, where they
    are expected: lips not in their own shade, or all that are painted.
    """

    skin: Mixture
    inside: Mixture
    bare: FloatArray
    own: FloatArray


def _separated(
    samples: FloatArray, prior: FloatArray, skin: Mixture, lips: Mixture, held: Mixture | None
) -> _Separated:
    """Expectation maximisation from a guess of the lips, at first held to anybody's if asked to.

    Held to the end they would stay broad, and take shaded teeth to themselves. Lips that are not
    held are painted: how they look in their own shade is not known, and all of them are learned.
    """
    around, core = prior[0] > 0.5, prior[1] > COLOURS.core * prior[1].max()
    anchor = inside = inside_guess(skin)
    strength = COLOURS.inside_held * prior[1].sum()
    count = COLOURS.lips_held * float(prior[1] @ core)
    for turn in range(COLOURS.rounds):
        whole = lips if held is None else with_shade(lips)
        share = posterior((skin, whole, inside), samples, prior)
        bare = share[0] * around
        own = share[1] * core * (1.0 if held is None else lit_share(whole, samples))
        if held is not None and 2 * turn < COLOURS.rounds:
            lips = lips.anchored(samples, own, held, count)
        elif own.sum() >= COLOURS.least_pixels:
            lips = shaded(lips.updated(samples, own), COLOURS.lip_shading)
        inside = less_red(inside.anchored(samples, share[2], anchor, strength), lips)
        skin = sound(skin.updated(samples, bare))
    return _Separated(skin, inside, bare, own)


def typical_classes(
    images: Sequence[NDArray[np.generic]], places: Sequence[FloatArray], plain: bool = False
) -> ColourClasses:
    """The classes of anybody beside the skin that a clip shows; errors as `learn_classes`.

    Only skin is learned, from where it is surely expected: where exactly the mouth is, and whether
    it is open, need not be known. If `plain`, skin is held to one component: lips that lie where
    skin was expected do not get one of their own then.
    """
    prior, pixels = _chosen(images, places)
    samples, reference, certain = sampled(prior, pixels)
    _enough("skin", prior[0] * certain)
    skin = skin_of(samples[certain], 1 if plain else COLOURS.skin_components)
    return assembled(skin, typical_lips(skin), inside_guess(skin), reference)


def border_axis(skin: Mixture, lips: Mixture) -> FloatArray:
    """By how much skin and lips mix at their border, (3,) in `features`."""
    return np.asarray(COLOURS.mix * (lips.weights @ lips.means - skin.weights @ skin.means))


def assembled(skin: Mixture, lips: Mixture, inside: Mixture, reference: float) -> ColourClasses:
    """The four classes, those of skin and lips widened by how they mix at their border."""
    axis = border_axis(skin, lips)
    skin, lips = bordered(skin, axis), bordered(lips, axis)
    parts = {"skin": skin, "lips": lips, "teeth": inside.part(TEETH), "dark": inside.part(DARK)}
    priors = np.r_[1.0, 1.0, inside.weights[TEETH].sum(), inside.weights[DARK].sum()]
    return ColourClasses({c: parts[c] for c in CLASSES}, priors, reference)


def placed(
    images: Sequence[NDArray[np.generic]], places: Sequence[FloatArray]
) -> tuple[FloatArray, FloatArray, IntArray]:
    """Prior (K, N) and RGB values (N, 3) of pixels in any place, thinned, and which they are."""
    prior = np.concatenate([p.reshape(len(p), -1) for p in places], axis=1)
    pixels = np.concatenate([np.asarray(i, np.float64).reshape(-1, 3) for i in images])
    keep = np.flatnonzero(prior.sum(axis=0) > COLOURS.least_place)
    keep = keep[:: max(1, -(-len(keep) // COLOURS.most_pixels))]
    return prior[:, keep], pixels[keep], keep


def sampled(prior: FloatArray, pixels: FloatArray) -> tuple[FloatArray, float, BoolArray]:
    """Features (N, 3) of pixels, the luminance of skin, and which pixels are certainly skin."""
    certain = np.asarray(prior[0] > COLOURS.certain * prior[0].max())
    reference = float(np.median(luminance(pixels)[certain]))
    return features(pixels, reference), reference, certain


def _chosen(
    images: Sequence[NDArray[np.generic]], places: Sequence[FloatArray]
) -> tuple[FloatArray, FloatArray]:
    """Priors (3, N) and RGB values (N, 3) of the pixels that are learned from."""
    prior, pixels, _ = placed(images, places)
    if not (prior.size and prior[:2].max(axis=1).min() > COLOURS.least_shown):
        raise FaceNotFoundError(
            "no skin and lips lie where the mouth was looked for",
            "give the mouth's box with --mouth X Y WIDTH HEIGHT in pixels of the first frame",
        )
    return prior, pixels


def _enough(name: str, weight: FloatArray) -> None:
    count = float(weight.sum())
    if count < COLOURS.least_pixels:
        raise TooFewPixelsError(
            f"only {count:.0f} pixels show {name}, "
            f"{COLOURS.least_pixels} are needed to learn their colour",
            "leave out --start blobs, or give the colours of another run with --colours FILE",
        )


def bordered(mixture: Mixture, axis: FloatArray) -> Mixture:
    """The mixture widened along `axis`, from skin to lips.

    Pixels on the border mix both colours. Of two classes the wider one would take them all, and
    lips vary more than skin: the drawn lips would grow by a pixel.
    """
    return Mixture(mixture.weights, mixture.means, mixture.covariances + np.outer(axis, axis))


def mixed_with(skin: Mixture, lips: Sequence[Mixture]) -> tuple[Mixture, float]:
    """Skin with the colours in which it mixes with each lip, and by how much more frequent it is.

    Where lips turn to skin over several pixels, those in between count as lips if these vary more
    than skin does, and the drawn lips grow by a pixel or two. `COLOURS.mixed_until` of the way from
    skin to a lip, what is returned is at least as dense as the lip. Lips with the skin's own chroma
    are left out. Each lip is of `with_shade`: its last component, in shade, does not count.
    """
    found = [part for lip in lips if (part := _between(skin, lip)) is not None]
    share = 1 + sum(float(part.weights[0]) for part in found)
    weights = np.concatenate([skin.weights, *(part.weights for part in found)])
    means = np.vstack([skin.means, *(part.means for part in found)])
    covariances = np.concatenate([skin.covariances, *(part.covariances for part in found)])
    return Mixture(weights / share, means, covariances), share


def _between(skin: Mixture, lip: Mixture) -> Mixture | None:
    """Colours that skin lacks of those that mix it with a lip; None if it lacks none."""
    lit, own = lip.part(slice(0, len(lip.weights) - 1)).as_one(), skin.weights @ skin.means
    way = lit.means[0] - own
    border = (own + COLOURS.mixed_until * way)[None]
    lacking = lip.density(border) - skin.density(border)
    if np.linalg.norm(way[:2]) < COLOURS.least_mixed or float(lacking[0]) <= 0:
        return None
    across = np.eye(3) - np.outer(way, way) / (way @ way)
    within = np.tensordot(lip.weights, lip.covariances, 1)
    spread = across @ within @ across + COLOURS.mixed_spread**2 * np.outer(way, way)
    one = Mixture(np.ones(1), (own + COLOURS.mixed_way * way)[None], spread[None])
    return replace(one, weights=lacking / one.density(border))


def shaded(mixture: Mixture, amount: float) -> Mixture:
    """The mixture with its luminance less certain by `amount` (standard deviation)."""
    covariances = mixture.covariances.copy()
    covariances[:, 2, 2] += amount**2
    return Mixture(mixture.weights, mixture.means, covariances)


def posterior(mixtures: Sequence[Mixture], samples: FloatArray, prior: FloatArray) -> FloatArray:
    """Probability (K, N) of K classes, given their priors (K, N) by place; the rest is none."""
    joint = np.stack([m.density(samples) for m in mixtures]) * prior
    # a flat density over the colour cube
    rest = np.maximum(1 - prior.sum(axis=0), COLOURS.elsewhere)
    return np.asarray(joint / (joint.sum(axis=0) + rest))


def skin_of(samples: FloatArray, components: int = COLOURS.skin_components) -> Mixture:
    """Skin colours without those that are farthest from the rest (nostrils, background)."""
    first = single(samples, np.ones(len(samples))).density(samples)
    core = samples[first >= np.quantile(first, COLOURS.stray_skin)]
    return sound(fit_mixture(core, np.ones(len(core)), components))


def sound(skin: Mixture) -> Mixture:
    """Skin as it was fitted, less what are teeth, in whatever shade."""
    return shaded(without_teeth(skin), COLOURS.skin_shading)


def _reddest(samples: FloatArray, prior: FloatArray, skin: Mixture) -> Mixture:
    """The reddest part of where lips are expected: for lips that are painted, or in odd light."""
    centre = skin.weights @ skin.means
    redness = (samples[:, 0] - centre[0]) - (samples[:, 1] - centre[1])
    expected = prior > COLOURS.painted_place * prior.max()
    threshold = np.quantile(redness[expected], COLOURS.painted_part)
    return single(samples, prior * (redness >= threshold) * expected)


def _likely(lips: Mixture, skin: Mixture) -> Mixture:
    """The components that are not greener than this skin, as teeth are; the least green if all."""
    green = lips.means[:, 1] - skin.weights @ skin.means[:, 1]
    return lips.part(np.flatnonzero(green <= max(0.0, green.min())))
