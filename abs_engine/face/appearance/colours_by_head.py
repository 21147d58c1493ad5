"""Learning the colour classes of a clip where a placed head shows them, each lip by itself.

Nothing is assumed of how lips differ from skin: what lies where the landmarks and the drawn head
put a lip is what that lip looks like. Few or unsure pixels make a class wide, and no person is
refused for them; how well the classes can be told apart is measured (`separability`).

Where a clip shows the mouth shut, lips are learned from that above all: of a parted mouth gums,
tongue and teeth may lie where its lips are expected, and all frames would then be fitted to them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.arrays import FloatArray
from abs_engine.core.errors import FaceNotFoundError
from abs_engine.core.threads import in_threads
from abs_engine.face.appearance.colour import ColourClasses
from abs_engine.face.appearance.colour_features import EACH_LIP
from abs_engine.face.appearance.colour_learning import (
    assembled,
    border_axis,
    bordered,
    mixed_with,
    placed,
    posterior,
    sampled,
    shaded,
    skin_of,
    sound,
)
from abs_engine.face.appearance.colour_prior import (
    inside_guess,
    less_red,
    lit_share,
    typical_lips,
    with_shade,
)
from abs_engine.face.appearance.mixture import Mixture, fit_mixture
from abs_engine.face.settings.colour import COLOURS

PLACES = ("skin", *EACH_LIP, "inside")
WIDTH = np.array(COLOURS.lip_width)
PLACE = np.array(COLOURS.lip_place)


def learn_placed(
    images: Sequence[NDArray[np.generic]], places: Sequence[FloatArray], chromatic: bool
) -> ColourClasses:
    """Skin, upper lip, lower lip, teeth and dark of a clip.

    Expectation maximisation in which a pixel's prior over the classes comes from its place.

    Parameters
    ----------
    images : sequence of (H, W, 3), RGB
    places : sequence of (4, H, W) float64
        Prior probability of each of `PLACES` at each pixel; the rest to 1 is "none of them".
    chromatic : bool
        Whether the clip is in colour: by brightness alone, what is between skin and lips may as
        well be lit lips.

    Returns
    -------
    ColourClasses
        With a mixture of each lip and their `separability`.

    Raises
    ------
    FaceNotFoundError
        If the places hold no skin or no lips: they lie outside of the picture.
    """
    prior, pixels, sure = _chosen(images, places)
    samples, reference, certain = sampled(prior, pixels)
    skin, inside, lips, share = _separated(samples, prior, sure, skin_of(samples[certain]))

    def learned(place: str) -> Mixture:
        k = PLACES.index(place)
        if place == "skin":
            return sound(fit_mixture(samples, share[k] * _around(prior), COLOURS.skin_components))
        return _finished(samples, sure * share[k] * _core(prior[k]), lips[EACH_LIP.index(place)])

    skin, *found = in_threads(learned, ("skin", *EACH_LIP))
    each = dict(zip(EACH_LIP, found, strict=True))
    both = _joined(list(each.values()))
    whole = assembled(skin, both, inside, reference)
    axis = border_axis(skin, both)
    told = {n: _told_apart(samples, prior, k, skin, each[n]) for k, n in enumerate(EACH_LIP, 1)}
    wide = {n: bordered(m, axis) for n, m in each.items()}
    mixed, more = mixed_with(whole.mixtures["skin"], list(wide.values()) if chromatic else [])
    return replace(
        whole,
        mixtures=whole.mixtures | wide | {"skin": mixed},
        priors=whole.priors * np.r_[more, 1.0, 1.0, 1.0],
        separability=told,
        chromatic=chromatic,
        mixed=len(mixed.weights) - len(whole.mixtures["skin"].weights),
    )


def _around(prior: FloatArray) -> NDArray[np.bool_]:
    """Pixels (N,) where skin is likelier than not, or as likely as anywhere in the clip."""
    return np.asarray(prior[0] > min(0.5, COLOURS.certain * float(prior[0].max())))


def _core(prior: FloatArray) -> NDArray[np.bool_]:
    return np.asarray(prior > COLOURS.core * prior.max())


def _separated(
    samples: FloatArray, prior: FloatArray, sure: FloatArray, skin: Mixture
) -> tuple[Mixture, Mixture, list[Mixture], FloatArray]:
    """Skin, inside, the two lips, and the probability (4, N) of each place's class.

    `sure` (N,) is the weight with which lips are learned from each pixel.
    """
    anchor = inside = inside_guess(skin)
    lips = [
        _drawn(_guess(samples, sure * prior[k] * _core(prior[k]), typical_lips(skin)), skin)
        for k in (1, 2)
    ]
    strength = COLOURS.inside_held * prior[1:3].sum()
    share = prior
    for _ in range(COLOURS.rounds):
        share = posterior([skin, *(with_shade(m) for m in lips), inside], samples, prior)
        own = [
            sure * share[k] * _core(prior[k]) * lit_share(with_shade(m), samples)
            for k, m in zip((1, 2), lips, strict=True)
        ]
        lips = [
            _drawn(
                m.anchored(samples, w, replace(_wide(m), weights=m.weights), COLOURS.lip_held), skin
            )
            for m, w in zip(lips, own, strict=True)
        ]
        inside = less_red(inside.anchored(samples, share[3], anchor, strength), _joined(lips))
        skin = sound(skin.updated(samples, share[0] * _around(prior)))
    return skin, inside, lips, share


def _guess(samples: FloatArray, weight: FloatArray, usual: Mixture) -> Mixture:
    """A lip by the median of where it is expected: what else shows there is the lesser part.

    One that is seen nowhere is taken for anybody's.
    """
    if not weight.any():
        return usual
    order = np.argsort(samples, axis=0)
    share = np.cumsum(weight[order], axis=0) / max(float(weight.sum()), 1e-9)
    middle = [samples[order[np.searchsorted(share[:, d], 0.5), d], d] for d in range(3)]
    return Mixture(np.ones(1), np.array([middle]), np.diag(WIDTH**2)[None])


def _drawn(lip: Mixture, skin: Mixture) -> Mixture:
    """A lip drawn towards anybody's beside such skin, as its place may be off (see `PLACE`)."""
    usual = typical_lips(skin)
    spread = np.diag(usual.covariances[0])
    share = PLACE**2 / (PLACE**2 + spread)
    return replace(lip, means=lip.means + share * (usual.means[0] - lip.means))


def _wide(mixture: Mixture) -> Mixture:
    """A mixture as wide as a lip of which nothing is known."""
    return replace(mixture, covariances=np.repeat(np.diag(WIDTH**2)[None], len(mixture.weights), 0))


def _finished(samples: FloatArray, weight: FloatArray, lip: Mixture) -> Mixture:
    """A lip with as many components as its pixels ask for, widened where they are few."""
    weight = weight * lit_share(with_shade(lip), samples)
    few = weight.sum() < COLOURS.lip_fitted
    found = lip if few else fit_mixture(samples, weight, COLOURS.lip_components)
    return with_shade(
        shaded(found.anchored(samples, weight, _wide(found), COLOURS.lip_held), COLOURS.lip_shading)
    )


def _joined(mixtures: Sequence[Mixture]) -> Mixture:
    """All of the mixtures, each as frequent."""
    return Mixture(
        np.concatenate([m.weights for m in mixtures]) / len(mixtures),
        np.vstack([m.means for m in mixtures]),
        np.concatenate([m.covariances for m in mixtures]),
    )


def _told_apart(
    samples: FloatArray, prior: FloatArray, place: int, skin: Mixture, lip: Mixture
) -> float:
    """Probability that a pixel of skin or of this lip is classified correctly: 0.5 to 1."""
    densities = np.stack([skin.density(samples), lip.density(samples)])
    right = densities / np.maximum(densities.sum(axis=0), 1e-300)
    surely = [prior[k] * _core(prior[k]) for k in (0, place)]
    means = [w @ r / max(float(w.sum()), 1e-9) for w, r in zip(surely, right, strict=True)]
    return float(np.mean(means))


def _sure(places: Sequence[FloatArray]) -> FloatArray:
    """Weight (N,) with which lips are learned from each pixel.

    1 for all where too few frames show the mouth shut.
    """
    inside = PLACES.index("inside")
    # not seen: outside of the picture
    seen = [p[1:inside].max(initial=0.0) > COLOURS.least_shown for p in places]
    closed = [p[inside].max(initial=0.0) < COLOURS.parted for p in places]
    shut = np.logical_and(seen, closed)
    least = COLOURS.parted_weight if shut.sum() >= COLOURS.least_shut else 1.0
    return np.repeat(np.where(shut, 1.0, least), [p[0].size for p in places])


def _chosen(
    images: Sequence[NDArray[np.generic]], places: Sequence[FloatArray]
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Priors (4, N), RGB values (N, 3) and weights for lips (N,) of the pixels learned from."""
    prior, pixels, keep = placed(images, places)
    if not (prior.size and min(prior[0].max(), prior[1:3].max()) > COLOURS.least_shown):
        raise FaceNotFoundError(
            "the mouth lies outside of the picture in the frames that were looked at",
            "give a video that shows the mouth",
        )
    return prior, pixels, _sure(places)[keep]
