"""Names of ARKit's 52 face units, which every head moves by.

Other heads write them in their own ways (``jawOpen``, ``JawOpen``, ``mouthSmile_L``,
``blendShape1.mouth_smile_left``).
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from enum import StrEnum


class Unit(StrEnum):
    """Face units that have no left and right, or move all of the face to a side."""

    BROW_INNER_UP = "browInnerUp"
    CHEEK_PUFF = "cheekPuff"
    JAW_FORWARD = "jawForward"
    JAW_LEFT = "jawLeft"
    JAW_OPEN = "jawOpen"
    JAW_RIGHT = "jawRight"
    MOUTH_CLOSE = "mouthClose"
    MOUTH_FUNNEL = "mouthFunnel"
    MOUTH_LEFT = "mouthLeft"
    MOUTH_PUCKER = "mouthPucker"
    MOUTH_RIGHT = "mouthRight"
    MOUTH_ROLL_LOWER = "mouthRollLower"
    MOUTH_ROLL_UPPER = "mouthRollUpper"
    MOUTH_SHRUG_LOWER = "mouthShrugLower"
    MOUTH_SHRUG_UPPER = "mouthShrugUpper"
    TONGUE_OUT = "tongueOut"


class Pair(StrEnum):
    """Movements that are two face units each, one of the left side and one of the right."""

    BROW_DOWN = "browDown"
    BROW_OUTER_UP = "browOuterUp"
    CHEEK_SQUINT = "cheekSquint"
    EYE_BLINK = "eyeBlink"
    EYE_LOOK_DOWN = "eyeLookDown"
    EYE_LOOK_IN = "eyeLookIn"
    EYE_LOOK_OUT = "eyeLookOut"
    EYE_LOOK_UP = "eyeLookUp"
    EYE_SQUINT = "eyeSquint"
    EYE_WIDE = "eyeWide"
    MOUTH_DIMPLE = "mouthDimple"
    MOUTH_FROWN = "mouthFrown"
    MOUTH_LOWER_DOWN = "mouthLowerDown"
    MOUTH_PRESS = "mouthPress"
    MOUTH_SMILE = "mouthSmile"
    MOUTH_STRETCH = "mouthStretch"
    MOUTH_UPPER_UP = "mouthUpperUp"
    NOSE_SNEER = "noseSneer"


_BOTH: dict[str, tuple[str, ...]] = {pair: (f"{pair}Left", f"{pair}Right") for pair in Pair}


def units_of(*movements: str) -> tuple[str, ...]:
    """Names of face units: of a `Pair` the left and the right one, of any other itself."""
    return tuple(unit for name in movements for unit in _BOTH.get(name, (str(name),)))


def by_unit(posture: Mapping[str, float]) -> dict[str, float]:
    """Weights by face unit of a posture in which those of a `Pair` have the same."""
    return {unit: weight for name, weight in posture.items() for unit in units_of(name)}


FACE_UNITS = tuple(sorted(units_of(*Unit, *Pair)))
"""ARKit's 52."""
BROWS, EYES, JAW = (
    tuple(unit for unit in FACE_UNITS if unit.startswith(part)) for part in ("brow", "eye", "jaw")
)
"""Face units that move brows, eyes with their lids, and the lower jaw."""
SHIFTS = units_of(Unit.JAW_LEFT, Unit.JAW_RIGHT), units_of(Unit.MOUTH_LEFT, Unit.MOUTH_RIGHT)
"""Face units that move to a side, left and right, whereas those of a `Pair` lie on theirs."""

WHOLE, PREFIXED, HALF = range(3)
"""How a name means a face unit, the surest first: by all of it, by its end, or a side of the unit
that has none."""
_SIDES = {"l": "Left", "r": "Right", "left": "Left", "right": "Right"}
_HALVED = units_of(Unit.BROW_INNER_UP, Unit.CHEEK_PUFF)
_BY_PLAIN = {name.lower(): (name, WHOLE, "") for name in FACE_UNITS} | {
    f"{name}{side}".lower(): (name, HALF, side) for name in _HALVED for side in ("Left", "Right")
}


def reading(name: str) -> tuple[str | None, int, str]:
    """The face unit that a name means, how it does (`WHOLE`, ...), and the side that is a half.

    A side that the unit does not have, as in ``cheekPuff_L``, is a part of the unit.
    """
    parts = name.split(".")  # Maya puts the deformer before the name, others a side behind it
    own = parts[-1] if len(parts[-1]) > 1 else "_".join(parts[-2:])
    words = [word for word in re.split(r"[^a-z0-9]+", own.lower()) if word]
    found = _read(words)
    for k in range(1, len(words)):  # "head_jawOpen", but not "mouthSmile_L_jawOpen", which is both
        if found or _read(words[:k]) or words[k - 1] in _SIDES:
            break
        found = _read(words[k:])
        if found and found[1] == WHOLE:
            found = found[0], PREFIXED, ""
    return found or (None, WHOLE, "")


def _read(words: Sequence[str]) -> tuple[str, int, str] | None:
    """Reading of words together, with a side before or behind them."""
    plain, first = "".join(words), _SIDES.get("".join(words[:1]))
    last = _SIDES.get(plain[-1:])
    texts = [plain]
    texts += [plain[:-1] + last] if last else []
    texts += ["".join(words[1:]) + first] if first else []
    return next((_BY_PLAIN[text] for text in map(str.lower, texts) if text in _BY_PLAIN), None)
