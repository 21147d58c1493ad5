"""Names of face units, of regions and of somebody's head: nothing else knows them.

ARKit's 52 face units are what every head moves by. Other heads write them in their own ways
(``jawOpen``, ``JawOpen``, ``mouthSmile_L``, ``blendShape1.mouth_smile_left``).
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence

_SIDED = (
    "browDown", "browOuterUp", "cheekSquint", "eyeBlink", "eyeLookDown", "eyeLookIn", "eyeLookOut",
    "eyeLookUp", "eyeSquint", "eyeWide", "mouthDimple", "mouthFrown", "mouthLowerDown",
    "mouthPress", "mouthSmile", "mouthStretch", "mouthUpperUp", "noseSneer",
)  # fmt: skip
_WHOLE = (
    "browInnerUp", "cheekPuff", "jawForward", "jawLeft", "jawOpen", "jawRight", "mouthClose",
    "mouthFunnel", "mouthLeft", "mouthPucker", "mouthRight", "mouthRollLower", "mouthRollUpper",
    "mouthShrugLower", "mouthShrugUpper", "tongueOut",
)  # fmt: skip
FACE_UNITS = tuple(sorted([*_WHOLE, *(f"{n}{side}" for n in _SIDED for side in ("Left", "Right"))]))
"""ARKit's 52."""
CLASS_NAMES = (
    "background", "skin", "upper_lip", "lower_lip", "inner_mouth", "upper_teeth", "lower_teeth",
    "tongue", "eyes",
)  # fmt: skip
"""Facet classes of every head, the first of them of no facet."""
TEETH, LIPS, HIDDEN = "teeth", "lips", "none"
"""Words for regions of which upper and lower are found out, and for what is not drawn."""
REGION_WORDS = (*CLASS_NAMES[1:], TEETH, LIPS, HIDDEN)

# Each is a pair of shape targets, less and more, and how far people vary (standard deviation)
PERSON_TARGETS: dict[str, tuple[str, str, float]] = {
    "mouth width": ("mouth_scale_horiz_decr", "mouth_scale_horiz_incr", 0.5),
    "upper lip height": ("mouth_upperlip_height_decr", "mouth_upperlip_height_incr", 0.6),
    "lower lip height": ("mouth_lowerlip_height_decr", "mouth_lowerlip_height_incr", 0.6),
    "mouth height": ("mouth_trans_down", "mouth_trans_up", 0.5),
    "cupid's bow": ("mouth_cupidsbow_decr", "mouth_cupidsbow_incr", 0.5),
    "corners": ("mouth_angles_down", "mouth_angles_up", 0.5),
    "upper lip flanks": ("mouth_upperlip_ext_down", "mouth_upperlip_ext_up", 0.6),
    "lower lip flanks": ("mouth_lowerlip_ext_up", "mouth_lowerlip_ext_down", 0.6),
    "lower lip width": ("mouth_lowerlip_width_decr", "mouth_lowerlip_width_incr", 0.6),
}
"""MakeHuman's targets of the mouth; a head that lacks them has no modes of a person's mouth."""

COMPONENT = "component/"
"""Before the names of identity targets that are principal components, a standard deviation each."""
PERSON = "person/"
"""Before the name of a target that is one person's difference, which no other varies by."""

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


WHOLE, PREFIXED, HALF = range(3)
"""How a name means a face unit, the surest first: by all of it, by its end, or a side of the unit
that has none."""
_SIDES = {"l": "Left", "r": "Right", "left": "Left", "right": "Right"}
_HALVED = ("browInnerUp", "cheekPuff")
_BY_PLAIN = {name.lower(): (name, WHOLE, "") for name in FACE_UNITS} | {
    f"{name}{side}".lower(): (name, HALF, side) for name in _HALVED for side in ("Left", "Right")
}


def face_unit(name: str) -> str | None:
    """The face unit that a morph target's name means; None where it means none.

    A side that the unit does not have, as in ``cheekPuff_L``, is a part of the unit.
    """
    return reading(name)[0]


def reading(name: str) -> tuple[str | None, int, str]:
    """The face unit that a name means, how it does (`WHOLE`, ...), and the side that is a half."""
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
