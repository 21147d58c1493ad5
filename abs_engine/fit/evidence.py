"""One kind of evidence bound to a face and a view, and what it may be asked for."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import AbstractContextManager
from typing import Protocol, runtime_checkable

import numpy as np

from abs_engine.compare.borders import Borders
from abs_engine.compare.residual_rows import Rows
from abs_engine.core.arrays import FloatArray
from abs_engine.core.camera import Camera, Window
from abs_engine.core.errors import TermError
from abs_engine.core.foreign import blamed, own
from abs_engine.core.scene import Candidates, Scene


class Term(Protocol):
    """One kind of evidence, bound to a face and a view."""

    def negative_log(self, candidates: Candidates) -> FloatArray:
        """Value of the drawing of each candidate, (B,), nats; less is more probable."""
        ...


@runtime_checkable
class Pushing(Term, Protocol):
    """A term that knows which way its scene's vertices should move."""

    @property
    def scene(self) -> Scene:
        """Scene that is drawn."""
        ...

    def forces(self, candidate: Candidates) -> FloatArray:
        """Forces (V, 3), camera frame, on the vertices of one candidate: nats per mm."""
        ...


class Bordered(Term, Protocol):
    """A term that knows what it gains as the drawn borders move."""

    @property
    def scene(self) -> Scene:
        """Scene that is drawn."""
        ...

    @property
    def camera(self) -> Camera:
        """Camera that sees it."""
        ...

    @property
    def window(self) -> Window:
        """Window of the picture that is drawn."""
        ...

    @property
    def observations(self) -> float:
        """Number of independent observations."""
        ...

    def borders(
        self, candidate: Candidates, reach: int, local: bool, floor: float
    ) -> tuple[float, Borders]:
        """Value of one candidate, and its borders with gains in nats; see `FacetLikelihood`."""
        ...


@runtime_checkable
class Squared(Term, Protocol):
    """A term that is a sum of squares.

    It may have `slopes`, which Newton steps ask for instead of differences over first steps:
    residuals (K,) of one candidate, and how they change with its pose, that turns about a pivot
    (3,), and its posture, (6 + P, K). As for borders, turns from the base pose are taken to be
    small, and the lens's distortion may be left out.
    """

    def rows(self, candidates: Candidates) -> Rows:
        """Residuals of a batch that are squared and summed, and what is compared in each."""
        ...


def failing(name: str) -> AbstractContextManager[None]:
    """Errors of evidence that is not the engine's own, as `TermError`; see `blamed`."""
    return blamed(f"the evidence '{name}'", TermError)


_GIVEN = {"forces": "forces", "residuals": "rows", "borders": "borders"}
"""The method by which a term gives what a driver needs."""


def check_given(name: str, term: Term, gives: Sequence[str]) -> None:
    """Raise `TermError` for a term that lacks what its kind says that it gives."""
    for need, method in _GIVEN.items():
        flat = need == "borders" and not getattr(term, "drawn", True)  # then rows will do
        if need in gives and not hasattr(term, "rows" if flat else method):
            raise TermError(
                f"the evidence '{name}' says that it gives {need}, but has no '{method}'",
                f"add it, or leave '{need}' out of what its TermKind gives",
            )


def finite(name: str, what: str, *values: FloatArray | float) -> None:
    """Raise `TermError` where what evidence gives beside its value is not finite."""
    if not all(np.isfinite(value).all() for value in values):
        raise TermError(
            f"the {what} of the evidence '{name}' are not finite",
            "correct its plugin, or use --driver simplex, which needs values alone",
        )


def valued(name: str, term: Term, candidates: Candidates) -> FloatArray:
    """Value of the drawing of each candidate, (B,), nats.

    Raises `TermError` if that is not a finite number for each, or if a term that is not the
    engine's own fails.
    """
    if own(type(term)):
        values = np.asarray(term.negative_log(candidates), np.float64)
    else:
        with failing(name):
            given = np.asarray(term.negative_log(candidates))
            values = given if np.iscomplexobj(given) else given.astype(np.float64)
    whole = values.shape == (len(candidates),) and not np.iscomplexobj(values)
    if not whole or not np.isfinite(values).all():
        raise TermError(
            f"the evidence '{name}' is not a finite number for each of the {len(candidates)} "
            f"candidates (shape {values.shape}, {values.dtype})",
            "let negative_log return them, in nats",
        )
    return values
