"""Dots of a corpus that two cameras follow: those of its points that can be seen from the front."""

from __future__ import annotations

import numpy as np

from abs_engine.capture.dot_annotations import LIPS16, LIPS17
from abs_engine.core.arrays import BoolArray
from abs_engine.core.geometry import vertex_normals
from abs_engine.face.schema import BROWS, EYES, Pair, units_of
from abs_engine.face.shape.lip_dots import lips17
from abs_engine.io.assets import Speaker
from abs_engine.learn.choice import Points, choose_points
from abs_engine.learn.settings import LEARNING

SKULL = "skull"
"""Group of the dots that neither speech nor the jaw moves."""
_SKULL_AT = ((0, 72), (25, 70), (-25, 70), (47, 63), (-47, 63), (0, 36), (9, 27), (-9, 27))
"""mm, head frame, across and up: forehead, temples and the root of the nose."""
_MIMIC = (*EYES, *BROWS, *units_of(Pair.NOSE_SNEER))  # at rest while visemes are said


def corpus_dots(speaker: Speaker) -> Points:
    """Choose the dots on a head: the same vertices for all its people.

    The 17 of lips and nose, and of `choose_points` those around the lips, on the jaw line and over
    the face that are seen from the front and lie far enough from each other to be kept apart, none
    on the throat; and eight on the skull. Groups are those of a corpus and ``skull``. That of the
    lower teeth is empty: they are hidden most of the time, so that what asks for jaw line and lower
    teeth gets the jaw line alone.
    """
    place = speaker.vertices.astype(np.float64)
    seen = vertex_normals(place, speaker.faces)[:, 2] > LEARNING.facing_dot
    known = choose_points(speaker)
    at = dict(zip(LIPS17, lips17(speaker).astype(np.int64).tolist(), strict=True))
    at |= {f"{SKULL}_{k}": vertex for k, vertex in enumerate(_skull(speaker, seen))}
    lowest = place[speaker.points["face"], 1].min()
    for name, vertex in zip(known.names, known.vertices.tolist(), strict=True):
        around = name.startswith(("around_", "jaw_line"))
        bead = name.startswith("bead_") and place[vertex, 1] > lowest
        if not (around or bead) or not seen[vertex]:
            continue
        apart = LEARNING.dots_apart if around else LEARNING.beads_apart
        away = np.linalg.norm(place[list(at.values())] - place[vertex], axis=1)
        if away.min() > apart:
            at[name] = vertex
    return Points(np.array(list(at.values())), tuple(at), _groups(tuple(at)))


def _skull(speaker: Speaker, seen: BoolArray) -> list[int]:
    """Vertices that no unit of speech moves."""
    used = tuple(name for name in speaker.unit_names if name not in _MIMIC)
    moved = np.linalg.norm(speaker.unit_matrix(used), axis=2).max(axis=0)
    skin = speaker.vertices_of("skin").astype(np.int64)
    pool = skin[seen[skin] & (moved[skin] < LEARNING.still)]
    place = speaker.vertices[pool, :2].astype(np.float64)
    return [int(pool[np.linalg.norm(place - at, axis=1).argmin()]) for at in _SKULL_AT]


def _groups(names: tuple[str, ...]) -> dict[str, tuple[str, ...]]:
    parts = {
        "lips": (*LIPS16, "around_"),
        "upper_lip": ("upper_", "around_upper"), "lower_lip": ("lower_", "around_lower"),
        "jaw_line": ("jaw_line",), "lower_teeth": (),
        "face": ("jaw_line", "around_", "bead_", "nose"), SKULL: (SKULL,),
    }  # fmt: skip
    return {group: tuple(n for n in names if n.startswith(own)) for group, own in parts.items()}
