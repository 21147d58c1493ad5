"""Colour classes from pixels whose class is known (Basu et al., section 5.1)."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.arrays import FloatArray
from abs_engine.core.errors import TooFewPixelsError
from abs_engine.face.appearance.colour import ColourClasses
from abs_engine.face.appearance.colour_features import CLASSES, features
from abs_engine.face.appearance.colour_learning import border_axis, bordered
from abs_engine.face.appearance.luminance import luminance
from abs_engine.face.appearance.mixture import Mixture, fit_mixture
from abs_engine.face.settings.colour import COLOURS


def train_classes(pixels: Mapping[str, NDArray[np.generic]], seed: int = 0) -> ColourClasses:
    """Learn the classes from pixels (N, 3), RGB 0 to 255, of each of `CLASSES`.

    Mixtures by expectation maximisation, their sizes chosen by the Bayesian information criterion:
    1 to 3 for skin, 1 or 2 for the others. `seed` is of the choice of examples where there are more
    than 6,000. Raises `TooFewPixelsError` if a class has fewer than `COLOURS.least_pixels`.
    """
    for name in CLASSES:
        count = len(pixels.get(name, ()))
        if count < COLOURS.least_pixels:
            raise TooFewPixelsError(
                f"only {count} pixels show {name}, "
                f"{COLOURS.least_pixels} are needed to learn their colour",
                "label more frames, with the mouth open and closed",
            )
    rng = np.random.default_rng(seed)
    chosen = {name: _some(np.asarray(pixels[name], np.float64), rng) for name in CLASSES}
    reference = float(np.median(luminance(chosen["skin"])))
    most = {"skin": COLOURS.skin_components, "lips": COLOURS.lip_components}
    found: dict[str, Mixture] = {}
    for name in CLASSES:
        samples = features(chosen[name], reference)
        found[name] = fit_mixture(
            samples, np.ones(len(samples)), most.get(name, COLOURS.inside_components)
        )
    skin, lips = found["skin"], found["lips"]
    axis = border_axis(skin, lips)
    found |= {"skin": bordered(skin, axis), "lips": bordered(lips, axis)}
    return ColourClasses(found, np.array([1.0, 1.0, COLOURS.inside, COLOURS.inside]), reference)


def _some(pixels: FloatArray, rng: np.random.Generator) -> FloatArray:
    if len(pixels) <= COLOURS.most_labelled:
        return pixels
    return pixels[rng.choice(len(pixels), COLOURS.most_labelled, replace=False)]
