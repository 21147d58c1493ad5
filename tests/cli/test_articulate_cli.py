"""A user's own articulatory model from the command line: files in, a model out, or one line."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import numpy as np
import pytest
from drawn import speaker
from made_visemes import GROUPS, NAMES, visemes
from marker_files import write_c3d, write_long, write_wide
from short import first_figure

import abs_engine
from abs_engine.capture.corpus import Corpus
from abs_engine.cli import main
from abs_engine.core.errors import InputFileError, ParameterError
from abs_engine.core.provenance import described
from abs_engine.face.shape.predictors import PAPER_PREDICTORS, Predictor
from abs_engine.learn.articulatory import build, leave_out_in_turn
from abs_engine.report.articulation import report
from abs_engine.report.articulation.applied import Applied
from abs_engine.report.articulation.predictor_file import predictors_text, read_predictors
from abs_engine.studio.corpus import speak_corpus

TEETH = ("right", "left", "front")
MARKS = np.array([[-25.0, 0, -35], [25, 0, -35], [0, 0, 0]])
OWN = (Predictor("jaw", ("jaw",), "y", "-y"), Predictor("lips", ("p4", "lips"), "z", "+z"))
WRITERS = {"c3d": write_c3d, "csv": write_wide, "long.csv": write_long}


def table(count: int) -> str:
    lines = ["what,name,value"]
    lines += [f"point,{n},{group}" for group, names in GROUPS.items() for n in names]
    lines += [f"viseme,v${k}$,{k}" for k in range(count)]
    return "\n".join([*lines, *(f"teeth,{n},{n}" for n in TEETH)]) + "\n"


def recorded(count: int = 12) -> tuple[np.ndarray, np.ndarray]:
    """Points (V, 12, 3) in the frame of the teeth; with these on a head elsewhere (V, 15, 3)."""
    own = visemes(count, noise=0.05)[1]
    turn = np.array([[0.0, -1, 0], [1, 0, 0], [0, 0, 1]])
    both = np.concatenate([own, np.tile(MARKS, (count, 1, 1))], axis=1)
    return own, both @ turn.T + [100.0, -40, 900]


def written(folder: Path, points: np.ndarray, kind: str = "csv") -> list[str]:
    """What is typed to build a model of the points."""
    path = folder / f"own.{kind}"
    if kind == "npz":
        np.savez(path, names=np.array([*NAMES, *TEETH]), points=points)
    else:
        WRITERS[kind](path, (*NAMES, *TEETH), points)
    (folder / "roles.csv").write_text(table(len(points)))
    (folder / "own.toml").write_text(predictors_text(OWN))
    return [
        "articulate", str(path), "--roles", str(folder / "roles.csv"),
        "--predictors", str(folder / "own.toml"), "-o", str(folder / "model"),
    ]  # fmt: skip


@pytest.fixture
def one_figure(monkeypatch):
    """For models of which nothing unusual is drawn: they take most of their time to be drawn."""
    monkeypatch.setattr(report, "figure_bytes", first_figure)


@pytest.mark.parametrize("kind", ["c3d", "csv", "long.csv", "npz"])
def test_a_model_of_recorded_points(tmp_path: Path, capsys: pytest.CaptureFixture[str], kind: str):
    own, points = recorded()
    assert main(written(tmp_path, points, kind)) == 0
    out = capsys.readouterr().out
    assert "12 visemes of 12 points" in out
    assert "kept out, 3 points in no group: right, left, front" in out
    model = abs_engine.load_articulatory(tmp_path / "model" / "model.npz")
    assert (model.names, model.parameters) == (NAMES, ("jaw", "lips"))
    np.testing.assert_allclose(model.mean, own.mean(axis=0), atol=1e-3)
    alpha = model.transform(own)
    assert alpha.shape == (12, 2)
    np.testing.assert_allclose(alpha, model.transform(own.reshape(12, 36)))
    np.testing.assert_allclose(model.inverse_transform(alpha), own, atol=0.5)
    told = json.loads((tmp_path / "model" / "results.json").read_text())
    assert told["variance"]["total"] == pytest.approx(model.held) == pytest.approx(1, abs=0.01)
    assert told["left_out_error_mm_median"] > told["model_error_mm_median"] > 0
    page = (tmp_path / "model" / "index.html").read_text()
    assert f"made by {described(told)}" in page
    for name in ("boxplots.svg", "nomograms.svg"):
        assert (tmp_path / "model" / name).read_bytes().lstrip().startswith(b"<?xml")
        assert name in page


@pytest.mark.usefixtures("one_figure")
def test_a_saved_corpus_needs_no_table_and_gives_the_same(tmp_path: Path):
    words = written(tmp_path, recorded()[1])
    assert main(words) == 0
    corpus = tmp_path / "model" / "corpus.npz"
    again = ["articulate", "-o", str(tmp_path / "again"), *words[4:6], str(corpus)]
    assert main(again) == 0
    first, second = (
        abs_engine.load_articulatory(tmp_path / name / "model.npz") for name in ("model", "again")
    )
    np.testing.assert_array_equal(first.modes, second.modes)


@pytest.mark.usefixtures("one_figure")
def test_units_are_turned_into_millimetres(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    own, points = recorded()
    words = written(tmp_path, points / 1000, "npz")
    assert main(words) == 2
    said = capsys.readouterr().err
    assert "are they in mm? say so with --unit" in said
    assert said.count("\n") == 1
    assert main([*words[:-1], str(tmp_path / "metres"), "--unit", "m"]) == 0
    model = abs_engine.load_articulatory(tmp_path / "metres" / "model.npz")
    np.testing.assert_allclose(model.mean, own.mean(axis=0))


@pytest.mark.usefixtures("one_figure")
def test_missing_points_are_kept_out_or_imputed_by_name(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
):
    points = recorded()[1]
    points[3, 5] = points[4, 5] = points[7, 9] = np.nan
    words = written(tmp_path, points)
    assert main(words) == 2
    line = capsys.readouterr().err
    assert "2 of 12 points are missing in some visemes: p5, p9; keep them out with --mi" in line
    assert main([*words, "--missing", "drop"]) == 0
    assert "kept out, 2 points missing in some visemes: p5, p9" in capsys.readouterr().out
    assert main([*words[:-1], str(tmp_path / "b"), "--missing", "impute"]) == 0
    assert "imputed, 2 points missing in some visemes (how many): p5 (2), p9 (1)" in (
        capsys.readouterr().out
    )
    assert main([*words[:-1], str(tmp_path / "c"), "--without", "p5", "--without", "v$7$"]) == 0
    out = capsys.readouterr().out
    assert "11 visemes of 11 points" in out
    assert "kept out as asked for: p5, v$7$" in out
    twice = [*words[:-1], str(tmp_path / "d"), "--without", "v$7$", "--missing", "impute"]
    assert main([*twice, "--without", "v$7$"]) == 0
    assert "kept out as asked for: v$7$\n" in capsys.readouterr().out


def test_just_enough_visemes_are_not_left_out_in_turn(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
):
    assert main(written(tmp_path, recorded(3)[1])) == 0
    out = capsys.readouterr().out
    assert "not left out in turn: v$0$, v$1$, v$2$: 2 visemes for 2 parameters" in out
    assert "each viseme in the model of the others" not in out
    told = json.loads((tmp_path / "model" / "results.json").read_text())
    assert "left_out_error_mm_median" not in told
    assert told["not_left_out"]["v$1$"] == "2 visemes for 2 parameters"


def test_only_the_viseme_that_cannot_be_left_out_is_skipped(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
):
    """All but one visemes lack a point: without that one nothing says where it is."""
    points = recorded()[1]
    words = [*written(tmp_path, points), "--missing", "impute"]
    assert main(words) == 0
    whole = json.loads((tmp_path / "model" / "results.json").read_text())
    points[[k for k in range(12) if k != 7], 9] = np.nan
    folder = tmp_path / "gaps"
    folder.mkdir()
    capsys.readouterr()
    assert main([*written(folder, points), "--missing", "impute"]) == 0
    out = capsys.readouterr().out
    assert "not left out in turn: v$7$: 1 points are missing in all visemes: p9" in out
    assert "warning: of 1 point imputed hardly anything is known" in out
    assert "(in how many): p9 (1)" in out
    told = json.loads((folder / "model" / "results.json").read_text())
    assert list(told["not_left_out"]) == ["v$7$"]
    key = "left_out_error_mm_median"
    assert told[key] == pytest.approx(whole[key], rel=0.3)
    assert "p9 (1)" in (folder / "model" / "index.html").read_text()


def test_a_viseme_with_too_few_points_of_its_own_is_told_of(monkeypatch):
    """Of many visemes several are left out at once: the others among them are measured."""
    monkeypatch.setattr("abs_engine.learn.articulatory.MOST_BUILT", 5)
    own, _ = recorded(40)
    own[3] = np.nan
    corpus = Corpus(own, NAMES, tuple(f"v{k}" for k in range(40)), GROUPS)
    done = leave_out_in_turn(corpus, OWN, "impute")
    assert list(done.skipped) == ["v3"]
    assert "do not determine" in done.skipped["v3"].problem
    assert np.isfinite(np.delete(done.errors, 3)).all()
    assert np.isnan(done.errors[3])


def infinite(points: np.ndarray) -> np.ndarray:
    points[2, 1, 0] = np.inf
    return points


def nowhere(points: np.ndarray) -> np.ndarray:
    points[2, :12] = np.nan
    return points


def noise(points: np.ndarray) -> np.ndarray:
    """One posture, measured again and again."""
    own = np.random.default_rng(0).normal(0, 0.01, points[:, :12].shape)
    return np.concatenate([points[:1, :12] + own, points[:, 12:]], axis=1)


@pytest.mark.parametrize(
    ("points", "more", "said"),
    [
        (lambda p: p[:2], (), "2 visemes for 2 parameters"),
        (nowhere, ("--missing", "impute"), "viseme 'v$2$': 0 points do not determine"),
        (lambda p: p[:, :, :] * 0 + p[:1], (), "nothing left to explain"),
        (noise, (), "no point moves by more than 0.02 mm over the visemes, where jaw and lips"),
        (lambda p: p, ("--without", "p50"), "neither a viseme nor a point 'p50'"),
        (lambda p: p, ("--person", "clara"), "CORPUS and --person were given"),
        (lambda p: p, ("--predictors", "none.toml"), "none.toml does not exist"),
        (lambda p: p, ("--roles", "none.csv"), "none.csv does not exist"),
        (lambda p: p, ("--roles", "/dev/null"), "/dev/null is not a file"),
        (lambda p: p, ("--predictors", "/dev"), "/dev is not a file"),
    ],
)
@pytest.mark.parametrize("kind", ["csv", "npz"])
def test_bad_input_is_one_line(tmp_path, capsys, points, more, said, kind):
    check_refused(tmp_path, capsys, [*written(tmp_path, points(recorded()[1]), kind), *more], said)


@pytest.mark.parametrize(  # infinity cannot be written to a C3D file
    ("kind", "said"),
    [
        ("csv", "line 4: 'inf' in column p1_x is not a number"),
        ("npz", "'p1' is out of all bounds in frame 2"),
    ],
)
def test_infinity_is_refused(tmp_path, capsys, kind, said):
    check_refused(tmp_path, capsys, written(tmp_path, infinite(recorded()[1]), kind), said)


def check_refused(tmp_path, capsys, words, said):
    before = sorted(tmp_path.rglob("*"))
    assert main(words) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert said in line
    assert sorted(tmp_path.rglob("*")) == before


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("what,", "kind,", "the first line is not what,name,value"),
        ("v$3$,3", "v$3$,x", "'x' are not frames"),
        ("v$3$,3", "v$3$,12", "names frame 12"),
        ("v$3$", "v$2$", "viseme 'v$2$' is given twice"),
        ("point,p1,", "point,q1,", "names 'q1', which is not a point"),
        ("jaw\n", "chin\n", "predictor 'jaw' asks for 'jaw'"),
        ("teeth,left,left\n", "", "upper_teeth are three points"),
    ],
)
def test_tables_that_are_wrong_are_one_line(tmp_path, capsys, old, new, said):
    words = written(tmp_path, recorded()[1])
    roles = tmp_path / "roles.csv"
    roles.write_text(roles.read_text().replace(old, new))
    assert main(words) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert said in line
    assert not (tmp_path / "model").exists()


def test_predictors_come_back(tmp_path: Path):
    path = tmp_path / "p.toml"
    odd = (*PAPER_PREDICTORS, Predictor('a "b" \\ é', ("x",), "zx", "-z"))
    path.write_text(predictors_text(odd), encoding="utf-8")
    assert read_predictors(path) == odd


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("points", "point", "has no key 'point' (nearest: 'points')"),
        ("[[predictor]]", "[[predictors]]", "no key 'predictors' (nearest: 'predictor')"),
        ('"jaw1"', '"jaw2"', "two predictors are named 'jaw2'"),
        ('["lips"]', "[]", "predictor 'lips1' has no points"),
        ('["lips"]', '"lips"', "give a list"),
        ('"xyz"', '"xyw"', "coordinates 'xyw'"),
        ("version = 1", "version = 2", "version 2"),
        ("version = 1", "version = true", "version True"),
        ("version = 1", "version = " + "[" * 5000, "too deep"),
        ('"jaw1"', '"a,b"', "no predictor can be named 'a,b'"),
        ('"jaw1"', '"frame"', "no predictor can be named 'frame'"),
        ('"jaw1"', '"rms_mm"', "no predictor can be named 'rms_mm'"),
        ('"jaw1"', '""', "a predictor has an empty name"),
        ('"jaw1"', '"a\\nb"', "cannot be printed"),
        ("version", "[", "is not TOML"),
    ],
)
def test_predictors_that_are_wrong_are_named(tmp_path: Path, old: str, new: str, said: str):
    path = tmp_path / "p.toml"
    path.write_text(predictors_text(PAPER_PREDICTORS).replace(old, new))
    with pytest.raises((InputFileError, ParameterError)) as error:
        read_predictors(path)
    assert said in str(error.value)


@pytest.mark.usefixtures("one_figure")
def test_a_model_refuses_what_does_not_fit(tmp_path: Path):
    own, points = recorded()
    assert main(written(tmp_path, points)) == 0
    model = abs_engine.load_articulatory(tmp_path / "model" / "model.npz")
    with pytest.raises(ParameterError, match="give 2: jaw, lips"):
        model.inverse_transform(np.zeros((4, 3)))
    with pytest.raises(ParameterError, match="infinite"):
        model.transform(np.where(own > own.max() - 1e-9, np.inf, own))


def test_of_many_visemes_several_are_left_out_at_once(tmp_path: Path, monkeypatch):
    monkeypatch.setattr("abs_engine.learn.articulatory.MOST_BUILT", 5)
    assert main(written(tmp_path, recorded()[1])) == 0
    told = json.loads((tmp_path / "model" / "results.json").read_text())
    assert 0.05 < told["left_out_error_mm_median"] < 0.2


@pytest.mark.usefixtures("one_figure")
def test_points_elsewhere_than_the_model_s_are_warned_of(tmp_path: Path, capsys):
    words = written(tmp_path, recorded()[1])
    assert main(words) == 0
    more = ["--model", str(tmp_path / "model" / "model.npz"), "-o", str(tmp_path / "talk.csv")]
    assert main([*words[:2], *more]) == 0
    assert "warning: the points lie far from the model's: name" in capsys.readouterr().out


@pytest.mark.usefixtures("one_figure")
def test_a_marker_that_flew_off_is_named_with_its_frame(tmp_path: Path, capsys):
    points = recorded()[1]
    assert main(written(tmp_path, points)) == 0
    capsys.readouterr()  # its progress, on a slow machine
    points[10, 3] = 1e5
    wild = tmp_path / "wild"
    wild.mkdir()
    words = written(wild, points)
    check_refused(wild, capsys, words, ": in frame 10, the point 'p3' lies 1")
    check_refused(wild, capsys, words, f"{words[1]}: in frame 10")
    more = ["--model", str(tmp_path / "model" / "model.npz"), "-o", str(tmp_path / "talk.csv")]
    assert main([*words[:4], *more]) == 0
    assert "warning: in 1 frame points lie far" in (out := capsys.readouterr().out)
    assert "10 (p3)" in out


@pytest.fixture(scope="module")
def talker(tmp_path_factory):
    """The corpus of a bundled person, its folder, and that of its model."""
    folder = tmp_path_factory.mktemp("talker")
    corpus = speak_corpus(speaker(), speaker().named("clara")).corpus
    build(corpus).model.save(folder / "model.npz")
    return corpus, folder


def applied(talker, tmp_path, capsys, points) -> tuple[int, str]:
    """The exit status for points (T, 275, 3) in the corpus's frame, and what is said."""
    corpus, folder = talker
    np.savez(tmp_path / "talk.npz", names=np.array(corpus.names), points=points)
    words = ["articulate", tmp_path / "talk.npz", "--model", folder / "model.npz"]
    status = main([*map(str, words), "-o", str(tmp_path / "talk.csv")])
    return status, "".join(capsys.readouterr())


def test_two_of_many_points_that_are_exchanged_in_a_frame_are_warned_of(talker, tmp_path, capsys):
    points, lips = talker[0].points.copy(), talker[0].names.index(talker[0].groups["lips"][0])
    assert "warning" not in applied(talker, tmp_path, capsys, points)[1]
    (tmp_path / "talk.csv").unlink()
    other = int(np.abs(np.linalg.norm(points[7] - points[7, lips], axis=1) - 44).argmin())
    points[7, [lips, other]] = points[7, [other, lips]]
    status, said = applied(talker, tmp_path, capsys, points)
    assert status == 0
    assert "warning: in 1 frame points lie far from the model's; check the markers" in said
    assert any(f"named): 7 ({talker[0].names[k]})" in said for k in (lips, other))


@pytest.mark.parametrize("scale", [1e-3, 0.1, 1e3])
def test_points_of_another_unit_than_the_model_s_are_refused(talker, tmp_path, capsys, scale):
    points = talker[0].points * scale
    points[3] = points[4, 1:] = np.nan
    status, said = applied(talker, tmp_path, capsys, points)
    assert status == 2
    assert "mm from end to end, the model's" in said
    assert len(said.splitlines()) == 1
    assert not (tmp_path / "talk.csv").exists()


def test_points_that_bear_each_other_s_names_are_named_with_their_frames(tmp_path: Path, capsys):
    points = recorded()[1]
    far = np.linalg.norm(points[:, :1, :] - points[:, :12], axis=2)[10]
    other = int(far.argmax())
    points[10, [0, other]] = points[10, [other, 0]]
    said = f"{NAMES[0]}' and '{NAMES[other]}' have each other's places in frame 10; exchange their"
    check_refused(tmp_path, capsys, written(tmp_path, points), said)


def test_points_in_a_smaller_unit_than_is_said_are_not_a_wild_marker(tmp_path: Path, capsys):
    words = [*written(tmp_path, recorded()[1], "npz"), "--unit", "m"]
    check_refused(tmp_path, capsys, words, "mm or more from their middle; is --unit right?")


@pytest.mark.usefixtures("one_figure")
def test_a_table_may_have_capitals_but_no_semicolons(tmp_path: Path, capsys):
    words = written(tmp_path, recorded()[1])
    roles = tmp_path / "roles.csv"
    text = roles.read_text()
    roles.write_text(text.replace(",", ";"), encoding="utf-8-sig")
    check_refused(tmp_path, capsys, words, "roles.csv has semicolons between its columns; separate")
    capital = text.replace("what,name,value", "What,Name,Value").replace("viseme,", "Viseme,")
    roles.write_text(capital, encoding="utf-8-sig")
    assert main(words) == 0


@pytest.mark.usefixtures("one_figure")
def test_a_model_gives_the_parameters_of_a_recording(tmp_path: Path, capsys):
    own, points = recorded()
    assert main(written(tmp_path, points)) == 0
    model = tmp_path / "model" / "model.npz"
    expected = abs_engine.load_articulatory(model).transform(own)
    points[3, 5] = points[4, 14] = points[5, :12] = np.nan  # a point, a tooth, all
    talk = write_c3d(tmp_path / "talk.c3d", (*NAMES[::-1], *TEETH), points[:, [*range(11, -1, -1),
                     12, 13, 14]])  # fmt: skip
    (tmp_path / "teeth.csv").write_text("what,name,value\n" + table(0).split("rest\n")[-1])
    words = ["articulate", str(talk), "--roles", str(tmp_path / "teeth.csv"), "--model", str(model)]
    capsys.readouterr()
    assert main([*words, "-o", str(tmp_path / "talk.csv")]) == 0
    assert "12 frames, 2 without parameters" in capsys.readouterr().out
    head, *lines = (tmp_path / "talk.csv").read_text().splitlines()
    assert head == "frame,jaw,lips,rms_mm,points"
    assert lines[4:6] == ["4,,,,0", "5,,,,0"]
    assert lines[3].endswith(",11")
    rows = [line.split(",") for k, line in enumerate(lines) if k not in (3, 4, 5)]
    found = np.array([row[1:3] for row in rows], float)
    np.testing.assert_allclose(found, np.delete(expected, (3, 4, 5), axis=0), atol=1e-3)
    assert main([*words, "-o", str(tmp_path / "x.csv"), "--without", "p1"]) == 2
    assert "leave them out with --model" in capsys.readouterr().err
    corpus = tmp_path / "model" / "corpus.npz"
    again = ["articulate", str(corpus), "--model", str(model), "-o", str(tmp_path / "y.csv")]
    assert main(again) == 0
    first = float((tmp_path / "y.csv").read_text().splitlines()[1].split(",")[1])
    assert first == pytest.approx(expected[0, 0], abs=1e-3)


@pytest.mark.parametrize(
    ("names", "points", "said"),
    [
        ([f"q{k}" for k in range(12)], np.zeros((4, 12, 3)), "none of the points"),
        (NAMES, np.full((4, 12, 3), np.nan), "no frame has enough points for 2 parameters"),
    ],
)
@pytest.mark.usefixtures("one_figure")
def test_a_recording_that_does_not_fit_is_one_line(tmp_path, capsys, names, points, said):
    assert main(written(tmp_path, recorded()[1])) == 0
    capsys.readouterr()
    np.savez(tmp_path / "talk.npz", names=np.array(names), points=points)
    model, out = tmp_path / "model" / "model.npz", tmp_path / "talk.csv"
    words = ["articulate", tmp_path / "talk.npz", "--model", model, "-o", out]
    assert main([str(word) for word in words]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert said in line
    assert not out.exists()


def test_names_are_quoted_in_the_table_of_parameters():
    alpha, one = np.array([[1.0, np.nan]]).T, np.array([0.5, np.nan])
    done = Applied(('a "b"',), alpha, one, np.array([4, 0]), (), ("p", ""), one, first=7)
    rows = list(csv.reader(done.as_csv().splitlines()))
    assert rows == [
        ["frame", 'a "b"', "rms_mm", "points"], ["7", "1.0000", "0.5000", "4"], ["8", "", "", "0"]
    ]  # fmt: skip


@pytest.mark.usefixtures("one_figure")
def test_two_points_of_one_name_have_no_parameters(tmp_path: Path, capsys):
    own, points = recorded()
    assert main(written(tmp_path, points)) == 0
    capsys.readouterr()
    np.savez(tmp_path / "talk.npz", names=np.array([*NAMES[:11], "p0"]), points=own)
    model, out = tmp_path / "model" / "model.npz", tmp_path / "talk.csv"
    words = ["articulate", tmp_path / "talk.npz", "--model", model, "-o", out]
    assert main([str(word) for word in words]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert "two points are named 'p0'" in line
    assert not out.exists()


@pytest.mark.parametrize(
    ("more", "said"),
    [
        (["--pictures", "own.csv"], "name its file with --face"),
        (["--face", "roles.csv"], "roles.csv does not end in .face"),
        (["--face", "old.face"], "old.face exists already"),
        (["--face", "me.face"], "name the frames of a closed mouth at rest"),
        (["--face", "me.face", "--pictures", "seen.csv"], "line 2: there is no viseme 'a'"),
    ],
)
def test_a_face_that_cannot_be_made_is_one_line(tmp_path, capsys, monkeypatch, more, said):
    words = written(tmp_path, recorded()[1])
    monkeypatch.chdir(tmp_path)
    (tmp_path / "seen.csv").write_text("picture,viseme\nown.csv,a\n")
    (tmp_path / "old.face").touch()
    assert main([*words, *more]) == 2
    line = capsys.readouterr().err.splitlines()[-1]
    assert line.startswith("abs-engine: error:")
    assert said in line
    assert not (tmp_path / "model").exists()
    assert not (tmp_path / "me.face").exists()


@pytest.mark.parametrize(("share", "settles"), [(0.1, True), (0.4, False)])
def test_imputed_points_that_do_not_settle_are_warned_of(
    share: float, settles: bool, tmp_path: Path, capsys: pytest.CaptureFixture[str]
):
    points = recorded()[1]
    points[:, :12][np.random.default_rng(1).random((12, 12)) < share] = np.nan
    assert main([*written(tmp_path, points), "--missing", "impute"]) == 0
    out = capsys.readouterr().out
    assert "imputed, " in out
    warned = [line for line in out.splitlines() if "imputed points do not settle" in line]
    assert len(warned) == (not settles)
    assert all(" mm; leave out visemes or points that lack much" in line for line in warned)
