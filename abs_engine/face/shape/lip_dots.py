"""Sixteen dots on the lips and one on the nose: the same places for all people of a head."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.geometry import vertex_normals
from abs_engine.io.assets import Speaker

_LIPS16 = (
    ("lower_lip", -0.94, 0.5), ("upper_lip", -0.48, 0.2), ("upper_lip", 0.0, 0.15),
    ("upper_lip", 0.48, 0.2), ("lower_lip", 0.94, 0.5),
    ("lower_lip", -0.5, 0.2), ("lower_lip", 0.0, 0.2), ("lower_lip", 0.5, 0.2),
    ("upper_lip", -0.65, 0.65), ("upper_lip", -0.2, 0.82), ("upper_lip", 0.2, 0.82),
    ("upper_lip", 0.65, 0.65),
    ("lower_lip", -0.66, 0.7), ("lower_lip", -0.22, 0.82), ("lower_lip", 0.22, 0.82),
    ("lower_lip", 0.66, 0.7),
)  # fmt: skip
"""Lip, place across (-1 at the right corner, 1 at the left one), and depth, from 0 at the outer
border to 1 where the lips meet, of the dots of ``lips17``."""
_FACING = 0.3
"""Least part of a vertex's normal that looks forward where a dot may be."""


def lips17(speaker: Speaker) -> NDArray[np.int32]:
    """Vertices (17,): eight dots around the mouth, four inside on each lip, one on the nose."""
    marks, place = speaker.landmarks, speaker.vertices
    ring = place[speaker.lip_ring]
    right, left = (place[v] for v in marks["mouth_corners"])
    half, middle = (left[0] - right[0]) / 2, (left[1] + right[1]) / 2
    inner = np.sort(place[marks["inner_lip_8"], 1])
    forward = vertex_normals(place.astype(np.float64), speaker.faces)[:, 2] > _FACING
    chosen: list[int] = []
    for name, across, depth in _LIPS16:
        own = speaker.vertices_of(name)
        upper = name == "upper_lip"
        edge = ring[(ring[:, 1] > middle) == upper]
        edge = edge[edge[:, 0].argsort()]
        border = float(np.interp(across * half, edge[:, 0], edge[:, 1]))
        contact = float((inner[:4] if upper else inner[4:]).mean())
        wanted = np.array([across * half, border + depth * (contact - border)])
        seen = own[forward[own] & ~np.isin(own, chosen)]
        gap = np.linalg.norm(place[seen, :2] - wanted, axis=1)
        chosen.append(int(seen[gap.argmin()]))
    return np.array([*chosen, int(marks["nose_tip"][0])], np.int32)
