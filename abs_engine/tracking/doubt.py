"""What speaks against a run: told in its summary, and printed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

LEAST_SEPARABILITY = 0.75
"""How probably a pixel of skin or lips is told right, below which colours say little of lips."""
LEAST_AGREEMENT = 0.7
"""Of apertures by colours alone with those by landmarks, a slope. Of p01 to p08 of the strangers'
clips six have 0.76 and more; two, which are right all the same, 0.60 and less."""
_MOST_HELD = 0.1  # of the frames
_MOST_APART, _MOST_APART_MM = 0.9, 1.0
"""How far apertures by colours and by landmarks may differ (RMS), as a share of how much those by
landmarks vary (standard deviation), and in any case, mm."""
_MOVES = 0.8  # mm, by which apertures vary in a clip that can be judged by them
_FEWEST = 10  # frames, for any of it


def doubts(
    aperture: FloatArray,
    by_landmarks: FloatArray,
    held: Sequence[bool],
    separability: Mapping[str, float],
    agreement: float = 1.0,
) -> list[str]:
    """What a user should know of a run before believing it, a line each.

    Parameters
    ----------
    aperture, by_landmarks : (T,) float64, mm
        As reported, and by the landmarks alone; NaN where nothing was found.
    held : sequence of bool, T
        Which frames were held to the landmarks.
    separability : mapping of str to float
        See `ColourClasses`.
    agreement : float
        See `ColourClasses`.
    """
    lines = []
    if separability and np.mean(list(separability.values())) < LEAST_SEPARABILITY:
        told = ", ".join(f"{k.replace('_', ' ')} {v:.0%}" for k, v in separability.items())
        lines.append(
            f"lips and skin have nearly the same colour here (told apart: {told}); the "
            "result rests more on landmarks and the prior"
        )
    if agreement < LEAST_AGREEMENT:
        lines.append(
            f"by colours alone the mouth opens {max(agreement, 0.0):.0%} as far as by landmarks: "
            "teeth or tongue may be taken for lips; look at the overlay before you use it"
        )
    both = np.isfinite(aperture) & np.isfinite(by_landmarks)
    if both.sum() >= _FEWEST:
        apart = float(np.sqrt(np.mean((aperture - by_landmarks)[both] ** 2)))
        varies = float(by_landmarks[both].std())
        if varies >= _MOVES and apart > max(_MOST_APART * varies, _MOST_APART_MM):
            lines.append(
                f"the aperture differs by {apart:.1f} mm (RMS) from what landmarks say, about as "
                "much as it varies: look at the overlay before you use it"
            )
    share = float(np.mean(held)) if len(held) else 0.0
    if share > _MOST_HELD:
        lines.append(
            f"in {share:.0%} of the frames what is drawn led off the lips; there landmarks alone "
            "are reported"
        )
    return lines
