"""Contact of the lips: measured on the mesh, not read from the script."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.geometry import edges_of
from abs_engine.dataset import lip_gap
from abs_engine.io.assets import Speaker


def widest_gap(speaker: Speaker, vertices: NDArray[np.floating]) -> float:
    """Widest gap between a speaker's lips, mm, of vertices (V, 3); see `lip_gap.widest_gap`."""
    corners = speaker.landmarks["mouth_corners"]
    return lip_gap.widest_gap(vertices, corners, *_lip_edges(speaker))


@lru_cache(maxsize=4)
def _lip_edges(speaker: Speaker) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Edges (E, 2) of the facets of the upper and of the lower lip."""
    upper, lower = (speaker.faces[speaker.facets_of(n)] for n in ("upper_lip", "lower_lip"))
    return edges_of(upper)[0], edges_of(lower)[0]
