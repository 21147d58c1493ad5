r"""The chart of the International Phonetic Alphabet, with the X-SAMPA spelling of each symbol.

Source: the chart of the International Phonetic Association (2020), and Wells, J. C. (1995),
"Computer-coding the IPA: a proposed extension of SAMPA".
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import cast

from abs_engine.studio.speech.phonemes import Manner, Phoneme, Place

# A row: place, manner, then IPA symbol and X-SAMPA spelling of its sounds, first the voiceless one.
# A '-' stands for a sound or a spelling that there is not.
_CONSONANTS = r"""
bilabial       plosive     p p    b b    ɓ b_<
bilabial       nasal       - -    m m
bilabial       trill       - -    ʙ B\
bilabial       fricative   ɸ p\   β B
bilabial       click       ʘ O\
labiodental    nasal       - -    ɱ F
labiodental    tap         - -    ⱱ -
labiodental    fricative   f f    v v
labiodental    approximant - -    ʋ v\   ʋ P
dental         fricative   θ T    ð D
dental         click       ǀ |\
alveolar       plosive     t t    d d    ɗ d_<
alveolar       nasal       - -    n n
alveolar       trill       - -    r r
alveolar       tap         - -    ɾ 4
alveolar       fricative   s s    z z
alveolar       lateral     ɬ K    l l    ɮ K\   ɺ l\   ɫ 5
alveolar       click       ǁ |\|\
postalveolar   fricative   ʃ S    ʒ Z
postalveolar   approximant - -    ɹ r\
postalveolar   click       ǃ !\
retroflex      plosive     ʈ t`   ɖ d`
retroflex      nasal       - -    ɳ n`
retroflex      tap         - -    ɽ r`
retroflex      fricative   ʂ s`   ʐ z`
retroflex      approximant - -    ɻ r\`
retroflex      lateral     - -    ɭ l`
alveolopalatal fricative   ɕ s\   ʑ z\
palatal        plosive     c c    ɟ J\   ʄ J\_<
palatal        nasal       - -    ɲ J
palatal        fricative   ç C    ʝ j\
palatal        approximant - -    j j
palatal        lateral     - -    ʎ L
palatal        click       ǂ =\
labial-palatal approximant - -    ɥ H
velar          plosive     k k    ɡ g    ɠ g_<
velar          nasal       - -    ŋ N
velar          fricative   x x    ɣ G    ɧ x\
velar          approximant - -    ɰ M\
velar          lateral     - -    ʟ L\
labial-velar   approximant ʍ W    w w
uvular         plosive     q q    ɢ G\   ʛ G\_<
uvular         nasal       - -    ɴ N\
uvular         trill       - -    ʀ R\
uvular         fricative   χ X    ʁ R
pharyngeal     plosive     ʡ >\
pharyngeal     fricative   ħ X\   ʕ ?\
pharyngeal     trill       ʜ H\   ʢ <\
glottal        plosive     ʔ ?
glottal        fricative   h h    ɦ h\
"""

# A row: height; then, unrounded and rounded, the front, the central and the back vowel.
_VOWELS = r"""
1.00  i i  y y   ɨ 1   ʉ }    ɯ M   u u
0.85  ɪ I  ʏ Y   ᵻ I\  ᵿ U\   - -   ʊ U
0.67  e e  ø 2   ɘ @\  ɵ 8    ɤ 7   o o
0.50  - -  - -   ə @   - -    - -   - -
0.33  ɛ E  œ 9   ɜ 3   ɞ 3\   ʌ V   ɔ O
0.15  æ {  - -   ɐ 6   - -    - -   - -
0.00  a a  ɶ &   - -   - -    ɑ A   ɒ Q
"""
_ROUNDED = {"w": 1.0, "ʍ": 1.0, "ɥ": 1.0, "ɹ": 0.35, "ɻ": 0.35}


def _sounds() -> Iterator[tuple[str, Phoneme]]:
    """X-SAMPA spelling of each sound, and the phoneme."""
    for (place, manner), index, ipa, sampa in _cells(_CONSONANTS, 2):
        yield sampa, Phoneme(
            ipa, cast(Place, place), cast(Manner, manner), voiced=index > 0,
            rounding=_ROUNDED.get(ipa, 0.0),
        )  # fmt: skip
    for (height,), index, ipa, sampa in _cells(_VOWELS, 1):
        yield sampa, Phoneme(
            ipa, "vowel", "vowel", height=float(height), backness=index // 2 / 2,
            rounding=float(index % 2), reduced=ipa in "əᵻᵿ",
        )  # fmt: skip


def _cells(table: str, heads: int) -> Iterator[tuple[list[str], int, str, str]]:
    """Heads of a table's row, and the place in it, IPA symbol and spelling of each sound."""
    for row in table.strip().splitlines():
        words = row.split()
        names = words[heads:]
        for index, pair in enumerate(zip(names[::2], names[1::2], strict=True)):
            yield words[:heads], index, *pair


_SOUNDS = [(sampa, phoneme) for sampa, phoneme in _sounds() if phoneme.label != "-"]

IPA: dict[str, Phoneme] = {phoneme.label: phoneme for _, phoneme in _SOUNDS}
"""Phonemes by IPA symbol."""

X_SAMPA: dict[str, Phoneme] = {sampa: phoneme for sampa, phoneme in _SOUNDS if sampa != "-"}
"""Phonemes by X-SAMPA spelling."""

# Carnegie Mellon's set, which forced aligners of English write; diphthongs are two symbols.
_ARPABET = """
AA ɑ  AE æ  AH ʌ  AO ɔ  AW aʊ̯  AX ə  AXR ə˞  AY aɪ̯  B b  CH t͡ʃ  D d  DH ð  DX ɾ  EH ɛ  ER ɜ˞
EY eɪ̯  F f  G ɡ  HH h  IH ɪ  IX ᵻ  IY i  JH d͡ʒ  K k  L l  M m  N n  NG ŋ  OW oʊ̯  OY ɔɪ̯  P p  Q ʔ
R ɹ  S s  SH ʃ  T t  TH θ  UH ʊ  UW u  UX ʉ  V v  W w  WH ʍ  Y j  Z z  ZH ʒ
"""
ARPABET: dict[str, str] = dict(zip(_ARPABET.split()[::2], _ARPABET.split()[1::2], strict=True))
"""IPA spellings by ARPABET symbol."""
