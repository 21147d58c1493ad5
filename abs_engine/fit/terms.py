"""Kinds of evidence by name, each bound to a face and a view as a term in nats.

Terms add up because each is the negative logarithm of a likelihood whose noise was measured where
its appearance was learned; none has a weight by hand.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from abs_engine.compare.descriptor import TextureError, texture_error
from abs_engine.compare.points import LocalError, local_error
from abs_engine.compare.pull import Pull
from abs_engine.compare.residual_rows import Rows
from abs_engine.core.arrays import FloatArray
from abs_engine.core.errors import ParameterError
from abs_engine.core.foreign import own
from abs_engine.core.registry import TERMS
from abs_engine.core.scene import Candidates
from abs_engine.face.appearance.chroma import sampled
from abs_engine.face.base import Face
from abs_engine.face.learned_appearance import LocalLooks, TextureLooks
from abs_engine.fit.evidence import Term, failing
from abs_engine.fit.head_frame import (
    class_maps,
    independent_side,
    likelihood_of,
    lip_window,
    plane_maps,
    seam_of,
    zone,
)
from abs_engine.fit.settings import HEAD_FIT
from abs_engine.fit.view import View
from abs_engine.optimise.drivers import Driver, Need

Bind = Callable[[Face, View], Term]


@dataclass(frozen=True)
class TermKind:
    """A kind of evidence.

    Parameters
    ----------
    name : str
        Under which its values are reported, and what it needs of a face's appearance.
    bind : callable
        Binds it to a face and a view.
    gives : tuple of {"values", "forces", "residuals", "borders"}
        What its terms can be asked for.
    learned : bool
        Whether it needs something that was learned of the face's appearance under its name.
    beside : str
        Name of the kind that it is compared beside, never alone; empty: it needs none.
    noun : str
        What a face has of it, as messages say; by default its name.
    remedy : str
        What to do where the face of a model has none; empty: no model that has is advised.
    """

    name: str
    bind: Bind
    gives: tuple[Need, ...] = ("values",)
    learned: bool = True
    beside: str = ""
    noun: str = ""
    remedy: str = ""

    @property
    def what(self) -> str:
        """Its noun, or its name."""
        return self.noun or self.name


@dataclass(frozen=True, eq=False)
class Weighted:
    """An error of descriptors in nats, of which an epsilon of 1 is worth `nats`."""

    error: TextureError | LocalError
    nats: float

    def negative_log(self, candidates: Candidates) -> FloatArray:
        """-log of the likelihood of each candidate, (B,), up to a constant."""
        return self.nats * self.error.epsilon(candidates)

    def rows(self, candidates: Candidates) -> Rows:
        """Residuals of a batch, row by row, that are squared and summed."""
        apart = self.error.rows(candidates)
        rows = np.sqrt(self.nats) * apart.rows
        return replace(apart, rows=rows, value=self.nats * apart.value)

    def explained(self, value: float) -> float:
        """Share, 0 to 1, of what a wrong match costs that a value of the term leaves out."""
        return max(0.0, 1.0 - value / (self.nats * self.error.unit))


def colour_term(face: Face, view: View) -> Term:
    """The facet likelihood of colour classes (Basu et al., eqs. 6 to 9)."""
    classes = face.learned("colour")
    missing = [name for name in ("skin", "lips") if name not in face.regions]
    if missing:
        raise ParameterError(
            f"the model '{face.name}' has no region that shows {' or '.join(missing)}",
            "give it regions of skin and lips, or use other evidence than colour",
        )
    window = view.window
    maps = class_maps(classes, face.regions, window, view.image, view.place)
    drawn = view.renderer, face.scene, view.camera
    term = likelihood_of(*drawn, window, maps, classes.weight, seam_of(face.regions))

    def pull() -> Pull:
        seen = classes.compared(sampled(window, view.image))
        wide = seen.probabilities(HEAD_FIT.pull * HEAD_FIT.drawn_mouth, view.place)
        shade = seen.teeth_in_shade()
        return Pull.within(plane_maps(wide, shade, face.regions, window), zone(window))

    return replace(term, pull=pull)


def texture_term(face: Face, view: View) -> Term:
    """The error of luminance-normalised texture (Odisio and Bailly, section 4), by its noise.

    As many observations are independent as was measured, or as `likelihood_of` counts for colours.
    """
    looks: TextureLooks = face.learned("texture")
    start = view.frame.candidates(view.start[None])
    given = view.image, view.camera, view.window, start, view.renderer
    error = texture_error(looks.model, looks.surface, *given, looks.dressed)
    if looks.observations:
        return Weighted(error, 0.5 * looks.observations / looks.noise**2)
    mouth = lip_window(face.border, view.frame.base, view.camera)
    side = independent_side(mouth) / mouth.scale * view.window.scale
    return Weighted(error, 1.5 * error.drawn / side**2 / looks.noise**2)


def local_term(face: Face, view: View) -> Term:
    """The error of local descriptors, made white by what the model leaves unexplained."""
    looks: LocalLooks = face.learned("local")
    pixel = pixels_per_mm(face.pivot, view)
    window = replace(view.window, scale=looks.scale_at(pixel))
    given = view.image, view.camera, window, view.renderer
    error = local_error(looks.model, looks.surface, *given, "all", looks.whitener)
    return Weighted(error, 0.5 * 8 * len(looks.model))


def pixels_per_mm(pivot: FloatArray, view: View) -> float:
    """Image pixels of a mm where a point (3,), mm, of the head is in a view."""
    depth = float(view.frame.base.apply(pivot[None])[0, 2])
    return float(view.camera.matrix[0, 0]) / depth


COLOUR = TermKind("colour", colour_term, ("values", "forces", "borders"))
_LEARNED = "use --model with a talking face (face.npz) or one that 'speaker' learned (me.face)"
TEXTURE = TermKind("texture", texture_term, ("values", "residuals"), remedy=_LEARNED)
LOCAL = TermKind(
    "local", local_term, ("values", "residuals"), noun="local appearance", remedy=_LEARNED
)
LOOKS = (TEXTURE.name, LOCAL.name)
"""Evidence that needs a learned appearance."""


def term_kinds(names: Sequence[str]) -> dict[str, TermKind]:
    """Kinds of evidence by their names; `ParameterError` if none is named, or one is not known."""
    if not names:
        raise ParameterError("no evidence is named", f"choose one of {', '.join(TERMS)}")
    twice = next((name for name in names if names.count(name) > 1), None)
    if twice is not None:
        raise ParameterError(f"the evidence '{twice}' is named twice", "name it once")
    return {name: TERMS.get(name) for name in names}


def bends(kinds: Mapping[str, TermKind]) -> bool:
    """Whether some of the evidence has borders, and all else residuals, for Newton's steps."""
    return _lacking(kinds, "borders") is None


def _lacking(kinds: Mapping[str, TermKind], need: Need) -> str | None:
    """The name of evidence by which a driver goes without what it needs; None if there is none.

    Forces and values of one kind are enough; beside borders, residuals will do.
    """
    has = [need in kind.gives for kind in kinds.values()]
    if need == "residuals":
        fine = has
    elif need == "borders" and any(has):
        fine = [need in kind.gives or "residuals" in kind.gives for kind in kinds.values()]
    else:
        fine = [any(has)] * len(has)
    return next((name for name, one in zip(kinds, fine, strict=True) if not one), None)


def served(need: Need, kinds: Mapping[str, TermKind]) -> tuple[list[str], list[str]]:
    """Names of the evidence that gives what a driver needs, and of that which it cannot take."""
    gives = [name for name in kinds if need in kinds[name].gives and _goes((name,), need, kinds)]
    takes = [name for name in kinds if any(_goes((one, name), need, kinds) for one in gives)]
    return gives, [name for name in kinds if name not in takes]


def _goes(names: Sequence[str], need: Need, kinds: Mapping[str, TermKind]) -> bool:
    """Whether some evidence, and what that is compared beside, gives what a driver needs."""
    beside = [kinds[name].beside for name in names]
    chosen = {name: kinds[name] for name in (*names, *beside) if name in kinds}
    return _lacking(chosen, need) is None


def bound(kinds: Mapping[str, TermKind], face: Face, view: View) -> dict[str, Term]:
    """The terms of a frame, in their kinds' order; `TermError` if a plugin's evidence fails."""
    return {
        name: _bound(name, face.own_terms.get(name, kind.bind), face, view)
        for name, kind in kinds.items()
    }


def _bound(name: str, bind: Bind, face: Face, view: View) -> Term:
    if own(bind):
        return bind(face, view)
    with failing(name):
        return bind(face, view)


def check_leaves(
    name: str,
    has: Sequence[str] | None,
    kinds: Mapping[str, TermKind],
    driver: Driver,
    chosen: str,
    others: bool = True,
) -> None:
    """Refuse what does not go together, before anything slow is done.

    `name` is the model's; `has` is what is, or will be, learned of its appearance, None if that is
    not known; `chosen` is the driver's name. Where no `others` may track the same video, none is
    advised.

    Raises
    ------
    ParameterError
        If the face has nothing for a kind of evidence, or no evidence gives the driver what it
        needs, or a kind is alone that is compared beside another.
    """
    for kind in kinds.values():
        if has is not None and kind.learned and kind.name not in has:
            other = f"{kind.remedy}, else" if kind.remedy and others else "use"
            raise ParameterError(
                f"the model '{name}' has no {kind.what} to compare", f"{other} --terms {has[0]}"
            )
        if kind.beside and kind.beside not in kinds:
            raise ParameterError(
                f"{kind.name} is compared beside {kind.beside}",
                f"use --terms {kind.beside}+{kind.name}",
            )
    lacks = _lacking(kinds, driver.needs)
    if lacks is not None:
        raise ParameterError(
            f"the driver '{chosen}' needs {driver.needs}, which the evidence '{lacks}' does not "
            "give",
            "use --driver simplex, which needs values alone",
        )
