"""The people of a scene, made when they are needed."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.errors import ParameterError
from abs_engine.io.assets import Speaker
from abs_engine.studio.people import (
    Person,
    dots,
    identity_vector,
    neutral,
    paint,
    random_person,
    skin_tone,
)
from abs_engine.studio.scenefile import ClipEntry, SpeakerEntry
from abs_engine.studio.scenefile.reader import nearest

NO_DOTS = np.zeros(0, np.int32)


@dataclass(frozen=True, eq=False)
class Actor:
    """A person ready to be filmed.

    Parameters
    ----------
    identity : (K,) float32
    neutral : (V, 3) float32, mm, head frame
    texture : (S, S, 3) uint8
    dots : (N,) int32
        Vertices on which dots are painted.
    """

    identity: NDArray[np.float32]
    neutral: NDArray[np.float32]
    texture: NDArray[np.uint8]
    dots: NDArray[np.int32]


class Cast:
    """The people whom clips may name: those of the scene, and the bundled ones."""

    def __init__(self, speaker: Speaker, entries: tuple[SpeakerEntry, ...]) -> None:
        self._speaker = speaker
        self._entries = {entry.name: entry for entry in entries}
        self._last: tuple[str, Actor] | None = None

    def person(self, name: str, where: str) -> Actor:
        """The person of a name; the last one is kept.

        Raises
        ------
        ParameterError
            If there is none; the nearest is named.
        """
        if self._last is None or self._last[0] != name:
            self._last = name, self._make(name, where)
        return self._last[1]

    def check(self, clips: tuple[ClipEntry, ...]) -> None:
        """Raise `ParameterError` if a clip names nobody, or somebody who cannot be made.

        It makes no pictures of them, so a scene of many clips is told of it at once.
        """
        for entry in self._entries.values():
            identity_vector(self._speaker, person_of(entry, self._speaker))
        for clip in clips:
            self._known(clip.speaker, f"clip '{clip.name}'")

    def _known(self, name: str, where: str) -> None:
        known = [*self._entries, *self._speaker.people]
        if name not in known:
            raise ParameterError(
                f"{where}: there is no person '{name}'{nearest(name, known)}",
                f"choose one of {', '.join(known)}, or add a [[speaker]]",
            )

    def _make(self, name: str, where: str) -> Actor:
        self._known(name, where)
        speaker = self._speaker
        if name in self._entries:
            person = person_of(self._entries[name], speaker)
            return Actor(
                identity_vector(speaker, person),
                neutral(speaker, person),
                paint(speaker, person),
                np.asarray(dots(speaker, person).vertices, np.int32),
            )
        return Actor(speaker.people[name], speaker.named(name), speaker.texture(name), NO_DOTS)


def person_of(entry: SpeakerEntry, speaker: Speaker) -> Person:
    """Person of an entry in a scene file.

    Raises
    ------
    ParameterError
        If a value is out of range or a tone is unknown.
    """
    if entry.random is not None:
        if entry.random < 0:
            raise ParameterError(f"speaker '{entry.name}' has a negative seed", "give 0 or more")
        person = random_person(speaker, np.random.default_rng(entry.random), entry.name)
    else:
        person = Person(entry.name, entry.base or "clara")
    changes: dict[str, Any] = {
        name: getattr(entry, name)
        for name in ("base", "lips", "hair", "stubble", "freckles", "beads", "seed")
        if getattr(entry, name) is not None
    }
    if entry.skin is not None:
        changes["skin"] = skin_tone(entry.skin) if isinstance(entry.skin, str) else entry.skin
    if entry.identity:
        changes["identity"] = {**person.identity, **entry.identity}
    return replace(person, **changes)
