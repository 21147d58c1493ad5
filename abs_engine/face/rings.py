"""Contours of a head: the lips, the corners of the mouth, and the jaw, as vertices."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.errors import ModelFormatError
from abs_engine.io.assets import Speaker


def lip_rings(speaker: Speaker) -> dict[str, NDArray[np.int32]]:
    """The lips' contours, the 20 points of the lips and the mouth's corners, as vertices."""
    marks = speaker.landmarks
    return {
        "outer": marks["outer_lip"],
        "upper": marks["inner_lip_upper"],
        "lower": marks["inner_lip_lower"],
        "points": np.concatenate([marks["outer_lip_20"], marks["inner_lip_8"]]),
        "corners": marks["mouth_corners"],
    }


def contours(speaker: Speaker) -> dict[str, NDArray[np.int32]]:
    """Those of the lips, and the lower teeth, which move as the jaw does, as vertices."""
    return {**lip_rings(speaker), "jaw": speaker.vertices_of("lower_teeth")}


def rings_of(speaker: Speaker, kept: NDArray[np.int32]) -> dict[str, NDArray[np.int32]]:
    """The contours by their places among the vertices that are kept, (K,).

    Raises `ModelFormatError` if a contour is not wholly on them.
    """
    sources = contours(speaker)
    lost = [name for name, vertices in sources.items() if not np.isin(vertices, kept).all()]
    if lost:
        raise ModelFormatError(
            f"the speaker's landmarks {', '.join(lost)} are not on the facets near its lip_ring",
            "check the landmarks of the speaker's file",
        )
    return {k: np.searchsorted(kept, v).astype(np.int32) for k, v in sources.items()}
