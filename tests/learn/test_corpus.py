"""The corpus of the bundled speakers, a user's own, and the model that is built of either."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from pathlib import Path
from zlib import crc32

import numpy as np
import pytest
from heads import spoken_heads
from marker_files import write_c3d, write_long, write_wide
from scipy.spatial.transform import Rotation

from abs_engine.capture.corpus import Corpus, bite_plane, load_corpus
from abs_engine.capture.corpus_file import read_corpus
from abs_engine.capture.corpus_table import read_table
from abs_engine.core.errors import (
    InputFileError,
    ModelFormatError,
    OutputError,
    ParameterError,
    TooFewPointsError,
)
from abs_engine.face.shape.articulatory_model import load_articulatory
from abs_engine.face.shape.predictors import PAPER_PREDICTORS
from abs_engine.io.assets import load_speaker
from abs_engine.learn.articulatory import build, dense_head, leave_out_in_turn
from abs_engine.learn.spoken import SpokenCorpus
from abs_engine.render.cpu import CpuRenderer
from abs_engine.report.articulation.analysis import analyse
from abs_engine.report.articulation.applied import apply_model
from abs_engine.report.articulation.figures import boxplot_figure, nomogram_figure
from abs_engine.report.articulation.report import HEADS, Heads, write_report
from abs_engine.report.articulation.tables import boxes, results, variance_table, variance_text
from abs_engine.report.drawing import smooth
from abs_engine.report.drawing.figure import figure_bytes
from abs_engine.studio.corpus import ALL_VISEMES, PAPER_VISEMES, speak_corpus
from abs_engine.studio.people.lip_contact import widest_gap

SPEAKER = load_speaker()
FROZEN = 843474347


@pytest.fixture(scope="module")
def spoken() -> SpokenCorpus:
    return speak_corpus(SPEAKER, SPEAKER.named("clara"))


def test_the_counts_are_the_paper_s(spoken: SpokenCorpus):
    corpus = spoken.corpus
    assert corpus.points.shape == (68, 275, 3)
    assert corpus.visemes == PAPER_VISEMES
    assert len(ALL_VISEMES) == 2 + 13 + 18 * 6
    assert set(PAPER_VISEMES) <= set(ALL_VISEMES)
    assert not any("T" in v or ("9" in v and v not in ("9", "9~")) for v in PAPER_VISEMES)
    counts = {group: len(names) for group, names in corpus.groups.items()}
    assert counts == {
        "lip_contour": 30, "lip_beads": 20, "lips": 50, "upper_lip": 22, "lower_lip": 22,
        "jaw_line": 11, "lower_teeth": 7, "face": 238,
    }  # fmt: skip
    assert len(set(spoken.chosen.vertices.tolist())) == 275


def of(corpus: Corpus, group: str) -> list[int]:
    return [corpus.names.index(name) for name in corpus.groups[group]]


def heads_of(spoken: SpokenCorpus) -> np.ndarray:
    return spoken_heads(spoken.speaker, spoken.neutral, spoken.weights)


def test_the_choice_of_points_is_frozen(spoken: SpokenCorpus):
    """Figures stay comparable only while it does not change."""
    assert crc32(spoken.chosen.vertices.astype("<i8").tobytes()) == FROZEN


def test_points_lie_where_their_names_say(spoken: SpokenCorpus):
    rest = SPEAKER.vertices[spoken.chosen.vertices]
    corpus = spoken.corpus
    assert rest[of(corpus, "upper_lip"), 1].mean() > rest[of(corpus, "lower_lip"), 1].mean() + 8
    teeth = np.unique(SPEAKER.faces[SPEAKER.facet_class == SPEAKER.class_id("lower_teeth")])
    assert set(spoken.chosen.vertices[of(corpus, "lower_teeth")]) <= set(teeth)
    ring = SPEAKER.vertices[SPEAKER.lip_ring]
    beads = rest[of(corpus, "lip_beads")]
    away = np.linalg.norm(beads[:, None] - ring, axis=2).min(axis=1)
    assert 3 < away.min() <= away.max() < 10
    mirrored = rest * [-1, 1, 1]
    nearest = np.linalg.norm(mirrored[:, None] - rest, axis=2).min(axis=1)
    assert np.median(nearest) < 4  # spread over both halves alike


def test_the_bite_plane_is_the_upper_teeth_s(spoken: SpokenCorpus):
    own = np.unique(SPEAKER.faces[SPEAKER.facet_class == SPEAKER.class_id("upper_teeth")])
    teeth = spoken.corpus.frame.apply(spoken.neutral[own].astype(np.float64))
    assert np.linalg.det(spoken.corpus.frame.rotation) == pytest.approx(1)
    ahead = teeth[(np.abs(teeth[:, 0]) < 5) & (teeth[:, 2] > -5)]
    assert ahead[:, 1].min() == pytest.approx(0, abs=0.3)
    assert np.abs(ahead[:, 2]).max() < 6
    behind = teeth[teeth[:, 2] < -30]
    assert behind[:, 1].min() == pytest.approx(0, abs=0.3)
    nose = SPEAKER.landmarks["nose_tip"]
    high = spoken.corpus.frame.apply(spoken.neutral[nose].astype(np.float64))[0]
    assert high[1] > 20
    assert high[2] > 5


def test_a_bite_plane_of_three_points():
    turn = Rotation.from_rotvec([0.3, -0.2, 1.0]).as_matrix()
    marks = np.array([[-25.0, 0, -35], [25, 0, -35], [0, 0, 0]]) @ turn.T + [5, 6, 7]
    frame = bite_plane(*marks)
    np.testing.assert_allclose(frame.rotation, turn.T, atol=1e-9)
    np.testing.assert_allclose(frame.apply(marks[2]), 0, atol=1e-9)
    for bad in (marks * np.nan, np.zeros((3, 3))):
        with pytest.raises(TooFewPointsError, match="upper teeth"):
            bite_plane(*bad)


def test_points_are_those_of_the_heads_but_for_the_noise(spoken: SpokenCorpus):
    seen = heads_of(spoken)[:, spoken.chosen.vertices].astype(np.float64)
    np.testing.assert_allclose(spoken.corpus.frame.apply(seen), spoken.exact, atol=1e-3)
    error = spoken.corpus.points - spoken.exact
    assert np.sqrt((error**2).sum(axis=2).mean()) == pytest.approx(0.3, abs=0.005)
    np.testing.assert_array_equal(spoken.noiseless.points, spoken.exact)


def test_the_same_seed_gives_the_same_corpus():
    few = ("rest", "apa", "y")
    first, again, other = (
        speak_corpus(SPEAKER, SPEAKER.named("mei"), few, seed=s).corpus.points for s in (3, 3, 4)
    )
    np.testing.assert_array_equal(first, again)
    assert not np.array_equal(first, other)


def test_visemes_look_as_they_are_spoken(spoken: SpokenCorpus):
    heads = dict(zip(PAPER_VISEMES, heads_of(spoken), strict=True))
    gap = {v: widest_gap(SPEAKER, head) for v, head in heads.items()}
    closed = {v for v in PAPER_VISEMES if v == "rest" or v[1:2] in ("p", "b", "m")}
    assert max(gap[v] for v in closed) < 0.3
    assert min(gap[v] for v in PAPER_VISEMES if v not in closed) > 0.3
    assert gap["a"] > 2 * gap["i"] > 0
    assert gap["ata"] > gap["iti"]  # coarticulation by the vowel
    corners = SPEAKER.landmarks["mouth_corners"]
    width = {v: np.ptp(head[corners, 0]) for v, head in heads.items()}
    assert width["y"] < width["a"] < width["i"]
    assert width["utu"] < width["iti"]


def test_bad_requests_are_refused():
    rest = SPEAKER.vertices
    for viseme in ("x", "ipa", "ip", "qqqq"):
        with pytest.raises(ParameterError, match="no viseme"):
            speak_corpus(SPEAKER, rest, (viseme,))
    with pytest.raises(ParameterError, match="noise"):
        speak_corpus(SPEAKER, rest, ("rest",), noise=-1)
    with pytest.raises(ParameterError, match="two visemes"):
        speak_corpus(SPEAKER, rest, ("rest", "rest"))


@pytest.mark.parametrize("person", ["clara", "kofi", "ravi"])
def test_seven_parameters_hold_what_the_paper_s_do(spoken: SpokenCorpus, person: str):
    one = spoken if person == "clara" else speak_corpus(SPEAKER, SPEAKER.named(person))
    built = build(one.corpus)
    assert built.model.held > 0.9629
    assert (built.viseme_errors <= 0.5).mean() > 0.9
    assert (leave_out_in_turn(one.corpus).errors <= 0.5).mean() > 0.9
    assert build(one.noiseless).model.held > built.model.held
    told = dict(zip(built.model.parameters, built.model.modes, strict=True))
    at = {group: of(one.corpus, group) for group in one.corpus.groups}
    assert told["jaw1"][at["lower_teeth"], 1].mean() < -2
    assert told["lips1"][at["lips"], 2].mean() > 1
    assert told["lips3"][at["upper_lip"], 1].mean() > 0.3
    assert told["jaw2"][at["lower_teeth"], 2].mean() > 0.3


def test_visemes_that_were_not_learned_are_reached(spoken: SpokenCorpus):
    """The contexts e, o and 9, and the consonant T."""
    others = tuple(v for v in ALL_VISEMES if v not in PAPER_VISEMES)
    unseen = speak_corpus(SPEAKER, SPEAKER.named("clara"), others, seed=1)
    errors = build(spoken.corpus).model.errors(unseen.corpus.points)
    assert np.median(np.sqrt((errors**2).mean(axis=1))) < 0.5


def test_the_whole_head_follows_the_model(spoken: SpokenCorpus):
    built = build(spoken.corpus)
    dense = dense_head(built, spoken)
    assert dense.modes.shape == (7, len(SPEAKER.vertices), 3)
    heads = dense.mean + np.tensordot(built.alpha, dense.modes, 1)
    missed = np.linalg.norm(heads_of(spoken) - heads, axis=2)
    assert np.sqrt((missed**2).mean()) < 0.25
    points = spoken.corpus.frame.apply(dense.mean[spoken.chosen.vertices].astype(np.float64))
    assert np.linalg.norm(points - built.model.mean, axis=1).max() < 0.3


def test_tables_and_results(spoken: SpokenCorpus):
    built = build(spoken.corpus)
    rows = variance_table(built.model)
    assert [name for name, *_ in rows] == [p.name for p in PAPER_PREDICTORS]
    assert rows[-1][2] == f"{100 * built.model.held:.2f}"
    assert (rows[0][3], rows[-1][4]) == ("16.11", "96.29")
    assert "| lips1 |" in variance_text(built.model)
    told = json.loads(json.dumps(results(built, leave_out_in_turn(spoken.corpus).errors)))
    assert set(told["variance"]) == {*built.model.parameters, "total"}
    assert told["model_error_mm_median"] < told["left_out_error_mm_median"]


def test_figures(spoken: SpokenCorpus, tmp_path: Path):
    built = build(spoken.corpus)
    told = boxes(built.corpus.visemes, built.model.names, built.errors)
    assert len(told) == 68
    box = told[5]
    quartiles = [box.drawn[name] for name in ("whislo", "q1", "med", "q3", "whishi")]
    assert quartiles == sorted(quartiles)
    assert box.rms == pytest.approx(float(built.viseme_errors[5]))
    assert figure_bytes(boxplot_figure(told)).startswith(b"\x89PNG")
    svg = figure_bytes(boxplot_figure(told), "svg")
    assert svg == figure_bytes(boxplot_figure(told), "svg")
    with CpuRenderer() as renderer:
        picture = nomogram_figure(
            renderer, SPEAKER, dense_head(built, spoken), built.model.parameters,
            size=(40, 48), values=(-2.0, 2.0), crop="mouth",
        )  # fmt: skip
    rows = picture[24:, 126:].reshape(7, -1, picture.shape[1] - 126, 3)
    left, right = np.split(rows[:, :, : rows.shape[2] // 2 * 2], 2, axis=2)
    changed = np.abs(left.astype(int) - right.astype(int)).mean(axis=(1, 2, 3))
    assert (changed[:2] > changed[5:].max()).all()  # jaw1 and lips1 are seen best


def test_missing_points_come_out_by_name(spoken: SpokenCorpus):
    points = spoken.corpus.points.copy()
    points[4, 100] = np.nan
    gappy = Corpus(points, spoken.corpus.names, PAPER_VISEMES, spoken.corpus.groups)
    with pytest.raises(TooFewPointsError, match=gappy.names[100]):
        build(gappy)
    dropped, imputed = build(gappy, missing="drop"), build(gappy, missing="impute")
    assert dropped.left_out == (gappy.names[100],)
    assert dropped.errors.shape == (68, 274)
    assert imputed.imputed == {gappy.names[100]: 1}
    assert np.isnan(imputed.errors[4, 100])
    assert np.isfinite(imputed.viseme_errors).all()
    with pytest.raises(TooFewPointsError, match="7 visemes for 7 parameters"):
        build(spoken.corpus.without(PAPER_VISEMES[7:]))


def test_a_corpus_is_saved_and_read_again(spoken: SpokenCorpus, tmp_path: Path):
    path = tmp_path / "corpus.npz"
    spoken.corpus.save(path)
    for again in (load_corpus(path), read_corpus(path)):
        np.testing.assert_array_equal(again.points, spoken.corpus.points)
        np.testing.assert_array_equal(again.frame.rotation, spoken.corpus.frame.rotation)
        assert again.groups == spoken.corpus.groups
        assert (again.names, again.visemes) == (spoken.corpus.names, PAPER_VISEMES)
    with np.load(path) as archive:
        whole = dict(archive)
    for change in ({"groups": "["}, {"groups": '{"lips": ["no"]}'}, {"version": 7},
                   {"points": whole["points"][:3]}):  # fmt: skip
        np.savez(tmp_path / "bad.npz", **{**whole, **change})
        with pytest.raises(ModelFormatError):
            load_corpus(tmp_path / "bad.npz")


def test_corpora_that_do_not_fit_are_refused(spoken: SpokenCorpus):
    points = np.zeros((2, 2, 3))
    for visemes, names, groups in (
        (("a", "a"), ("p", "q"), {}), (("a", "i"), ("p", "p"), {}), (("a",), ("p", "q"), {}),
        (("a", "i"), ("p", "q"), {"lips": ("r",)}),
    ):  # fmt: skip
        with pytest.raises(ParameterError):
            Corpus(points, names, visemes, groups)


NAMES = ("m1", "m2", "m3", "right", "left", "front")
TABLE = {
    "groups": {"lips": ["m1", "m2"], "jaw_line": ["m3"]},
    "visemes": {"ipi": 1, "a": [2, 3]},
    "upper_teeth": ["right", "left", "front"],
}
LINES = """what,name,value
point,m1,lips
point,m2,lips
point,m3,jaw_line
viseme,ipi,1
viseme,a,2-3
teeth,right,right
teeth,left,left
teeth,front,front
"""


def recording() -> tuple[np.ndarray, np.ndarray]:
    """Points (4, 6, 3) in the frame of the teeth, and the same on a head that turns."""
    rng = np.random.default_rng(0)
    own = np.concatenate(
        [
            rng.normal(size=(4, 3, 3)) * 20,
            np.tile([[-25.0, 0, -35], [25, 0, -35], [0, 0, 0]], (4, 1, 1)),
        ],
        axis=1,
    )
    own[3, :3] = own[2, :3]
    turns = Rotation.from_rotvec(0.3 * rng.normal(size=(4, 3))).as_matrix()
    return own, own @ turns.transpose(0, 2, 1) + 50 * rng.normal(size=(4, 1, 3))


@pytest.mark.parametrize("kind", ["c3d", "wide", "long", "npz"])
@pytest.mark.parametrize("table", ["json", "csv"])
def test_a_user_s_own_corpus(tmp_path: Path, kind: str, table: str):
    own, points = recording()
    points[2, 0] = np.nan  # one of two frames of a viseme
    path = tmp_path / f"own.{kind if kind in ('c3d', 'npz') else 'csv'}"
    if kind == "npz":
        np.savez(path, names=np.array(NAMES), points=points)
    else:
        {"c3d": write_c3d, "wide": write_wide, "long": write_long}[kind](path, NAMES, points)
    told = tmp_path / f"table.{table}"
    told.write_text(json.dumps(TABLE) if table == "json" else LINES)
    corpus = read_corpus(path, told)
    assert corpus.visemes == ("ipi", "a")
    assert corpus.groups == {"lips": ("m1", "m2"), "jaw_line": ("m3",)}
    np.testing.assert_allclose(corpus.points, own[1:3], atol=1e-3)


def test_tables_that_are_wrong_are_refused(tmp_path: Path):
    path = tmp_path / "own.npz"
    np.savez(path, names=np.array(NAMES), points=recording()[1])
    told = tmp_path / "table.json"
    cases = {
        "{": InputFileError, "[]": InputFileError, '{"groups": {}}': InputFileError,
        json.dumps({**TABLE, "visemes": {}}): InputFileError,
        json.dumps({**TABLE, "visemes": {"a": [3, 2]}}): InputFileError,
        json.dumps({**TABLE, "visemes": {"a": 4}}): ParameterError,
        json.dumps({**TABLE, "groups": {"lips": ["no"]}}): ParameterError,
        json.dumps({**TABLE, "upper_teeth": ["right", "left", "no"]}): ParameterError,
        json.dumps({**TABLE, "upper_teeth": ["right", "left"]}): InputFileError,
    }  # fmt: skip
    for text, error in cases.items():
        told.write_text(text)
        with pytest.raises(error):
            read_corpus(path, told)
    lines = tmp_path / "table.csv"
    for line in ("viseme,ipi,1", "tooth,x,y", "viseme,u,x"):
        lines.write_text(LINES + line + "\n")
        with pytest.raises(InputFileError):
            read_table(lines)
    marker = write_wide(tmp_path / "m.csv", NAMES, recording()[1])
    with pytest.raises(ParameterError, match="give a table"):
        read_corpus(marker)
    with pytest.raises(InputFileError, match="does not exist"):
        read_corpus(path, tmp_path / "none.json")
    np.savez(path, names=np.array(NAMES), points=np.zeros((4, 5, 3)))
    told.write_text(json.dumps(TABLE))
    with pytest.raises(InputFileError, match="6 names"):
        read_corpus(path, told)


def test_a_lost_tooth_is_named(tmp_path: Path):
    _, points = recording()
    points[3, 5] = np.nan
    path, told = tmp_path / "own.npz", tmp_path / "table.json"
    np.savez(path, names=np.array(NAMES), points=points)
    told.write_text(json.dumps(TABLE))
    with pytest.raises(TooFewPointsError, match="frame 3"):
        read_corpus(path, told)


def test_the_report_of_a_person_is_written(tmp_path: Path, monkeypatch):
    monkeypatch.setattr(smooth, "FINER", 1)  # nobody looks at the pictures
    one = speak_corpus(SPEAKER, SPEAKER.named("mei"))
    done = analyse(one.corpus, without=("ipi", "bead_001"))
    with CpuRenderer() as renderer:
        heads = Heads(one, "mei", renderer)
        write_report(tmp_path / "mei", done, heads)
        with pytest.raises(OutputError):
            write_report(tmp_path / "mei", done, heads)
    assert {p.name for p in (tmp_path / "mei").iterdir()} == {
        "corpus.npz", "model.npz", "variance.md", "results.json", "index.html", "boxplots.svg",
        "nomograms.svg", "heads_front.png", "heads_side.png", "points.csv", "roles.csv",
        "predictors.toml",
    }  # fmt: skip
    page = (tmp_path / "mei" / "index.html").read_text()
    for name, (_, shown) in HEADS.items():
        assert re.search(f'"{name}" alt="[^"]*{shown}', page), "a caption says what is drawn"
    told = json.loads((tmp_path / "mei" / "results.json").read_text())
    assert told["variance"]["total"] == pytest.approx(done.built.model.held)
    assert told["variance_without_noise"]["total"] > told["variance"]["total"]
    assert told["kept_out"]["asked"] == ["ipi", "bead_001"]
    again = build(load_corpus(tmp_path / "mei" / "corpus.npz"))
    model = load_articulatory(tmp_path / "mei" / "model.npz")
    np.testing.assert_allclose(again.model.modes, model.modes)
    example = read_corpus(tmp_path / "mei" / "points.csv", tmp_path / "mei" / "roles.csv")
    assert example.visemes == PAPER_VISEMES
    assert example.groups == {k: tuple(v) for k, v in one.corpus.groups.items()}
    assert example.roleless == ("upper_right", "upper_left", "upper_front")
    shown = example.without(example.roleless).points
    np.testing.assert_allclose(shown, one.corpus.points, atol=2e-4)


def test_ordinary_gaps_are_filled_in(spoken: SpokenCorpus):
    """These leave a residual that LAPACK's fast singular values do not converge for."""
    gappy = spoken.corpus.points.copy()
    gappy[np.random.default_rng(3).random(gappy.shape[:2]) < 0.3] = np.nan
    filled = build(replace(spoken.corpus, points=gappy), missing="impute")
    away = np.linalg.norm(filled.model.points(filled.alpha) - spoken.corpus.points, axis=2)
    assert np.sqrt((away**2).mean()) < 1.0
    assert filled.model.held == pytest.approx(build(spoken.corpus).model.held, abs=0.01)


LIPS_4 = ("lip_upper_006", "lip_lower_006", "lip_corner_000", "lip_corner_001")
LIPS_JAW_6 = (*LIPS_4, "jaw_line_005", "tooth_003")


def test_parameters_that_few_points_leave_open_are_none(spoken: SpokenCorpus):
    """Four points on the lips would give parameters that are off by 5 standard deviations."""
    built = build(spoken.corpus)
    assert np.median(built.errors) < built.model.noise * np.sqrt(3) < 2 * np.median(built.errors)

    def seen(*names: str) -> np.ndarray:
        kept = np.isin(spoken.corpus.names, names)[:, None]
        return np.where(kept, spoken.corpus.points, np.nan)

    for few in (LIPS_4, LIPS_4[:3]):
        with pytest.raises(TooFewPointsError, match="points do not determine 7 parameters"):
            built.model.invert(seen(*few))
    for enough in (LIPS_JAW_6, [n for n in spoken.corpus.names if n.startswith("lip_")]):
        away = built.model.invert(seen(*enough)) - built.alpha
        assert np.sqrt((away**2).mean(axis=0)).max() < 1.5
    mixed = seen(*LIPS_JAW_6)
    mixed[3] = seen(*LIPS_4)[3]
    done = apply_model(built.model, spoken.corpus.names, mixed)
    assert np.flatnonzero(~done.found).tolist() == [3]
    with pytest.raises(TooFewPointsError, match="no frame has enough points for 7"):
        apply_model(built.model, spoken.corpus.names, seen(*LIPS_4))
