"""Warnings about a run: in its summary, and printed."""

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
NO_COLOUR = (
    "the video has no colour: its classes rest on brightness alone, and the result is less exact; "
    "landmarks and the prior go on as usual"
)
_MOST_HELD = 0.1  # of the frames
_UNSURE, _SHARE = 0.8, 0.15
"""Standard deviation of an aperture by landmarks, mm, and so much of it."""
_CONTRADICTED = 2.0
"""Standard deviations of both, from which on an aperture and the landmarks' do not agree."""
_MOST_CONTRADICTED = 0.15
"""Of the frames. Of p01 to p08 of the strangers' clips it is 0.22 in the one where teeth are taken
for lips; in the others, and in eight clips of GRID, 0.12 and less."""
_FEWEST = 10  # frames, for any of it


def contradicted(
    aperture: FloatArray, deviation: FloatArray, by_landmarks: FloatArray
) -> NDArray[np.bool_]:
    """Mask (T,) of the frames in which an aperture and that of the landmarks disagree.

    Parameters
    ----------
    aperture, deviation, by_landmarks : (T,) float64, mm
        As reported, its standard deviation, and by the landmarks alone; NaN where not known.
    """
    own = np.where(np.isfinite(deviation), deviation, _UNSURE)
    spread = np.sqrt(own**2 + _UNSURE**2 + (_SHARE * by_landmarks) ** 2)
    return np.asarray(np.abs(aperture - by_landmarks) > _CONTRADICTED * spread)


def doubts(
    against: NDArray[np.bool_],
    held: Sequence[bool],
    separability: Mapping[str, float],
    agreement: float = 1.0,
    chromatic: bool = True,
) -> list[str]:
    """Doubts that a user should know before believing a run, a line each.

    Parameters
    ----------
    against : (T,) bool
        Frames that landmarks contradict, see `contradicted`.
    held : sequence of bool, T
        Which frames were held to the landmarks.
    separability : mapping of str to float
        See `ColourClasses`.
    agreement : float
        See `ColourClasses`.
    chromatic : bool
        Whether the video is in colour.
    """
    lines = [] if chromatic else [NO_COLOUR]
    if separability and np.mean(list(separability.values())) < LEAST_SEPARABILITY:
        told = ", ".join(f"{k.replace('_', ' ')} {v:.0%}" for k, v in separability.items())
        lines.append(
            f"lips and skin have nearly the same colour here (separability: {told}); the "
            "result rests more on landmarks and the prior"
        )
    if agreement < LEAST_AGREEMENT:
        lines.append(
            f"by colours alone the mouth opens {max(agreement, 0.0):.0%} as far as by landmarks: "
            "teeth or tongue may be taken for lips; look at the overlay before you use it"
        )
    if len(against) >= _FEWEST and against.mean() > _MOST_CONTRADICTED:
        lines.append(
            f"in {against.mean():.0%} of the frames the mouth is open farther, or less, than "
            "landmarks say, by more than either may be off: look at the overlay before you use it"
        )
    share = float(np.mean(held)) if len(held) else 0.0
    if share > _MOST_HELD:
        lines.append(
            f"in {share:.0%} of the frames what is drawn led off the lips; there landmarks alone "
            "are reported"
        )
    return lines
