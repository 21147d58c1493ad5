"""The page of an articulatory model: what it was built of, and how well it holds that."""

from __future__ import annotations

from collections.abc import Collection, Sequence

import numpy as np

from abs_engine.core.provenance import described, made_by
from abs_engine.core.words import counted
from abs_engine.report.articulation.analysis import Analysis
from abs_engine.report.articulation.applied import Applied
from abs_engine.report.articulation.tables import boxes, variance_table
from abs_engine.report.document import figures, results_page, table

_MOST_NAMED = 12
_LEAST_SPAN, _LARGEST_SPAN = 15.0, 600.0
"""mm; points that span less or more are hardly of a face."""
_FAR = 4.0
"""mm; the bundled people are missed by 0.5 mm in their own models, by 6 to 12 in each other's."""
_FAR_POINT = 10.0
"""mm; in models of two bundled people the farthest point of a frame of speech is missed by up to
2.7 mm, of a recorded range of motion by up to 8.6, and of a viseme in which two points that lie 10
mm or more apart are exchanged by 10.4 and more."""


def corpus_lines(done: Analysis) -> list[str]:
    """Names of what was read, kept out and filled in, by name."""
    built = done.built
    span = np.nanmax(built.corpus.points, axis=(0, 1)) - np.nanmin(built.corpus.points, axis=(0, 1))
    size = " x ".join(f"{extent:.0f}" for extent in span)
    lines = [
        f"{len(built.corpus)} visemes of {len(built.model.names)} points, which span {size} mm "
        "(across, up, forward)"
    ]
    if not _LEAST_SPAN < span.max() < _LARGEST_SPAN:
        lines.append("warning: this is hardly a face; say with --unit what the numbers are in")
    if done.asked:
        lines.append(f"kept out as asked for: {_named(done.asked)}")
    if done.roleless:
        lines.append(f"kept out, {_points(done.roleless)} in no group: {_named(done.roleless)}")
    if built.left_out:
        told = f"kept out, {_points(built.left_out)} missing in some visemes"
        lines.append(f"{told}: {_named(built.left_out)}")
    if built.imputed:
        each = [f"{name} ({count})" for name, count in built.imputed.items()]
        lines.append(f"imputed, {_points(each)} missing in some visemes (how many): {_named(each)}")
    if built.unsettled:
        lines.append(
            f"warning: imputed points do not settle: in the last round one moved by "
            f"{built.unsettled:.2g} mm; leave out visemes or points that lack much"
        )
    if done.guessed:
        each = [f"{name} ({count})" for name, count in done.guessed.items()]
        lines.append(
            f"warning: of {_points(each)} imputed hardly anything is known, seen in fewer visemes "
            f"than there are parameters (in how many): {_named(each)}"
        )
    return lines


def error_lines(done: Analysis) -> list[str]:
    """Residual of the direct inversion, and what visemes are missed that were not learned."""
    built = done.built
    errors = built.viseme_errors
    worst = int(errors.argmax())
    lines = [
        f"error of the model, RMS over the points: median {np.median(errors):.2f} mm, worst "
        f"{errors[worst]:.2f} mm ({built.corpus.visemes[worst]}); {(errors <= 0.5).mean():.0%} of "
        "the visemes within 0.5 mm"
    ]
    unseen = done.unseen.errors
    if np.isfinite(unseen).any():
        lines.append(
            f"each viseme in the model of the others: median {np.nanmedian(unseen):.2f} mm, worst "
            f"{np.nanmax(unseen):.2f} mm ({built.corpus.visemes[int(np.nanargmax(unseen))]})"
        )
    return lines + _skipped_lines(done)


def _skipped_lines(done: Analysis) -> list[str]:
    """Visemes that could not be left out in turn, a line for each reason."""
    by_reason: dict[str, list[str]] = {}
    for viseme, error in done.unseen.skipped.items():
        by_reason.setdefault(error.problem, []).append(viseme)
    return [
        f"not left out in turn: {_named(visemes)}: {reason}"
        for reason, visemes in by_reason.items()
    ]


def variance_lines(done: Analysis) -> list[str]:
    """Table 1 for a terminal, percent."""
    rows = variance_table(done.built.model)
    wide = max(len("parameter"), *(len(name) for name, *_ in rows))
    beside = any(paper for *_, paper in rows)
    head = "  (paper:  %     sum)" if beside else ""
    lines = [f"{'parameter':{wide}}       %     sum{head}"]
    for name, share, total, paper, paper_total in rows:
        told = f"     {paper:>8}{paper_total:>8}" if paper else ""
        lines.append(f"{name:{wide}}{share:>8}{total:>8}{told}")
    return lines


def applied_lines(done: Applied) -> list[str]:
    """Frames with parameters, their error at the points, and the points that lack."""
    error = done.error[done.found]
    lines = [
        f"{counted(len(done.found), 'frame')}, {int((~done.found).sum())} without parameters; "
        f"error, RMS over the points: median {np.median(error):.2f} mm, "
        f"worst {error.max():.2f} mm (frame {done.first + int(np.nanargmax(done.error))})"
    ]
    far = np.flatnonzero((done.error > _FAR) | (done.off > _FAR_POINT))
    if np.median(error) > _FAR:
        lines.append(
            "warning: the points lie far from the model's: name the upper teeth in --roles, or "
            "give --unit; or they are another speaker's"
        )
    elif len(far):
        named = [f"{done.first + k} ({done.farthest[k]})" for k in far.tolist()]
        lines.append(
            f"warning: in {counted(len(far), 'frame')} points lie far from the model's; check "
            f"the markers there (the farthest is named): {_some(named)}"
        )
    if done.lacking:
        lines.append(f"{_points(done.lacking)} of the model not recorded: {_some(done.lacking)}")
    return lines


def model_page(done: Analysis, pictures: Sequence[tuple[str, str]]) -> str:
    """The page of a model beside its figures.

    Parameters
    ----------
    pictures : sequence of (str, str)
        Address of a figure from the page, and its caption.
    """
    built = done.built
    shown = sorted(
        boxes(built.corpus.visemes, built.model.names, built.errors), key=lambda b: -b.rms
    )
    missed = [(b.viseme, f"{b.rms:.2f}", f"{b.drawn['med']:.2f}", b.worst) for b in shown]
    visemes = table(("viseme", "RMS, mm", "median, mm", "worst point"), missed)
    made = f"made by {described(made_by())}"
    told = [(line,) for line in (*corpus_lines(done), *error_lines(done), made)]
    body = f"""{table((), told)}
<h2>Variance that each parameter explains</h2>
{table(("parameter", "%", "sum", "paper, %", "sum"), variance_table(built.model))}
<h2>Figures</h2>
{figures(pictures)}
<h2>Errors of the direct inversion</h2>
<details><summary>all visemes</summary>{visemes}</details>
<p>The model is <a href="model.npz">model.npz</a>; <code>abs_engine.load_articulatory</code> reads
it. The method is that of Odisio and Bailly, Shape and appearance models of talking faces for
model-based tracking, section 2.</p>"""
    title = f"Articulatory model: {built.model.source or 'a corpus'}"
    return results_page(title, title, body, made_by())


def _points(names: Collection[str]) -> str:
    return counted(len(names), "point")


def _named(names: Sequence[str]) -> str:
    """The names, the first of them if they are many."""
    return _some(names) + (" (all in results.json)" if len(names) > _MOST_NAMED else "")


def _some(names: Sequence[str]) -> str:
    return ", ".join(names[:_MOST_NAMED]) + (", ..." if len(names) > _MOST_NAMED else "")
