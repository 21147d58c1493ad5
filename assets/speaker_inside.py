"""Set teeth and tongue in the average mouth to where they are in a person at rest.

In the base mesh the upper teeth end above the line where the lips touch, so that they never show
in speech, and the tongue fills the whole mouth, so that open lips look closed. Only the neutral
shape is changed here; units and identity targets displace the parts as before.
"""

from __future__ import annotations

import numpy as np
import speaker_mesh as sm

UPPER_DROP = 3.0  # mm, all upper teeth
FRONT_DROP = 1.6  # mm, lower front teeth: less than the upper ones, which so overlap them a little
OVERJET = (0.7, 1.2)  # mm, upper front teeth forward, lower ones back: so they do not touch
SPREAD = 0.015  # the upper arch is wider by this share, the lower one narrower
EDGE = (1.6, 2.2)  # mm, the ridge behind the upper edge goes outwards and down: thinner front teeth
RIDGE = (1.8, 2.6, 4.6, 6.0)  # mm behind the outer face, where that ridge is
ARCH = (75.0, 91.0)  # mm, z over which molars become front teeth
TONGUE_Z = (16.0, 30.0, 42.0, 54.0, 70.0, 86.0)  # mm, from the root to the tip
TONGUE_DROP = (4.0, 8.0, 11.0, 12.0, 11.0, 7.0)  # mm, its back, at these
TONGUE_CORE = (-31.0, -28.0, -25.5, -24.6, -25.0, -30.0)  # mm, y between back and underside
TONGUE_THIN = 0.25  # share of the drop that the underside does not make
TONGUE_BACK = 4.0  # mm, the tip
TONGUE_WIDTH = 0.85  # of the tip and middle, so that it stays between the lower teeth


def smooth_step(x: np.ndarray, low: float, high: float) -> np.ndarray:
    """Rise smoothly from 0 at `low` to 1 at `high`."""
    t = np.clip((x - low) / (high - low), 0.0, 1.0)
    return t * t * (3.0 - 2.0 * t)


def thin_edge(place: np.ndarray) -> np.ndarray:
    """Return the displacements that thin the edge of the upper teeth, whose normals then face out.

    Parameters
    ----------
    place : (N, 3) float64
        Vertices of the upper teeth, mm.

    Returns
    -------
    moved : (N, 3) float64
    """
    out = place[:, [0, 2]] - [0.0, place[:, 2].min()]
    radius = np.linalg.norm(out, axis=1)
    angle = np.arctan2(out[:, 0], out[:, 1])
    near = np.abs(angle[:, None] - angle) < 0.07
    behind = np.where(near, radius, 0.0).max(1) - radius
    share = np.interp(behind, RIDGE, [0.0, 1.0, 1.0, 0.0]) * smooth_step(place[:, 2], *ARCH)
    share = share * (place[:, 1] < np.median(place[:, 1]))
    along = EDGE[0] * out / np.maximum(radius, 1e-9)[:, None]
    return share[:, None] * np.stack([along[:, 0], np.full(len(out), -EDGE[1]), along[:, 1]], 1)


def settle(vertices: np.ndarray, faces: np.ndarray, facet_class: np.ndarray) -> np.ndarray:
    """Lower the teeth and the tongue.

    Parameters
    ----------
    vertices : (V, 3) float64
        The average person, mm, head frame.
    faces : (F, 3) int
    facet_class : (F,) uint8

    Returns
    -------
    settled : (V, 3) float64
    """
    settled = vertices.copy()
    for kind in (sm.UPPER_TEETH, sm.LOWER_TEETH):
        part = np.unique(faces[facet_class == kind])
        front = smooth_step(vertices[part, 2], *ARCH)
        upper = kind == sm.UPPER_TEETH
        settled[part] += thin_edge(vertices[part]) if upper else 0.0
        settled[part, 1] -= UPPER_DROP if upper else UPPER_DROP + front * (FRONT_DROP - UPPER_DROP)
        settled[part, 2] += front * (OVERJET[0] if upper else -OVERJET[1])
        settled[part, 0] *= 1.0 + (SPREAD if upper else -SPREAD)
    part = np.unique(faces[facet_class == sm.TONGUE])
    z = vertices[part, 2]
    settled[part, 0] *= 1.0 + (TONGUE_WIDTH - 1.0) * smooth_step(z, 24.0, 60.0)
    under = 1.0 - smooth_step(vertices[part, 1] - np.interp(z, TONGUE_Z, TONGUE_CORE), -4.0, 4.0)
    settled[part, 1] -= np.interp(z, TONGUE_Z, TONGUE_DROP) * (1.0 - TONGUE_THIN * under)
    settled[part, 2] -= TONGUE_BACK * smooth_step(z, 40.0, 86.0)
    return settled
