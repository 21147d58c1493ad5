"""A plain shirt under the head: drawn, never tracked."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.geometry import Pose, edges_of, pose_vectors, vertex_normals
from abs_engine.dataset.codec import OTHER
from abs_engine.io.assets import Speaker
from abs_engine.studio.appearance.look import Colour
from abs_engine.studio.plan import Prop

_COLLAR = ((10.0, 2.0), (8.0, 4.5), (-3.0, 8.0))
"""Rings above and around the neck's open end: height and distance from it, mm."""

_SHOULDERS = (
    (-34.0, 125.0, 74.0),
    (-54.0, 168.0, 84.0),
    (-82.0, 198.0, 92.0),
    (-130.0, 212.0, 98.0),
    (-330.0, 215.0, 100.0),
)
"""Ellipses below the neck's open end: height, half width, half depth, mm."""


def shirt(
    speaker: Speaker, neutral: NDArray[np.float32], heads: list[Pose], colour: Colour
) -> Prop:
    """A shirt (linear RGB) that hangs from the neck and follows the head's turning by a quarter."""
    rim = neutral[neck_rim(speaker)].astype(np.float64)
    anchor = np.array([0.0, rim[:, 1].mean(), rim[:, 2].mean()])
    rim = rim - anchor
    turn = np.arctan2(rim[:, 2], rim[:, 0])
    rim, turn = rim[turn.argsort()], np.sort(turn)
    waves = np.column_stack([f(k * turn) for k in (0, 1, 2) for f in (np.cos, np.sin)])
    rim[:, 1] = waves @ np.linalg.lstsq(waves, rim[:, 1])[0]  # a hem without dents
    out = rim * [1, 0, 1] / np.linalg.norm(rim[:, [0, 2]], axis=1, keepdims=True)
    rings = [rim + [0, up, 0] + away * out for up, away in _COLLAR]
    low, level = rim[:, 1].min(), np.ones_like(turn)
    below = [
        np.column_stack([a * np.cos(turn), (low + y) * level, b * np.sin(turn)])
        for y, a, b in _SHOULDERS
    ]
    rings += [0.6 * rings[-1] + 0.4 * below[0] + [0, 6, 0], *below]
    vertices, faces = np.concatenate(rings), _strips(len(rings), len(turn))
    normals = vertex_normals(vertices, faces).astype(np.float32)
    poses = [Pose.from_vectors(0.25 * head.rotation_vector, head.apply(anchor)) for head in heads]
    cloth = np.tile(np.array(colour, np.float32), (len(vertices), 1))
    present = np.ones(len(heads), np.bool_)
    return Prop(
        OTHER, vertices.astype(np.float32), faces, normals, cloth, *pose_vectors(poses), present
    )


def _strips(rings: int, around: int) -> NDArray[np.int32]:
    """Facets between rings of vertices, each counted against the clock from above."""
    here = np.arange(around)
    following = (here + 1) % around
    faces = []
    for ring in range(rings - 1):
        a, b = ring * around + here, ring * around + following
        c, d = a + around, b + around
        faces += [np.column_stack([a, b, c]), np.column_stack([b, d, c])]
    return np.concatenate(faces).astype(np.int32)


def neck_rim(speaker: Speaker) -> NDArray[np.int64]:
    """Vertices on the open lower end of the neck: on an edge of one facet only, below the chin."""
    unique, count = edges_of(speaker.weld[speaker.faces])
    first = np.unique(speaker.weld, return_index=True)[1]
    rim = first[np.unique(unique[count == 1])]
    chin = speaker.vertices[speaker.landmarks["chin"][0], 1]
    return np.asarray(rim[speaker.vertices[rim, 1] < chin - 5.0])
