"""The performance of a clip's person, whichever way the scene file puts it."""

from __future__ import annotations

import logging
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.errors import ParameterError
from abs_engine.io.assets import Speaker
from abs_engine.studio.scenefile import ClipEntry
from abs_engine.studio.sequence import check_length, expression, utter
from abs_engine.studio.speech import (
    Speech,
    articulate,
    doubtful,
    parse_phonemes,
    play_recording,
    read_livelink,
    read_textgrid,
)
from abs_engine.studio.speech.phonemes import PAUSE
from abs_engine.studio.visemes import ALIASES

_log = logging.getLogger(__name__)
DEFAULT_SENTENCE = "demo"


def perform(
    entry: ClipEntry,
    speaker: Speaker,
    neutral: NDArray[np.float32],
    rate: float,
    folder: Path,
    rng: np.random.Generator,
) -> Speech:
    """Work out what is said in a clip.

    Parameters
    ----------
    neutral : (V, 3) float32, mm
        The person, whose lips must meet where they are to be closed.
    folder : Path
        Where the files that the entry names are looked for.
    rng : numpy.random.Generator
        Of blinks and brows.

    Raises
    ------
    ParameterError, InputFileError
        If it says nothing or several things, or what it says cannot be said.
    """
    where = f"clip '{entry.name}'"
    _check(entry, where)
    try:
        said = _say(entry, speaker, neutral, rate, folder)
    except ParameterError as error:
        raise ParameterError(f"{where}: {error.problem}", error.remedy) from error
    check_length(len(said.weights) * entry.repeat)
    said = _repeated(said, entry.repeat)
    if entry.frames is not None:
        of_sounds = entry.say is not None or entry.textgrid is not None
        still = PAUSE.label if of_sounds else ALIASES[PAUSE.label]
        said = _cut(said, entry.frames, still, where)
    _warn_of_short(said, where)
    if entry.blinks and entry.arkit is None:
        times = np.arange(len(said.weights)) / rate
        said = replace(said, weights=said.weights + expression(times, speaker.unit_names, rng))
    return said


def _check(entry: ClipEntry, where: str) -> None:
    ways = ("sentence", "say", "textgrid", "arkit")
    given = [way for way in ways if getattr(entry, way) is not None]
    if len(given) > 1:
        raise ParameterError(f"{where} has {' and '.join(given)}", "give one of them")
    if entry.repeat < 1 or (entry.frames is not None and entry.frames < 1):
        raise ParameterError(f"{where} has no frames", "give frames and repeat of at least 1")
    check_length(entry.frames or 0)


def _say(
    entry: ClipEntry, speaker: Speaker, neutral: NDArray[np.float32], rate: float, folder: Path
) -> Speech:
    if entry.say is not None:
        text = " ".join(entry.say.split())
        utterance = parse_phonemes(text, entry.alphabet)
        _warn_of_words(text, entry)
        return replace(articulate(speaker, neutral, utterance, rate), text=text)
    if entry.textgrid is not None:
        utterance = read_textgrid(folder / entry.textgrid, entry.tier)
        text = " ".join(segment.phoneme.label for segment in utterance.segments)
        return replace(articulate(speaker, neutral, utterance, rate), text=text)
    if entry.arkit is not None:
        recording = read_livelink(folder / entry.arkit)
        played = play_recording(recording, speaker.unit_names, rate)
        return replace(played, text="(recording)")
    text = DEFAULT_SENTENCE if entry.sentence is None else " ".join(entry.sentence.split())
    frames = None if entry.frames is None else max(1, entry.frames // entry.repeat)
    return utter(text, speaker, neutral, rate, frames)


def _warn_of_words(text: str, entry: ClipEntry) -> None:
    """Say how words in ordinary spelling are read: each of their letters is a sound as well."""
    read = doubtful(text, entry.alphabet)
    if read:
        some = ", ".join(f"'{word}' as {sounds}" for word, sounds in list(read.items())[:3])
        more = f" and {len(read) - 3} more" if len(read) > 3 else ""
        _log.warning(
            "clip '%s' reads %s%s, sound by sound; if that is ordinary spelling, write sounds "
            "instead, such as h @ l @U",
            entry.name, some, more,
        )  # fmt: skip


def _cut(said: Speech, frames: int, still: str, where: str) -> Speech:
    """The same with a number of frames; warns of speech that is lost, and the text tells of it."""
    made = _fitted(said, frames, still)
    before, after = _sounds(said), _sounds(made)
    lost = f"the last {before - after} of {before} sounds"
    if after < before:
        _log.warning("%s: %s lie after its last frame", where, lost)
        return replace(made, text=f"{said.text} (cut: without {lost})")
    if not said.intervals and frames < len(said.weights):
        return replace(made, text=f"{said.text} (cut)")
    return made


def _sounds(said: Speech) -> int:
    return sum(label != PAUSE.label for label, _, _ in said.intervals)


def _warn_of_short(said: Speech, where: str) -> None:
    """Say how many p, b and m no frame is labelled with, as they fall between two frames."""
    closures = [(a, b) for label, a, b in said.intervals if label[0] in "pbm"]
    short = sum(bool(np.ceil(a * said.rate) >= np.ceil(b * said.rate)) for a, b in closures)
    if short:
        _log.warning(
            "%s: %d of %d p, b, m are shorter than a frame, and no frame is labelled with them",
            where, short, len(closures),
        )  # fmt: skip


def _repeated(said: Speech, times: int) -> Speech:
    """The same said several times over."""
    if times == 1:
        return said
    length = len(said.weights) / said.rate
    intervals = tuple(
        (label, start + k * length, min(end, length) + k * length)
        for k in range(times)
        for label, start, end in said.intervals
        if start < length
    )
    return replace(
        said,
        weights=np.tile(said.weights, (times, 1)),
        phonemes=said.phonemes * times,
        intervals=intervals,
        head=None if said.head is None else np.tile(said.head, (times, 1)),
    )


def _fitted(said: Speech, frames: int, still: str) -> Speech:
    """The same cut to a number of frames, or held at its end.

    What begins after the last frame of a cut is left out: none of it is filmed. What was said has
    ended before frames that are held, so they are a pause, labelled `still`.
    """
    take = np.minimum(np.arange(frames), len(said.weights) - 1)
    length = frames / said.rate
    last = (frames - 1) / said.rate + 1e-9 if frames < len(said.weights) else length
    cut = [(a, b, min(c, length)) for a, b, c in said.intervals if b < last]
    phonemes, held = said.phonemes[:frames], max(frames - len(said.weights), 0)
    if cut and held:
        label, start, end = cut[-1]
        paused = (still, start if label == still else end, length)
        cut = [*cut[:-1], paused] if label == still else [*cut, paused]
    return replace(
        said,
        weights=said.weights[take],
        phonemes=phonemes + (still if cut else phonemes[-1],) * held,
        intervals=tuple(cut),
        head=None if said.head is None else said.head[take],
    )
