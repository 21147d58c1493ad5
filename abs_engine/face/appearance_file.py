"""Arrays of a head's learned appearance in a file, named as those of a talking face are."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from abs_engine.core.errors import ParameterError
from abs_engine.face.appearance import local, texture
from abs_engine.face.appearance.local import LocalModel
from abs_engine.face.appearance.texture import TextureModel
from abs_engine.face.learned_appearance import Appearance
from abs_engine.io.arrays import Array, Layout, flat, index, part_of, real, truth

TEXTURE, LOCAL = "tex_lin", "la_lin"
NUMBERS = {
    "la_per_mm": "per_mm", "la_own_share": "own_share", "tex_per_mm": "texture_per_mm",
    "tex_noise": "texture_noise",
    "tex_observations": "texture_observations",
}  # fmt: skip
"""Single numbers of an appearance, by their names in a file."""
TWINS = {"tex_cst_is_constant_tex_lin": True, "la_cst_is_constant_la_lin": True}
"""The constant models are the linear ones' constants, as a talking face's file says of its own."""


def _within(prefix: str, layout: Layout) -> dict[str, Array]:
    """A layout under a prefix, none of it required; all lengths but P are its own."""

    def own(length: int | str) -> int | str:
        kept = isinstance(length, int) or length.rstrip("*?") == "P"
        return length if kept else f"{prefix}_{length}"

    return {
        f"{prefix}.{name}": replace(array, shape=tuple(map(own, array.shape)), optional=True)
        for name, array in layout.items()
    }


LAYOUT: Layout = {
    **_within(TEXTURE, texture.LAYOUT),
    **_within(LOCAL, local.LAYOUT),
    f"{LOCAL}.vertices": index("V", f"{LOCAL}_N", dtype=np.int64, optional=True),
    **dict.fromkeys(NUMBERS, real(low=1e-9, optional=True)),
    **{name: truth(optional=True) for name in TWINS},
}
"""Its arrays in the file of a head of V vertices and P parameters."""


def appearance_arrays(appearance: Appearance | None) -> dict[str, Any]:
    """Arrays of an appearance by name; none where nothing is known of it."""
    if appearance is None:
        return {}
    parts = flat({TEXTURE: appearance.texture.arrays(), LOCAL: appearance.local.arrays()})
    return {**parts, **{name: getattr(appearance, own) for name, own in NUMBERS.items()}, **TWINS}


def has_appearance(names: Iterable[str]) -> bool:
    """Whether some of the arrays of a file are an appearance's."""
    return not LAYOUT.keys().isdisjoint(names)


def appearance_of(data: Mapping[str, Any], parameters: int) -> Appearance | None:
    """The appearance in the arrays of a file, as in `LAYOUT`; None where there is nothing of it.

    It has so many parameters, P, as the posture. Raises `KeyError` if some arrays are missing;
    `TypeError`, `ValueError` or `ParameterError` if they do not make an appearance.
    """
    if not has_appearance(data):
        return None
    tex = TextureModel.from_arrays(part_of(data, TEXTURE))
    la = LocalModel.from_arrays(part_of(data, LOCAL))
    if not all(data[name] for name in TWINS) or {len(tex.modes), len(la.modes)} != {parameters}:
        raise ParameterError("the appearance is not of these postures", "learn it again")
    return Appearance(tex, la, **{own: float(data[name]) for name, own in NUMBERS.items()})
