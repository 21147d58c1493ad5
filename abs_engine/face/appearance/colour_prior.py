"""Colours of anybody's mouth beside a skin: where learning a clip's own begins, and is held to.

Colours are in `features`: r, g, and a third of the logarithm of luminance relative to the skin.
"""

from __future__ import annotations

import numpy as np

from abs_engine.core.arrays import FloatArray
from abs_engine.face.appearance.mixture import Mixture
from abs_engine.face.settings.colour import COLOURS

DARK, TEETH = slice(0, 1), slice(1, 4)
"""Components of the mixture of what is inside a mouth."""
_LIT_TEETH, _SHADED_TEETH = 2, 3  # of the same
_LIPS_MEAN = np.array(COLOURS.lips_mean)
_LIPS_SPREAD = np.array(COLOURS.lips_spread)
_LIPS_NOISE = np.diag(COLOURS.lips_noise)
_LIP_SHADE_MEAN = np.array(COLOURS.lip_shade_mean)
_LIP_SHADE_SPREAD = np.diag(np.array(COLOURS.lip_shade_spread) ** 2)


def typical_lips(skin: Mixture) -> Mixture:
    """Lips of anybody beside this skin."""
    centre = skin.weights @ skin.means + _LIPS_MEAN
    return Mixture(np.ones(1), centre[None], _LIPS_SPREAD[None] + _LIPS_NOISE)


def with_shade(lips: Mixture) -> Mixture:
    """Lips, lit ones given, with those in their own shade as one more component, the last.

    Without it the mouth's inside would learn them, and lips that are closed would seem parted.
    """
    centre = lips.weights @ lips.means + _LIP_SHADE_MEAN
    return Mixture(
        np.append((1 - COLOURS.lip_shade_part) * lips.weights, COLOURS.lip_shade_part),
        np.vstack([lips.means, centre]),
        np.concatenate([lips.covariances, _LIP_SHADE_SPREAD[None]]),
    )


def beside_teeth(lips: Mixture, teeth: Mixture) -> Mixture:
    """Lips, of `with_shade`, where they touch teeth, of which the last component is in shade.

    Video keeps chroma at half the resolution of luminance, so that the dark edge of a lip takes on
    the chroma of bright teeth beside it, and looks as teeth in shade do: an opening would seem a
    pixel higher than it is.
    """
    own, lit = (m.part(slice(0, max(1, len(m.weights) - 1))).as_one() for m in (lips, teeth))
    paler = COLOURS.beside_teeth_way * (lit.means[0] - own.means[0]) * [1, 1, 0]
    darker = np.array([0.0, 0.0, COLOURS.beside_teeth_darker])
    spread = own.covariances + 0.25 * np.outer(paler, paler) + np.outer(darker, darker)
    return Mixture(np.ones(1), own.means + paler - darker, spread)


def lit_share(mixture: Mixture, samples: FloatArray) -> FloatArray:
    """Probability (N,) that lips, of `with_shade`, or teeth are not in shade, the last part."""
    parts = mixture.densities(samples)
    return np.asarray(1 - parts[:, -1] / np.maximum(parts.sum(axis=1), 1e-300))


def less_red(inside: Mixture, lips: Mixture) -> Mixture:
    """The inside of a mouth, teeth in shade held to be less red than lips.

    Else they would learn the lips' own shade where full lips meet. Those in shade are about
    half-way between lips and lit teeth where they were looked at; lips in shade redden.
    """
    means, redder = inside.means.copy(), np.array([1.0, -1.0])
    away = (means[_LIT_TEETH] - lips.weights @ lips.means)[:2]
    least = redder @ means[_LIT_TEETH, :2] - (1 - COLOURS.less_red) * redder @ away
    excess = redder @ means[_SHADED_TEETH, :2] - least
    if redder @ away < 0 < excess:
        # lips as pale as teeth leave no direction: never farther than from lips to teeth
        means[_SHADED_TEETH, :2] += min(1.0, excess / -(redder @ away)) * away
    return Mixture(inside.weights, means, inside.covariances)


def without_teeth(skin: Mixture) -> Mixture:
    """Skin without components as pale as teeth: those of a smile that was taken for closed lips.

    A pale component that is frequent stays: skin under two lights. In clips where no teeth were
    learned for skin, none was paler than the most frequent one by 0.4 of the way to teeth; where
    they were, it was so by 1.6, and a sixteenth of the skin.
    """
    centre = skin.means[skin.weights.argmax()]
    way = _teeth_beside(centre) - centre[:2]
    pale = (skin.means - centre)[:, :2] @ way > COLOURS.palest * (way @ way)
    return skin.part(np.flatnonzero(~pale | (skin.weights > COLOURS.frequent)))


def _teeth_beside(skin: FloatArray) -> FloatArray:
    """Chromaticity (2,) of teeth beside skin of this colour (3,)."""
    light = np.array([skin[0], skin[1], 1 - skin[0] - skin[1]]) / COLOURS.skin_chroma
    return np.asarray(0.5 * (skin[:2] + light[:2] / light.sum()))


def inside_guess(skin: Mixture) -> Mixture:
    """Dark of the mouth, then teeth in light and in the lips' shade, from the skin's colour.

    What skin is like in neutral light (`COLOURS.skin_chroma`) gives the light's own chromaticity;
    teeth lie half-way between. The dark is red. Teeth that a smile bares are a little brighter than
    skin. Others are darker, and those in shade, lit by what the lips throw back, lie between teeth
    and dark.
    """
    centre = skin.weights @ skin.means
    teeth = _teeth_beside(centre)
    dark = np.r_[centre[:2], 0.0] + COLOURS.dark
    bright, bared = (np.array([*teeth, light]) for light in (COLOURS.teeth, COLOURS.bared_teeth))
    shade = 0.5 * (dark + bright)
    covariances = np.stack([np.diag(s**2) for s in np.array(COLOURS.inside_spread)])
    return Mixture(
        np.array(COLOURS.inside_parts), np.stack([dark, bared, bright, shade]), covariances
    )
