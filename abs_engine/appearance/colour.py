"""Colour classes: skin, lips, and what shows between parted lips, as probability maps.

Basu et al. (section 5.1) learn skin and lips in chromatic space (r, g). Lips that part are told
by neither class: teeth and the dark of the mouth are a class of their own here, and need
luminance; so all classes live in (r, g, y), y the logarithm of luminance relative to the skin.
Between skin and lips chromaticity is to decide, as in the paper: their luminance, which shading
below the lip and at the corners changes, is taken as less certain than it was in the samples.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from abs_engine.appearance.mixture import Mixture, fit_mixture, single
from abs_engine.errors import FaceNotFoundError

FloatArray = NDArray[np.float64]
CLASSES = ("skin", "lips", "interior")
_LUMA = np.array([0.299, 0.587, 0.114])
_OUTLIER = 2e-4  # share of the lowest peak density below which a colour belongs to no class
_SKIN_SHADING, _LIP_SHADING = 0.03, 0.015  # added spread of a third of log luminance
_CORE = 0.6  # of the largest prior: where lips are expected surely enough to learn from
_MIX = 0.2  # of the way from skin to lips: spread of both by mixing at their border
_SKIN_COMPONENTS, _LIP_COMPONENTS = 3, 2


def features(image: NDArray[np.generic], reference: float) -> FloatArray:
    """Colour features of an image.

    Parameters
    ----------
    image : (..., 3), RGB 0 to 255
    reference : float
        Luminance of the skin, 0 to 255.

    Returns
    -------
    (..., 3) float64
        r, g (chromaticity; (R + 1) / (R + G + B + 3), which is 1/3 at black) and a third of the
        natural logarithm of relative luminance, so that the three have like spreads.
    """
    rgb = np.asarray(image, np.float64)
    total = rgb.sum(axis=-1) + 3
    luminance = np.log((rgb @ _LUMA + 2) / (reference + 2)) / 3
    return np.stack([(rgb[..., 0] + 1) / total, (rgb[..., 1] + 1) / total, luminance], axis=-1)


@dataclass(frozen=True, eq=False)
class ColourClasses:
    """Densities of skin, lips and interior in colour space.

    Parameters
    ----------
    mixtures : mapping of class name to Mixture
    reference : float
        Luminance of the skin.
    """

    mixtures: dict[str, Mixture]
    reference: float

    def probabilities(self, image: NDArray[np.generic], smoothing: float = 0.0) -> FloatArray:
        """Probability maps of the classes.

        Parameters
        ----------
        image : (H, W, 3), RGB 0 to 255
        smoothing : float
            Width in pixels of the Hamming window that the maps are convolved with; 0 for none.

        Returns
        -------
        (3, H, W) float64
            P(class | colour) for equal class priors, in the order of `CLASSES`; colours that are
            far from every class belong to none.
        """
        shape = image.shape[:2]
        samples = features(image, self.reference).reshape(-1, 3)
        likelihood = np.stack([self.mixtures[c].density(samples) for c in CLASSES])
        floor = _OUTLIER * min(_peak(self.mixtures[c]) for c in CLASSES)
        maps = (likelihood / (likelihood.sum(axis=0) + floor)).reshape(-1, *shape)
        return hamming(maps, smoothing) if smoothing > 0 else maps


def _peak(mixture: Mixture) -> float:
    return float(mixture.density(mixture.means).max())


def hamming(maps: FloatArray, width: float) -> FloatArray:
    """Convolve maps (C, H, W) with a separable Hamming window `width` px wide (Basu, 5.1)."""
    size = 2 * int(np.ceil(width / 2)) + 1
    offset = np.arange(size) - size // 2
    inside = np.abs(offset) <= width / 2
    window = np.where(inside, 0.54 + 0.46 * np.cos(2 * np.pi * offset / max(width, 1e-9)), 0.0)
    window /= window.sum()
    return np.stack(
        [cv2.sepFilter2D(m, -1, window, window, borderType=cv2.BORDER_REPLICATE) for m in maps]
    )


def learn_classes(
    images: Sequence[NDArray[np.generic]],
    places: Sequence[FloatArray],
    rounds: int = 10,
    most: int = 12_000,
) -> ColourClasses:
    """Learn the classes from a clip, given where each class is expected.

    Expectation maximisation in which a pixel's prior over the classes comes from its place. Lips
    learn only where lips are surely expected, skin where it is likelier than not; the interior,
    which may hardly show in the clip, is held near what its colours are like in anybody.

    Parameters
    ----------
    images : sequence of (H, W, 3), RGB
    places : sequence of (3, H, W) float64
        Prior probability of each class at each pixel; the rest to 1 is "none of them".
    rounds : int
    most : int
        Largest number of pixels used, evenly spread.

    Returns
    -------
    ColourClasses

    Raises
    ------
    FaceNotFoundError
        If the places hold no skin or no lips.
    """
    prior = np.concatenate([p.reshape(len(CLASSES), -1) for p in places], axis=1)
    pixels = np.concatenate([np.asarray(i, np.float64).reshape(-1, 3) for i in images])
    keep = np.flatnonzero(prior.sum(axis=0) > 0.02)
    keep = keep[:: max(1, -(-len(keep) // most))]
    prior, pixels = prior[:, keep], pixels[keep]
    if not (prior.size and prior[:2].max(axis=1).min() > 0.2):
        raise FaceNotFoundError(
            "no skin and lips lie where the mouth was looked for",
            "give the mouth's box with --mouth X Y WIDTH HEIGHT in pixels of the first frame",
        )
    certain = prior[0] > 0.9 * prior[0].max()
    reference = float(np.median((pixels @ _LUMA)[certain]))
    samples = features(pixels, reference)
    skin = _skin(samples[certain])
    lips = _lips_guess(samples, prior[1], skin)
    anchor = interior = _interior_guess(skin)
    strength = 0.25 * prior[1].sum()
    around = prior[0] > 0.5
    core = prior[1] > _CORE * prior[1].max()
    for _ in range(rounds):
        share = _posterior(dict(zip(CLASSES, (skin, lips, interior), strict=True)), samples, prior)
        lips = shaded(lips.updated(samples, share[1] * core), _LIP_SHADING)
        interior = interior.anchored(samples, share[2], anchor, strength)
        skin = shaded(skin.updated(samples, share[0] * around), _SKIN_SHADING)
    lips = shaded(fit_mixture(samples, share[1] * core, _LIP_COMPONENTS), _LIP_SHADING)
    skin = shaded(fit_mixture(samples, share[0] * around, _SKIN_COMPONENTS), _SKIN_SHADING)
    axis = _MIX * (lips.weights @ lips.means - skin.weights @ skin.means)
    skin, lips = bordered(skin, axis), bordered(lips, axis)
    return ColourClasses(dict(zip(CLASSES, (skin, lips, interior), strict=True)), reference)


def bordered(mixture: Mixture, axis: FloatArray) -> Mixture:
    """The mixture widened along `axis`, from skin to lips.

    Pixels on the border mix both colours. Of two classes the wider one would take them all, and
    lips vary more than skin: the drawn lips would grow by a pixel.
    """
    return Mixture(mixture.weights, mixture.means, mixture.covariances + np.outer(axis, axis))


def shaded(mixture: Mixture, amount: float) -> Mixture:
    """The mixture with its luminance less certain by `amount` (standard deviation)."""
    covariances = mixture.covariances.copy()
    covariances[:, 2, 2] += amount**2
    return Mixture(mixture.weights, mixture.means, covariances)


def _posterior(mixtures: dict[str, Mixture], samples: FloatArray, prior: FloatArray) -> FloatArray:
    joint = np.stack([mixtures[c].density(samples) for c in CLASSES]) * prior
    rest = np.maximum(1 - prior.sum(axis=0), 0.02)  # a flat density over the colour cube
    return np.asarray(joint / (joint.sum(axis=0) + rest))


def _skin(samples: FloatArray) -> Mixture:
    """Skin colours without the tenth that is farthest from the rest (nostrils, background)."""
    first = single(samples, np.ones(len(samples))).density(samples)
    core = samples[first >= np.quantile(first, 0.1)]
    return shaded(fit_mixture(core, np.ones(len(core)), _SKIN_COMPONENTS), _SKIN_SHADING)


def _lips_guess(samples: FloatArray, prior: FloatArray, skin: Mixture) -> Mixture:
    """The reddest part of where lips are expected."""
    centre = skin.weights @ skin.means
    redness = (samples[:, 0] - centre[0]) - (samples[:, 1] - centre[1])
    expected = prior > 0.5 * prior.max()
    threshold = np.quantile(redness[expected], 0.4)
    return single(samples, prior * (redness >= threshold) * expected)


def _interior_guess(skin: Mixture) -> Mixture:
    """Dark of the mouth and teeth, from the skin's colour.

    Skin is taken to have the chromaticity (0.42, 0.33) in neutral light, which gives the light's
    own; teeth lie half-way between. The dark is red and has a third of the skin's luminance.
    """
    centre = skin.weights @ skin.means
    light = np.array([centre[0] / 0.42, centre[1] / 0.33, (1 - centre[0] - centre[1]) / 0.25])
    teeth = 0.5 * (centre[:2] + light[:2] / light.sum())
    means = np.array([[centre[0] + 0.03, centre[1] - 0.03, -0.37], [*teeth, -0.10]])
    spread = [np.diag([0.05**2, 0.04**2, 0.11**2]), np.diag([0.02**2, 0.02**2, 0.09**2])]
    return Mixture(np.array([0.6, 0.4]), means, np.stack(spread))
