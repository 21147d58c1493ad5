"""Phonemes as bundles of articulatory features, and the chart of the IPA that names them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

Place = Literal[
    "bilabial", "labiodental", "labial-velar", "labial-palatal", "dental", "alveolar",
    "postalveolar", "retroflex", "alveolopalatal", "palatal", "velar", "uvular", "pharyngeal",
    "glottal", "vowel", "pause",
]  # fmt: skip
Manner = Literal[
    "plosive", "nasal", "trill", "tap", "fricative", "affricate", "approximant", "lateral", "click",
    "vowel", "pause",
]  # fmt: skip


@dataclass(frozen=True)
class Phoneme:
    """A speech sound.

    Parameters
    ----------
    label : str
        In the IPA, with its diacritics and without stress; '_' for a pause.
    place : str
        Of a consonant; else 'vowel' or 'pause'.
    manner : str
        Of a consonant; else 'vowel' or 'pause'.
    height : float
        Of a vowel: 0 open, 1 close.
    backness : float
        Of a vowel: 0 front, 1 back.
    rounding : float
        Of the lips, 0 to 1; also that of a labialised consonant.
    reduced : bool
        A vowel without a target of its own, as the first of 'about'.
    nasal : bool
        Of a vowel.
    stress : int
        2 primary, 1 secondary, 0 none.
    length : float
        Factor of the default duration.
    """

    label: str
    place: Place
    manner: Manner
    voiced: bool = True
    height: float = 0.0
    backness: float = 0.0
    rounding: float = 0.0
    palatalised: bool = False
    rhotic: bool = False
    reduced: bool = False
    nasal: bool = False
    stress: int = 0
    length: float = 1.0

    @property
    def is_vowel(self) -> bool:
        """Whether it is a vowel."""
        return self.manner == "vowel"

    @property
    def closes_lips(self) -> bool:
        """Whether the lips touch all along: bilabial stops, nasals and clicks."""
        return self.place == "bilabial" and self.manner in ("plosive", "nasal", "click")

    @property
    def touches_teeth(self) -> bool:
        """Whether the lower lip touches the upper teeth; in approximants it only comes near."""
        return self.place == "labiodental" and self.manner != "approximant"


PAUSE = Phoneme("_", "pause", "pause", voiced=False)
