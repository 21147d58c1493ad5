"""Names of the identity targets by which heads differ: MakeHuman's, components and people."""

from __future__ import annotations

from collections.abc import Mapping

from abs_engine.face.settings.shape import SHAPE

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
