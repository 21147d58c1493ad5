"""Sentences, trees and teleconference as parts of ``abs-engine reproduce 001``."""

from __future__ import annotations

from dataclasses import replace

from abs_engine.face.talking import LOCALS, MODELS, TalkingFace
from abs_engine.papers.odisio2004.filmed import SIZE
from abs_engine.papers.odisio2004.gathered import Amount, Report
from abs_engine.papers.odisio2004.reproduce import filmed
from abs_engine.papers.odisio2004.sentences import (
    chosen,
    in_spread_order,
    run_sentences,
    trees_of,
)
from abs_engine.papers.odisio2004.sentences_figures import curves_figure
from abs_engine.papers.odisio2004.sentences_filmed import cut, film_plan, plan_sentence
from abs_engine.papers.odisio2004.sentences_work import Job, Work
from abs_engine.papers.odisio2004.sequence import AS_PRINTED
from abs_engine.papers.odisio2004.sequence_measure import by_articulation, practise
from abs_engine.papers.odisio2004.teleconference import run_teleconference
from abs_engine.papers.odisio2004.trees import CONSONANTS, VOWELS, trees_figure
from abs_engine.papers.odisio2004.unassisted import unassisted
from abs_engine.papers.odisio2004.visemes import Speech
from abs_engine.report.drawing.figure import figure_bytes
from abs_engine.studio.french import PRACTICE, SENTENCES

TRACKED = "tracked"
TREE_MODEL = "tex_cst"
"""That of the paper's figure 7; where not all sentences have it, trees are of the first linear one,
which has them all."""
LINEAR = tuple(name for name in MODELS if name.endswith("lin"))
_CUT = {VOWELS: 3, CONSONANTS: 6}
"""Into how many groups the paper's text cuts its trees."""


def sentences_part(report: Report, speech: Speech) -> None:
    """Practice, figures 7 and 8, and the tables over the sentences; all in 320x240."""
    if speech.pictures.camera.size != SIZE:
        report.tell("filming visemes for the sentences")
        speech = filmed(report, "sentences", speech.beads, SIZE)
    report.tell("learning appearance for the sentences")
    face = speech.learn(range(len(speech.pictures)), report.renderer)
    if report.amount.practised:
        report.stage("practice", lambda own: _practice(own, speech, face))
    count = report.amount.sentences or len(SENTENCES)
    twins = report.amount.twins or count
    report.stage(f"sentences-{count}-{twins}", lambda own: _sentences(own, speech, face))
    few = min(count, report.amount.printed)
    if few:
        report.stage(f"as-printed-{few}", lambda own: _as_printed(own, speech, face))


def _practice(report: Report, speech: Speech, face: TalkingFace) -> None:
    report.tell("practising")
    frames = report.amount.practised
    plan = plan_sentence(
        report.speaker, report.person, PRACTICE, speech.pictures.camera, report.seed, speech.beads
    )
    filmed = film_plan(report.speaker, cut(plan, frames), PRACTICE, face.shape.vertices)
    report.results["practice_frames"] = frames
    kept = report.kept / "practice"
    report.results["practice"] = practise(speech, face, filmed, report.renderer, kept=kept)


def _sentences(report: Report, speech: Speech, face: TalkingFace) -> None:
    done = run_sentences(report, _work(report, speech, face), speech, jobs_of(report.amount))
    report.results["sentences"] = done.told()
    report.results["sentences_each"] = done.told_each()
    report.timing["seconds_per_frame"] = done.took()
    first = done.runs[0]
    report.figure(
        "figure8.svg", figure_bytes(curves_figure(face.shape, first.filmed, first.curves), "svg"),
        "Figure 8: a tracked sentence; the truth is the solid line.",
    )  # fmt: skip
    papers = all(TREE_MODEL in run.tracked for run in done.runs)
    model = TREE_MODEL if papers else LINEAR[0]
    trees = trees_of(done, face, model)
    report.results["trees_of"] = model
    report.results["trees"] = {
        kind: [list(group) for group in tree.groups(_CUT[kind])] for kind, tree in trees.items()
    }
    report.figure(
        "figure7.svg", figure_bytes(trees_figure(trees), "svg"),
        f"Figure 7: phonemes by the faces that {model} found.",
    )  # fmt: skip


def _work(report: Report, speech: Speech, face: TalkingFace) -> Work:
    return Work(
        report.folder / TRACKED, report.kept / TRACKED, report.person, speech.beads,
        speech.pictures.camera, face, speech.built.alpha, report.renderer.description,
        report.seed, report.amount.frames,
    )  # fmt: skip


def _as_printed(report: Report, speech: Speech, face: TalkingFace) -> None:
    """Some of the sentences by our local appearance, and by the paper's as printed."""
    model = LOCALS[0]
    jobs = [Job(job.sentence, (model,)) for job in jobs_of(report.amount)[: report.amount.printed]]
    ours = _work(report, speech, face)
    report.tell("choosing points as the paper does")
    papers = by_articulation(speech, face, report.renderer)
    literal = replace(ours, face=papers, settings=AS_PRINTED)
    report.results["as_printed"] = {
        "sentences": len(jobs),
        **{
            name: run_sentences(report, work, speech, jobs).told()[model]
            for name, work in ((model, ours), (f"{model}_as_printed", literal))
        },
    }


def jobs_of(amount: Amount) -> list[Job]:
    """The sentences in spread order; the constant models have some, the linear ones all."""
    if amount.frames:
        return [Job(s, MODELS) for s in SENTENCES[: amount.sentences]]
    twins = chosen(amount.twins)
    which = in_spread_order()[: amount.sentences]
    return [Job(s, MODELS if s in twins else LINEAR) for s in which]


def teleconference_part(report: Report, speech: Speech) -> None:
    """Figure 10 and the errors with the worn camera."""
    report.stage("teleconference", lambda own: run_teleconference(own, speech))


def unassisted_part(report: Report, speech: Speech) -> None:
    """Sentences that are tracked with less given."""
    few = min(report.amount.sentences or len(SENTENCES), report.amount.unassisted)
    if few:
        report.stage(f"unassisted-{few}", lambda own: _unassisted(own, few))


def _unassisted(report: Report, few: int) -> None:
    report.results["unassisted"] = unassisted(report, filmed(report, "bare", 0), few)


PARTS = (sentences_part, teleconference_part, unassisted_part)
