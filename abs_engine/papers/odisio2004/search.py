"""The search: solvers at equal numbers of evaluations, and when to stop (item 4 of the paper)."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from abs_engine.core.arrays import FloatArray
from abs_engine.core.blocks import POSTURE
from abs_engine.core.geometry import Pose, rotations
from abs_engine.core.objective import Evaluation
from abs_engine.core.pose import at_base
from abs_engine.core.scene import Renderer
from abs_engine.face.talking import TalkingFace
from abs_engine.fit.problem import Problem
from abs_engine.fit.settings import TALKING_FIT
from abs_engine.fit.talking import Solver, talking_problem
from abs_engine.optimise.by_nlopt import DerivativeFree, Simplex
from abs_engine.optimise.levenberg import LevenbergMarquardt
from abs_engine.optimise.restarted import RestartedSimplex
from abs_engine.optimise.variations import LocalVariations
from abs_engine.papers.odisio2004.visemes import Speech

MODEL = "tex_lin"
"""Of appearance, that the search is tried with."""
FAILED = 2.0
"""mm of residual above which a fit has failed."""
TOLERANCES = (1e-2, 3e-3, 1e-3, 3e-4, 1e-4, 3e-5, 1e-5)
_NEVER = 1e-12
_POSE_OFF = np.array([0.02, 0.02, 0.02, 1.0, 1.0, 4.0])  # rad, mm

SOLVERS: dict[str, Callable[[float, int], Solver]] = {
    "nelder_mead": Simplex,
    "nelder_mead_restarted": lambda t, n: RestartedSimplex(max(t, 1e-3), n, 99),
    "levenberg_marquardt": LevenbergMarquardt,  # type: ignore[dict-item]
    "local_variations": LocalVariations,
    "sbplx": lambda t, n: DerivativeFree("sbplx", t, n),
    "bobyqa": lambda t, n: DerivativeFree("bobyqa", t, n),
    "cobyla": lambda t, n: DerivativeFree("cobyla", t, n),
    "praxis": lambda t, n: DerivativeFree("praxis", t, n),
}
"""By the key of results.json: a solver of a tolerance and a limit of evaluations."""


@dataclass(eq=False)
class Watched:
    """A problem in units of a wrong match, that remembers the best place after each evaluation."""

    problem: Problem
    best: list[FloatArray] = field(default_factory=list)
    seconds: list[float] = field(default_factory=list)
    _value: float = np.inf
    _start: float = field(default_factory=time.perf_counter)

    def __call__(self, x: FloatArray) -> Evaluation:
        """Epsilon in units of what a wrong match costs."""
        found = self.problem(x).value / self.problem.unit
        self._note(x, found)
        return Evaluation(found)

    def values(self, vectors: FloatArray) -> FloatArray:
        """The same at several vectors (B, n)."""
        found = self.problem.values(vectors) / self.problem.unit
        for x, value in zip(vectors, found, strict=True):
            self._note(x, float(value))
        return np.asarray(found)

    def gauss_newton(
        self, x: FloatArray, scale: FloatArray, difference: float
    ) -> tuple[float, FloatArray, FloatArray]:
        """Value, matrix and half the gradient in the same units; n + 1 evaluations."""
        value, matrix, gradient = self.problem.gauss_newton(x, scale, difference)
        unit = self.problem.unit
        for _ in range(len(x) + 1):
            self._note(x, value / unit)
        return value / unit, matrix / unit, gradient / unit

    def _note(self, x: FloatArray, value: float) -> None:
        if value < self._value or not self.best:
            self._value = value
            self.best.append(np.array(x))
        else:
            self.best.append(self.best[-1])
        self.seconds.append(time.perf_counter() - self._start)

    def after(self, count: int) -> tuple[FloatArray, float, int]:
        """Best place, seconds and evaluations when at most so many were spent."""
        at = min(count, len(self.best)) - 1
        return self.best[at], self.seconds[at], at + 1


def moved_problem(
    speech: Speech, face: TalkingFace, which: int, renderer: Renderer, seed: int
) -> Problem:
    """A picture's epsilon over 13 parameters, from neutral and a pose that is somewhat wrong."""
    seen = speech.pictures
    true = seen.poses[which]
    away = np.random.default_rng([seed, which]).normal(0.0, _POSE_OFF)
    turned = rotations(away[None, :3])[0] @ true.rotation
    pivot = speech.shape.pivot
    shift = true.apply(pivot) + away[3:] - turned @ pivot
    return talking_problem(
        face, MODEL, seen.pictures[which], seen.camera, Pose(turned, shift),
        speech.shape.neutral, renderer,
    )  # fmt: skip


def compare_solvers(
    speech: Speech,
    face: TalkingFace,
    tests: Iterable[int],
    renderer: Renderer,
    *,
    budgets: Sequence[int],
    solvers: Sequence[str] = tuple(SOLVERS),
    seed: int = 0,
) -> list[dict[str, Any]]:
    """All solvers on the same fits over all 13 parameters, at equal numbers of evaluations.

    No solver stops by itself before it has collapsed; the best place after each budget counts.

    Parameters
    ----------
    face : TalkingFace
        Learned from other visemes.
    budgets : sequence of int
        Ascending.
    solvers : sequence of str
        Of `SOLVERS`.
    seed : int
        Of how the pose at the start is wrong.

    Returns
    -------
    list of dict
        A row of each solver and budget, of each fit: "mm" and "lips_mm" are median residuals of
        all points and of the lips', head coordinates, "failures" the share with more than `FAILED`
        mm, "seconds" and the "evaluations" that it used means.
    """
    tests = list(tests)
    rows = []
    for name in solvers:
        runs = [
            _watched(speech, face, k, renderer, SOLVERS[name](_NEVER, budgets[-1]), seed)
            for k in tests
        ]
        for budget in budgets:
            rows.append(_row(speech, name, budget, dict(zip(tests, runs, strict=True))))
    return rows


def _watched(
    speech: Speech, face: TalkingFace, which: int, renderer: Renderer, solver: Solver, seed: int
) -> Watched:
    watched = Watched(moved_problem(speech, face, which, renderer, seed))
    start = at_base(speech.shape.neutral)
    solver.minimise(watched, start, watched.problem.spec, TALKING_FIT.from_neutral)
    return watched


def _row(speech: Speech, name: str, budget: int, runs: dict[int, Watched]) -> dict[str, Any]:
    after = {k: run.after(budget) for k, run in runs.items()}
    missed = [speech.missed(runs[k].problem.part(x, POSTURE), k) for k, (x, _, _) in after.items()]
    every, lips = np.array(missed).T
    seconds, counts = (np.mean([a[i] for a in after.values()]) for i in (1, 2))
    return {
        "solver": name, "model": MODEL, "budget": budget, "mm": float(np.median(every)),
        "lips_mm": float(np.median(lips)), "failures": float((every > FAILED).mean()),
        "seconds": float(seconds), "evaluations": float(counts),
    }  # fmt: skip


def compare_tolerances(
    speech: Speech, face: TalkingFace, tests: Iterable[int], renderer: Renderer
) -> list[dict[str, Any]]:
    """Nelder-Mead from neutral, the pose known, with tighter and tighter stopping rules.

    A rule that is chosen by this is chosen without the results only if these are of other visemes.
    Tolerances of the rows are in units of what a wrong match costs; "mm" is the median residual of
    all points.
    """
    tests, rows = list(tests), []
    for tolerance in TOLERANCES:
        errors, counts = [], []
        for k in tests:
            watched = Watched(speech.problem(face, MODEL, k, renderer))
            start, spec = speech.shape.neutral, watched.problem.spec
            solver = RestartedSimplex(tolerance, 2000, 2)
            found = solver.minimise(watched, start, spec, TALKING_FIT.from_neutral)
            errors.append(speech.missed(found.x, k)[0])
            counts.append(found.n_evaluations)
        rows.append(
            {
                "tolerance": tolerance, "model": MODEL, "mm": float(np.median(errors)),
                "mean_mm": float(np.mean(errors)), "evaluations": float(np.mean(counts)),
            }
        )  # fmt: skip
    return rows
