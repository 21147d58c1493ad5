"""An utterance: phonemes and when each is spoken."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from abs_engine.core.errors import ParameterError
from abs_engine.studio.speech.notation import Alphabet, spell
from abs_engine.studio.speech.phonemes import PAUSE, Phoneme

_SLACK = 1e-6
"""Seconds by which times may overlap through rounding."""

# Seconds, typical of read sentences (Klatt 1976, "Linguistic uses of segmental duration in
# English", gives the same order: stops and nasals below fricatives below stressed vowels).
_SECONDS = {
    "pause": 0.25,
    "vowel": 0.11,
    "plosive": 0.09,
    "click": 0.10,
    "nasal": 0.08,
    "trill": 0.08,
    "tap": 0.04,
    "fricative": 0.09,
    "affricate": 0.12,
    "approximant": 0.075,
    "lateral": 0.075,
}


@dataclass(frozen=True)
class Segment:
    """A phoneme and its time.

    Parameters
    ----------
    start, end : float
        Seconds.
    """

    phoneme: Phoneme
    start: float
    end: float

    @property
    def middle(self) -> float:
        """Seconds."""
        return (self.start + self.end) / 2


@dataclass(frozen=True)
class Utterance:
    """Phonemes from 0 seconds on, one after the other, pauses among them.

    Parameters
    ----------
    segments : tuple of Segment
        Each begins where the one before ends.

    Raises
    ------
    ParameterError
        If there is none, or one has no length, or they overlap or leave a gap.
    """

    segments: tuple[Segment, ...]

    def __post_init__(self) -> None:
        if not self.segments:
            raise ParameterError("there is nothing to say", "give at least one phoneme")
        for segment in self.segments:
            if not segment.start < segment.end < float("inf"):
                raise ParameterError(
                    f"'{segment.phoneme.label}' lasts from {segment.start:g} to {segment.end:g} s",
                    "give it a positive duration",
                )
        if abs(self.segments[0].start) > _SLACK:
            raise ParameterError("the utterance does not begin at 0 s", "put a pause before it")
        for one, other in pairwise(self.segments):
            if abs(one.end - other.start) > _SLACK:
                raise ParameterError(
                    f"'{one.phoneme.label}' ends at {one.end:g} s, but '{other.phoneme.label}' "
                    f"begins at {other.start:g} s",
                    "let each phoneme begin where the one before ends",
                )

    @property
    def seconds(self) -> float:
        """Length."""
        return self.segments[-1].end


def default_seconds(phoneme: Phoneme) -> float:
    """Duration, seconds, of a phoneme that comes without one: by class, stress and length mark."""
    seconds = _SECONDS[phoneme.manner] * phoneme.length
    if phoneme.is_vowel:
        seconds *= (0.6 if phoneme.reduced else 1.0) * (1.0 + 0.15 * phoneme.stress)
        seconds *= 1.2 if phoneme.nasal else 1.0
    elif phoneme.voiced and phoneme.manner in ("plosive", "fricative", "affricate"):
        seconds *= 0.8
    return seconds


def parse_phonemes(text: str, alphabet: Alphabet = "x-sampa") -> Utterance:
    """Read phonemes.

    Tokens stand between spaces. Each is one or more sounds with stress and length marks, and may
    end in a duration or in its times, seconds: ``_ "h@(0.2) l@U(0.35-0.6) _(0.3)``. Without one,
    sounds last what is usual for their class; sounds in one token share its time in proportion.
    ``_``, ``#`` and ``|`` are pauses; a space between words is none.

    Parameters
    ----------
    alphabet : {"x-sampa", "ipa", "arpabet"}

    Returns
    -------
    Utterance
        Time that no token covers is a pause.

    Raises
    ------
    ParameterError
        If there is nothing, a sound is unknown (the nearest is named), a duration is not
        positive, or times overlap.
    """
    parts: list[tuple[tuple[Phoneme, ...], float, float]] = []
    clock = 0.0
    for token in text.split():
        sounds, when = _split(token)
        phonemes = spell(sounds, alphabet)
        start, end = _times(token, when, clock, sum(map(default_seconds, phonemes)))
        parts.append((phonemes, start, end))
        clock = end
    return assemble(parts)


def assemble(
    parts: Sequence[tuple[tuple[Phoneme, ...], float, float]], seconds: float = 0.0
) -> Utterance:
    """Utterance of (phonemes, start, end) in order; pauses fill the gaps, and up to `seconds`.

    Raises
    ------
    ParameterError
        If there is none but pauses, or one has no length.
    """
    segments: list[Segment] = []
    for phonemes, start, end in parts:
        clock = segments[-1].end if segments else 0.0
        if start > clock + _SLACK:
            _append(segments, PAUSE, clock, start)
            clock = start
        ends = np.cumsum([default_seconds(p) for p in phonemes])
        for phoneme, share in zip(phonemes, ends / ends[-1], strict=True):
            _append(segments, phoneme, clock, start + (end - start) * float(share))
            clock = segments[-1].end
    if segments and seconds > segments[-1].end + _SLACK:
        _append(segments, PAUSE, segments[-1].end, seconds)
    return Utterance(tuple(segments))


def _append(segments: list[Segment], phoneme: Phoneme, start: float, end: float) -> None:
    """Add a segment; a pause after a pause makes that one longer."""
    if segments and phoneme == PAUSE == segments[-1].phoneme:
        start = segments.pop().start
    segments.append(Segment(phoneme, start, end))


def _split(token: str) -> tuple[str, str]:
    """The sounds of a token and what stands in brackets behind them."""
    found = re.fullmatch(r"(.+?)\(([^()]*)\)", token)
    if found is None and "(" in token:
        raise ParameterError(
            f"'{token}' is not a phoneme with a duration",
            "write one such as a(0.12) or a(0.30-0.42)",
        )
    return (found[1], found[2]) if found else (token, "")


def _times(token: str, when: str, clock: float, usual: float) -> tuple[float, float]:
    """Start and end of a token from what stands in its brackets."""
    if not when and not token.endswith(")"):
        return clock, clock + usual
    number = r"(-?\d*\.?\d+)"
    found = re.fullmatch(rf"{number}s?(?:-{number}s?)?", when)
    if found is None:
        raise ParameterError(
            f"'{when}' in '{token}' is not a duration",
            "write seconds, such as a(0.12) or a(0.3-0.42)",
        )
    start, end = (
        (clock, clock + float(found[1])) if found[2] is None else map(float, found.groups())
    )
    if not end > start >= 0:
        raise ParameterError(f"the duration of '{token}' is not positive", "give seconds above 0")
    if start < clock - _SLACK:
        raise ParameterError(
            f"'{token}' begins at {start:g} s, but what stands before it ends at {clock:g} s",
            "let no phonemes overlap",
        )
    return start, end
