"""The head of an inspection picture, with its classes and, where there is one, its texture."""

from __future__ import annotations

import difflib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.arrays import FloatArray
from abs_engine.core.errors import ParameterError
from abs_engine.core.geometry import seamless_normals
from abs_engine.io.assets import Speaker, load_speaker
from abs_engine.report.drawing.colours import clay_of
from abs_engine.report.drawing.paint import Coat, facet_coat
from abs_engine.report.drawing.palette import CLASS_COLOURS

PALETTES = ("colour", "clay", "classes")
MOUTH_MM = 42.0
"""What lies nearer than this to the middle of the lips is in the picture of the mouth."""


@dataclass(frozen=True, eq=False)
class Body:
    """A head in a posture.

    Parameters
    ----------
    speaker : Speaker
        Gives faces, classes, seams and texture coordinates.
    vertices : (V, 3) float64, mm, head frame
    texture : (H, W, 3) uint8 RGB, or None
    """

    speaker: Speaker
    vertices: FloatArray
    texture: NDArray[np.uint8] | None = None

    def moved(self, vertices: NDArray[np.floating]) -> Body:
        """The same head with other vertices."""
        return replace(self, vertices=np.asarray(vertices, np.float64))

    @property
    def faces(self) -> NDArray[np.integer]:
        """Vertices of each facet, (F, 3)."""
        return self.speaker.faces

    @property
    def two_sided(self) -> bool:
        """Whether its back is drawn: a head is closed."""
        return False

    def shown(self, crop: str) -> FloatArray:
        """The vertices (N, 3) that have to be in a picture of the "head" or of the "mouth"."""
        if crop == "head":
            return self.vertices
        lips = self.vertices[self.speaker.lip_ring].mean(axis=0)
        near = np.linalg.norm(self.vertices - lips, axis=1) < MOUTH_MM
        return np.asarray(self.vertices[near])

    @cached_property
    def normals(self) -> FloatArray:
        """Unit vertex normals (V, 3), head frame, smooth across the seams of the texture."""
        return seamless_normals(self.vertices, self.speaker.faces, self.speaker.weld)


def coat(body: Body, palette: str) -> Coat:
    """A coat by its name, of `PALETTES`.

    Raises
    ------
    ParameterError
        If there is no such palette, or the body has no texture.
    """
    speaker = body.speaker
    if palette == "classes":
        return facet_coat(CLASS_COLOURS, speaker.facet_class)
    if palette == "clay":
        return facet_coat(clay_of(speaker.class_names), speaker.facet_class)
    if palette != "colour":
        raise ParameterError(
            f"there is no palette '{palette}'", f"choose one of {', '.join(PALETTES)}"
        )
    if body.texture is None:
        raise ParameterError("this head has no texture", "choose the palette clay or classes")
    return Coat(speaker.uv, body.texture)


def check_person(person: str | None, speaker: Path | None) -> None:
    """Raise `ParameterError` unless the speaker of a file, or the bundled one, has the person.

    Every speaker has somebody who stands in for None.
    """
    head = load_speaker(speaker)
    if person is not None:
        _check_name(person, head)


def _check_name(person: str, speaker: Speaker) -> None:
    if person not in speaker.people:
        raise ParameterError(*unknown("person", person, tuple(speaker.people)))


def person_body(speaker: Speaker, person: str) -> Body:
    """A person of the speaker at rest, with texture.

    Raises
    ------
    ParameterError
        If there is no such person; the nearest name is given.
    """
    _check_name(person, speaker)
    return Body(speaker, speaker.named(person).astype(np.float64), speaker.texture(person))


def posed(body: Body, units: Mapping[str, float]) -> Body:
    """The body with face units added, weights by name.

    Raises
    ------
    ParameterError
        If there is no such face unit, the nearest is named; or a weight is not finite.
    """
    check_units(body.speaker, tuple(units))
    if not np.isfinite(list(units.values())).all():
        raise ParameterError("the weight of a face unit is NaN or infinite", "give a number")
    if not units:
        return body
    deltas = body.speaker.unit_matrix(tuple(units)).astype(np.float64)
    return body.moved(body.vertices + np.tensordot(list(units.values()), deltas, 1))


def check_units(speaker: Speaker, names: Sequence[str]) -> None:
    """Raise `ParameterError` for a name that is no face unit; the nearest is named."""
    for name in names:
        if name not in speaker.unit_names:
            raise ParameterError(*unknown("face unit", name, speaker.unit_names))


def unknown(what: str, name: str, known: tuple[str, ...]) -> tuple[str, str]:
    """Problem and remedy for a name that is not known."""
    lower = {k.lower(): k for k in known}
    near = difflib.get_close_matches(name.lower(), lower, 1, 0.5)
    few = len(known) <= 12
    choice = f"choose one of {', '.join(known)}" if few else f"'{known[0]}' and the like are known"
    return f"there is no {what} '{name}'", f"did you mean '{lower[near[0]]}'?" if near else choice
