"""The 275 points of a corpus on a head: the same vertices for all its people, by rules alone."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.arrays import IntArray
from abs_engine.core.errors import ParameterError
from abs_engine.core.geometry import vertex_normals
from abs_engine.io.assets import LIPS_OF_68, Speaker
from abs_engine.learn.settings import LEARNING

COUNT = 275
"""Of the paper, section 2.2; 30 of them on the lips."""
_JAW_LINE = slice(3, 14)  # of the 17 landmarks from ear to ear
_RED = ("upper_lip", "lower_lip")
_LIPS = {"upper": (slice(1, 6), slice(1, 4)), "lower": (slice(7, 12), slice(5, 8))}
"""Of the 12 landmarks of the lips' outer border and the 8 of the inner one; the rest: corners."""


@dataclass(frozen=True, eq=False)
class Points:
    """The points of a corpus on a mesh.

    Parameters
    ----------
    vertices : (N,) int64
    names : tuple of str, N
    groups : mapping of str to tuple of str
        ``lip_contour`` (30), ``lip_beads`` around it, ``lips`` (both), ``upper_lip`` and
        ``lower_lip`` (those of both without the corners), ``jaw_line``, ``lower_teeth``, and
        ``face``: everything but the points on the lips and the teeth.
    """

    vertices: IntArray
    names: tuple[str, ...]
    groups: Mapping[str, tuple[str, ...]]


def choose_points(speaker: Speaker) -> Points:
    """Choose them on a head.

    On the lips 12 of the outer border, 8 of the inner and 10 between; 7 on the edge of the lower
    teeth; 11 on the jaw line; 20 beads around the lips; and 207 beads over the face below the eyes
    and the throat, each as far as possible from all before it. Raises `ParameterError` if the head
    has no `points.json`, or too few vertices.
    """
    if "landmark_68" not in speaker.points or "face" not in speaker.points:
        raise ParameterError(
            "the speaker has no landmarks to choose points by",
            "make its points.json with assets/speaker_points.py",
        )
    landmarks = speaker.points["landmark_68"].astype(np.int64)
    parts = {f"lip_{part}": own for part, own in _contour(speaker).items()}
    parts |= {"tooth": _teeth(speaker), "jaw_line": landmarks[_JAW_LINE]}
    parts |= {f"around_{part}": own for part, own in _around(speaker).items()}
    before = np.concatenate(list(parts.values()))
    parts["bead"] = _spread(speaker, before, COUNT - len(before))
    vertices = np.concatenate(list(parts.values()))
    names = tuple(f"{part}_{k:03d}" for part, own in parts.items() for k in range(len(own)))
    return Points(vertices, names, _groups(names))


def _groups(names: tuple[str, ...]) -> dict[str, tuple[str, ...]]:
    """Groups of points by the first parts of their names."""
    parts = {
        "lip_contour": ("lip_",), "lip_beads": ("around_",), "lips": ("lip_", "around_"),
        "upper_lip": ("lip_upper", "around_upper"), "lower_lip": ("lip_lower", "around_lower"),
        "jaw_line": ("jaw_line",), "lower_teeth": ("tooth",),
        "face": ("jaw_line", "around_", "bead_"),
    }  # fmt: skip
    return {group: tuple(n for n in names if n.startswith(own)) for group, own in parts.items()}


def _contour(speaker: Speaker) -> dict[str, IntArray]:
    """30 points on the lips: the landmarks, and points halfway between their two borders."""
    marks = speaker.points["landmark_68"][LIPS_OF_68].astype(np.int64)
    outer, inner = marks[:12], marks[12:]
    out = {"corner": np.array([outer[0], outer[6], inner[0], inner[4]])}
    for lip, (borders, edges) in _LIPS.items():
        own = speaker.vertices_of(f"{lip}_lip")
        inside = np.concatenate([inner[edges], out["corner"][2:]])
        halfway = _halfway(speaker, outer[borders], inside, own)
        out[lip] = np.concatenate([outer[borders], inner[edges], halfway])
    return out


def _halfway(
    speaker: Speaker, border: IntArray, inside: IntArray, own: NDArray[np.int32]
) -> IntArray:
    """Vertices of a lip nearest to the middle between its border and its inner edge."""
    place = speaker.vertices.astype(np.float64)
    inside = inside[place[inside, 0].argsort()]
    edge = np.stack(
        [np.interp(place[border, 0], place[inside, 0], place[inside, k]) for k in range(3)], axis=1
    )
    wanted = (place[border] + edge) / 2
    away = np.linalg.norm(place[own][:, None] - wanted, axis=2)
    return np.asarray(own[away.argmin(axis=0)], np.int64)


def _teeth(speaker: Speaker) -> IntArray:
    """Points of the edge of the lower front teeth, the highest near each place across."""
    own = speaker.vertices_of("lower_teeth")
    x, y, z = speaker.vertices[own].astype(np.float64).T
    front = z > (z.min() + z.max()) / 2
    return np.array(
        [own[np.where(front, y - np.abs(x - at), -np.inf).argmax()] for at in LEARNING.teeth_beads]
    )


def _around(speaker: Speaker) -> dict[str, IntArray]:
    """Skin vertices a little outside of the lips' border, evenly around it."""
    place = speaker.vertices.astype(np.float64)
    ring = place[speaker.lip_ring]
    steps = np.linalg.norm(np.roll(ring, -1, axis=0) - ring, axis=1)
    at = np.concatenate([[0.0], np.cumsum(steps)])
    closed = np.concatenate([ring, ring[:1]])
    wanted = (np.arange(LEARNING.ring_beads) + 0.5) * at[-1] / LEARNING.ring_beads
    edge = np.stack([np.interp(wanted, at, closed[:, k]) for k in range(3)], axis=1)
    middle = ring.mean(axis=0)
    out = (edge - middle) * [1.0, 1.0, 0.0]
    goal = edge + LEARNING.ring_away * out / np.linalg.norm(out, axis=1, keepdims=True)
    skin = speaker.vertices_of("skin")
    skin = skin[place[skin, 2] > ring[:, 2].min() - 3 * LEARNING.ring_away]
    away = np.linalg.norm(place[skin][:, None, :2] - goal[:, :2], axis=2)
    found = np.unique(skin[away.argmin(axis=0)]).astype(np.int64)
    corner = place[speaker.landmarks["mouth_corners"], 1].mean()
    above = place[found, 1] - corner
    return {
        "upper": found[above > LEARNING.corner], "lower": found[above < -LEARNING.corner],
        "corner": found[np.abs(above) <= LEARNING.corner],
    }  # fmt: skip


def _spread(speaker: Speaker, before: IntArray, count: int) -> IntArray:
    """Beads, each as far as possible from all before it; nothing is drawn by chance."""
    place = speaker.vertices.astype(np.float64)
    skin = speaker.vertices_of("skin")
    forward = vertex_normals(place, speaker.faces)[:, 2] > 0
    lowest = place[speaker.points["face"], 1].min()
    throat = skin[forward[skin] & (place[skin, 1] < lowest)]
    lips = speaker.vertices_of(*_RED)
    face = np.setdiff1d(speaker.points["face"], lips)
    pool = np.union1d(face[place[face, 1] < LEARNING.highest_bead], throat)
    if len(pool) < count:
        raise ParameterError(
            f"{count} beads do not fit the face", f"give a head of {count} vertices there or more"
        )
    away = np.linalg.norm(place[pool][:, None] - place[before], axis=2).min(axis=1)
    chosen: list[int] = []
    for _ in range(count):
        at = int(away.round(6).argmax())  # of mirrored ones, which tie, always the first
        chosen.append(int(pool[at]))
        away = np.minimum(away, np.linalg.norm(place[pool] - place[pool[at]], axis=1))
    return np.array(chosen, np.int64)
