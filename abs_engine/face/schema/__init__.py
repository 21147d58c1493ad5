"""Names of face units, of identity targets and of a head's regions: nothing else spells them.

Every head moves by ARKit's 52 face units; other heads write them in their own ways (``jawOpen``,
``JawOpen``, ``mouthSmile_L``, ``blendShape1.mouth_smile_left``). Heads differ by identity targets:
MakeHuman's, principal components and people. Regions are parts of meshes.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from enum import StrEnum

from abs_engine.face.settings.shape import SHAPE


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


# Each is a pair of shape targets, less and more, and how far people vary (standard deviation)
PERSON_TARGETS: dict[str, tuple[str, str, float]] = {
    "mouth width": ("mouth_scale_horiz_decr", "mouth_scale_horiz_incr", SHAPE.mouth_target),
    "upper lip height": (
        "mouth_upperlip_height_decr", "mouth_upperlip_height_incr", SHAPE.lip_target,
    ),
    "lower lip height": (
        "mouth_lowerlip_height_decr", "mouth_lowerlip_height_incr", SHAPE.lip_target,
    ),
    "mouth height": ("mouth_trans_down", "mouth_trans_up", SHAPE.mouth_target),
    "cupid's bow": ("mouth_cupidsbow_decr", "mouth_cupidsbow_incr", SHAPE.mouth_target),
    "corners": ("mouth_angles_down", "mouth_angles_up", SHAPE.mouth_target),
    "upper lip flanks": ("mouth_upperlip_ext_down", "mouth_upperlip_ext_up", SHAPE.lip_target),
    "lower lip flanks": ("mouth_lowerlip_ext_up", "mouth_lowerlip_ext_down", SHAPE.lip_target),
    "lower lip width": ("mouth_lowerlip_width_decr", "mouth_lowerlip_width_incr", SHAPE.lip_target),
}  # fmt: skip
"""MakeHuman's targets of the mouth; a head that lacks them has no modes of a person's mouth."""
DRAWN_TARGETS: Mapping[str, float] = {
    "mouth_scale_horiz": 0.20, "mouth_upperlip_height": 0.22, "mouth_lowerlip_height": 0.22,
    "mouth_upperlip_volume": 0.25, "mouth_lowerlip_volume": 0.25, "mouth_cupidsbow": 0.30,
    "chin_bones": 0.22, "chin_height": 0.16, "chin_width": 0.22, "chin_prominent": 0.22,
    "chin_jaw_drop": 0.25, "chin_prognathism": 0.14,
    "nose_hump": 0.28, "nose_nostrils_width": 0.22, "nose_point_width": 0.3,
    "nose_scale_depth": 0.16, "nose_scale_horiz": 0.25, "nose_scale_vert": 0.20,
    "nose_volume": 0.22,
    "cheek_bones": 0.28, "cheek_inner": 0.25, "cheek_volume": 0.20,
    "head_fat": 0.20, "head_scale_depth": 0.13, "head_scale_horiz": 0.10,
    "head_scale_vert": 0.08, "forehead_scale_vert": 0.10,
}  # fmt: skip
"""MakeHuman's pairs of targets, less and more, by which people are drawn by chance: the standard
deviation of each pair's weight; drawn weights stay within two."""
FORMS = ("head_oval", "head_rectangular", "head_round", "head_square", "chin_triangle")
"""MakeHuman's targets of the form of a whole face."""
MACRO = "macro/"
"""Before the names of MakeHuman's targets of origin, sex and age."""
ORIGINS = AFRICAN, ASIAN, CAUCASIAN = "african", "asian", "caucasian"
SEXES = FEMALE, MALE = "female", "male"
COMPONENT = "component/"
"""Before the names of identity targets that are principal components, a standard deviation each."""
PERSON = "person/"
"""Before the name of a target that is one person's difference, which no other varies by."""
_LESS = {"incr": "decr", "up": "down", "forward": "backward", "out": "in"}


def drawn_targets(pair: str, weight: float) -> dict[str, float]:
    """Weights of the targets of one of `DRAWN_TARGETS`: below zero of less, above zero of more.

    Names are spelled as the bundled head has them, ``nose_hump_incr``.
    """
    end = "incr" if weight > 0 else "decr"
    sides = ("l_", "r_") if pair.startswith("cheek") else ("",)
    return {f"{side}{pair}_{end}": abs(weight) for side in sides}


def macro_targets(origin: str, sex: str, age: float) -> dict[str, float]:
    """Weights, 1 together, of MakeHuman's targets of somebody's origin, sex and age, 0 to 1."""
    return {f"{origin}_{sex}_young": 1 - age, f"{origin}_{sex}_old": age}


def less_of(target: str) -> str | None:
    """Name of the target that takes away what this one adds; None if none does.

    Names are spelled as MakeHuman's files are, ``nose/nose-hump-incr``.
    """
    stem, _, end = target.rpartition("-")
    return f"{stem}-{_LESS[end]}" if end in _LESS else None


CLASS_NAMES = (
    "background", "skin", "upper_lip", "lower_lip", "inner_mouth", "upper_teeth", "lower_teeth",
    "tongue", "eyes",
)  # fmt: skip
"""Facet classes of every head, the first of them of no facet."""
TEETH, LIPS, HIDDEN = "teeth", "lips", "none"
"""Words for regions of which upper and lower are found out, and for what is not drawn."""
REGION_WORDS = (*CLASS_NAMES[1:], TEETH, LIPS, HIDDEN)

# Before and behind a word that is written together with others, as in "lefteye" and "teethmesh"
_BEFORE = "l|r|left|right|upper|lower|up|low|top|bottom|facial|body|long|short"
_BEHIND = "l|r|left|right|upper|lower|up|low|top|bottom|mesh|mat|material|geo|shape"
_UPPER, _LOWER = "upper|up|top", "lower|low|bottom"
_PARTS: tuple[tuple[str, str], ...] = (
    (r"(eye ?)?(lash|brow)|hair( ?(cap|card|style|cut|line|band))?|beard|m(o|ou)stache|lacrimal"
     r"|tear( ?(line|duct))?|(eye ?)?occlusion|eye ?blend|caruncle|(eye ?)?glass|eye ?wear|cloth"
     r"|t? ?shirt", HIDDEN),
    (r"teeth|tooth|denture", TEETH),
    (r"tongue", "tongue"),
    (r"gum|inner ?mouth|mouth ?(inner|bag|socket|cavity|interior)|oral", "inner_mouth"),
    (rf"({_UPPER}) ?lip|lips? ?({_UPPER})", "upper_lip"),
    (rf"({_LOWER}) ?lip|lips? ?({_LOWER})", "lower_lip"),
    (r"lip( ?(gloss|stick))?", LIPS),
    (r"eye ?(socket|lid|shadow|liner?)", "skin"),
    (r"cornea", HIDDEN),
    (r"eye( ?ball)?|sclera|iris|pupil", "eyes"),
)  # fmt: skip
ICT_PARTS: Mapping[str, str] = {"M_GumsTongue": "inner_mouth", "M_IrisLeft": HIDDEN,
                                "M_IrisRight": HIDDEN, "M_BackHead": "skin"}  # fmt: skip
"""Materials of ICT's face model whose names do not say what they are here; its irises are the
clear shells before the eyes."""
ICT_68 = (
    1225, 1888, 1052, 367, 1719, 1722, 2199, 1447, 966, 3661, 4390, 3927, 3924, 2608, 3272, 4088,
    3443, 268, 493, 1914, 2044, 1401, 3615, 4240, 4114, 2734, 2509, 978, 4527, 4942, 4857, 1140,
    2075, 1147, 4269, 3360, 1507, 1542, 1537, 1528, 1518, 1511, 3742, 3751, 3756, 3721, 3725, 3732,
    5708, 5695, 2081, 0, 4275, 6200, 6213, 6346, 6461, 5518, 5957, 5841, 5702, 5711, 5533, 6216,
    6207, 6470, 5517, 5966,
)  # fmt: skip
"""Vertices of ICT's face model at the 68 usual landmarks, by its own page."""


def region_of(part: str) -> str:
    """Region of a part of a mesh by its name, one of `REGION_WORDS`; skin where it does not say.

    Only whole words count: there is no hair in "Chair", and no brow in "BrownSkin".
    """
    apart = re.sub(r"(?<=[a-z])(?=[A-Z])|(?<=[A-Z])(?=[A-Z][a-z])", " ", part)
    text = " ".join(re.findall(r"[a-z]+", apart.lower()))
    for pattern, region in _PARTS:
        if re.search(rf"\b({_BEFORE})*({pattern})(s|es|ing)?({_BEHIND})?\b", text):
            return region
    return "skin"
