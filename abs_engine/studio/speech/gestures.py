"""Gestures: holds where lips meet lips or teeth, and the movements around them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from abs_engine.core.arrays import FloatArray
from abs_engine.studio.speech.phonemes import Phoneme
from abs_engine.studio.speech.targets import hold
from abs_engine.studio.speech.utterance import Segment

Kind = Literal["lips", "teeth"]

_SLOWEST, _QUICKEST = 0.080, 0.001
"""Seconds of the movement into or out of a contact."""


@dataclass(frozen=True)
class Contact:
    """A time in which the lips are closed, or the lower lip is at the upper teeth.

    Parameters
    ----------
    kind : {"lips", "teeth"}
    start, end : float
        Seconds between which the contact holds, both included.
    rise, fall : float
        Seconds of the movement into it and out of it.
    """

    kind: Kind
    start: float
    end: float
    rise: float = _SLOWEST
    fall: float = _SLOWEST

    def activation(self, times: FloatArray) -> FloatArray:
        """1 while it holds, 0 away from it, and a raised cosine between."""
        before = (self.start - times) / self.rise
        after = (times - self.end) / self.fall
        away = np.clip(np.maximum(before, after), 0.0, 1.0)
        return np.asarray(0.5 + 0.5 * np.cos(np.pi * away), np.float64)


def contacts(segments: tuple[Segment, ...], times: FloatArray) -> tuple[Contact, ...]:
    """Contacts of an utterance that is sampled at `times` (T,), seconds.

    However short, a closure of the lips holds in one frame at least, and so does a labiodental
    unless a closure needs that frame. Lips stay closed from one closure to the next where nothing
    stands between them.
    """
    kinds = [_kind(segment.phoneme) for segment in segments]
    spans = [_span(segments, kinds, index, times) for index in range(len(segments))]
    found = []
    for index, kind in enumerate(kinds):
        if kind is None:
            continue
        start, end = spans[index]
        following = kinds[index + 1] if index + 1 < len(kinds) else None
        if following == kind:
            end = max(end, spans[index + 1][0])
        elif kind == "teeth":
            start, end = _yielding(spans, kinds, index)
        rise = _room(start - _reach(segments, kinds, spans, index, -1))
        fall = _room(_reach(segments, kinds, spans, index, 1) - end)
        found.append(Contact(kind, start, end, rise, fall))
    return tuple(found)


def _kind(phoneme: Phoneme) -> Kind | None:
    if phoneme.closes_lips:
        return "lips"
    return "teeth" if phoneme.touches_teeth else None


def _span(
    segments: tuple[Segment, ...], kinds: list[Kind | None], index: int, times: FloatArray
) -> tuple[float, float]:
    """Hold of a contact, widened to the nearest frame: its own, else one that no other has."""
    segment = segments[index]
    first, last = hold(segment.phoneme)
    length = segment.end - segment.start
    start, end = segment.start + first * length, segment.start + last * length
    if kinds[index] is None:
        return start, end
    owner = np.searchsorted([s.end for s in segments[:-1]], times, side="right")
    near = np.abs(times - (start + end) / 2) <= np.diff(times[:2], append=np.inf)[0]
    free = near & np.array([kinds[i] in (None, kinds[index]) for i in owner])
    choices = (times[owner == index], times[free], times)
    choice = next(c for c in choices if len(c))
    nearest = float(choice[np.abs(choice - (start + end) / 2).argmin()])
    return min(start, nearest), max(end, nearest)


def _yielding(
    spans: list[tuple[float, float]], kinds: list[Kind | None], index: int
) -> tuple[float, float]:
    """Hold of a labiodental without the time that closures beside it take."""
    start, end = spans[index]
    if index > 0 and kinds[index - 1] == "lips":
        start = min(max(start, spans[index - 1][1] + _QUICKEST), end)
    if index + 1 < len(spans) and kinds[index + 1] == "lips":
        end = max(min(end, spans[index + 1][0] - _QUICKEST), start)
    return start, end


def _reach(
    segments: tuple[Segment, ...],
    kinds: list[Kind | None],
    spans: list[tuple[float, float]],
    index: int,
    step: int,
) -> float:
    """End of the movement away: the neighbour's hold, or the middle of its time."""
    other = index + step
    if not 0 <= other < len(segments):
        return -np.inf if step < 0 else np.inf
    if kinds[other] is None:
        return segments[other].middle
    return spans[other][1 if step < 0 else 0]


def _room(seconds: float) -> float:
    return float(np.clip(seconds, _QUICKEST, _SLOWEST))
