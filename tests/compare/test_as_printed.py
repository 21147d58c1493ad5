"""Local appearance as the paper prints it, beside ours, on the same sentences."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import appearances
import numpy as np
import pytest
import shapes

from abs_engine.compare.points import local_error
from abs_engine.core.pose import at_base, mode_block, pose_and
from abs_engine.face.appearance.local_learning import learn_local
from abs_engine.face.appearance.point_selection import choose_points
from abs_engine.face.penalty import ImprobablePenalty
from abs_engine.face.talking import TalkingFace
from abs_engine.fit.settings import TALKING_FIT
from abs_engine.fit.talking import talking_problem
from abs_engine.optimise.by_nlopt import Simplex
from abs_engine.papers.odisio2004 import sentences_parts, sentences_work, sequence
from abs_engine.papers.odisio2004.gathered import FULL, QUICK, Report
from abs_engine.papers.odisio2004.page import reproduction_page
from abs_engine.papers.odisio2004.sentences import chosen
from abs_engine.papers.odisio2004.sentences_work import Job, Work, settings_of, track_sentences
from abs_engine.papers.odisio2004.sequence import AS_PRINTED, PAPER, Settings, clip_setting
from abs_engine.papers.odisio2004.sequence_measure import by_articulation
from abs_engine.render.cpu import CpuRenderer
from abs_engine.studio.french import SENTENCES

RENDERER = CpuRenderer()
POINTS, SPACING = 20, 8.0
N = appearances.N_MODES
LITERAL, OURS = "la_lin_as_printed", "la_lin"


class Pictures:
    """So many pictures of a camera."""

    def __init__(self, camera, count):
        self.camera, self._count = camera, count

    def __len__(self):
        return self._count


@pytest.fixture(scope="module")
def ball():
    """A ball as a face of local appearance, pictures it was learned from, and another one."""
    scene = appearances.varying_ball()
    camera = shapes.view(appearances.PIXELS)[0]
    frames = appearances.sightings(scene, camera, 12)
    front = np.flatnonzero(scene.mean[:, 2] > 0.5 * shapes.RADIUS)
    every = learn_local(frames, scene, front, camera, RENDERER)
    local = every.only(choose_points(every, POINTS, scene.mean[front], SPACING, whiten=True))
    alpha = np.array([frame.parameters for frame in frames])
    shape = SimpleNamespace(
        pivot=np.zeros(3), penalty=ImprobablePenalty.of_corpus(alpha),
        blocks=pose_and(mode_block(N, 3.5)), surface=scene, outer=scene, scene=scene, marks=front,
        kept=np.arange(len(scene.mean)),
    )  # fmt: skip
    speech = SimpleNamespace(pictures=Pictures(camera, len(frames)), sightings=lambda _: frames)
    other = appearances.sightings(scene, camera, 1, seed=77)[0]
    face = TalkingFace(shape, None, None, local, local.constant())
    return SimpleNamespace(face=face, every=every, camera=camera, other=other, speech=speech)


@pytest.mark.parametrize("printed", [True, False])
def test_printed_is_raw_descriptors_and_all_of_the_penalty(ball, printed):
    """Epsilon (section 4): the mean square of differences, and A(a)."""
    other, face = ball.other, ball.face
    given = other.image, ball.camera, other.pose, np.zeros(N), RENDERER
    asked = talking_problem(face, OURS, *given, window=ball.camera.whole, printed=printed)
    how = "no" if printed else "all"
    whole = ball.camera.whole
    error = local_error(
        face.la_lin, face.shape.outer, other.image, ball.camera, whole, RENDERER, whiten=how
    )
    x = at_base(8 * other.parameters)
    share = TALKING_FIT.penalty_share * (1.0 if printed else TALKING_FIT.whitened)
    walls = float(face.shape.penalty(x[None, 6:])[0])
    differ, shown = error.differences(asked.candidates(x[None]))
    rows = differ.ravel() if printed else error.mixed(differ)[0]
    hidden = np.where(shown[0], 0.0, error.wrong).mean()
    assert walls > 0
    expected = (rows**2).mean() + hidden + share * error.unit * walls
    assert asked(x).value == pytest.approx(expected, rel=1e-6)


def test_the_papers_points_may_lie_near_each_other(ball):
    found, front = by_articulation(ball.speech, ball.face, RENDERER), ball.face.shape.marks
    best = front[choose_points(ball.every, POINTS)]
    np.testing.assert_array_equal(found.la_lin.vertices, best)
    apart = by_articulation(ball.speech, ball.face, RENDERER, SPACING, whiten=True)
    np.testing.assert_array_equal(apart.la_lin.vertices, ball.face.la_lin.vertices)


def test_the_search_is_the_papers(monkeypatch):
    asked = {}
    monkeypatch.setattr(sequence, "as_face", lambda face: face)
    monkeypatch.setattr(sequence, "talking_problem", lambda *_, **how: asked.update(how))
    face = SimpleNamespace(shape=SimpleNamespace(neutral=None))
    postures = np.zeros((3, N))
    setting = clip_setting(face, OURS, None, None, AS_PRINTED, postures)
    assert replace(PAPER, printed=True) == AS_PRINTED
    assert setting.driver == Simplex(PAPER.tolerance, PAPER.limit)
    assert not setting.binder.predict
    assert setting.binder.postures is None
    setting.binder.problem(None, None, None)
    assert asked["printed"]
    clip_setting(face, OURS, None, None, Settings()).binder.problem(None, None, None)
    assert not asked["printed"]


def work(folder, **other):
    face = SimpleNamespace(shape=SimpleNamespace(vertices=None, neutral=None))
    return Work(folder, folder / "aside", "clara", 0, None, face, np.zeros((1, N)), "none", **other)


def test_a_works_own_settings_are_searched_with_and_kept_apart(tmp_path, monkeypatch):
    used = []
    film = SimpleNamespace(pictures=[], camera=None, poses=[None])
    monkeypatch.setattr(Work, "plan", lambda *_: None)
    monkeypatch.setattr(sentences_work, "film_plan", lambda *_: film)

    def search(_face, _model, *given):
        used.append(given[-3])
        nothing = np.zeros((0, N))
        return sequence.Tracked(nothing, (), nothing[:, 0], np.zeros(0, int), np.zeros(0, bool))

    monkeypatch.setattr(sentences_work, "track", search)
    monkeypatch.setattr(sentences_work.Kept, "save", lambda *_: None)
    jobs = [Job(SENTENCES[0], (OURS,))]
    usual, literal = work(tmp_path), work(tmp_path, settings=AS_PRINTED)
    track_sentences(usual, jobs, None, None)
    track_sentences(literal, jobs, None, None)
    assert used == [settings_of(OURS), AS_PRINTED]


@pytest.mark.parametrize(("amount", "count", "frames"), [(FULL, 10, None), (QUICK, 2, 36)])
def test_both_are_tracked_on_the_same_sentences(tmp_path, monkeypatch, amount, count, frames):
    ran = []

    def run(_report, own, _speech, jobs):
        ran.append((own, jobs))
        row = {"rms_mm": 1.0 + len(ran), "sentences": len(jobs)}
        return SimpleNamespace(told=lambda: {OURS: row})

    monkeypatch.setattr(sentences_parts, "run_sentences", run)
    monkeypatch.setattr(sentences_parts, "by_articulation", lambda *_: "the paper's")
    speech = SimpleNamespace(
        beads=0, pictures=SimpleNamespace(camera=None), built=SimpleNamespace(alpha=None)
    )
    drawn = SimpleNamespace(description="none")
    report = Report(tmp_path, tmp_path, drawn, None, 0, lambda _: None, "clara", False, amount)
    sentences_parts._as_printed(report, speech, "ours")
    (usual, jobs), (literal, same) = ran
    assert jobs == same
    assert {job.models for job in jobs} == {(OURS,)}
    assert len(jobs) == count
    if amount is FULL:
        assert {job.sentence for job in jobs} == set(chosen(count))
    assert (usual.face, usual.settings, usual.frames) == ("ours", None, frames)
    assert (literal.face, literal.settings, literal.frames) == ("the paper's", AS_PRINTED, frames)
    assert report.results["as_printed"] == {
        "sentences": count,
        OURS: {"rms_mm": 2.0, "sentences": count},
        LITERAL: {"rms_mm": 3.0, "sentences": count},
    }


def test_the_page_has_both_rows():
    rows = {OURS: {"rms_mm": 0.345, "sentences": 10}, LITERAL: {"rms_mm": 1.87, "frames": 999}}
    text = reproduction_page({"as_printed": {"sentences": 10, **rows}}, [])
    part = text[text.index("The paper's system as printed") :]
    assert "<td>10</td>" in part
    assert part.index("0.345") < part.index("la_lin, as printed") < part.index("1.87")
    assert "999" in part


def test_a_page_of_older_results_says_that_it_was_not_measured():
    text = reproduction_page({"sentences": {}}, [])
    part = text[text.index("The paper's system as printed") : text.index("Figure 7")]
    assert "not measured" in part
