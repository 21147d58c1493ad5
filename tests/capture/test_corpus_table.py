"""Tables and recordings of a user's own: what is ambiguous or broken is refused in one line."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from marker_files import write_c3d, write_long

from abs_engine.capture.corpus import Corpus
from abs_engine.capture.corpus_file import read_corpus, read_recording
from abs_engine.capture.corpus_table import read_table
from abs_engine.core.errors import (
    AbsEngineError,
    InputFileError,
    ModelFormatError,
    ParameterError,
    TooFewPointsError,
)

TEETH = ("right", "left", "front")
NAMES = ("m1", "m2", "m3", *TEETH)
MARKS = np.array([[-25.0, 0, -35], [25, 0, -35], [0, 0, 0]])
TABLE = {
    "groups": {"lips": ["m1", "m2"], "jaw_line": ["m3"]},
    "visemes": {"ipi": 1, "a": [2, 3]},
    "upper_teeth": list(TEETH),
}
LINES = (
    "what,name,value\npoint,m1,lips\npoint,m2,lips\npoint,m3,jaw_line\nviseme,ipi,1\n"
    "viseme,a,2-3\nteeth,right,right\nteeth,left,left\nteeth,front,front\n"
)


def points(frames: int = 4) -> np.ndarray:
    """Points (T, 6, 3) in the frame of their teeth."""
    own = np.random.default_rng(0).normal(size=(frames, 3, 3)) * 20
    return np.concatenate([own, np.tile(MARKS, (frames, 1, 1))], axis=1)


def table(folder: Path, text: str | None = None, kind: str = "json") -> Path:
    path = folder / f"table.{kind}"
    path.write_text(json.dumps(TABLE) if text is None else text, encoding="utf-8")
    return path


def recording(folder: Path, names: object = NAMES, at: np.ndarray | None = None) -> Path:
    path = folder / "own.npz"
    np.savez(path, names=np.array(names), points=points() if at is None else at)
    return path


def line_of(error: AbsEngineError) -> str:
    (line,) = str(error).splitlines()
    line.encode("utf-8")
    return line


def test_what_is_told_is_read(tmp_path: Path):
    told = read_table(table(tmp_path))
    assert told == read_table(table(tmp_path, LINES, "csv"))
    assert told.visemes == {"ipi": (1, 1), "a": (2, 3)}
    one = read_table(table(tmp_path, json.dumps({**TABLE, "visemes": {"a": [7]}})))
    assert one.visemes == {"a": (7, 7)}


@pytest.mark.parametrize(
    "frames", ["12", [5.9, 6.9], 5.0, True, [True, 2], [1, 2, 3], [], None, {"1": 2}, [3, 2], -1]
)
def test_frames_are_whole_numbers(tmp_path: Path, frames: object):
    with pytest.raises(InputFileError, match="viseme 'a' has no frames such as 12") as error:
        read_table(table(tmp_path, json.dumps({**TABLE, "visemes": {"a": frames}})))
    line_of(error.value)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"upper_teeth": "abc"}, "upper_teeth is not a list"),
        ({"upper_teeth": {"right": 1, "left": 2, "front": 3}}, "upper_teeth is not a list"),
        ({"groups": {"x": "ab"}}, "group 'x' is not a list"),
        ({"groups": {"x": [1]}}, "group 'x' is not a list"),
        ({"groups": ["x"]}, "there are no groups"),
        ({"groups": {"x": ["m1", "m2", "m1"]}}, "'m1' is given twice in group 'x'"),
        ({"visemes": ["a"]}, "visemes are not names"),
        ({"visemes": {"\ud800": 1}}, "cannot be printed"),
        ({"visemes": {"a\nb": 1}}, "cannot be printed"),
        ({"visemes": {" ": 1}}, "a viseme has an empty name"),
        ({"groups": {"l\0": ["m1"]}}, "cannot be printed"),
        ({"upper_teeth": ["right", "left", "m\n3"]}, "cannot be printed"),
    ],
)
def test_a_json_table_that_is_wrong_is_named(tmp_path: Path, change: dict[str, object], said: str):
    with pytest.raises(InputFileError, match=said) as error:
        read_table(table(tmp_path, json.dumps({**TABLE, **change})))
    line_of(error.value)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ('{"groups": {}, "visemes": {"a": 1, "a": 2}}', "'a' is given twice"),
        ('{"groups": {}, "groups": {}}', "'groups' is given twice"),
        ('{"groups": ' + "[" * 100_000, "too deep"),
        ("[]", "there are no groups"),
    ],
)
def test_json_that_is_wrong_is_named(tmp_path: Path, text: str, said: str):
    with pytest.raises(InputFileError, match=said) as error:
        read_table(table(tmp_path, text))
    line_of(error.value)


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ("teeth,left,m2", "line 10: the left teeth are given twice"),
        ("point,m1,lips", "'m1' is given twice in group 'lips'"),
        ("point,m2,x x", "'m2' is given twice in group 'x'"),
        ("viseme,a,1", "line 10: viseme 'a' is given twice"),
        ("viseme,,1", "a viseme has an empty name"),
    ],
)
def test_what_a_csv_table_gives_twice_is_named(tmp_path: Path, line: str, said: str):
    with pytest.raises(InputFileError, match=said):
        read_table(table(tmp_path, LINES + line + "\n", "csv"))


def test_what_is_there_but_no_file_is_not_said_to_be_missing(tmp_path: Path):
    for path in (tmp_path, Path("/dev/null")):
        with pytest.raises(InputFileError, match="is not a file"):
            read_table(path)
        with pytest.raises(InputFileError, match="is not a file"):
            read_recording(path)
    with pytest.raises(InputFileError, match="does not exist"):
        read_table(tmp_path / "none.csv")


@pytest.mark.parametrize("group", ["visemes", "groups"])
def test_a_corpus_has_names_that_can_be_shown(group: str):
    own = {"visemes": ("a", "i"), "groups": {}}
    own |= {"visemes": ("a", "\ud800")} if group == "visemes" else {"groups": {"a\tb": ()}}
    with pytest.raises(ParameterError, match="cannot be printed") as error:
        Corpus(np.zeros((2, 1, 3)), ("p",), **own)
    line_of(error.value)


def test_two_points_of_one_name_are_refused(tmp_path: Path):
    path = recording(tmp_path, ("m1", "m1", "m3", *TEETH))
    for read in (read_recording, read_corpus):
        with pytest.raises(ParameterError, match="two points are named 'm1'"):
            read(path, table(tmp_path))
    with pytest.raises(ParameterError, match="two points are named 'm1'"):
        read_recording(path)


@pytest.mark.parametrize(
    ("names", "at", "error"),
    [
        (NAMES, points() + 1j, ModelFormatError),
        (NAMES, points() > 0, ModelFormatError),
        (range(6), points(), ModelFormatError),
        ([NAMES], points(), ModelFormatError),
        (("m1", "m2", "m\n3", *TEETH), points(), InputFileError),
    ],
    ids=["complex", "bool", "numbers", "2d", "newline"],
)
def test_arrays_that_are_no_points_are_refused(tmp_path: Path, names, at, error):
    with pytest.raises(error) as raised:
        read_recording(recording(tmp_path, names, at))
    line_of(raised.value)


def test_plain_arrays_without_a_table_ask_for_one(tmp_path: Path):
    with pytest.raises(ParameterError, match="does not say what its points are; give a table"):
        read_corpus(recording(tmp_path))
    np.savez(tmp_path / "other.npz", x=np.zeros(3))
    with pytest.raises(ModelFormatError):
        read_corpus(tmp_path / "other.npz")


@pytest.mark.parametrize("lost", [np.zeros((6, 3)), np.full((6, 3), 7.0)], ids=["zeros", "equal"])
@pytest.mark.parametrize("kind", ["npz", "c3d"])
def test_a_frame_whose_teeth_span_no_plane_is_missing(tmp_path: Path, kind: str, lost: np.ndarray):
    own = points()
    broken = own + 50.0
    broken[2] = lost
    if kind == "npz":
        path = recording(tmp_path, NAMES, broken)
    else:
        path = write_c3d(tmp_path / "own.c3d", NAMES, broken)
    found = read_recording(path, table(tmp_path))
    assert found.names == NAMES
    assert np.isnan(found.points[2]).all()
    kept = [0, 1, 3]
    np.testing.assert_allclose(found.points[kept], own[kept], atol=1e-3)
    said = "frame 2: three points of the upper teeth" if lost.any() else "missing in frame 2"
    with pytest.raises(TooFewPointsError, match=said):
        read_corpus(path, table(tmp_path))


@pytest.mark.parametrize("kind", ["npz", "c3d", "csv"])
def test_places_at_zero_are_missing_and_counted(tmp_path: Path, kind: str):
    """But for the front teeth's, which are the origin of their own frame."""
    own = points()
    own[2, 1] = own[3, 0] = 0
    path = recording(tmp_path, NAMES, own) if kind == "npz" else tmp_path / f"own.{kind}"
    if kind != "npz":
        (write_c3d if kind == "c3d" else write_long)(path, NAMES, own)
    said: list[str] = []
    found = read_corpus(path, table(tmp_path), say=said.append).points
    assert said == ["2 positions at exactly 0, 0, 0 treated as missing"]
    expected = np.stack([own[1], [own[3, 0], own[2, 1], *own[2:, 2:].mean(axis=0)]])
    expected[1, 0], expected[1, 1] = own[2, 0], own[3, 1]  # where the other frame lacks it
    np.testing.assert_allclose(found, expected, atol=1e-3)


def test_frames_have_the_numbers_of_their_column(tmp_path: Path):
    own = points()
    path = write_long(tmp_path / "own.csv", NAMES, own, first=1)
    found = read_corpus(path, table(tmp_path)).points
    np.testing.assert_allclose(found, [own[0], own[1:3].mean(axis=0)], atol=1e-3)
    assert read_recording(path).first == 1
    with pytest.raises(ParameterError, match=r"frame 0 for 'u', .* has frames 1 to 4") as error:
        read_corpus(path, table(tmp_path, LINES + "viseme,u,0\n", "csv"))
    line_of(error.value)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda own: own * [1, -1, 1], "the upper lip lies 22 mm below the lower one"),
        (lambda own: own - [0, 0, 40], "the lips lie 32 mm behind the edge of the front teeth"),
    ],
    ids=["down", "behind"],
)
def test_lips_that_do_not_lie_on_the_teeth_as_lips_do_are_refused(tmp_path: Path, change, said):
    own = points()
    own[:, :2] = [[-20, 11, 8], [20, -11, 8]]
    told = {**TABLE, "groups": {"upper_lip": ["m1"], "lower_lip": ["m2"]}}
    read_corpus(recording(tmp_path, at=own), table(tmp_path, json.dumps(told)))
    own[:, :3] = change(own[:, :3])
    path = recording(tmp_path, at=own)
    with pytest.raises(ParameterError, match=f"own.npz: {said}") as error:
        read_corpus(path, table(tmp_path, json.dumps(told)))
    line_of(error.value)


def test_teeth_that_never_span_a_plane_are_an_error(tmp_path: Path):
    path = recording(tmp_path, NAMES, np.full((4, 6, 3), 7.0))
    with pytest.raises(TooFewPointsError, match="frame 0: three points of the upper teeth"):
        read_recording(path, table(tmp_path))


@pytest.mark.parametrize("unit", ["m", "cm"])
def test_points_in_metres_are_refused_until_their_unit_is_given(tmp_path: Path, unit: str):
    lips = points()
    path = recording(tmp_path, at=lips / {"m": 1000, "cm": 10}[unit])
    with pytest.raises(ParameterError, match="say so with --unit") as told:
        read_corpus(path, table(tmp_path))
    assert "own.npz" in line_of(told.value)
    whole = read_corpus(recording(tmp_path, at=lips), table(tmp_path))
    path = recording(tmp_path, at=lips / {"m": 1000, "cm": 10}[unit])
    np.testing.assert_allclose(read_corpus(path, table(tmp_path), unit=unit).points, whole.points)
