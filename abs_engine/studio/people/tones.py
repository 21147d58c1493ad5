"""Colours of skin and lips."""

from __future__ import annotations

import numpy as np

from abs_engine.core.errors import ParameterError
from abs_engine.face.appearance.luminance import luminance

Colour = tuple[int, int, int]

SKIN_TONES: dict[str, Colour] = {
    "very_light": (241, 208, 190),
    "light": (229, 186, 163),
    "light_medium": (222, 175, 146),
    "medium": (206, 155, 124),
    "tan": (180, 130, 98),
    "brown": (146, 98, 70),
    "dark_brown": (108, 72, 52),
    "very_dark": (74, 50, 40),
}
"""Skin in even steps from the lightest to the darkest, sRGB medians of forehead, cheeks and nose.

light, tan, brown and dark_brown are those that the shipped textures were painted with; the others
lie between or continue the row. The scale is this project's own.
"""
_LIP_SHARES = {50.0: (1.14, 0.98, 1.16), 80.0: (1.09, 0.92, 1.15), 109.0: (1.04, 0.82, 1.08),
               141.0: (0.84, 0.68, 0.82), 196.0: (0.83, 0.57, 0.64)}  # fmt: skip
"""Colour of the lips over that of the skin, for skin of some lumas: from the shipped textures."""


def skin_tone(name: str) -> Colour:
    """A tone of the scale by its name.

    Raises
    ------
    ParameterError
        If there is no such tone.
    """
    if name not in SKIN_TONES:
        raise ParameterError(
            f"there is no skin tone '{name}'", f"choose one of {', '.join(SKIN_TONES)}"
        )
    return SKIN_TONES[name]


def tone_at(place: float) -> Colour:
    """The tone at a place on the scale, from 0 (lightest) to 1 (darkest); straight in between."""
    scale = np.array(list(SKIN_TONES.values()), float)
    at = np.clip(place, 0, 1) * (len(scale) - 1)
    return _rounded(np.array([np.interp(at, range(len(scale)), c) for c in scale.T]))


def lip_colour(skin: Colour) -> Colour:
    """The colour of unpainted lips that goes with a skin."""
    shares = np.array(list(_LIP_SHARES.values()))
    luma = float(luminance(np.array(skin)))
    share = [np.interp(luma, list(_LIP_SHARES), column) for column in shares.T]
    return _rounded(np.array(share) * skin)


def _rounded(values: np.ndarray) -> Colour:
    red, green, blue = (int(v) for v in np.clip(np.rint(values), 0, 255))
    return red, green, blue
