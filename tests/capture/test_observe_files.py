"""Files of points, markers and observations: whole ones come back, broken ones are one line."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from marker_files import write_analog, write_c3d, write_long, write_wide

from abs_engine.capture.corpus_file import read_recording
from abs_engine.capture.dot_annotations import LIPS17, Mark, initial_places, read_marks, write_marks
from abs_engine.capture.head import read_head_poses, read_reference
from abs_engine.capture.headframe import check_names
from abs_engine.capture.markers import Markers, read_markers
from abs_engine.capture.observations import Observations, read_observations, write_observations
from abs_engine.cli import main
from abs_engine.core.errors import (
    AbsEngineError,
    InputFileError,
    ModelFormatError,
    ParameterError,
    TooFewPointsError,
)
from abs_engine.io.assets import load_speaker
from abs_engine.learn.training import train

SKULL = ("a", "b", "c")
NAMES = (*LIPS17, *SKULL)
_OUTER, _INNER = np.array([-10.0, 0, 10]), np.array([-12.0, -4, 4, 12])


def _row(across: np.ndarray, up: float, out: float) -> np.ndarray:
    return np.stack([across, np.full_like(across, up), np.full_like(across, out)], axis=1)


FACE = np.concatenate(
    [
        [[-20, 0, 0]], _row(_OUTER, 6, 0), [[20, 0, 0]], _row(_OUTER, -6, 0),
        _row(_INNER, 3, 1), _row(_INNER, -3, 1),
        [[0, 40, 15], [-50, 90, 0], [50, 90, 0], [0, 60, 10]],
    ]
)  # fmt: skip
"""mm: 17 points of the mouth and nose, three of the skull."""


def talking(frames: int = 5) -> np.ndarray:
    """Places (T, 20, 3): the lower lip goes down by 2 mm a frame, the head 3 mm to the left."""
    out = np.tile(FACE, (frames, 1, 1))
    lower = [k for k, name in enumerate(NAMES) if name.startswith("lower")]
    out[:, lower, 1] -= 2.0 * np.arange(frames)[:, None]
    out[..., 0] += 3.0 * np.arange(frames)[:, None]
    return out


def expected(frames: int = 5) -> np.ndarray:
    """The same without the head's motion, from the nose."""
    out = talking(frames)
    out[..., 0] -= 3.0 * np.arange(frames)[:, None]
    return out - FACE[16]


@pytest.mark.parametrize("lost", ["x", "z"])
def test_a_table_of_points_without_a_coordinate_says_which(tmp_path: Path, lost: str):
    path = write_long(tmp_path / "markers.csv", NAMES, talking())
    path.write_text(path.read_text().replace(f",{lost}", ",u", 1))
    with pytest.raises(InputFileError, match=f"lacks the columns {lost}"):
        read_markers(path)


@pytest.mark.parametrize("kind", ["c3d", "wide", "long"])
def test_marker_files_become_observations(tmp_path: Path, kind: str):
    """By the command line; a marker is missing in one frame, and the nose has another name."""
    points, names = talking(), tuple("Nase" if n == "nose" else n for n in NAMES)
    points[2, 4] = np.nan
    path = tmp_path / f"markers.{'c3d' if kind == 'c3d' else 'csv'}"
    {"c3d": write_c3d, "wide": write_wide, "long": write_long}[kind](path, names, points)
    rate = ["--rate", "60"] if kind == "long" else []
    out = tmp_path / "o.npz"
    command = ["observe", str(path), "--rename", "Nase=nose", "--rigid", "a,b,c", *rate]
    assert main([*command, "-o", str(out)]) == 0
    seen = read_observations(out)
    assert seen.names == NAMES
    assert seen.rate == pytest.approx(60)
    assert seen.found.sum() == seen.found.size - 1
    assert not seen.found[2, 4]
    assert np.isnan(seen.points[2, 4]).all()
    assert seen.points[seen.found] == pytest.approx(expected()[seen.found], abs=1e-4)
    assert np.isfinite(seen.of(LIPS17)).all(axis=(1, 2)).tolist() == [True, True, False, True, True]


def test_any_set_of_markers_will_do_if_none_is_of_the_lips(tmp_path: Path):
    """Beads of a user's own, one of them hidden in a frame."""
    beads = tuple(f"bead{k:02d}" if name in LIPS17 else name for k, name in enumerate(NAMES))
    points = talking()
    points[2, 4] = np.nan
    out, path = tmp_path / "o.npz", write_wide(tmp_path / "m.csv", beads, points)
    skull = dict(zip(NAMES, expected()[0].tolist(), strict=True))
    lines = [f"{name},{skull[name][0]},{skull[name][1]},{skull[name][2]}" for name in "abc"]
    (tmp_path / "skull.csv").write_text("\n".join(["point,x,y,z", *lines]))
    words = ["--rigid", "a,b,c", "--reference", str(tmp_path / "skull.csv"), "-o", str(out)]
    assert main(["observe", str(path), *words]) == 0
    seen = read_observations(out)
    assert seen.names == beads
    assert seen.found.sum() == seen.found.size - 1
    assert seen.points[seen.found] == pytest.approx(expected()[seen.found], abs=1e-4)
    with pytest.raises(TooFewPointsError, match="16 of 16 points were not observed"):
        train(seen, load_speaker())


def test_labels_of_a_c3d_file_go_on_in_further_lists(tmp_path: Path):
    further = NAMES[8:13], NAMES[13:]
    path = write_c3d(tmp_path / "m.c3d", NAMES[:8], talking(), further=further)
    markers = read_markers(path)
    assert markers.names == NAMES
    assert markers.points == pytest.approx(talking(), abs=1e-3)


def test_a_c3d_file_with_fewer_labels_than_points_is_refused(tmp_path: Path):
    path = write_c3d(tmp_path / "m.c3d", NAMES[:8], talking())
    with pytest.raises(InputFileError, match="has 20 points and 8 labels"):
        read_markers(path)


def test_labels_of_a_c3d_file_beyond_its_points_are_left_out(tmp_path: Path):
    path = write_c3d(tmp_path / "m.c3d", (*NAMES, "spare"), talking())
    assert read_markers(path).names == NAMES


def test_a_rate_that_a_c3d_file_states_may_be_given(tmp_path: Path):
    path = write_c3d(tmp_path / "m.c3d", NAMES, talking(), rate=59.94)  # kept in 32 bits
    assert read_markers(path, 59.94).rate == pytest.approx(59.94)
    with pytest.raises(ParameterError, match=r"states the rate 59\.94; leave the option out"):
        read_markers(path, 60.0)


def test_of_many_markers_a_message_lists_some():
    names = tuple(f"marker{k}" for k in range(255))
    markers = Markers(names, np.zeros((1, 255, 3)), np.zeros((1, 255)), 60.0)
    for ask in (lambda: markers.renamed({"nose": "x"}), lambda: check_names(names, ["nose"])):
        with pytest.raises(ParameterError, match=r"marker59 and 195 more$"):
            ask()


def test_messages_of_observations_have_the_frame_numbers_of_the_file(tmp_path, capsys):
    path, out = write_long(tmp_path / "m.csv", NAMES, talking(), first=100), tmp_path / "o.npz"
    words = ["--rigid", "a,b,c", "--rate", "60", "-o", str(out)]
    assert main(["observe", str(path), *words]) == 0
    assert read_observations(out).first == 100
    assert read_recording(out).numbers == "frames 100 to 104"
    with np.load(out) as archive:
        np.savez(tmp_path / "old.npz", **{n: v for n, v in archive.items() if n != "first"})
    assert read_observations(tmp_path / "old.npz").first == 0
    path.write_text(path.read_text().replace("102,nose,6.0", "102,nose,1e11"))
    with pytest.raises(InputFileError, match=r"'nose' is .* in frame 102"):
        read_markers(path, 60.0, "m")


def test_a_rate_that_contradicts_the_column_time_is_refused(tmp_path: Path):
    path = write_wide(tmp_path / "m.csv", NAMES, talking())
    assert read_markers(path, 60.5).rate == 60.5
    with pytest.raises(ParameterError, match="states the rate 60 by its column time; leave the op"):
        read_markers(path, 30.0)
    assert read_markers(path, 30.0, timed=False).rate == 30


def test_times_in_milliseconds_are_named(tmp_path: Path):
    path = tmp_path / "m.csv"
    path.write_text("time,a_x,a_y,a_z\n0,1,2,3\n33.3,1,2,3\n66.7,1,2,3")
    with pytest.raises(InputFileError, match=r"33.* s apart .*; give seconds there, not millisec"):
        read_markers(path)


def test_a_line_for_each_point_may_have_frame_and_time(tmp_path: Path):
    path = tmp_path / "m.csv"
    rows = [f"{k},{(k - 100) / 50},{name},1,2,{k}" for k in (100, 101, 102) for name in "ab"]
    path.write_text("\n".join(["frame,time,point,x,y,z", *rows]))
    markers = read_markers(path)
    assert (markers.rate, markers.first, markers.names) == (pytest.approx(50), 100, ("a", "b"))
    assert markers.points[:, 1].tolist() == [[1, 2, 100], [1, 2, 101], [1, 2, 102]]


def test_zeros_are_counted_and_points_that_are_not_rigid_named(tmp_path: Path, capsys):
    points = talking()
    points[2, 4] = 0
    points[3, NAMES.index("a")] += [30.0, 0, 0]
    path = write_wide(tmp_path / "m.csv", NAMES, points)
    assert main(["observe", str(path), "--rigid", "a,b,c", "-o", str(tmp_path / "o.npz")]) == 0
    told = capsys.readouterr().out
    assert "1 position at exactly 0, 0, 0 treated as missing" in told
    assert "warning: these points are not rigid" in told
    assert not read_observations(tmp_path / "o.npz").found[2, 4]


def test_units_are_turned_into_millimetres(tmp_path: Path):
    path = write_c3d(tmp_path / "m.c3d", NAMES, talking() / 1000, "m")
    assert read_markers(path).points == pytest.approx(talking(), abs=1e-3)
    wide = write_wide(tmp_path / "cm.csv", NAMES, talking() / 10)
    assert read_markers(wide, unit="cm").points == pytest.approx(talking())


@pytest.mark.parametrize(
    "text",
    ["Frame,a_x,a_y,a_z\n0,1,2,3\n1,1,2,3", "FRAME,Point,X,Y,Z\n0,a,1,2,3\n1,a,1,2,3"],
)
def test_columns_of_a_marker_file_may_have_capitals(tmp_path, text):
    path = tmp_path / "m.csv"
    path.write_text(text)
    markers = read_markers(path, 50.0)
    assert markers.names == ("a",)
    assert markers.points == pytest.approx(np.array([[[1.0, 2, 3]]] * 2))


def test_broken_marker_files_are_one_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    whole = write_c3d(tmp_path / "whole.c3d", NAMES, talking())
    cut, none, empty = (tmp_path / f"{n}.c3d" for n in ("cut", "none", "empty"))
    cut.write_bytes(whole.read_bytes()[:-700])
    none.write_bytes(b"no markers at all" * 100)
    empty.write_bytes(b"")
    analog = write_analog(tmp_path / "analog.c3d")
    gap = write_wide(tmp_path / "gap.csv", NAMES, talking(), time=False)
    gap.write_text("\n".join(line for k, line in enumerate(gap.read_text().split("\n")) if k != 3))
    words = write_wide(tmp_path / "words.csv", NAMES, talking())
    words.write_text(words.read_text().replace("-20.0", "left", 1))
    few = write_wide(tmp_path / "few.csv", NAMES[4:], talking()[:, 4:])
    timeless = write_long(tmp_path / "timeless.csv", NAMES, talking())
    inches = write_c3d(tmp_path / "in.c3d", NAMES, talking(), "in")
    without = np.where((np.array(NAMES) == "nose")[:, None], np.nan, talking())
    noseless = write_c3d(tmp_path / "noseless.c3d", NAMES, without)
    metres = write_wide(tmp_path / "metres.csv", NAMES, talking() / 1000)
    semi, tabs, bare, decimals = (
        write_wide(tmp_path / f"{n}.csv", NAMES, talking()) for n in ("semi", "tabs", "bare", "de")
    )
    whole_text = semi.read_text()
    semi.write_text(whole_text.replace(",", ";"))
    tabs.write_text(whole_text.replace(",", "\t"))
    bare.write_text(whole_text.partition("\n")[2])
    decimals.write_text(whole_text.replace(".", ","))
    cases = [
        (cut, "export it again"), (none, "not a C3D file that can be read; export"),
        (empty, "not a C3D file that can be read; export"),
        (analog, "holds no points, only analog channels"),
        (gap, "skips or repeats"), (words, "left"), (few, "4 of the 17 points are missing"),
        (noseless, "'nose', the origin of the head frame, is found in no frame"),
        (metres, "0.15 mm from end to end; are they in mm? say so with --unit"),
        (semi, "has semicolons between its columns"), (tabs, "has tabs between its columns"),
        (bare, "has no column names in its first line"), (decimals, "use commas only between"),
        (timeless, "frame rate"), (inches, "is in 'in'"), (tmp_path / "x.c3d", "does not exist"),
    ]  # fmt: skip
    for path, told in cases:
        out = tmp_path / "o.npz"
        assert main(["observe", str(path), "--rigid", "a,b,c", "-o", str(out)]) == 2
        assert told in capsys.readouterr().err
        assert not out.exists()


@pytest.mark.parametrize(
    ("order", "said"),
    [
        ([0, 1, 3, 2], r"lines of .* are not in order: frame 3 comes after frame 1; sort them"),
        ([0, 1, 3, 4], "skips or repeats a frame: frame 3 comes after frame 1"),
        ([0, 1, 1, 2], "skips or repeats a frame: frame 1 comes after frame 1"),
    ],
)
def test_frames_out_of_order_are_named(tmp_path, order, said):
    path = tmp_path / "m.csv"
    path.write_text("\n".join(["frame,a_x,a_y,a_z", *(f"{k},1,2,3" for k in order)]))
    with pytest.raises(InputFileError, match=said):
        read_markers(path, 50.0)


@pytest.mark.parametrize("wide", [True, False])
@pytest.mark.parametrize("end", [",left", ",0,0"])
def test_what_is_wrong_has_the_line_in_the_file_blank_ones_too(tmp_path, wide, end):
    path = tmp_path / "wide.csv"
    header, key = ("frame,a_x,a_y,a_z", "") if wide else ("frame,point,x,y,z", ",a")
    rows = [f"{100 + k}{key},0,0,0" for k in range(4)]
    rows[2] = rows[2].rpartition(",")[0] + end
    path.write_text("\n".join([header, "", *rows]))
    with pytest.raises(InputFileError, match=r"wide.csv, line 5\b"):
        read_markers(path, 50.0)


@pytest.mark.parametrize("rate", [0, -5])
def test_a_rate_that_is_none_is_refused(tmp_path, capsys, rate):
    path = write_long(tmp_path / "m.csv", NAMES, talking())
    out = tmp_path / "o.npz"
    assert main(["observe", str(path), "--rate", str(rate), "-o", str(out)]) == 2
    assert f"{rate} is not a number above 0" in capsys.readouterr().err
    assert not out.exists()
    with pytest.raises(ParameterError, match=f"{rate} is not a rate above 0"):
        read_markers(path, rate)


def test_a_last_line_that_is_cut_says_how_much_is_left(tmp_path):
    path = write_long(tmp_path / "cut.csv", NAMES, talking())
    text = path.read_text()
    path.write_text(text[: text.rindex(",")])
    line = len(text.splitlines())
    with pytest.raises(InputFileError, match=f"line {line}: 4 cells under 5 names"):
        read_markers(path, 50.0)


def test_points_are_read_from_csv_and_json(tmp_path: Path):
    table, tree = tmp_path / "p.csv", tmp_path / "p.json"
    table.write_text("\ufeffpoint, x ,y,view,note\nnose,1.5,2,2,fine\nchin,,,1,\n")
    marks = (Mark(0, 1, "nose", (1.5, 2.0)), Mark(0, 0, "chin", None))
    assert read_marks(table) == marks
    rows = [
        {"point": "nose", "view": 2, "x": 1.5, "y": 2},
        {"point": "chin", "x": None, "y": None},
    ]
    tree.write_text(json.dumps({"format": "abs_engine.dots", "version": 1, "points": rows}))
    assert read_marks(tree) == marks
    table.write_text(write_marks((m, {"why": "lost"}) for m in marks))
    assert read_marks(table) == marks
    tree.write_text(json.dumps({"format": "abs_engine.dots", "version": 2, "points": rows}))
    with pytest.raises(ModelFormatError, match="version 2"):
        read_marks(tree)
    for text in ("", "point,x\nnose,1\n", "point,x,y\nnose,one,2\n", "point,x,y\nnose,1,\n",
                 "point,x,y,frame\nnose,1,2,-1\n", "point,x,y\n,1,2\n"):  # fmt: skip
        table.write_text(text)
        with pytest.raises(InputFileError):
            read_marks(table)


@pytest.mark.parametrize("again", ["9,1,nose,3,4", "9,1,nose,,", "9.0,,nose,1,2"])
def test_a_point_has_one_place_in_a_frame_of_a_view(tmp_path: Path, again: str):
    table = tmp_path / "p.csv"
    rows = ["frame,view,point,x,y", "9,1,nose,,", "8,1,nose,1,2", "9,2,nose,1,2", "9,1,chin,1,2"]
    table.write_text("\n".join(rows))
    assert len(read_marks(table)) == 4
    table.write_text("\n".join([*rows, again]))
    said = r"p\.csv, line 6: point 'nose' is given twice for frame 9 and view 1; keep one"
    with pytest.raises(InputFileError, match=said):
        read_marks(table)


def test_numbers_of_frames_and_views_may_have_a_point(tmp_path: Path):
    """As spreadsheets and pandas write them; a fraction of a frame there is not."""
    table, tree = tmp_path / "p.csv", tmp_path / "p.json"
    table.write_text("frame,view,point,x,y\n9.0,2.0,nose,1,2\n")
    rows = [{"frame": 9.0, "view": 2.0, "point": "nose", "x": 1, "y": 2}]
    tree.write_text(json.dumps({"format": "abs_engine.dots", "version": 1, "points": rows}))
    assert read_marks(table) == read_marks(tree) == (Mark(9, 1, "nose", (1.0, 2.0)),)
    table.write_text("frame,view,point,x,y\n9.5,2,nose,1,2\n")
    with pytest.raises(InputFileError, match=r"line 2: '9\.5' is not a whole number; give columns"):
        read_marks(table)


def test_points_that_are_missing_or_double_are_named():
    every = [Mark(0, v, n, (1.0, 2.0)) for v in (0, 1) for n in LIPS17]
    names, places = initial_places([*every, *(Mark(0, v, "x", (3.0, 4.0)) for v in (0, 1))], 2)
    assert names == (*LIPS17, "x")
    assert places[:, -1].tolist() == [[3, 4], [3, 4]]
    with pytest.raises(TooFewPointsError, match=r"1 places are missing.*nose \(view 2\)"):
        initial_places(every[:-1], 2)
    own = [Mark(0, v, n, (1.0, 2.0)) for n in ("b", "a") for v in (0, 1)]
    assert initial_places(own, 2)[0] == ("b", "a")
    with pytest.raises(TooFewPointsError, match=r"1 places are missing.*a \(view 2\)"):
        initial_places(own[:-1], 2)
    with pytest.raises(ModelFormatError, match="twice"):
        initial_places([*every, every[3]], 2)
    with pytest.raises(ModelFormatError, match="view 3"):
        initial_places([*every, Mark(0, 2, "nose", (1.0, 1.0))], 2)


def some() -> Observations:
    found = np.ones((5, 20), bool)
    found[1, 3] = False
    points = np.where(found[..., None], expected(), np.nan)
    flat, still = np.where(found, 0.2, np.nan), np.zeros((5, 3))
    return Observations(
        points, NAMES, found, np.zeros_like(found), flat, flat, 30.0, still, still,
        np.zeros(5), np.ones((2, 5, 20, 2)), "by hand",
    )  # fmt: skip


def test_observations_come_back(tmp_path: Path):
    path = write_observations(tmp_path / "o.npz", some())
    back = read_observations(path)
    for name in Observations.__dataclass_fields__:
        assert np.array_equal(
            getattr(back, name), getattr(some(), name), equal_nan=name not in ("names", "source")
            and getattr(some(), name).__class__ is np.ndarray,
        )  # fmt: skip
    with np.load(path, allow_pickle=False) as archive:
        assert (str(archive["format"]), int(archive["version"])) == ("abs_engine.observations", 1)
    with pytest.raises(TooFewPointsError, match="1 of 2"):
        back.of(("nose", "chin"))
    with pytest.raises(AbsEngineError, match="exists already"):
        write_observations(path, some())


def test_a_place_that_was_not_found_is_no_place():
    found = np.ones((5, 20), bool)
    found[2, 4] = False
    seen = replace(some(), points=expected(), found=found)
    assert np.isfinite(seen.points).all()
    assert np.isfinite(seen.of(LIPS17)).all(axis=(1, 2)).tolist() == [True, True, False, True, True]
    assert np.isnan(seen.of(LIPS17)[2, 4]).all()
    assert np.isfinite(seen.of(LIPS17)).sum() == 3 * (5 * 17 - 1)


def test_broken_observations_are_named(tmp_path: Path):
    path = write_observations(tmp_path / "o.npz", some())
    with np.load(path) as archive:
        fields = dict(archive)
    for change in ({"version": 9}, {"points": np.zeros((4, 20, 3))}, {"names": ["x"] * 20}):
        np.savez(tmp_path / "bad.npz", **(fields | change))
        with pytest.raises(ModelFormatError):
            read_observations(tmp_path / "bad.npz")
    del fields["score"]
    np.savez(tmp_path / "bad.npz", **fields)
    with pytest.raises(ModelFormatError, match="score"):
        read_observations(tmp_path / "bad.npz")
    with pytest.raises(AbsEngineError, match="no place"):
        replace(some(), found=np.ones((5, 20), bool))


def test_head_poses_and_references(tmp_path: Path):
    poses, reference = tmp_path / "poses.csv", tmp_path / "reference.csv"
    poses.write_text("frame,rx,ry,rz,tx,ty,tz\n1,,,,,,\n0,0,0,0.5,1,2,3\n")
    motion = read_head_poses(poses, 2)
    assert motion.rotations[0].tolist() == [0, 0, 0.5]
    assert motion.found.tolist() == [True, False]
    with pytest.raises(InputFileError, match="frame 2"):
        read_head_poses(poses, 3)
    reference.write_text("point,x,y,z\na,1,2,3\n")
    assert read_reference(reference)["a"].tolist() == [1, 2, 3]
    reference.write_text("point,x,y,z\na,1,2,\n")
    with pytest.raises(InputFileError, match="'a'"):
        read_reference(reference)


def test_poses_are_of_the_frames_that_their_numbers_say(tmp_path: Path):
    poses = tmp_path / "poses.csv"
    lines = [f"{k},0,0,0,{k},0,0" for k in range(9)]
    poses.write_text("\n".join(["frame,rx,ry,rz,tx,ty,tz", *lines]))
    assert read_head_poses(poses, 3, first=5).translations[:, 0].tolist() == [5, 6, 7]
    with pytest.raises(InputFileError, match="no line for frame 9; give frames 7 to 9"):
        read_head_poses(poses, 3, first=7)


def test_the_poses_of_markers_go_by_the_numbers_of_their_frames(tmp_path: Path):
    path, poses = write_long(tmp_path / "m.csv", NAMES, talking(), first=100), tmp_path / "p.csv"
    lines = [f"{k},0,0,0,{3 * (k - 100)},0,0" for k in range(90, 110)]
    poses.write_text("\n".join(["frame,rx,ry,rz,tx,ty,tz", *lines]))
    out = tmp_path / "o.npz"
    words = ["--pose", str(poses), "--rate", "60", "-o", str(out)]
    assert main(["observe", str(path), *words]) == 0
    assert read_observations(out).points - FACE[16] == pytest.approx(expected(), abs=1e-4)


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ("1,0,0,0,4,5,6", r"poses.csv, line 4: frame 1 is given twice; keep one"),
        ("1.5,0,0,0,4,5,6", r"poses.csv, line 4: '1.5' is not a frame number; use whole numbers"),
    ],
)
def test_a_pose_is_of_one_frame(tmp_path: Path, line: str, said: str):
    poses = tmp_path / "poses.csv"
    rows = ["frame,rx,ry,rz,tx,ty,tz", "0,0,0,0,1,2,3", "1,0,0,0,1,2,3"]
    poses.write_text("\n".join([*rows, ",,,,,,"]))
    assert read_head_poses(poses, 2).found.all()
    poses.write_text("\n".join([*rows, line]))
    with pytest.raises(InputFileError, match=said):
        read_head_poses(poses, 2)


def test_a_point_of_a_reference_has_one_place(tmp_path: Path):
    reference = tmp_path / "reference.csv"
    reference.write_text("point,x,y,z\na,1,2,3\nb,4,5,6\na,1,2,3\n")
    with pytest.raises(InputFileError, match=r"line 4: point 'a' is given twice; keep one"):
        read_reference(reference)


def test_calibration_commands_that_lack_something_are_one_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
):
    import cv2

    wall = tmp_path / "wall.png"
    cv2.imwrite(str(wall), np.full((120, 160, 3), 99, np.uint8))
    board, out = ["--squares", "7", "5", "--square", "20"], ["-o", str(tmp_path / "c.json")]
    cases = [
        ([str(wall), *out], "--squares"),
        (
            [str(wall), *board, *out],
            "found in no picture; check --squares (columns before rows), --board, --marker and",
        ),
        ([str(wall), *board, "--board", "chessboard", "--mirror", *out], "ChArUco"),
        ([str(wall), *board, "--second", str(wall), *out], "--second-output"),
        ([str(wall), *board, "--second", str(wall), "--second-output", out[1], *out], "two names"),
        ([str(tmp_path / "no.png"), *board, *out], "no.png does not exist"),
    ]
    for arguments, told in cases:
        assert main(["observe", "calibrate", *arguments]) == 2
        assert told in capsys.readouterr().err
        assert not (tmp_path / "c.json").exists()
