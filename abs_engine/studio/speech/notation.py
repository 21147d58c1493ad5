"""X-SAMPA and IPA: from spelling to phonemes."""

from __future__ import annotations

import difflib
import re
import unicodedata
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Literal

from abs_engine.core.errors import ParameterError
from abs_engine.studio.speech.chart import ARPABET, IPA, X_SAMPA
from abs_engine.studio.speech.phonemes import PAUSE, Phoneme

Alphabet = Literal["x-sampa", "ipa", "arpabet"]
_Change = Callable[[Phoneme], Phoneme]


def _longer(factor: float) -> _Change:
    return lambda p: replace(p, length=p.length * factor)


def _more(feature: str, step: float) -> _Change:
    """More of a feature that goes from 0 to 1; less where the step is below 0."""
    return lambda p: replace(p, **{feature: min(max(getattr(p, feature) + step, 0.0), 1.0)})


def _same(phoneme: Phoneme) -> Phoneme:
    return phoneme


# IPA mark, X-SAMPA marks, and what it does to the sound as seen from outside.
_MARKS: tuple[tuple[str, tuple[str, ...], _Change], ...] = (
    ("ː", (":",), _longer(1.6)),
    ("ˑ", (":\\",), _longer(1.3)),
    ("\u0306", ("_X",), _longer(0.6)),  # extra short
    ("\u032f", ("_^",), _longer(0.6)),  # not syllabic
    ("\u0329", ("_=", "="), _longer(1.4)),  # syllabic
    ("\u0303", ("_~", "~"), lambda p: replace(p, nasal=True)),
    ("ʷ", ("_w",), _more("rounding", 0.7)),
    ("ʲ", ("_j", "'"), lambda p: replace(p, palatalised=True)),
    ("˞", ("`",), lambda p: replace(p, rhotic=True)),
    ("\u0339", ("_O",), _more("rounding", 0.25)),
    ("\u031c", ("_c",), _more("rounding", -0.25)),
    ("\u031d", ("_r",), _more("height", 0.12)),
    ("\u031e", ("_o",), _more("height", -0.12)),
    ("\u031f", ("_+",), _more("backness", -0.25)),
    ("\u0320", ("_-",), _more("backness", 0.25)),
    ("\u0308", ('_"',), lambda p: replace(p, backness=0.5)),
    ("\u033d", ("_x",), lambda p: replace(p, backness=0.5)),
    # The rest leaves lips and jaw where they are: phonation, release, tone, places in the mouth.
    ("\u0325", ("_0",), _same), ("\u030a", (), _same), ("\u032c", ("_v",), _same),
    ("\u0324", ("_t",), _same), ("\u0330", ("_k",), _same), ("\u033c", ("_N",), _same),
    ("\u032a", ("_d",), _same), ("\u033a", ("_a",), _same), ("\u033b", ("_m",), _same),
    ("\u031a", ("_}",), _same), ("\u0334", ("_e",), _same), ("\u0318", ("_A",), _same),
    ("\u0319", ("_q",), _same), ("ʰ", ("_h",), _same), ("ʱ", ("_h\\",), _same),
    ("ⁿ", ("_n",), _same), ("ˡ", ("_l",), _same), ("ˠ", ("_G",), _same),
    ("ˤ", ("_?\\",), _same), ("ʼ", ("_>",), _same),
    ("˥", ("_T",), _same), ("˦", ("_H",), _same), ("˧", ("_M",), _same), ("˨", ("_L",), _same),
    ("˩", ("_B",), _same), ("\u0301", (), _same), ("\u0300", (), _same), ("\u0304", (), _same),
    ("\u030b", (), _same), ("\u030f", (), _same), ("\u030c", ("_R",), _same),
    ("\u0302", ("_F",), _same),
)  # fmt: skip


@dataclass(frozen=True)
class _Script:
    """Spelling of an alphabet: sounds, marks after them, ties, stress, pauses, and what is void."""

    sounds: Mapping[str, Phoneme]
    marks: Mapping[str, tuple[str, _Change]]
    ties: tuple[str, ...]
    stress: Mapping[str, int]
    pauses: tuple[str, ...]
    void: tuple[str, ...]


def _nfd(text: str) -> str:
    return unicodedata.normalize("NFD", text)


_SCRIPTS: dict[str, _Script] = {
    "ipa": _Script(
        {_nfd(symbol): phoneme for symbol, phoneme in (*IPA.items(), ("g", IPA["ɡ"]))}
        | {"ɚ": replace(IPA["ə"], rhotic=True), "ɝ": replace(IPA["ɜ"], rhotic=True)},
        {mark: (mark, change) for mark, _, change in _MARKS} | {":": ("ː", _longer(1.6))},
        ("\u0361", "\u035c"),
        {"ˈ": 2, "'": 2, "ˌ": 1},
        ("_", "#", "|", "‖"),
        (".", "‿", "-"),
    ),
    "x-sampa": _Script(
        X_SAMPA,
        {mark: (ipa, change) for ipa, marks, change in _MARKS for mark in marks},
        ("_",),
        {'"': 2, "%": 1},
        ("_", "#", "|", "||"),
        (".", "-\\", "-"),
    ),
}


def spell(text: str, alphabet: Alphabet) -> tuple[Phoneme, ...]:
    """Phonemes of one token, without spaces.

    Parameters
    ----------
    text : str
        One or more sounds with their marks, such as 'p', 'a:' or 'bɔ̃ʒuʁ'; or a pause.
    alphabet : {"x-sampa", "ipa", "arpabet"}

    Raises
    ------
    ParameterError
        If the alphabet is unknown, or a sound, whose nearest is named.
    """
    if alphabet == "arpabet":
        return _spell_arpabet(text)
    if alphabet not in _SCRIPTS:
        raise ParameterError(
            f"there is no phonetic alphabet '{alphabet}'", "choose x-sampa, ipa or arpabet"
        )
    script = _SCRIPTS[alphabet]
    if text in script.pauses:
        return (PAUSE,)
    return _scan(_nfd(text), script, alphabet)


def _spell_arpabet(text: str) -> tuple[Phoneme, ...]:
    found = re.fullmatch(r"([A-Za-z]+)([012]?)", text)
    name = found[1].upper() if found else text
    if found is None or name not in ARPABET:
        raise _unknown(text, text, "arpabet", tuple(ARPABET))
    stress = {"1": 2, "2": 1}.get(found[2], 0)
    plain = "ə" if (name, found[2]) == ("AH", "0") else ARPABET[name]
    sounds = spell(plain, "ipa")
    return tuple(replace(p, stress=stress if p is sounds[0] and p.is_vowel else 0) for p in sounds)


def _scan(text: str, script: _Script, alphabet: str) -> tuple[Phoneme, ...]:
    """Take the longest symbol at each place; stress waits for the next vowel."""
    found: list[Phoneme] = []
    at, stress, tied = 0, 0, False
    while at < len(text):
        sign = _longest(text, at, (*script.stress, *script.void)) if not tied else ""
        mark = _longest(text, at, tuple(script.marks)) if found and not tied else ""
        tie = _longest(text, at, script.ties) if found and not tied else ""
        sound = _longest(text, at, tuple(script.sounds))
        size = max(len(sign), len(mark), len(tie), len(sound))
        if size == 0:
            raise _unknown(text, text[at], alphabet, tuple(script.sounds))
        if size == len(mark):
            name, change = script.marks[mark]
            found[-1] = _marked(found[-1], name, change)
        elif size == len(sound):
            phoneme = script.sounds[sound]
            if phoneme.is_vowel:
                phoneme, stress = replace(phoneme, stress=stress), 0
            found[-1:] = _tied(found[-1], phoneme) if tied else [*found[-1:], phoneme]
            tied = False
        elif size == len(sign):
            stress = script.stress.get(sign, stress)
        else:
            tied = True
        at += size
    if not found or tied:
        raise _unknown(text, text, alphabet, tuple(script.sounds))
    return tuple(found)


def _longest(text: str, at: int, names: tuple[str, ...]) -> str:
    return max((n for n in names if text.startswith(n, at)), key=len, default="")


def _marked(phoneme: Phoneme, mark: str, change: _Change) -> Phoneme:
    label = unicodedata.normalize("NFC", phoneme.label + mark)
    return replace(change(phoneme), label=label)


def _tied(first: Phoneme, second: Phoneme) -> list[Phoneme]:
    """One sound of two that are tied, or two halves where the lips do one thing after the other."""
    label = f"{first.label}\u0361{second.label}"
    if first.manner == second.manner:  # such as k͡p: both at once, and the lips show one
        seen = first if first.closes_lips else second
        return [replace(seen, label=label)]
    if first.closes_lips:  # such as p͡f
        return [replace(first, length=0.6), replace(second, length=0.7)]
    return [replace(second, label=label, manner="affricate")]


def _unknown(text: str, rest: str, alphabet: str, known: tuple[str, ...]) -> ParameterError:
    where = f" in '{text}'" if rest != text else ""
    return ParameterError(
        f"'{rest}'{where} is not in {_TITLES[alphabet]} (nearest: '{nearest(rest, known)}')",
        "write sounds such as " + " ".join(known[:8]) + ", durations such as a(0.12), pauses as _",
    )


_TITLES = {"ipa": "the IPA", "x-sampa": "X-SAMPA", "arpabet": "ARPABET"}


def nearest(text: str, known: tuple[str, ...]) -> str:
    """The known symbol most like the text: by spelling, else by the first letter's Unicode name."""
    for candidate in (text, text.lower(), text[:1], text[:1].lower()):
        close = difflib.get_close_matches(candidate, known, n=1, cutoff=0.5)
        if close:
            return close[0]
    names = {unicodedata.name(symbol[0], ""): symbol for symbol in reversed(known)}
    wanted = unicodedata.name(text[:1] or " ", "")
    return names[difflib.get_close_matches(wanted, list(names), n=1, cutoff=0.0)[0]]


def doubtful(text: str, alphabet: Alphabet) -> dict[str, str]:
    """Tokens that look like words in ordinary spelling, and how each is read, sounds in the IPA.

    All letters are sounds of X-SAMPA and of the IPA, so a word is no error: it is read letter by
    letter. Four letters without a mark look like a word, three do where nothing else is marked.

    Raises
    ------
    ParameterError
        If a sound is unknown.
    """
    if alphabet == "arpabet":
        return {}
    tokens = [re.sub(r"\([^()]*\)$", "", token) for token in text.split()]
    tokens = [token for token in tokens if token not in _SCRIPTS["x-sampa"].pauses]
    words = [token for token in tokens if re.fullmatch(r"[A-Za-z][a-z]{2,}", token)]
    plain = len(words) > 1 and all(re.fullmatch(r"[A-Za-z][a-z]*", token) for token in tokens)
    taken = [word for word in words if plain or len(word) > 3]
    return {word: " ".join(p.label for p in spell(word, alphabet)) for word in taken}
