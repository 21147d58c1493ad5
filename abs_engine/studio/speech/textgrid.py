"""Phonemes and their times from a Praat TextGrid, as forced aligners write them."""

from __future__ import annotations

import re
from pathlib import Path

from praatio import textgrid as praat
from praatio.utilities.errors import PraatioException

from abs_engine.core.errors import InputFileError, ParameterError
from abs_engine.io.inputs import check_file
from abs_engine.studio.speech.chart import ARPABET
from abs_engine.studio.speech.notation import Alphabet, spell
from abs_engine.studio.speech.phonemes import PAUSE, Phoneme
from abs_engine.studio.speech.utterance import Utterance, assemble

_PHONE_TIERS = re.compile(r"(^|\b)(phon(e|eme)?s?|mau|segments?|ipa|x?-?sampa)$", re.IGNORECASE)
"""Names that aligners give to the tier of phonemes; the speaker's name may stand before."""

_SILENCES = {
    "", "_", "#", "-", "|", "sil", "sp", "spn", "pau", "<p:>", "<p>", "<usb>", "<nib>", "<eps>",
    "<sil>", "h#", "silence", "...",
}  # fmt: skip


def read_textgrid(path: Path | str, tier: str | None = None) -> Utterance:
    """Read an utterance from a Praat TextGrid.

    Parameters
    ----------
    path : Path
        Long or short text format, UTF-8 or UTF-16.
    tier : str, optional
        Name of the interval tier with the phonemes. By default the one that is named as aligners
        name it ('phones', 'MAU', ...), else the only one whose labels are all phonemes.

    Returns
    -------
    Utterance
        From the grid's beginning to its end; empty labels, 'sil' and the like are pauses. The
        alphabet is the first of ARPABET, X-SAMPA and the IPA that spells all labels.

    Raises
    ------
    InputFileError
        If the file is missing or no TextGrid, has no such tier, or its intervals overlap.
    ParameterError
        If a label is no phoneme; the nearest is named.
    """
    path = Path(path)
    grid = _open(path)
    name = _choose(path, grid, tier)
    spans = [(float(i.start), float(i.end), i.label.strip()) for i in grid.getTier(name).entries]
    chosen = _guess([label for *_, label in spans])
    begin = float(grid.minTimestamp)
    parts = [
        (_sounds(path, label, start, chosen), start - begin, end - begin)
        for start, end, label in spans
    ]
    if all(phonemes == (PAUSE,) for phonemes, *_ in parts):
        raise InputFileError(f"tier '{name}' of {path} is empty", "name the tier with the phonemes")
    return assemble(parts, float(grid.maxTimestamp) - begin)


def _open(path: Path) -> praat.Textgrid:
    check_file(path)
    try:
        return praat.openTextgrid(str(path), False, "silence", "rename")
    except PraatioException as error:
        reason = " ".join(str(error).split())[:120] or type(error).__name__
        raise InputFileError(
            f"{path} cannot be read: {reason}", "correct it in Praat and save it as text"
        ) from error
    except (ValueError, LookupError, AttributeError, TypeError, OSError, RecursionError) as error:
        raise InputFileError(
            f"{path} is not a TextGrid", "save it from Praat as a text file in UTF-8"
        ) from error


def _choose(path: Path, grid: praat.Textgrid, tier: str | None) -> str:
    """Name of the interval tier that is wanted."""
    names = [n for n in grid.tierNames if isinstance(grid.getTier(n), praat.IntervalTier)]
    if tier is not None:
        if tier not in names:
            raise InputFileError(
                f"{path} has no interval tier '{tier}'", f"choose one of {', '.join(names) or '-'}"
            )
        return tier
    likely = [n for n in names if _PHONE_TIERS.search(n)]
    if not likely:
        likely = [n for n in names if _spelt([i.label.strip() for i in grid.getTier(n).entries])]
    if not likely and len(names) == 1:
        likely = names
    if len(likely) != 1:
        raise InputFileError(
            f"which tier of {path} holds the phonemes is not clear",
            f"name one of {', '.join(likely or names) or '-'}",
        )
    return str(likely[0])


def _guess(labels: list[str]) -> Alphabet:
    spelt = _spelt(labels)
    return spelt[0] if spelt else ("x-sampa" if all(map(str.isascii, labels)) else "ipa")


def _spelt(labels: list[str]) -> list[Alphabet]:
    """Alphabets that spell all labels, the likeliest first."""
    voiced = [label for label in labels if label.lower() not in _SILENCES]
    order: list[Alphabet] = ["x-sampa", "ipa"]
    if any(len(label) > 1 and label.rstrip("012") in ARPABET for label in voiced):
        order = ["arpabet", *order]
    found: list[Alphabet] = []
    for alphabet in order if voiced else []:
        try:
            for label in set(voiced):
                spell(label, alphabet)
        except ParameterError:
            continue
        found.append(alphabet)
    return found


def _sounds(path: Path, label: str, start: float, alphabet: Alphabet) -> tuple[Phoneme, ...]:
    if label.lower() in _SILENCES:
        return (PAUSE,)
    try:
        return spell(label, alphabet)
    except ParameterError as error:
        raise ParameterError(
            f"{path}, at {start:g} s: {error.problem}",
            "correct the label, or name another tier",
        ) from error
