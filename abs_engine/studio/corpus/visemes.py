"""The visemes of a corpus, in X-SAMPA: vowels, consonants between vowels, silent postures.

Odisio and Bailly (2003), section 2.1.
"""

from __future__ import annotations

from abs_engine.core.errors import ParameterError

VOWELS = ("i", "e", "E", "a", "o", "u", "y", "2", "9", "A~", "E~", "O~", "9~")
"""The oral and nasal vowels of French that the paper names."""
CONTEXTS = ("i", "e", "a", "o", "u", "9")
CONSONANTS = ("p", "t", "k", "b", "d", "g", "f", "v", "s", "z", "S", "Z", "R", "l", "m", "n",
              "D", "T")  # fmt: skip
"""The paper's: those of French, and the two of English 'then' and 'thin'."""
SILENT = ("rest", "preph")
"""Closed mouth, and mouth half open before speech."""


def between(consonant: str, vowel: str) -> str:
    """Name of the consonant between two of a vowel, such as ``ipi``."""
    return f"{vowel}{consonant}{vowel}"


ALL_VISEMES = (*SILENT, *VOWELS, *(between(c, v) for c in CONSONANTS for v in CONTEXTS))
"""All of the paper's corpus: 123."""

PAPER_VISEMES = (
    *SILENT,
    *VOWELS,
    *(between(c, v) for c in CONSONANTS if c != "T" for v in "iau"),
    "epe",
    "opo",
)
"""The 68 that the model is built from.

The paper does not list its 68; it says that none of them has the vowel 9 or the consonant T. Here
they are the 17 other consonants between i, a and u, and p between e and o.
"""


def spelled(viseme: str) -> tuple[str, int]:
    """Phonemes as `parse_phonemes` reads them, and the place of the viseme in it.

    Raises
    ------
    ParameterError
        If it is neither one of `VOWELS` nor a sound between two of one vowel, a letter each.
    """
    if viseme in VOWELS:
        return f"_(0.3) {viseme}(0.5) _(0.3)", 1
    if len(viseme) != 3 or viseme[0] != viseme[2]:
        raise ParameterError(
            f"there is no viseme '{viseme}'",
            f"give rest, preph, one of {', '.join(VOWELS)}, or one such as ipi",
        )
    vowel, consonant = viseme[0], viseme[1]
    return f"_(0.3) {vowel} {consonant} {vowel} _(0.3)", 2
