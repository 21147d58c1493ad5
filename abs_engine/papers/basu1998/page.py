"""The report of a reproduction as one HTML page beside its figures."""

from __future__ import annotations

import html
from collections.abc import Mapping, Sequence
from typing import Any

from abs_engine.core.provenance import described
from abs_engine.papers.basu1998.page_by_yaw import by_yaw, cameras, visemes
from abs_engine.papers.basu1998.scores import (
    FURTHER_LEFT,
    GOALS,
    GRID,
    POSES,
    RECONSTRUCTION,
    VARIANCE,
    Goal,
    Unit,
    remark,
    told,
)
from abs_engine.papers.results import MISSING, Results, finite, number
from abs_engine.report.document import figures as pictures
from abs_engine.report.document import results_page, table

DRIVERS = {
    "forces": "forces at the borders of classes: the whole derivative of eq. 7 (ours)",
    "forces_exact": "forces of eq. 11, exact sum over the visible pixels",
    "forces_one_sample": "forces of eq. 12, one sample for each facet (paper)",
    "forces_as_printed": "the same as printed: one fixed step, one start, one Gaussian",
    "gradient": "gradient in parameter space, by differences",
    "simplex": "Nelder-Mead simplex",
    "simplex_one_sample": "the same, one sample for each facet (eq. 8)",
}
SPLIT = {
    "interpolation_mm": "shell between exact dots",
    "modes_mm": "nearest to it in ten modes",
    "picture_mm": "found in the picture, weak prior",
    "mm": "found in the picture, usual prior",
}
FURTHER = {
    "before_mm": "five seconds of dots",
    "cross_validated_mm": "the same, variances of the modes cross-validated",
    "after_mm": "and learned again from the relaxed shell",
}
_INTEGRALS = {"exact": "exact sum", "sample": "one sample"}
"""How a posterior is integrated over a facet, in words."""
_COLUMNS: dict[str, tuple[str, Unit | None]] = {
    "mm": ("lip error, RMS", "mm"),
    "highest_mm": ("of the highest end", "mm"),
    "evaluations": ("evaluations", "count"),
    "iterations": ("iterations", "count"),
    "posterior": ("\N{MINUS SIGN}log posterior", None),
    "converged": ("converged within 15", "share"),
}


def reproduction_page(
    results: Results, figures: Sequence[tuple[str, str]], remarks: Sequence[str]
) -> str:
    """The page of ``results.json``, figures by address and caption, and remarks on the numbers.

    What the results lack is told as not measured.
    """
    body = f"""{_made(results)}
{"".join(f"<p>{html.escape(line)}</p>" for line in remarks)}
<h2>At a glance</h2>
{_goals(results, GOALS)}
<h2>Lips of a recording, in other motion</h2>
{_recorded(results)}
<h2>Variance held by the first modes</h2>
{_variance(results)}
<h2>Table 1: reconstruction of frames not learned from</h2>
{_table_1(results)}
<h2>Which camera would help most</h2>
{cameras(results)}
<h2>Drivers, on the same frames</h2>
{_drivers(results)}
<h2>Lip error from every side, pose known</h2>
{by_yaw(results)}
<h2>Lip error by what is known of the pose</h2>
{_goals(results, POSES)}
<h2>Visemes by solid lips and by flat ones</h2>
{visemes(results)}
<h2>Further training</h2>
{_further(results)}
<h2>Closures in the GRID recordings</h2>
{_grid(results)}
<h2>Figures</h2>
{pictures(figures)}
<p>What it took: <a href="timing.json">timing.json</a>.</p>"""
    return results_page(
        "Basu, Oliver and Pentland (1998) reproduced",
        "3D modeling and tracking of human lip motions, reproduced",
        body,
        results,
    )


def _made(results: Results) -> str:
    """Making of the results."""
    people = results.get("people")
    rows = [
        ("command", results.get("command")),
        ("motion that was learned from", results.get("motion")),
        ("people", ", ".join(map(str, people)) if isinstance(people, list | tuple) else None),
        ("seed", results.get("seed")),
        ("drawn by", results.get("renderer")),
        ("made by", described(dict(results))),
    ]
    told_of = {name: str(value) for name, value in rows}
    return table(
        (), [(k, "not recorded" if v in ("None", "nan") else v) for k, v in told_of.items()]
    )


def _goals(results: Results, goals: Sequence[Goal]) -> str:
    rows = [(g.name, g.told(results), g.aim(), remark(results, g)) for g in goals]
    return table(("", "here", "goal", ""), rows)


def _variance(results: Results) -> str:
    shares = results.get("variance")
    if not isinstance(shares, list | tuple) or not shares:
        return f"<p>{MISSING.capitalize()}.</p>"
    head = ("modes", *(str(k) for k in range(1, len(shares) + 1)))
    paper = [told(VARIANCE.bound, "share") if k == 10 else "" for k in range(1, len(shares) + 1)]
    ours = [told(finite(share), "share") for share in shares]
    found = f"<p>Ten modes: {html.escape(VARIANCE.verdict(results))}.</p>"
    return table(head, [("here", *ours), ("paper", *paper)]) + found


def _table_1(results: Results) -> str:
    """Errors with the noise of observed dots; those without, where they were measured, too."""
    rows = []
    exact = isinstance(results.get("table1_without_noise"), Mapping)
    for goal in RECONSTRUCTION:
        bare = number(results, goal.key.replace("table1.", "table1_without_noise."))
        beside = (told(bare, "error"),) if exact else ()
        paper = told(goal.bound, "error")
        rows.append((goal.name, goal.told(results), *beside, paper, goal.verdict(results)))
    head = ("", "here", *(("here, dots without noise",) if exact else ()), "paper", "")
    units = "<p>Mean squared error for each degree of freedom, in the paper's coordinates.</p>"
    return units + table(head, rows)


def _drivers(results: Results) -> str:
    named = [(name, _integral(results, key), f"drivers.{key}") for key, name in DRIVERS.items()]
    blob = "from the blob, place fitted along: forces (ours)", _INTEGRALS["exact"], "blob"
    rows = [
        (name, by, *(_driven(number(results, f"{key}.{column}"), column) for column in _COLUMNS))
        for name, by, key in (*named, blob)
    ]
    what = (
        "<p>The posterior (section 5.4) is integrated over each facet by the exact sum over its "
        "visible pixels, or by one sample at its centre times its visible area (eq. 8). Values of "
        "the one are not to be compared with those of the other.</p>"
    )
    head = ("", "posterior by", *(title for title, _ in _COLUMNS.values()))
    return what + table(head, rows)


def _integral(results: Results, key: str) -> str:
    drivers: Any = results.get("drivers")
    of = drivers.get(key) if isinstance(drivers, Mapping) else None
    told_of = of.get("posterior_rule") if isinstance(of, Mapping) else None
    return _INTEGRALS.get(str(told_of), "not recorded")


def _driven(value: float | None, column: str) -> str:
    unit = _COLUMNS[column][1]
    return f"{value:.1f}" if unit is None and value is not None else told(value, unit or "count")


def _recorded(results: Results) -> str:
    """A row for each person, a column for each of `SPLIT`."""
    given: Any = results.get("recorded")
    if not isinstance(given, Mapping):
        return f"<p>{MISSING.capitalize()}: --quick leaves it out, and it needs the recording.</p>"
    what = (
        f"<p>As in the paper, each person's lips are learned from five seconds: {given['motion']}. "
        "They are then found in pictures of the same person who speaks, from the front, the pose "
        "known. Errors are in mm, RMS, of the lips' nodes. The second column includes the first: "
        "its shape is the nearest, in the ten modes, to the one that exact dots give. The last two "
        "add what the picture leaves open: once with a prior so wide (ten times the usual standard "
        "deviations) that it says next to nothing, once with the prior used everywhere else.</p>"
    )
    rows = [
        (name, *(told(number(of, key), "mm") for key in SPLIT))
        for name, of in [*given["people"].items(), ("all", given["all"])]
    ]
    return what + table(("", *SPLIT.values()), rows)


def _further(results: Results) -> str:
    rows = [
        (name, told(number(results, f"further_training.{key}"), "mm"))
        for key, name in FURTHER.items()
    ]
    what = (
        "<p>Lip error, frontal camera, pose known. The shell is relaxed on another clip, seen by "
        f"three cameras at once. What is left of the first: {FURTHER_LEFT.told(results)} (goal: "
        f"{FURTHER_LEFT.aim()}).</p>"
    )
    return what + table(("", "lip error, RMS"), rows)


def _grid(results: Results) -> str:
    if all(number(results, goal.key) is None for goal in GRID):
        return f"<p>{MISSING.capitalize()}: {remark(results, GRID[0])}.</p>"
    return _goals(results, GRID)
