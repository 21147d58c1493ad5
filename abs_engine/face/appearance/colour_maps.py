"""Probability maps of colour classes over a picture.

All classes are compared at once and in single precision, as every frame needs it.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.arrays import Float32Array, FloatArray
from abs_engine.face.appearance.colour_features import CLASSES, EACH_LIP, features
from abs_engine.face.appearance.colour_prior import beside_teeth, lit_share
from abs_engine.face.appearance.hamming import hamming
from abs_engine.face.appearance.mixture import Mixture, Mixtures
from abs_engine.face.appearance.mouth_area import MouthPlace
from abs_engine.face.settings.colour import COLOURS

_SKIN, _LIPS, _TEETH, _DARK = map(CLASSES.index, ("skin", "lips", "teeth", "dark"))
_LEAST = 1e-30  # below this a density counts as none


@dataclass(frozen=True, eq=False)
class Palette:
    """The colours of a clip's classes, ready to be compared with pixels; see `ColourClasses`."""

    mixtures: dict[str, Mixture]
    priors: FloatArray
    reference: float
    chromatic: bool = True
    mixed: int = 0

    def compared(self, image: NDArray[np.generic]) -> ComparedColours:
        """Pixels of an image (H, W, 3), RGB 0 to 255, beside every class: once for several maps."""
        samples = features(image, self.reference).reshape(-1, 3)
        return ComparedColours(self, samples, (image.shape[0], image.shape[1]))

    @cached_property
    def floor(self) -> np.float32:
        """Density of what belongs to no class."""
        skin, lips, *inside = (self.mixtures[c].peak for c in CLASSES)
        weighted = (float(p) * peak for p, peak in zip(self.priors[2:], inside, strict=True))
        return np.float32(max(COLOURS.outlier * min(skin, lips, max(weighted)), _LEAST))

    @cached_property
    def black(self) -> np.float32:
        """Weighted density of the dark at its middle."""
        return np.float32(self.priors[_DARK] * self._dark.density(self._dark.means[:1])[0])

    @cached_property
    def deep(self) -> float:
        """Luminance, as a feature, below which chroma says nothing."""
        return float(self._dark.means[0, 2])

    @property
    def _dark(self) -> Mixture:
        return self.mixtures["dark"]

    @cached_property
    def classes(self) -> Mixtures:
        """The mixtures of `CLASSES`."""
        return Mixtures(tuple(self.mixtures[name] for name in CLASSES))

    @cached_property
    def edges(self) -> tuple[Mixtures, np.float32] | None:
        """Skin in the colours in which it mixes with lips, and its weight; None without these."""
        if not self.mixed:
            return None
        skin, some = self.mixtures["skin"], slice(-self.mixed, None)
        weight = self.priors[_SKIN] * skin.weights[some].sum()
        return Mixtures((skin.part(some),)), np.float32(weight)

    @cached_property
    def lips(self) -> Mixtures | None:
        """Each lip, and each where it has taken on the chroma of teeth; None if not known."""
        if not all(name in self.mixtures for name in EACH_LIP):
            return None
        own = [self.mixtures[name] for name in EACH_LIP]
        return Mixtures((*own, *(beside_teeth(lip, self.mixtures["teeth"]) for lip in own)))


@dataclass(frozen=True, eq=False)
class ComparedColours:
    """Pixels (N, 3) of a picture, as `features` gives them, beside the classes of a clip.

    `shape` is the picture's height and width.
    """

    palette: Palette
    samples: FloatArray
    shape: tuple[int, int]

    def probabilities(self, smoothing: float = 0.0, place: MouthPlace | None = None) -> FloatArray:
        """Probability maps (4, H, W) of the classes: P(class | colour), in the order of `CLASSES`.

        Colours that are far from every class belong to none.

        Parameters
        ----------
        smoothing : float
            Width in pixels of the Hamming window that the maps are convolved with; 0 for none.
        place : MouthPlace, optional
            Where the mouth is known to be: what lies there is no skin, what lies elsewhere no
            mouth, and each lip is compared with its own colours, where they are known.
        """
        priors = self.palette.priors.astype(np.float32)[:, None]
        likelihood = self.palette.classes.densities(self._single) * priors
        if place is not None:
            likelihood = self._placed(likelihood, place)
        total = likelihood.sum(axis=0) + self.palette.floor
        maps = np.asarray(likelihood / total, np.float64).reshape(-1, *self.shape)
        return hamming(maps, smoothing) if smoothing > 0 else maps

    def teeth_in_shade(self) -> FloatArray:
        """Probability (H, W) that teeth seen at each pixel lie in shade."""
        return (1 - self._lit).reshape(self.shape)

    @cached_property
    def _single(self) -> Float32Array:
        return self.samples.astype(np.float32)

    @cached_property
    def _lit(self) -> FloatArray:
        """Probability (N,) that teeth lie in light.

        In double precision: single would end where colours are far from those of teeth.
        """
        return lit_share(self.palette.mixtures["teeth"], self.samples)

    def _placed(self, likelihood: Float32Array, place: MouthPlace) -> Float32Array:
        """The classes' weighted densities (4, N) with what the place of the mouth says."""
        skin, lips, teeth, dark = likelihood
        elsewhere, within, upper = (
            share.ravel().astype(np.float32)
            for share in (1 - place.beyond, place.within, place.upper)
        )
        if self.palette.lips is not None:
            above, below, *pale = self.palette.lips.densities(self._single)
            beside = self._beside_teeth(likelihood, place)
            above, below = above + beside * pale[0], below + beside * pale[1]
            prior = np.float32(self.palette.priors[_LIPS])
            lips = prior * (upper * above + (1 - upper) * below)
        # the chroma of what is darker yet says nothing
        black = (self.samples[:, 2] < self.palette.deep) * self.palette.black
        teeth = teeth + np.float32(COLOURS.pale_teeth) * within * self._plain(skin)
        return np.stack(
            [
                skin * (1 - within), lips * elsewhere, teeth * elsewhere,
                np.maximum(dark, black) * elsewhere,
            ]
        )  # fmt: skip

    def _plain(self, skin: Float32Array) -> Float32Array:
        """The weighted density (N,) of skin without that of its colours at the edges of lips.

        Teeth in shade have the colour of plain skin; that of an edge may be a lip's.
        """
        if self.palette.edges is None:
            return skin
        edges, weight = self.palette.edges
        return np.asarray(np.maximum(skin - weight * edges.densities(self._single)[0], 0))

    def _beside_teeth(self, likelihood: Float32Array, place: MouthPlace) -> Float32Array:
        """Weight, at each pixel (N,), of lips that have taken on the chroma of teeth beside them.

        It is a share of how surely bright teeth are as near as chroma mixes, where there is chroma,
        and is added to that of lips as they are elsewhere: else these would seem rarer by teeth,
        and closed lips in poor light parted.
        """
        if not self.palette.chromatic:
            return np.zeros(len(self.samples), np.float32)
        seen = self._lit * likelihood[_TEETH] / np.maximum(likelihood.sum(axis=0), _LEAST)
        return (COLOURS.beside_teeth_part * place.mixed(seen)).astype(np.float32)
