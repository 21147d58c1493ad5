"""Probability maps of colour classes over a picture.

All densities are computed at once and in single precision, since every frame needs them.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.arrays import FloatArray
from abs_engine.face.appearance.colour_features import CLASSES, EACH_LIP, features
from abs_engine.face.appearance.colour_prior import beside_teeth
from abs_engine.face.appearance.hamming import hamming
from abs_engine.face.appearance.mixture import Mixture, Mixtures, Singles
from abs_engine.face.appearance.mouth_area import MouthPlace
from abs_engine.face.settings.colour import COLOURS

_SKIN, _LIPS, _TEETH, _DARK = range(len(CLASSES))
_LEAST = np.float32(1e-30)  # a density that is none


@dataclass(frozen=True, eq=False)
class Palette:
    """The colours of a clip's classes, ready to be compared with pixels.

    Parameters
    ----------
    mixtures, priors, reference, chromatic
        As `ColourClasses` has them.
    """

    mixtures: Mapping[str, Mixture]
    priors: FloatArray
    reference: float
    chromatic: bool

    def compared(self, image: NDArray[np.generic]) -> ComparedColours:
        """Pixels of an image (H, W, 3), RGB 0 to 255, beside every class."""
        samples = features(image, self.reference).reshape(-1, 3).astype(np.float32)
        parts = self._all.components(samples)
        teeth = parts[self._all.of(_TEETH)]
        lit = 1 - teeth[-1] / np.maximum(teeth.sum(axis=0), _LEAST)
        shape = image.shape[0], image.shape[1]
        return ComparedColours(self, self._all.added(parts), lit, samples[:, 2], shape)

    @property
    def lips_apart(self) -> bool:
        """Whether each lip has colours of its own."""
        return all(name in self.mixtures for name in EACH_LIP)

    @cached_property
    def floor(self) -> np.float32:
        """Density of what belongs to no class."""
        skin, lips, *inside = (self.mixtures[c].peak for c in CLASSES)
        weighted = (float(p) * peak for p, peak in zip(self.priors[2:], inside, strict=True))
        return np.float32(COLOURS.outlier * min(skin, lips, max(weighted)))

    @cached_property
    def weights(self) -> Singles:
        """Prior weight of each class, (4,)."""
        return self.priors.astype(np.float32)

    @cached_property
    def black(self) -> np.float32:
        """Weighted density of the dark at its middle."""
        return np.float32(self.priors[_DARK] * self._dark.density(self._dark.means[:1])[0])

    @cached_property
    def deep(self) -> np.float32:
        """Luminance below which chroma says nothing, a feature."""
        return np.float32(self._dark.means[0, 2])

    @property
    def _dark(self) -> Mixture:
        return self.mixtures["dark"]

    @cached_property
    def _all(self) -> Mixtures:
        """The classes, then each lip where it is known, and each where it took chroma of teeth."""
        own = [self.mixtures[name] for name in EACH_LIP if self.lips_apart]
        pale = [beside_teeth(lip, self.mixtures["teeth"]) for lip in own]
        return Mixtures((*(self.mixtures[name] for name in CLASSES), *own, *pale))


@dataclass(frozen=True, eq=False)
class ComparedColours:
    """Pixels of a picture beside the classes of a clip.

    Parameters
    ----------
    palette : Palette
    densities : (4 or 8, N) float32
        Of the classes; then of the upper and the lower lip as they are, and beside teeth.
    lit : (N,) float32
        Probability that teeth seen there lie in light.
    luminance : (N,) float32
        As a feature.
    shape : (int, int)
        Height and width.
    """

    palette: Palette
    densities: Singles
    lit: Singles
    luminance: Singles
    shape: tuple[int, int]

    def probabilities(self, smoothing: float = 0.0, place: MouthPlace | None = None) -> FloatArray:
        """Probability maps of the classes, (4, H, W); see `ColourClasses.probabilities`."""
        likelihood = self.densities[: len(CLASSES)] * self.palette.weights[:, None]
        if place is not None:
            likelihood = self._placed(likelihood, place)
        total = likelihood.sum(axis=0) + self.palette.floor
        maps = np.asarray(likelihood / total, np.float64).reshape(-1, *self.shape)
        return hamming(maps, smoothing) if smoothing > 0 else maps

    def teeth_in_shade(self) -> FloatArray:
        """Probability (H, W) that teeth seen at each pixel lie in shade."""
        return np.asarray(1 - self.lit, np.float64).reshape(self.shape)

    def _placed(self, likelihood: Singles, place: MouthPlace) -> Singles:
        """The classes' weighted densities (4, N) with what the place of the mouth says."""
        skin, lips, teeth, dark = likelihood
        elsewhere, within, upper = (
            share.ravel().astype(np.float32)
            for share in (1 - place.beyond, place.within, place.upper)
        )
        if self.palette.lips_apart:
            above, below, *pale = self.densities[len(CLASSES) :]
            beside = self._beside_teeth(likelihood, place)
            above, below = above + beside * pale[0], below + beside * pale[1]
            lips = self.palette.weights[_LIPS] * (upper * above + (1 - upper) * below)
        # the chroma of what is darker yet says nothing
        black = np.where(self.luminance < self.palette.deep, self.palette.black, np.float32(0))
        teeth = teeth + np.float32(COLOURS.pale_teeth) * within * skin
        return np.stack(
            [
                skin * (1 - within), lips * elsewhere, teeth * elsewhere,
                np.maximum(dark, black) * elsewhere,
            ]
        )  # fmt: skip

    def _beside_teeth(self, likelihood: Singles, place: MouthPlace) -> Singles:
        """Weight, at each pixel (N,), of lips that have taken on the chroma of teeth beside them.

        It is a share of how surely bright teeth are as near as chroma mixes, where there is chroma,
        and is added to that of lips as they are elsewhere: else these would seem rarer by teeth,
        and closed lips in poor light parted.
        """
        if not self.palette.chromatic:
            return np.zeros_like(self.lit)
        seen = self.lit * likelihood[_TEETH] / np.maximum(likelihood.sum(axis=0), _LEAST)
        return (COLOURS.beside_teeth_part * place.mixed(seen)).astype(np.float32)
