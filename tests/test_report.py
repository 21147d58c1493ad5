"""What a report is made of: numbers, charts, pictures and text. No browser is needed."""

from __future__ import annotations

import base64
import html
import json
import re

import cv2
import numpy as np
import pytest
import reported

from abs_engine.cli import main
from abs_engine.errors import OutputError, ParameterError, VideoError
from abs_engine.evaluate.report.colours import bar_colours, clay_colours, scale_end
from abs_engine.evaluate.report.embed import packed, packed_motion, script_json
from abs_engine.evaluate.report.film import mouth_picture, shorten, worst_frames
from abs_engine.evaluate.report.motion import LARGEST_ERROR_MM, LinearMotion, compress
from abs_engine.systems import reporting
from abs_engine.systems.reporting import ReportOptions, write_report

KINDS = {"f4": "<f4", "i2": "<i2", "u1": "u1", "u4": "<u4", "f8": "<f8"}


def unpacked(told):
    raw = base64.b64decode(told["data"])
    return np.frombuffer(raw, KINDS[told["kind"]]).reshape(told["shape"])


def plotted(told):
    """An array of a plotly figure."""
    if isinstance(told, list):
        return np.array(told)
    return np.frombuffer(base64.b64decode(told["bdata"]), KINDS[told["dtype"]])


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
    return json.loads(
        re.search(r'<script type="application/json" id="data">(.*?)</script>', page)[1]
    )


def test_a_motion_comes_back_within_the_largest_error():
    rng = np.random.default_rng(1)
    paths = rng.normal(size=(20, 3)) @ rng.normal(size=(3, 120)) * 5
    frames = (50 + paths + rng.normal(size=paths.shape) * 0.01).reshape(20, 40, 3)
    motion = compress(lambda k: frames[k], 20)
    assert len(motion.modes) == 3  # what was put in; the noise is below the limit
    found = np.array([motion.vertices(k) for k in range(20)])
    assert np.abs(found - frames).max() < LARGEST_ERROR_MM


def test_lost_frames_of_a_motion_stay_lost():
    frames = np.random.default_rng(2).normal(size=(5, 4, 3))
    frames[3] = np.nan
    motion = compress(lambda k: frames[k], 5)
    assert np.isnan(motion.weights).all(axis=1).tolist() == [False, False, False, True, False]
    assert np.allclose(motion.vertices(4), frames[4], atol=LARGEST_ERROR_MM)


@pytest.mark.parametrize("value", [0.0, np.nan])
def test_a_motion_that_stands_still_or_is_never_seen(value):
    motion = compress(lambda _: np.full((4, 3), value), 3)
    assert motion.modes.shape == (1, 4, 3)
    assert np.isnan(motion.weights).all() == np.isnan(value)


def test_sixteen_bits_are_fine_enough_for_a_mesh():
    rng = np.random.default_rng(3)
    motion = LinearMotion(
        rng.normal(size=(9, 3)).astype("f4") * 100,
        rng.normal(size=(4, 9, 3)).astype("f4") * 10,
        rng.uniform(0, 1, (6, 4)).astype("f4"),
    )
    told = packed_motion(motion)
    modes, weights = (unpacked(told[k]).astype(float) for k in ("modes", "weights"))
    found = unpacked(told["mean"]) + np.tensordot(weights, modes, 1)
    assert np.abs(found - [motion.vertices(k) for k in range(6)]).max() < 0.01
    assert not unpacked(told["lost"]).any()


def test_arrays_are_little_endian_and_text_ends_no_script():
    assert unpacked(packed(np.array([[1.5, -2]], ">f4"))).tolist() == [[1.5, -2]]
    text = script_json({"a": "</script><!--\u2028"})
    assert "<" not in text
    assert json.loads(text) == {"a": "</script><!--\u2028"}


def test_worst_frames_keep_apart():
    errors = np.array([1, 9, 8.5, 2, np.nan, 3, 7, 0])
    assert worst_frames(errors, 3, 2) == [1, 6, 3]
    assert worst_frames(errors, 9, 1) == [1, 2, 6, 5, 3, 0, 7]
    assert worst_frames(np.full(3, np.nan), 2, 1) == []


def test_a_contour_is_drawn_where_it_lies():
    picture = np.zeros((200, 200, 3), np.uint8)
    square = np.array([[80.0, 90], [120, 90], [120, 110], [80, 110]])
    coded = np.frombuffer(mouth_picture(picture, [(square, "#ff0000")], square), np.uint8)
    drawn = cv2.imdecode(coded, cv2.IMREAD_COLOR)[..., ::-1]
    height, width = drawn.shape[:2]
    y, x = np.nonzero(drawn[..., 0] > 128)
    # the square lies in the middle and takes 1 / 1.7 of the width
    assert (x.min() + x.max()) / 2 == pytest.approx((width - 1) / 2, abs=1.5)
    assert (y.min() + y.max()) / 2 == pytest.approx((height - 1) / 2, abs=1.5)
    assert x.max() - x.min() == pytest.approx(width / 1.7, abs=4)
    assert drawn[..., 2].max() < 100


def test_a_film_is_cut_and_made_smaller():
    pictures = [np.full((600, 1280, 3), 10 * k, np.uint8) for k in range(6)]
    film, kept = shorten(iter(pictures), 25.0, 3, {4})
    assert film.size == (1280, 600)
    assert kept.keys() == {4}
    assert kept[4].max() == 40
    with pytest.raises(VideoError, match="the video has 6 frames"):
        shorten(iter(pictures), 25.0, 7, ())


def test_the_scale_of_errors_ends_at_a_round_number():
    assert scale_end([np.linspace(0, 3.1, 100)]) == 4.0
    assert scale_end([np.array([0.017, np.nan])]) == pytest.approx(0.02)
    assert scale_end([]) == 1.0
    assert bar_colours().shape == (256, 3)


def test_lips_and_skin_have_their_colours():
    faces, classes = np.array([[0, 1, 2], [2, 3, 4]]), np.array([0, 1])
    found = clay_colours(faces, classes, ("skin", "upper_lip"), 5)
    assert (found[2] == found[3]).all()
    assert (found[0] != found[3]).any()


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


def test_the_error_on_the_face_is_the_shift(told):
    maps = {head["name"]: head["map"] for head in told["heads"]}
    assert maps["truth"] is None
    assert np.allclose(unpacked(maps["shifted"]), reported.SHIFT_MM, atol=2e-2)


def test_heads_move_as_they_did(told):
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


def test_contours_lie_on_the_true_lips(told):
    true = reported.truth()
    named = {c["name"]: c["loops"] for c in told["contours"]}
    assert set(named) == {"truth", "shifted", "exact", "marks"}
    outer = unpacked(named["truth"][0])
    assert np.allclose(outer[5], true.pixels(5, true.landmarks["outer_lip"]), atol=0.02)
    assert np.abs(unpacked(named["exact"][1]) - unpacked(named["truth"][1])).max() < 0.05
    assert np.isnan(unpacked(named["shifted"][0])[reported.LOST]).all()
    assert unpacked(named["marks"][0]).shape == (reported.FRAMES, 12, 2)


def test_seams_of_the_texture_are_closed(told):
    weld = unpacked(told["weld"])
    assert len(np.unique(reported.speaker().weld)) == len(np.unique(weld))


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


def test_the_page_asks_for_nothing_from_outside(page):
    body = page[page.rindex("</head>") :]
    assert not re.findall(r'(?:src|href)="(?!data:)[^"]*"', body)
    assert "default-src 'none'" in page
    assert len(page) < 15e6


def test_without_truth_there_are_curves_and_heads_but_no_scores(folder):
    out = folder / "plain.html"
    film = reported.write_film(folder / "film.mp4")
    write_report([folder / "exact"], out, ReportOptions(video=film))
    page = out.read_text(encoding="utf-8")
    assert "Lip curves" in page
    for absent in ("<h2>Scores", "<h2>Worst frames", "<h2>Error", "over the truth"):
        assert absent not in page[page.index("<main>") : page.index('id="data"')]


def test_a_long_clip_is_played_in_part(folder, monkeypatch):
    monkeypatch.setattr(reporting, "MOST_PLAYED", 10)
    out = folder / "cut.html"
    write_report([folder / "exact"], out, ReportOptions(folder / "data"))
    page = out.read_text(encoding="utf-8")
    assert f"The first 10 of {reported.FRAMES} frames" in page
    told = json.loads(re.search(r'id="data">(.*?)</script>', page)[1])
    assert told["heads"][0]["motion"]["weights"]["shape"][0] == 10
    assert told["contours"][0]["loops"][0]["shape"][0] == 10


@pytest.mark.parametrize(
    ("words", "part"),
    [
        (["nothing"], "nothing"),
        (["exact", "--truth", "exact"], "no ground truth"),
        (["exact"], "--video"),
        (["marks.csv"], "marks.csv"),
        (["exact", "--truth", "data", "--video", "short.mp4"], "frames"),
    ],
)
def test_bad_input_takes_one_line(folder, capsys, monkeypatch, words, part):
    monkeypatch.chdir(folder)
    if not (folder / "short.mp4").exists():
        reported.write_film(folder / "short.mp4", 4)
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
