"""The report of a reproduction as one HTML page beside its figures."""

from __future__ import annotations

import html
from collections.abc import Mapping, Sequence
from typing import Any

from abs_engine.core.provenance import described
from abs_engine.papers.basu1998.filmed import YAWS, camera_name
from abs_engine.papers.basu1998.scores import (
    FRONTAL,
    FURTHER_LEFT,
    GOALS,
    GRID,
    KNOWN,
    MISSING,
    POSES,
    RECONSTRUCTION,
    VARIANCE,
    Goal,
    Results,
    Unit,
    finite,
    number,
    remark,
    told,
)
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
LIPS = {
    "solid": "in three dimensions, with noise of the pose",
    "flat": "in the picture, learned from the front",
    "flat_each_yaw": "in the picture, learned at that yaw",
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
_FORMATS = {"posterior": "{:.1f}"}


def reproduction_page(
    results: Results, figures: Sequence[tuple[str, str]], remarks: Sequence[str]
) -> str:
    """The page; what the results lack is told as not measured.

    Parameters
    ----------
    results : mapping
        What ``results.json`` holds.
    figures : sequence of (str, str)
        Address of a picture from the page, and its caption.
    remarks : sequence of str
        What to know about the numbers.
    """
    body = f"""{_made(results)}
{"".join(f"<p>{html.escape(remark)}</p>" for remark in remarks)}
<h2>At a glance</h2>
{_goals(results, GOALS)}
<h2>Lips of a recording, in other motion</h2>
{_recorded(results)}
<h2>Variance held by the first modes</h2>
{_variance(results)}
<h2>Table 1: reconstruction of frames not learned from</h2>
{_table_1(results)}
<h2>Which camera would help most</h2>
{_cameras(results)}
<h2>Drivers, on the same frames</h2>
{_drivers(results)}
<h2>Lip error from every side, pose known</h2>
{_yaws(results)}
<h2>Lip error by what is known of the pose</h2>
{_goals(results, POSES)}
<h2>Visemes by solid lips and by flat ones</h2>
{_visemes(results)}
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


def _cameras(results: Results) -> str:
    """Expected remaining errors with a camera at each yaw, alone and beside a frontal one."""
    given: Any = results.get("cameras")
    yaws = given.get("yaw") if isinstance(given, Mapping) else None
    if not isinstance(yaws, Mapping) or not yaws:
        return f"<p>{MISSING.capitalize()}.</p>"
    rows: list[tuple[str, ...]] = [
        (_degrees(yaw), told(number(given, f"yaw.{yaw}.dots"), "count")) for yaw in yaws
    ]
    for column in ("alone_mm", "beside_frontal_mm"):
        left = [number(given, f"yaw.{yaw}.{column}") for yaw in yaws]
        best = min((mm for mm in left if mm is not None), default=None)
        rows = [(*row, _remaining(mm, mm == best)) for row, mm in zip(rows, left, strict=True)]
    none, frontal = (number(given, key) for key in ("without_mm", "frontal_mm"))
    what = (
        "<p>Section 6.2 turned around: how far a node of the lips is expected to be off, RMS, by "
        "the posterior covariance, once a camera at that yaw, to the subject's left, shows the "
        "dots that it sees, with the noise of the dots. Without any camera: "
        f"{told(none, 'mm')}; with a frontal one: "
        f"{told(frontal, 'mm')}. For lips of your own: <code>abs-engine cameras LIPS</code>.</p>"
    )
    return what + table(("camera at", "dots seen", "alone", "beside a frontal camera"), rows)


def _remaining(value: float | None, best: bool) -> str:
    """Remaining errors with three digits, as cameras differ by little, and the best one."""
    if value is None:
        return MISSING
    return f"{value:.3f} mm{' (best)' * best}"


def _degrees(yaw: object) -> str:
    return f"{yaw}°".replace("-", "\N{MINUS SIGN}")


def _drivers(results: Results) -> str:
    rows = [
        (
            name,
            _integral(results, key),
            *(_driven(number(results, f"drivers.{key}.{column}"), column) for column in _COLUMNS),
        )
        for key, name in DRIVERS.items()
    ]
    rows.append(
        (
            "from the blob, place fitted along: forces (ours)",
            _INTEGRALS["exact"],
            *(_driven(number(results, f"blob.{column}"), column) for column in _COLUMNS),
        )
    )
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
    if value is None or unit is not None:
        return told(value, unit or "count")
    return _FORMATS[column].format(value)


def _yaws(results: Results) -> str:
    """A row for each camera, a column for each person, or one if they are given as one."""
    given: Any = results.get("yaw_mm")
    if not isinstance(given, Mapping) or not given:
        return f"<p>{MISSING.capitalize()}.</p>"
    people = {str(k): v for k, v in given.items() if isinstance(v, Mapping)} or {"here": given}
    rows = []
    for yaw in YAWS:
        errors = [finite(of.get(camera_name(yaw))) for of in people.values()]
        goal = FRONTAL if yaw == 0 else KNOWN
        worst = max((e for e in errors if e is not None), default=None)
        rows.append(
            (_degrees(yaw), *(told(e, "mm") for e in errors), goal.aim(), goal.judged(worst))
        )
    verdict = "the worst" if len(people) > 1 else ""
    return table(("seen from", *people, "goal", verdict), rows)


def _visemes(results: Results) -> str:
    """Bits and error rates against the head's yaw; see `viseme_information`."""
    given: Any = results.get("viseme_information")
    if not isinstance(given, Mapping):
        return f"<p>{MISSING.capitalize()}.</p>"
    most = given["bits_at_most"]
    rows = [
        (name, *(f"{b:.2f} ({e:.0%})" for b, e in zip(arm["bits"], arm["error_rate"], strict=True)))
        for name, arm in ((name, given[key]) for key, name in LIPS.items())
    ]
    what = (
        f"<p>{len(given['visemes'])} visemes, {given['samples']} of them in random syllables of "
        "the bundled people; each person's are classified by a discriminant of the others'. Given "
        f"are the bits that reach the answer, {most:.2f} at most, and the error rate. Solid lips "
        "have the same noise from every side, where a tracker's grows with the yaw.</p>"
    )
    return what + table(("head turned by", *map(_degrees, given["yaws"])), rows)


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
