"""Names of a head's regions, and of the parts of meshes that show them."""

from __future__ import annotations

import re
from collections.abc import Mapping

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
