"""Dots that are painted on a face: ink on the lips, coloured beads on cheeks and chin."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.arrays import Float32Array
from abs_engine.core.errors import ParameterError
from abs_engine.face.shape.lip_dots import lips17
from abs_engine.io.assets import Speaker
from abs_engine.learn.corpus_dots import corpus_dots
from abs_engine.studio.people.chart import Chart
from abs_engine.studio.people.person import Person, neutral
from abs_engine.studio.people.regions import step

INK = (28, 32, 74)
BEADS = ((34, 120, 204), (30, 158, 92), (238, 214, 60), (214, 70, 160))
"""Colours that no face has."""

DOT_SETS = {"lips17": 0.8, "corpus": 0.9}
"""Sets by name, and the radius (mm) of their dots.

``lips17``: sixteen dots of ink on the lips and one on the tip of the nose, the number that Basu,
Oliver and Pentland (1998) marked: eight just inside the outer border of the lips, the corners
among them, and four on each lip as near to where they meet as is seen with the mouth closed.
``corpus``: these, and more of ink around them, on the jaw line, over the face and on the skull, for
a corpus of visemes that two cameras see; see `learn.corpus_dots`.
"""
_BEAD_RADIUS = 1.3


@dataclass(frozen=True, eq=False)
class Dots:
    """Dots on a face, each centred at a vertex of the mesh.

    Parameters
    ----------
    vertices : (N,) int32
        Vertex at the centre; its place in a frame is the dot's true place.
    radius : float
        mm, on the person at rest.
    colours : (N, 3) uint8, sRGB
    """

    vertices: NDArray[np.int32]
    radius: float
    colours: NDArray[np.uint8]


def dots(speaker: Speaker, person: Person) -> Dots:
    """The dots of a person.

    Raises
    ------
    ParameterError
        If there is no such set, or the base is unknown.
    """
    if isinstance(person.beads, str):
        if person.beads not in DOT_SETS:
            raise ParameterError(
                f"{person.name}: there is no set of dots '{person.beads}'",
                f"give a number or one of {', '.join(DOT_SETS)}",
            )
        lips_only = person.beads == "lips17"
        chosen = lips17(speaker) if lips_only else corpus_dots(speaker).vertices.astype(np.int32)
        return Dots(
            chosen, DOT_SETS[person.beads], np.tile(np.array(INK, np.uint8), (len(chosen), 1))
        )
    chosen = _spread(speaker, neutral(speaker, person), person.beads)
    palette = np.array(BEADS, np.uint8)
    return Dots(chosen, _BEAD_RADIUS, palette[np.arange(len(chosen)) % len(palette)])


def add_dots(colour: Float32Array, speaker: Speaker, chart: Chart, person: Person) -> Float32Array:
    """Paint a person's dots over texel colours (T, 3), round on this person's face."""
    marks = dots(speaker, person)
    if not len(marks.vertices):
        return colour
    rest, out = neutral(speaker, person), colour.copy()
    order = chart.face.argsort(kind="stable")
    start = np.searchsorted(chart.face[order], np.arange(len(speaker.faces) + 1))
    for vertex, tone in zip(marks.vertices, marks.colours, strict=True):
        near = _around(speaker, rest, int(vertex), marks.radius + 1.0)
        texels = np.concatenate([order[start[f] : start[f + 1]] for f in near])
        corners = rest[speaker.faces[chart.face[texels]]]
        place = np.einsum("tk,tkc->tc", chart.weights[texels], corners)
        distance = np.linalg.norm(place - rest[vertex], axis=1)
        share = step(distance, marks.radius + 0.12, marks.radius - 0.12)[:, None]
        out[texels] += share * (tone.astype(np.float32) - out[texels])
    return out


def _around(speaker: Speaker, rest: Float32Array, vertex: int, reach: float) -> NDArray[np.int64]:
    """Facets that can be walked to without leaving a ball, so that no dot leaps from lip to lip."""
    weld, corners = speaker.weld, speaker.weld[speaker.faces]
    near = np.zeros(int(weld.max()) + 1, np.bool_)
    near[weld] = np.linalg.norm(rest - rest[vertex], axis=1) < reach
    reached = np.zeros_like(near)
    reached[weld[vertex]] = True
    while True:
        facets = np.flatnonzero(reached[corners].any(axis=1))
        further = corners[facets].ravel()
        further = further[near[further] & ~reached[further]]
        if not len(further):
            return facets
        reached[further] = True


def _spread(speaker: Speaker, rest: Float32Array, count: int) -> NDArray[np.int32]:
    """Vertices of the face's front, each as far as possible from those before it.

    Lips and eyes are left free. Nothing is drawn by chance.
    """
    if not count:
        return np.zeros(0, np.int32)
    skin = speaker.vertices_of("skin")
    x, y, z = speaker.vertices[skin].T
    face = (np.abs(x) < 62) & (y > -62) & (y < 80) & (z > 45) & (speaker.uv[skin, 1] < 0.7)
    lids = (np.abs(np.abs(x) - 30) < 18) & (np.abs(y - 38) < 13)
    nostrils = (np.abs(x) < 14) & (np.abs(y + 3) < 7) & (z < 108)
    skin = skin[face & ~lids & ~nostrils]
    ring = rest[speaker.lip_ring]
    away = np.linalg.norm(rest[skin][:, None] - ring[None], axis=2).min(axis=1)
    skin, away = skin[away > 2.5], away[away > 2.5]
    if count > len(skin):
        raise ParameterError(
            f"{count} beads do not fit the face", f"give at most {len(skin)} beads"
        )
    away = np.full(len(skin), np.inf)
    at = int(np.linalg.norm(rest[skin] - rest[speaker.landmarks["nose_tip"][0]], axis=1).argmin())
    chosen: list[int] = []
    for _ in range(count):
        chosen.append(at)
        away = np.minimum(away, np.linalg.norm(rest[skin] - rest[skin[at]], axis=1))
        at = int(away.argmax())
    return np.asarray(skin[chosen], np.int32)
