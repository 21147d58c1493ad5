"""Goals of the reproduction of Odisio and Bailly (2003), and why some are missed."""

from __future__ import annotations

from dataclasses import dataclass

from abs_engine.papers.results import MISSING, Results, number
from abs_engine.report.document import MISSED

CLEARLY = 0.8
"""Share of the constant twin's error that counts as clearly below it."""


@dataclass(frozen=True)
class Goal:
    """A number that is aimed at.

    Parameters
    ----------
    key : str
        Dotted, of the results.
    least : bool
        Whether the number is to be at least the bound, not at most.
    over : str
        Key of a number that it is divided by.
    why : str
        The reason that was found, told where the goal is missed.
    """

    key: str
    name: str
    bound: float
    least: bool = False
    over: str = ""
    why: str = ""

    def measured(self, results: Results) -> float | None:
        """The number, or None where it was not measured."""
        value = number(results, self.key)
        if not self.over or value is None:
            return value
        whole = number(results, self.over)
        return value / whole if whole else None


_TWINS_BEADS = (
    "beads are colours that do not change with articulation, so the constant model lacks little; "
    "that the linear one is learned too freely is not it: shrinking it by what left-out pictures "
    "say hardly changed the error"
)
_BARE_TEX = (
    "what a texture misses, whole regions miss alike (shading, lips that roll in), so that moved "
    "lips explain it; such noise counts once here, but only in its six strongest directions"
)
_BARE_LA = (
    "what appearance at points misses, many points miss alike, so that moved lips explain it; "
    "noise that points have in common counts once"
)
_DEPTH = (
    "most of it lies along z (see below): one camera in front hardly shows how far the jaw "
    "is pushed forward from how far the head is away"
)
_PICTURES = (
    ("visemes", "beads", {"tex": _TWINS_BEADS, "la": _TWINS_BEADS}),
    ("visemes_bare", "bare face", {"tex": _BARE_TEX, "la": _BARE_LA}),
)
GOALS = (
    Goal("variance.total", "variance held by seven parameters", 0.9629, least=True),
    Goal("model_error_mm_median", "model error, median over visemes, mm", 0.5),
    *(
        Goal(
            f"{group}.{kind}_lin.median_mm", f"visemes, {kind}_lin, {what}, mm", 0.5, why=why[kind]
        )
        for group, what, why in _PICTURES
        for kind in ("tex", "la")
    ),
    *(
        Goal(
            f"{group}.{kind}_lin.median_mm",
            f"visemes, {kind}_lin over {kind}_cst, {what}",
            CLEARLY,
            over=f"{group}.{kind}_cst.median_mm",
            why=why[kind],
        )
        for group, what, why in _PICTURES
        for kind in ("tex", "la")
    ),
    Goal("sentences.tex_lin.rms_mm", "sentences, tex_lin, mm", 0.4, why=_DEPTH),
    Goal("sentences.la_lin.rms_mm", "sentences, la_lin, mm", 0.8, why=_DEPTH),
    Goal("sentences.tex_lin.evaluations_per_frame", "sentences, tex_lin, evaluations", 300),
    Goal("sentences.la_lin.evaluations_per_frame", "sentences, la_lin, evaluations", 300),
    *(
        Goal(f"sentences.{model}.{key}", f"sentences, {model}, {what}", bound, least=True)
        for model in ("tex_lin", "la_lin")
        for key, what, bound in (
            ("closure_recall", "closures, recall", 1.0),
            ("closure_precision", "closures, precision", 0.95),
        )
    ),
    Goal("teleconference.tex_cst.rms_mm", "teleconference, tex_cst, mm", 2.5),
    Goal("teleconference.la_lin.rms_mm", "teleconference, la_lin, mm", 1.3),
)


def goal_rows(results: Results) -> list[tuple[str, str, str, str]]:
    """Goals: name, measured, bound, and by how much it is met or missed, and why."""
    rows = []
    for goal in GOALS:
        value = goal.measured(results)
        aim = f"{'≥' if goal.least else '≤'} {goal.bound:g}"
        if value is None:
            rows.append((goal.name, MISSING, aim, ""))
            continue
        ahead = value - goal.bound if goal.least else goal.bound - value
        verdict = f"{'met' if ahead >= 0 else MISSED}, by {abs(ahead):.3g}"
        why = f": {goal.why}" if ahead < 0 and goal.why else ""
        rows.append((goal.name, f"{value:.4g}", aim, verdict + why))
    return rows


def score_lines(results: Results) -> list[str]:
    """The main numbers for a terminal; the page has the reasons."""
    lines = [f"{'':40}{'here':>14}  goal"]
    rows = goal_rows(results)
    lines += [f"{a:40}{b:>14}  {c:10}{d.split(':')[0]}".rstrip() for a, b, c, d in rows]
    return lines
