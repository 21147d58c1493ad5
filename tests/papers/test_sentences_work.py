"""Tracking sentences is cut off and goes on; what is stale is not taken; folders in the making."""

from __future__ import annotations

import multiprocessing
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from abs_engine.core.errors import OutputError
from abs_engine.core.geometry import Pose
from abs_engine.face.talking import MODELS
from abs_engine.io.naming import RECORD, partial_of
from abs_engine.io.unfinished import Unfinished
from abs_engine.papers.odisio2004 import sentences_work
from abs_engine.papers.odisio2004.gathered import FULL, QUICK, Report
from abs_engine.papers.odisio2004.result_cache import Kept, digest
from abs_engine.papers.odisio2004.sentences import chosen
from abs_engine.papers.odisio2004.sentences_parts import jobs_of
from abs_engine.papers.odisio2004.sentences_work import Job, Work, settings_of, track_sentences
from abs_engine.papers.odisio2004.sequence import Settings, Tracked
from abs_engine.studio.french import SENTENCES

FRAMES, P = 3, 2
JOBS = [Job(s, ("tex_lin", "la_lin")) for s in SENTENCES[:3]]


def tracked(value=0.5):
    rng = np.random.default_rng(0)
    return Tracked(
        rng.normal(size=(FRAMES, P)), (Pose.facing(600.0),) * FRAMES, np.full(FRAMES, value),
        np.arange(FRAMES), np.zeros(FRAMES, np.bool_), 1.25,
    )  # fmt: skip


def test_what_is_kept_comes_back(tmp_path):
    kept = Kept(tmp_path / "tracked", {"seed": 0}, tmp_path / "aside")
    assert kept.load("massue", "tex_lin", Settings()) is None
    kept.save("massue", "tex_lin", Settings(), tracked())
    found, own = kept.load("massue", "tex_lin", Settings()), tracked()
    np.testing.assert_array_equal(found.alpha, own.alpha)
    np.testing.assert_array_equal(found.evaluations, own.evaluations)
    assert [p.translation.tolist() for p in found.poses] == [[0, 0, 600]] * FRAMES
    assert found.seconds == 1.25
    assert len(list((tmp_path / "tracked").iterdir())) == 1


@pytest.mark.parametrize(
    ("basis", "settings"),
    [({"seed": 1}, Settings()), ({"seed": 0, "person": "kofi"}, Settings()),
     ({"seed": 0}, Settings(limit=99))],
)  # fmt: skip
def test_what_is_stale_is_not_taken(tmp_path, basis, settings):
    Kept(tmp_path, {"seed": 0}, tmp_path).save("massue", "tex_lin", Settings(), tracked())
    assert Kept(tmp_path, basis, tmp_path).load("massue", "tex_lin", settings) is None


def test_half_a_file_is_not_taken(tmp_path):
    kept = Kept(tmp_path, {}, tmp_path / "aside")
    kept.save("massue", "tex_lin", Settings(), tracked())
    path = kept.path("massue", "tex_lin", Settings())
    path.write_bytes(path.read_bytes()[:100])
    assert kept.load("massue", "tex_lin", Settings()) is None


def test_a_digest_sees_every_number():
    first = tracked()
    assert digest(first) == digest(tracked())
    moved = first.alpha.copy()
    moved[0, 0] += 1e-12
    assert digest(replace(first, alpha=moved)) != digest(first)
    assert digest({"a": [1, 2]}) != digest({"a": [1, 3]})


class Cut(Exception):
    """The power fails."""


@pytest.fixture
def studio(monkeypatch):
    """Filming and tracking that only note what they are asked for."""
    asked, fail_at = [], []

    def film(*_):
        return SimpleNamespace(pictures=[], camera=None, poses=[None])

    def search(_face, model, *_):
        asked.append(model)
        if len(asked) in fail_at:
            raise Cut
        return tracked(len(asked))

    monkeypatch.setattr(sentences_work, "film_plan", film)
    monkeypatch.setattr(sentences_work, "track", search)
    monkeypatch.setattr(Work, "plan", lambda *_: None)
    return asked, fail_at


def work(folder, **other):
    face = SimpleNamespace(shape=SimpleNamespace(vertices=None, neutral=None))
    return Work(
        folder, folder.parent / "aside", "clara", 0, None, face, np.zeros((1, P)), "none", **other
    )


def test_an_interrupted_run_goes_on_where_it_stopped(studio, tmp_path):
    asked, fail_at = studio
    fail_at.append(4)  # the second model of the second sentence
    folder, said = tmp_path / "tracked", []
    with pytest.raises(Cut):
        track_sentences(work(folder), JOBS, None, None)
    assert len(list(folder.iterdir())) == 3
    fail_at.clear()
    asked.clear()
    track_sentences(work(folder), JOBS, None, None, tell=said.append)
    assert asked == ["la_lin", "tex_lin", "la_lin"]
    assert said[0] == "1 of 3 sentences were there from before"
    assert "1 of 2 sentences done, about" in said[-1]
    track_sentences(work(folder), JOBS, None, None)
    assert len(asked) == 3
    track_sentences(work(folder, seed=1), JOBS, None, None)
    assert len(asked) == 9


def test_a_worker_draws_by_itself(tmp_path, monkeypatch):
    """Every process opens its own renderer; the order in which they end does not matter."""
    monkeypatch.setattr(
        multiprocessing, "get_context", lambda _: multiprocessing.context.ForkContext()
    )
    monkeypatch.setattr(sentences_work, "open_renderer", lambda name: f"{name} of its own")
    monkeypatch.setattr(sentences_work, "load_speaker", lambda: "speaker")

    def job(own, one, speaker, renderer):
        assert (speaker, renderer) == ("speaker", "cpu of its own")
        for model in one.models:
            own.kept.save(one.sentence.name, model, settings_of(model), tracked())

    monkeypatch.setattr(sentences_work, "track_job", job)
    own, said = work(tmp_path / "tracked"), []
    track_sentences(own, JOBS, None, None, workers=2, renderer_name="cpu", tell=said.append)
    assert not own.left(JOBS)
    assert len(said) == 3


def test_sentences_are_chosen_evenly():
    assert chosen(None) == SENTENCES
    assert chosen(100) == SENTENCES
    for count in (1, 5, 11, 40):
        own = [SENTENCES.index(s) for s in chosen(count)]
        assert len(own) == count
        assert own[0] == 0
        assert np.diff([*own, 77]).max() <= 2 * 128 / count
        assert set(chosen(count)) < set(chosen(count + 1))


def test_the_linear_models_have_all_sentences():
    assert {job.models for job in jobs_of(FULL)} == {MODELS}
    full = jobs_of(replace(FULL, twins=11))
    assert {job.sentence for job in full} == set(SENTENCES)
    assert sum(len(job.models) == 4 for job in full) == 11
    assert {job.models for job in full if len(job.models) < 4} == {("tex_lin", "la_lin")}
    fewer = jobs_of(replace(FULL, sentences=20, twins=11))
    assert fewer == full[:20]
    assert [(j.sentence.name, len(j.models)) for j in jobs_of(QUICK)] == [
        ("massue", 4), ("bouquet", 4)
    ]  # fmt: skip


def test_a_stage_is_done_once(tmp_path):
    def report():
        return Report(tmp_path, tmp_path, None, None, 0, print, "clara", True, QUICK)

    def make(own):
        own.results["mm"] = 0.4
        own.figure("a.png", b"png", "A figure.")

    first, second = report(), report()
    first.stage("visemes", make)
    second.stage("visemes", None)
    assert second.results == first.results
    assert second.results["mm"] == 0.4
    assert second.figures == [("a.png", "A figure.")]


def test_the_command_is_told_as_it_is_typed(tmp_path):
    def command(quick, amount, workers=1):
        made = Report(tmp_path, tmp_path, None, None, 3, print, "kofi", quick, amount, workers)
        return made.command

    assert command(True, QUICK) == "abs-engine reproduce 001 --quick --seed 3 --person kofi"
    assert command(False, replace(FULL, sentences=40, twins=2), 2) == (
        "abs-engine reproduce 001 --seed 3 --person kofi --sentences 40 --twins 2 --workers 2"
    )


def test_a_folder_in_the_making_survives(tmp_path):
    target = tmp_path / "report"
    with Unfinished(target, "seed 0") as made:
        (made.work / "half").write_text("done")
    assert not target.exists()
    with pytest.raises(OutputError, match="an interrupted command had kept"):
        Unfinished(target, "seed 1")
    with Unfinished(target, "seed 0") as again:
        assert again.resumed
        with pytest.raises(OutputError, match="another process makes"):
            Unfinished(target, "seed 0")
        again.finish()
    assert {p.name for p in target.iterdir()} == {"half", RECORD}
    assert not partial_of(target).exists()
    with pytest.raises(OutputError, match="exists already"):
        Unfinished(target, "seed 1")
