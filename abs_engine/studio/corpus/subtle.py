"""Small movements of speech beyond the lips' targets: jaw thrust, pressed cheeks, a smile.

No face unit moves the larynx of the bundled head. What the paper's lar1 finds on it is cheeks, and
what the parameters before it leave around the lips.
"""

from __future__ import annotations

import numpy as np

from abs_engine.core.arrays import FloatArray
from abs_engine.face.schema import Pair, Unit, units_of
from abs_engine.studio.speech.dominance import Score, blend
from abs_engine.studio.speech.phonemes import Phoneme
from abs_engine.studio.speech.utterance import Utterance

UNITS = units_of(Unit.JAW_FORWARD, Unit.CHEEK_PUFF)
"""Face units that are set here, which the targets of `abs_engine.studio.speech` leave alone."""
SMILES, LARGEST_SMILE = 0.2, 0.25
"""How many visemes are said with a smile, and its largest weight.

'Whereas instructed to utter neutral speech, the speaker has sometimes smiled' (section 2.2).
"""

THRUST_VARIES, PRESSURE_VARIES = 0.06, 0.07
"""Standard deviation of a viseme's `UNITS` from one utterance to the next: 0.5 and 1 mm."""

# The jaw goes forward to bring the teeth edge to edge for hissing sounds, and back where the lower
# lip goes to the upper teeth. One is 8 mm, so that a hissing sound has 2 to 3.
_THRUST = {
    "bilabial": 0.10, "labiodental": 0.0, "dental": 0.12, "alveolar": 0.15, "postalveolar": 0.18,
    "velar": 0.08, "uvular": 0.04,
}  # fmt: skip
_HISS = {"alveolar": 0.28, "postalveolar": 0.36}
# Pressure behind a closure or a narrow gap bulges the cheeks, most at the lips. One is 14 mm.
_PRESSURE = {"plosive": 0.15, "fricative": 0.06}
_RISE, _FALL = 0.06, 0.06  # seconds


def subtle(utterance: Utterance, times: FloatArray, unit_names: tuple[str, ...]) -> FloatArray:
    """Weights (T, 52) of `UNITS` at times (T,), seconds, blended as `blend` does; else 0."""
    score = _score(utterance)
    out = np.zeros((len(times), len(unit_names)))
    out[:, [unit_names.index(unit) for unit in UNITS]] = blend(score, times)
    return out


def as_it_happens(
    weights: FloatArray, unit_names: tuple[str, ...], rng: np.random.Generator
) -> FloatArray:
    """Weights (52,) of one utterance: thrust and pressure as they vary, now and then a smile."""
    out = weights.copy()
    for unit, spread in zip(UNITS, (THRUST_VARIES, PRESSURE_VARIES), strict=True):
        out[unit_names.index(unit)] += rng.normal(0.0, spread)
    smiling, smile = rng.random() < SMILES, rng.uniform(0, LARGEST_SMILE)
    for unit in units_of(Pair.MOUTH_SMILE):
        out[unit_names.index(unit)] += smile * smiling
    return np.asarray(np.clip(out, 0.0, 1.0), np.float64)


def _score(utterance: Utterance) -> Score:
    segments = utterance.segments
    middle = np.array([s.middle for s in segments])
    half = np.array([0.2 * (s.end - s.start) for s in segments])
    target = np.array([_targets(s.phoneme) for s in segments])
    shape = target.shape
    return Score(
        middle - half, middle + half, target, np.ones(shape), np.full(shape, _RISE),
        np.full(shape, _FALL),
    )  # fmt: skip


def _targets(phoneme: Phoneme) -> tuple[float, float]:
    """Thrust of the jaw, and pressure in the cheeks."""
    if phoneme.manner == "pause":
        return 0.0, 0.0
    if phoneme.is_vowel:  # close vowels, and rounded ones more, have the jaw forward
        return 0.16 * phoneme.height + 0.06 * phoneme.rounding, 0.0
    hissing = phoneme.manner == "fricative" and phoneme.place in _HISS
    thrust = (_HISS if hissing else _THRUST).get(phoneme.place, 0.05)
    front = 1.0 if phoneme.place == "bilabial" else 0.5
    voice = 0.6 if phoneme.voiced else 1.0
    return thrust, _PRESSURE.get(phoneme.manner, 0.0) * front * voice
