"""The report of Odisio and Bailly (2003) as one HTML page beside its figures."""

from __future__ import annotations

import html
from collections.abc import Mapping, Sequence
from typing import Any

from abs_engine.face.talking import MODELS
from abs_engine.papers.odisio2004.goals import goal_rows
from abs_engine.papers.odisio2004.sequence import PAPER
from abs_engine.papers.odisio2004.visemes import ASKED, NEUTRAL, PRINTED
from abs_engine.papers.results import MISSING, Results, number
from abs_engine.report.articulation.tables import PAPER_TOTAL, PAPER_VARIANCE
from abs_engine.report.document import figures as pictures
from abs_engine.report.document import results_page, table

_WORST = 5
_MADE = (
    ("command", "command"), ("person", "person"), ("seed", "seed"), ("drawn by", "renderer"),
    ("abs_engine", "engine_version"), ("commit", "commit"),
)  # fmt: skip
_PAPER_TREES = {
    "vowels": "{i e ɛ} {a} and the rounded ones",
    "consonants": "{p b m} {f v} {t d n} {ʁ l} {s z k g} {ʃ ʒ}",
}
_VISEMES = (
    ("median_mm", "median, mm"), ("lips_median_mm", "lips, mm"), ("worst_mm", "worst, mm"),
    ("below_half_mm", "share ≤ 0.5 mm"), ("evaluations", "evaluations"),
)  # fmt: skip
_SENTENCES = (
    ("rms_mm", "all, mm"), ("lips_mm", "lips, mm"), ("face_mm", "but lips, mm"),
    ("depth_mm", "along z, mm"), ("worst_sentence_mm", "worst sentence, mm"),
    ("evaluations_per_frame", "evaluations a frame"),
    ("closure_recall", "closures, recall"), ("closure_precision", "precision"),
    ("sentences", "sentences"), ("frames", "frames"),
)  # fmt: skip
_AS_PRINTED = (("la_lin", "la_lin"), ("la_lin_as_printed", "la_lin, as printed"))
_TELECONFERENCE = (
    ("tex_cst", "tex_cst of one image", "2.5"), ("la_lin", "la_lin of 75 images", "1.3"),
    ("tex_cst_heldout", "tex_cst, held-out sequence", ""),
    ("la_lin_heldout", "la_lin, held-out sequence", ""),
)  # fmt: skip


def reproduction_page(results: Results, figures: Sequence[tuple[str, str]]) -> str:
    """The page of ``results.json`` and of figures by address and caption.

    What the results lack is said to be not measured.
    """
    made = [(name, str(results.get(key, "not recorded"))) for name, key in _MADE]
    body = f"""{table((), made)}
<p>Errors are those of the 275 points from where they were filmed, in head coordinates: what the
seven parameters cannot follow is in them. Visemes are those that appearance was not learned from,
found from the neutral posture with the head's motion known, as in the paper. Sentences are tracked
with all 13 parameters, from rest and the true pose in the first frame. A constant model differs
from its linear twin by M = 0 alone. Beyond epsilon as printed, differences of local appearance are
whitened by what the linear model leaves out of its own training pictures, and so are those of
textures in the visemes, where pixels beside an outline are left out, too; rows "as printed" are
without. Sentences are tracked by textures with epsilon as printed, which is several times less
work.</p>
{_face(results)}
<h2>At a glance</h2>
{table(("", "here", "goal", ""), goal_rows(results))}
<h2>Table 1: variance</h2>
{_variance(results)}
<h2>Visemes the models were not learned from</h2>
{_visemes(results)}
<h2>Sentences</h2>
{_sentences(results)}
{_each(results)}
{_as_printed(results)}
<h2>With less given</h2>
{_unassisted(results)}
<h2>Figure 7: groups of phonemes</h2>
{_trees(results)}
<h2>Teleconference: a camera that the head wears</h2>
{_teleconference(results)}
<h2>The search, all 13 parameters, at equal numbers of evaluations</h2>
{_rows(results.get("search_table"))}
<h2>The stopping rule, measured on visemes kept out of training and tests</h2>
{_rows(results.get("stopping"))}
<h2>The search of a sequence, measured on a sentence kept for practice</h2>
{_practice(results)}
<h2>Figures</h2>
{pictures(figures)}
<p>What it took: <a href="timing.json">timing.json</a>.</p>"""
    heading = "Shape and appearance models of talking faces, reproduced"
    return results_page("Odisio and Bailly (2003) reproduced", heading, body, results)


def _face(results: Results) -> str:
    """Path of the learned face."""
    if "face" not in results:
        return ""
    name = html.escape(str(results["face"]))
    return (
        f'<p>The bare face, its appearance learned from all visemes: <a href="{name}">{name}</a>; '
        f"<code>abs-engine track --model {name}</code> tracks its speaker.</p>"
    )


def _cell(value: float | None) -> str:
    if value is None or value != value:
        return MISSING
    return f"{value:.0f}" if abs(value) >= 100 or float(value).is_integer() else f"{value:.3g}"


def _variance(results: Results) -> str:
    papers = {**PAPER_VARIANCE, "total": PAPER_TOTAL}
    rows = []
    for name, paper in papers.items():
        value = number(results, f"variance.{name}")
        rows.append((name, MISSING if value is None else f"{value:.2%}", f"{paper:.2%}"))
    return table(("parameter", "here", "paper"), rows)


def _visemes(results: Results) -> str:
    rows = []
    for key, what in (("visemes", "beads"), ("visemes_bare", "bare")):
        for name in (*ASKED, NEUTRAL):
            if name in PRINTED and number(results, f"{key}.{name}.median_mm") is None:
                continue
            cells = (_cell(number(results, f"{key}.{name}.{c}")) for c, _ in _VISEMES)
            title = f"{PRINTED[name]}, epsilon as printed" if name in PRINTED else name
            rows.append((what, title, *cells))
    return table(("face", "model", *(title for _, title in _VISEMES)), rows)


def _sentences(results: Results) -> str:
    """A row for each model, the paper's few numbers below."""
    rows = []
    for name in MODELS:
        rows.append(
            (name, *(_cell(number(results, f"sentences.{name}.{c}")) for c, _ in _SENTENCES))
        )
    told = {"evaluations_per_frame": "about 300", "sentences": "77", "frames": "7546"}
    rows.append(("paper", *(told.get(c, "") for c, _ in _SENTENCES)))
    short = ""
    if any(number(results, f"sentences.{n}.sentences") != 77 for n in MODELS):
        short = "<p>Not all 77 sentences, or not with every model: see the columns.</p>"
    return short + table(("model", *(title for _, title in _SENTENCES)), rows)


def _each(results: Results) -> str:
    """A row for each sentence, those with the largest errors of the first model marked."""
    rows = results.get("sentences_each")
    if not isinstance(rows, Sequence) or not rows:
        return ""
    first = next((m for m in MODELS if m in rows[0]), MODELS[0])
    errors = sorted((row[first]["rms_mm"] for row in rows if first in row), reverse=True)
    bad = errors[min(_WORST, len(errors)) - 1] if len(errors) > _WORST else float("inf")
    lines = [
        (
            row["name"], str(row["frames"]), *(_one(row.get(m)) for m in MODELS),
            _missing(row), "worst" if first in row and row[first]["rms_mm"] >= bad else "",
        )
        for row in rows
    ]  # fmt: skip
    head = ("sentence", "frames", *(f"{m}, mm (lips)" for m in MODELS), "closures missed", "")
    return f"<details><summary>Every sentence</summary>{table(head, lines)}</details>"


def _one(found: Mapping[str, float] | None) -> str:
    return "" if found is None else f"{found['rms_mm']:.2f} ({found['lips_mm']:.2f})"


def _missing(row: Mapping[str, Any]) -> str:
    """Models that miss closures, or find some that are none, with their number."""
    told = []
    for model in MODELS:
        own = row.get(model)
        if own is None:
            continue
        lost, wrong = own["spoken"] - own["closed"], own["found"] - own["true"]
        told += [f"{model}: {lost} of {own['spoken']}"] if lost else []
        told += [f"{model}: {wrong} too many"] if wrong else []
    return "; ".join(told)


def _as_printed(results: Results) -> str:
    """Our local appearance and the paper's as printed, on the same frames."""
    about = (
        "<p>The paper's system as printed, on some of these sentences, and ours on the "
        "same frames. As printed, descriptors are compared raw, beside all of A(a); points are "
        "those of which the parameters' columns of M_D reconstruct most variance, however near "
        "they lie; the search is Nelder-Mead from the frame before, without prediction or restart, "
        f"cut off after {PAPER.limit} evaluations, about the paper's mean. What is not printed is "
        "ours: the form of A(a), what a hidden point costs, which points are seen well "
        "enough to be chosen, and the first simplex.</p>"
    )
    rows = [
        (title, *(_cell(number(results, f"as_printed.{key}.{c}")) for c, _ in _SENTENCES))
        for key, title in _AS_PRINTED
    ]
    return about + table(("model", *(title for _, title in _SENTENCES)), rows)


def _unassisted(results: Results) -> str:
    """A row for each face and test."""
    about = (
        "<p>An experiment of our own. Sentences of the bare face are tracked without its first "
        "pose, which landmarks estimate; otherwise the search is that of the sentences above. The "
        "given face is the true head's, learned from pictures whose poses are known. The measured "
        "face is made of the corpus' points, which are 0.3 mm off, and the poses of its pictures "
        "are estimated. So are those of the face of tracked beads, whose corpus is filmed: a "
        "speaker with dots of ink says the visemes in front of two cameras, calibrated by a board, "
        "and the dots are followed and triangulated, in the frame of a plate between the teeth; "
        "the truth says only where a person would point at them at the start. Hidden lower teeth "
        "have no dots, so jaw1 and jaw2 are those of the jaw line alone; the pictures that "
        "appearance is learned from show the same postures without dots. &ldquo;As training&rdquo; "
        "has the training pictures' camera, light and motion; &ldquo;otherwise&rdquo; has a larger "
        "picture, a wider lens nearer to the face, "
        "light from the other side, and a head that moves 1.7 times as far. The camera's "
        "calibration is given, and films are compressed. Errors are in mm, RMS, of all vertices of "
        "the lips, in the frame of the upper teeth, so they do not compare with the table above; "
        "&ldquo;less constant&rdquo; leaves out what all frames of a sentence have in common, and "
        "&ldquo;motion&rdquo; is how far the lips move about their mean. A sentence is found or "
        "lost as a whole; errors are of found ones alone.</p>"
    )
    found = results.get("unassisted")
    return about + _rows(found) if found else _rows(found)


def _trees(results: Results) -> str:
    trees = results.get("trees")
    if not isinstance(trees, Mapping):
        return f"<p>{MISSING.capitalize()}.</p>"
    rows = [
        (kind, " ".join("{" + " ".join(group) + "}" for group in groups), _PAPER_TREES[kind])
        for kind, groups in trees.items()
    ]
    return table(("", "here, cut into as many groups as the paper's", "paper"), rows)


def _teleconference(results: Results) -> str:
    rows = [
        (
            name, *(_cell(number(results, f"teleconference.{key}.{c}"))
                    for c in ("rms_mm", "lips_mm", "evaluations_per_frame", "frames")),
            paper,
        )
        for key, name, paper in _TELECONFERENCE
    ]  # fmt: skip
    return table(("", "mm", "lips, mm", "evaluations a frame", "frames", "paper, mm"), rows)


def _practice(results: Results) -> str:
    found = results.get("practice")
    about = (
        f"<p>The first {results.get('practice_frames', 'few')} frames of a sentence that is none "
        "of the 77; settings were chosen on more of it. simplex is the paper's warm start "
        "(but the frame before is a vertex of the first simplex, in the paper its centroid), "
        "predicted the same from a place predicted from the frames before, axes ours, along "
        "Gauss-Newton's axes; axes_predicted is what sentences are tracked with, and the other "
        "rows change one thing of it. Where the head's distance drifts, later in the sentence, "
        "A(a) is worth more.</p>"
    )
    return _rows(found) if not found else about + _rows(found)


def _rows(found: object) -> str:
    if not isinstance(found, Sequence) or not found:
        return f"<p>{html.escape(MISSING.capitalize())}.</p>"
    rows = [[v if isinstance(v, str) else _cell(v) for v in row.values()] for row in found]
    return table([name.replace("_", " ") for name in found[0]], rows)
