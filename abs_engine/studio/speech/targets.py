"""Targets of lips and jaw for a phoneme, composed from its features."""

from __future__ import annotations

from dataclasses import dataclass, replace

from abs_engine.face.schema import Pair, Unit, units_of
from abs_engine.studio.speech.phonemes import Phoneme

ARTICULATORS: dict[str, tuple[str, ...]] = {
    "jaw": units_of(Unit.JAW_OPEN),
    "pucker": units_of(Unit.MOUTH_PUCKER),
    "funnel": units_of(Unit.MOUTH_FUNNEL),
    "smile": units_of(Pair.MOUTH_SMILE),
    "stretch": units_of(Pair.MOUTH_STRETCH),
    "upper": units_of(Pair.MOUTH_UPPER_UP),
    "lower": units_of(Pair.MOUTH_LOWER_DOWN),
    "roll_lower": units_of(Unit.MOUTH_ROLL_LOWER),
    "roll_upper": units_of(Unit.MOUTH_ROLL_UPPER),
    "tongue": units_of(Unit.TONGUE_OUT),
}
"""Face units that move together, by the articulator's name."""

_LIPS = ("pucker", "funnel", "smile", "stretch", "upper", "lower", "roll_lower", "roll_upper")
_ROUNDING = ("pucker", "funnel", "smile", "stretch")


@dataclass(frozen=True)
class Goal:
    """Target that a phoneme sets for an articulator.

    Parameters
    ----------
    target : float
        Weight of its face units.
    magnitude : float
        Of the dominance; a sound that does not care has little.
    """

    target: float = 0.0
    magnitude: float = 0.04


# Jaw opening and the dominance of the jaw by place of a consonant: the nearer to the teeth a sound
# is made, the higher the jaw has to be; sibilants need it most, the throat does not care.
_JAW = {
    "bilabial": Goal(0.05, 0.4),
    "labiodental": Goal(0.06, 0.6),
    "labial-velar": Goal(0.13, 0.6),
    "labial-palatal": Goal(0.12, 0.6),
    "dental": Goal(0.10, 0.6),
    "alveolar": Goal(0.10, 0.5),
    "postalveolar": Goal(0.12, 0.6),
    "retroflex": Goal(0.14, 0.5),
    "alveolopalatal": Goal(0.10, 0.6),
    "palatal": Goal(0.13, 0.5),
    "velar": Goal(0.17, 0.35),
    "uvular": Goal(0.20, 0.35),
    "pharyngeal": Goal(0.28, 0.4),
    "glottal": Goal(0.20, 0.05),
}
_SIBILANTS = {
    "alveolar": {"jaw": 0.06, "stretch": 0.20, "lower": 0.30, "upper": 0.20},
    "postalveolar": {"jaw": 0.08, "funnel": 0.50, "upper": 0.20, "lower": 0.20},
    "retroflex": {"jaw": 0.09, "funnel": 0.40, "upper": 0.20, "lower": 0.20},
    "alveolopalatal": {"jaw": 0.07, "funnel": 0.20, "stretch": 0.15, "upper": 0.2, "lower": 0.25},
}


_PARTING = 0.015
"""Jaw opening that takes up what the lips overlap at rest, 0.8 mm on the bundled head."""


def goals(phoneme: Phoneme) -> dict[str, Goal]:
    """Goal of each articulator."""
    if phoneme.manner == "pause":
        return dict.fromkeys(ARTICULATORS, Goal(0.0, 0.5))
    made = _vowel(phoneme) if phoneme.is_vowel else _consonant(phoneme)
    if not phoneme.closes_lips:
        made["jaw"] = replace(made["jaw"], target=made["jaw"].target + _PARTING)
    return {name: made.get(name, Goal()) for name in ARTICULATORS}


def _vowel(p: Phoneme) -> dict[str, Goal]:
    """Height opens the jaw, rounding protrudes the lips, front and close spreads them."""
    openness, frontness = 1.0 - p.height, 1.0 - p.backness
    plain = 1.0 - p.rounding
    care = 0.3 if p.reduced else 1.0 + 0.25 * p.stress
    jaw = 0.13 + 0.42 * openness * (0.35 if p.reduced else 1.0) + 0.02 * p.stress * openness
    spread = frontness * p.height * plain
    targets = {
        "jaw": jaw,
        "smile": 0.40 * spread,
        "stretch": 0.32 * spread + 0.10 * plain * openness * frontness,
        "lower": 0.10 + 0.22 * spread,
        "upper": 0.10 * openness,
    } | _round(p.rounding * (0.7 if p.reduced else 1.0), openness)
    if p.rhotic:
        targets["pucker"] = max(targets["pucker"], 0.25)
    made = {name: Goal(target, care) for name, target in targets.items()}
    if not p.rounding and not p.rhotic:  # lips at ease give way to a rounded neighbour
        ease = care * (0.3 + 0.4 * spread)
        made |= {name: Goal(made[name].target, ease) for name in _ROUNDING}
    return made


def _round(rounding: float, openness: float) -> dict[str, float]:
    """Close rounded vowels purse the lips, open ones funnel them."""
    return {
        "pucker": rounding * max(0.72 - 0.85 * openness, 0.15),
        "funnel": rounding * min(0.15 + 0.80 * openness, 0.60),
    }


def _consonant(p: Phoneme) -> dict[str, Goal]:
    made = {"jaw": _JAW[p.place], "lower": Goal(0.12, 0.2), "upper": Goal(0.04, 0.2)}
    if p.place == "glottal":
        return {name: Goal(made.get(name, Goal()).target, 0.05) for name in ARTICULATORS}
    if p.manner in ("fricative", "affricate") and p.place in _SIBILANTS:
        strength = 1.0 if p.place == "alveolar" else 1.5
        shape = _SIBILANTS[p.place]
        made |= {name: Goal(value, strength) for name, value in shape.items()}
        if p.place != "alveolar":
            made |= {name: Goal(shape.get(name, 0.0), 0.6) for name in ("smile", "stretch")}
    elif p.place == "bilabial":
        made |= _bilabial(p)
    elif p.place == "labiodental":
        near = 0.45 if p.manner == "approximant" else 0.65
        made |= {"roll_lower": Goal(near, 3.0), "upper": Goal(0.10, 2.0), "lower": Goal(0.0, 2.0)}
    elif p.place == "dental":
        made |= {"tongue": Goal(0.12, 1.0)}
    elif p.place == "palatal" or p.palatalised:
        made |= {"smile": Goal(0.15, 0.3), "stretch": Goal(0.15, 0.3)}
    if p.rounding:
        made |= _protrusion(p)
    return made


def _bilabial(p: Phoneme) -> dict[str, Goal]:
    """Lips that meet are rolled in a little; lips that only come near stay apart."""
    if p.closes_lips:
        rolled = {"roll_lower": Goal(0.12, 1.5), "roll_upper": Goal(0.10, 1.5)}
        return rolled | {"upper": Goal(0.0, 2.0), "lower": Goal(0.0, 2.0), "jaw": Goal(0.04, 0.6)}
    return {"jaw": Goal(0.06, 1.5), "upper": Goal(0.04, 1.5), "lower": Goal(0.0, 1.5)}


def _protrusion(p: Phoneme) -> dict[str, Goal]:
    """Rounding of a consonant: as of a close vowel, the stronger the more it matters."""
    strength = 0.4 + 1.6 * p.rounding
    made = {n: Goal(v * 1.1, strength) for n, v in _round(p.rounding, 0.0).items()}
    return made | {"smile": Goal(0.0, strength), "stretch": Goal(0.0, strength)}


# Seconds in which dominance changes by a factor e, before and after: protrusion is anticipated.
_PACE = {"jaw": (0.045, 0.045), "pucker": (0.100, 0.065), "funnel": (0.085, 0.060)}
_PACE_OF_LIPS = (0.055, 0.050)
_PACE_OF_TONGUE = (0.030, 0.030)


def pace(phoneme: Phoneme, articulator: str) -> tuple[float, float]:
    """Seconds of rise and of fall of a phoneme's dominance over an articulator."""
    others = _PACE_OF_LIPS if articulator in _LIPS else _PACE_OF_TONGUE
    rise, fall = _PACE.get(articulator, others)
    quick = 0.7 if phoneme.closes_lips or phoneme.touches_teeth else 1.0
    return rise * quick, fall * quick


def hold(phoneme: Phoneme) -> tuple[float, float]:
    """Shares of a phoneme's time between which its dominance is whole.

    A stop's closure ends before the sound does, in the burst; a nasal is closed all along.
    """
    if phoneme.manner in ("plosive", "click"):
        return 0.10, 0.75
    if phoneme.manner == "nasal":
        return 0.05, 0.95
    if phoneme.manner == "pause":
        return 0.25, 0.75
    return (0.35, 0.65) if phoneme.is_vowel else (0.20, 0.80)
