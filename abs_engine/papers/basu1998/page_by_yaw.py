"""Tables of a reproduction's page whose rows or columns are yaws: of the camera, of the head."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from abs_engine.papers.basu1998.filmed import YAWS, camera_name
from abs_engine.papers.basu1998.scores import FRONTAL, KNOWN, told
from abs_engine.papers.results import MISSING, Results, finite, number
from abs_engine.report.document import table

LIPS = {
    "solid": "in three dimensions, with noise of the pose",
    "flat": "in the picture, learned from the front",
    "flat_each_yaw": "in the picture, learned at that yaw",
}


def cameras(results: Results) -> str:
    """Expected remaining errors with a camera at each yaw, alone and beside a frontal one."""
    given: Any = results.get("cameras")
    yaws = given.get("yaw") if isinstance(given, Mapping) else None
    if not isinstance(yaws, Mapping) or not yaws:
        return f"<p>{MISSING.capitalize()}.</p>"
    rows: list[tuple[str, ...]] = [
        (degrees(yaw), told(number(given, f"yaw.{yaw}.dots"), "count")) for yaw in yaws
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


def degrees(yaw: object) -> str:
    """An angle, with a true minus sign."""
    return f"{yaw}°".replace("-", "\N{MINUS SIGN}")


def by_yaw(results: Results) -> str:
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
            (degrees(yaw), *(told(e, "mm") for e in errors), goal.aim(), goal.judged(worst))
        )
    verdict = "the worst" if len(people) > 1 else ""
    return table(("seen from", *people, "goal", verdict), rows)


def visemes(results: Results) -> str:
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
    return what + table(("head turned by", *map(degrees, given["yaws"])), rows)
