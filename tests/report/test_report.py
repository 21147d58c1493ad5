"""What a report is made of: numbers, charts, pictures and text. No browser is needed."""

from __future__ import annotations

import base64
import html
import json
import re

import numpy as np
import pytest
import reported

from abs_engine.cli import main
from abs_engine.core.errors import ModelFormatError, OutputError, ParameterError
from abs_engine.core.provenance import FIGURES
from abs_engine.dataset import write_sums
from abs_engine.report import facts, gathering
from abs_engine.report.gathering import ReportOptions, write_report


def plotted(told):
    """An array of a plotly figure."""
    if isinstance(told, list):
        return np.array(told)
    return np.frombuffer(base64.b64decode(told["bdata"]), {"f4": "<f4", "f8": "<f8"}[told["dtype"]])


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    place = tmp_path_factory.mktemp("report")
    reported.write_dataset(place / "data")
    reported.write_shifted(place / "shifted")
    reported.write_exact(place / "exact")
    reported.write_landmarks(place / "marks.csv")
    return place


@pytest.fixture(scope="module")
def page(folder):
    words = [str(folder / name) for name in ("shifted", "exact", "marks.csv")]
    out = folder / "page.html"
    assert main(["report", *words, "--truth", str(folder / "data"), "-o", str(out)]) == 0
    return out.read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def told(page):
    return reported.told_by(page)


@pytest.fixture(scope="module")
def unpacked(page):
    store = reported.part_of(page, "arrays")
    return lambda told: reported.unpacked(told, store)


def test_error_curves_are_the_known_errors(told):
    rows = told["charts"]["errors"]["data"]
    lips = next(plotted(row["y"]) for row in rows if row["name"] == "shifted")
    assert np.isnan(lips).nonzero()[0].tolist() == [reported.LOST]
    assert np.nanmax(np.abs(lips - reported.SHIFT_MM)) < 1e-2  # the truth is kept in 16 bits
    exact = next(plotted(row["y"]) for row in rows if row["name"] == "exact")
    assert np.abs(exact).max() < 1e-2
    boxes = [b for b in told["charts"]["boxes"]["data"] if b["name"] == "shifted"]
    assert len(plotted(boxes[0]["y"])) == reported.FRAMES - 1


def test_lip_curves_stand_beside_the_truth(told):
    figure = told["charts"]["lips"]
    axes = [v for k, v in sorted(figure["layout"].items()) if k.startswith("yaxis")]
    titles = [axis["title"]["text"] for axis in axes if "text" in axis["title"]]
    assert titles == ["aperture, mm", "width, mm", "protrusion, mm"]
    true = [plotted(row["y"]) for row in figure["data"] if row.get("name") == "truth"]
    assert np.allclose(true[0], reported.truth().aperture, atol=0.02)
    assert np.allclose(true[1], reported.truth().width, atol=0.02)
    said = next(row for row in figure["data"] if row["mode"] == "text")
    assert said["text"] == ["m", "a"]
    assert np.allclose(plotted(said["x"]), [0.24, 0.84])


def test_true_closures_are_shaded(told):
    closed = reported.truth().closed
    shades = [s for s in told["charts"]["lips"]["layout"]["shapes"] if s["yref"] == "paper"]
    for frame in range(reported.FRAMES):
        within = any(s["x0"] < frame / 25 < s["x1"] for s in shades)
        assert within == closed[frame]


def test_legends_name_the_truth_where_it_is_drawn(page):
    lips, errors = (
        page.split(f"<h2>{section}</h2>")[1].split("</ul>")[0]
        for section in ("Lip curves", "Errors")
    )
    assert "</svg>truth" in lips
    assert "</svg>truth" not in errors
    assert "</svg>shifted" in errors


def test_the_error_on_the_face_is_the_shift(told, unpacked):
    maps = {head["name"]: head["map"] for head in told["heads"]}
    assert maps["truth"] is None
    assert np.allclose(unpacked(maps["shifted"]), reported.SHIFT_MM, atol=2e-2)


def test_heads_move_as_they_did(told, unpacked):
    true = reported.truth()
    for head in told["heads"]:
        weights, modes = (unpacked(head["motion"][k]).astype(float) for k in ("weights", "modes"))
        found = unpacked(head["motion"]["mean"]) + np.tensordot(weights[20], modes, 1)
        expected = true.vertices(20) + (
            reported.SHIFT_MM if head["name"] == "shifted" else 0
        ) * np.array([1, 0, 0])
        assert np.abs(found - expected).max() < 0.1
        lost = unpacked(head["motion"]["lost"]).nonzero()[0].tolist()
        assert lost == ([reported.LOST] if head["name"] == "shifted" else [])
    assert [h["name"] for h in told["heads"]] == ["truth", "shifted", "exact"]


def test_contours_lie_on_the_true_lips(told, unpacked):
    true = reported.truth()
    named = {c["name"]: c["loops"] for c in told["contours"]}
    assert set(named) == {"truth", "shifted", "exact", "marks"}
    outer = unpacked(named["truth"][0])
    assert np.allclose(outer[5], true.pixels(5, true.landmarks["outer_lip"]), atol=0.02)
    assert np.abs(unpacked(named["exact"][1]) - unpacked(named["truth"][1])).max() < 0.05
    assert np.isnan(unpacked(named["shifted"][0])[reported.LOST]).all()
    assert unpacked(named["marks"][0]).shape == (reported.FRAMES, 12, 2)


def test_seams_of_the_texture_are_closed(told, unpacked):
    weld = unpacked(told["weld"])
    assert len(np.unique(reported.speaker().weld)) == len(np.unique(weld))


def test_notes_of_the_scores_stand_below_the_numbers(folder, page):
    """A file that lacks points in some frames says so; others do not."""
    marks = folder / "marks.csv"
    head, *rows = marks.read_text(encoding="utf-8").splitlines()
    names = head.split(",")
    gone = [k for k, name in enumerate(names) if name.split("_")[-1] == "50"]
    assert gone
    for line in (3, 4):
        cells = rows[line].split(",")
        for k in gone:
            cells[k] = ""
        rows[line] = ",".join(cells)
    (folder / "gaps.csv").write_text("\n".join([head, *rows]) + "\n", encoding="utf-8")
    out = folder / "gaps.html"
    write_report([folder / "exact", folder / "gaps.csv"], out, ReportOptions(folder / "data"))
    shown = out.read_text(encoding="utf-8")
    top = shown[shown.index("<main>") : shown.index("<h2>Video")]
    said = '<p class="warning">2 of 30 tracked frames lack points that are given in others (50)'
    assert top.count(said) == 1
    assert "count as failed.</p>" in top
    assert "tracked frames lack points" not in page


def test_the_page_says_where_it_comes_from(page, folder):
    for text in (
        "9.9.9",
        "a renderer",
        "abs-engine report",
        "numpy",
        "seed",
        "What the numbers mean",
    ):
        assert text in page
    assert html.escape(str(folder / "exact")) in page
    assert page.count("<figure>") >= 3 * 3
    assert "lips, head coordinates, RMS" in page


CLEAN = {"engine_version": "9.9.9", "commit": 40 * "a", "dirty": False}


def write_made(folder, made, name):
    """A run or a dataset made by code of some provenance."""
    if name == "data":
        reported.write_dataset(folder / name)
        file = folder / name / "dataset.json"
    else:
        file = reported.write_exact(folder / name) / "run.json"
    file.write_text(json.dumps(json.loads(file.read_text()) | made))
    write_sums(folder / name)
    return folder / name


@pytest.mark.parametrize(
    ("dirty", "said"),
    [
        ((), ""),
        (("run",), "the code that made the run 'run' had changes that are in no commit"),
        (("data",), "the code that made the ground truth had changes that are in no commit"),
    ],
)
def test_a_page_of_what_changed_code_made_says_so_above_its_title(
    tmp_path, monkeypatch, dirty, said
):
    monkeypatch.setattr(facts, "made_by", lambda: CLEAN)
    run, data = (write_made(tmp_path, CLEAN | {"dirty": n in dirty}, n) for n in ("run", "data"))
    film = data / "clip/camera/video.mp4"
    for truth in (data, None):
        out = tmp_path / f"{truth is None}.html"
        write_report([run], out, ReportOptions(truth, video=film))
        top = out.read_text(encoding="utf-8").split("<h1>")[0]
        expected = said if truth or "run" in dirty else ""
        assert ("Not for publication" in top) == bool(expected)
        assert html.escape(expected) in top


def test_the_page_says_which_commit_made_what_it_shows(page):
    assert page.count(">engine<") == 2  # of the film and of the page


def test_what_other_systems_made_has_no_commit_of_ours(folder):
    assert [*facts.origins({"marks": folder / "marks.csv"})] == [FIGURES]
    assert facts.origins({"none": folder})["the run 'none'"] == {}


def test_the_page_asks_for_nothing_from_outside(page):
    body = page[page.rindex("</head>") :]
    assert not re.findall(r'(?:src|href)="(?!data:)[^"]*"', body)
    assert "default-src 'none'" in page
    assert len(page) < 4e6  # two of it plotly


def test_without_truth_there_are_curves_and_heads_but_no_scores(folder):
    out = folder / "plain.html"
    film = reported.write_film(folder / "film.mp4")
    write_report([folder / "exact"], out, ReportOptions(video=film))
    page = out.read_text(encoding="utf-8")
    assert "Lip curves" in page
    for absent in ("<h2>Scores", "<h2>Worst frames", "<h2>Error", "over the truth"):
        assert absent not in page[page.index("<main>") : page.index('id="data"')]
    assert "at 25 a second, " in page
    uneven = reported.write_uneven(folder / "uneven")
    write_report([uneven], folder / "uneven.html", ReportOptions(video=film))
    assert "at 25 a second on average, " in (folder / "uneven.html").read_text(encoding="utf-8")


def test_a_long_clip_is_played_in_part(folder, monkeypatch):
    monkeypatch.setattr(gathering, "MOST_PLAYED", 10)
    out = folder / "cut.html"
    write_report([folder / "exact"], out, ReportOptions(folder / "data"))
    page = out.read_text(encoding="utf-8")
    assert f"The first 10 of {reported.FRAMES} frames" in page
    told = reported.told_by(page)
    assert told["heads"][0]["motion"]["weights"]["shape"][0] == 10
    assert told["contours"][0]["loops"][0]["shape"][0] == 10


def test_runs_of_different_videos_are_refused(tmp_path):
    runs = [tmp_path / name for name in ("old", "one", "other")]
    for run in runs:
        run.mkdir()
        told = {} if run.name == "old" else {"video_sha256": run.name}
        (run / "run.json").write_text(json.dumps({"settings": told}))
    with pytest.raises(ParameterError, match=r"other is of another video than .*one; report runs"):
        write_report(runs, tmp_path / "new.html", ReportOptions())


def test_what_has_names_in_place_of_paths_is_refused_as_such(tmp_path):
    """Arrays of a run, or a run, which is gone through by their names."""
    with pytest.raises(ParameterError, match=r"results is \{'time': 0.0\}; give a list of paths"):
        write_report({"time": 0.0}, tmp_path / "new.html")


@pytest.mark.parametrize(
    ("words", "part"),
    [
        (["nothing"], "nothing"),
        (["exact", "--truth", "exact"], "not ground truth"),
        (["exact"], "--video"),
        (["exact", "--seed", "5"], "a seed is for scores, which need a dataset; give --truth"),
        (["marks.csv"], "marks.csv"),
        (
            ["exact", "--truth", "data", "--video", "long.mp4"],
            "differ in number of frames: 31 and 30",
        ),
    ],
)
def test_bad_input_takes_one_line(folder, capsys, monkeypatch, words, part):
    monkeypatch.chdir(folder)
    if not (folder / "long.mp4").exists():
        reported.write_film(folder / "long.mp4", reported.FRAMES + 1)
    film, hidden = folder / "film.mp4", folder / "hidden.mp4"
    if film.exists():
        film.rename(hidden)
    assert main(["report", *words, "-o", "new.html"]) == 2
    shown = capsys.readouterr().err
    assert shown.startswith("abs-engine: error: ")
    assert len(shown.splitlines()) == 1
    assert part in shown
    assert not (folder / "new.html").exists()


def test_nothing_is_written_over(folder, page):
    with pytest.raises(OutputError):
        write_report([folder / "exact"], folder / "page.html", ReportOptions(folder / "data"))


def test_runs_of_other_lengths_do_not_stand_side_by_side(folder):
    short = reported.write_exact(folder / "short")
    with np.load(short / "results.npz") as archive:
        arrays = dict(archive)
    each = {k: v[:-1] if v.shape[:1] == (reported.FRAMES,) else v for k, v in arrays.items()}
    np.savez(short / "results.npz", **each)
    mesh = dict(np.load(short / "mesh.npz"))
    np.savez(short / "mesh.npz", **(mesh | {"weights": mesh["weights"][:-1]}))
    with pytest.raises(ParameterError, match="30, 29 frames"):
        write_report([folder / "exact", short], folder / "no.html", ReportOptions())


def test_runs_of_different_heads_do_not_stand_on_one_page(folder):
    """No --speaker goes with both, so that to give one is no remedy."""
    other = reported.write_exact(folder / "other")
    mesh = dict(np.load(other / "mesh.npz"))
    np.savez(other / "mesh.npz", **(mesh | {"faces": mesh["faces"][:, ::-1]}))
    with pytest.raises(ParameterError, match="were tracked with different heads; write a report"):
        write_report([folder / "exact", other], folder / "no.html", ReportOptions())
    with pytest.raises(ModelFormatError, match="tracked with another head; give that head"):
        write_report([other], folder / "no.html", ReportOptions())
