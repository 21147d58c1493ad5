"""The head of an inspection picture, with its classes and, where there is one, its texture."""

from __future__ import annotations

import difflib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.errors import ParameterError
from abs_engine.core.geometry import FloatArray, vertex_normals
from abs_engine.io.assets import Speaker, load_speaker


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

    @cached_property
    def normals(self) -> FloatArray:
        """Unit vertex normals (V, 3), head frame, smooth across the seams of the texture."""
        weld = self.speaker.weld
        points = np.zeros((int(weld.max()) + 1, 3))
        points[weld] = self.vertices
        return vertex_normals(points, weld[self.speaker.faces])[weld]


def check_person(person: str, speaker: Path | None) -> None:
    """Raise `ParameterError` unless the speaker of a file, or the bundled one, has the person."""
    _check_name(person, load_speaker(speaker))


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


def check_same_mesh(speaker: Speaker, faces: NDArray[np.integer], what: str) -> None:
    """Raise `ParameterError` unless faces (F, 3) are those of the speaker."""
    if not np.array_equal(speaker.faces, faces):
        raise ParameterError(
            f"{what} has another mesh than the speaker", "give its head.npz with --speaker"
        )


def unknown(what: str, name: str, known: tuple[str, ...]) -> tuple[str, str]:
    """Problem and remedy for a name that is not known."""
    lower = {k.lower(): k for k in known}
    near = difflib.get_close_matches(name.lower(), lower, 1, 0.5)
    few = len(known) <= 12
    choice = f"choose one of {', '.join(known)}" if few else f"'{known[0]}' and the like are known"
    return f"there is no {what} '{name}'", f"did you mean '{lower[near[0]]}'?" if near else choice
