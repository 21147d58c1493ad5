"""Whatever is in a file, a reader takes it or refuses it by a named error, in one line.

`tests/mutate_readers.py` does the same by hand with thousands of files for each reader.
"""

from __future__ import annotations

import json
import math
import os
import signal
import warnings
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays_of
from mutations import mutation
from readable import READERS, Reader, came_of, problem

from abs_engine.core.errors import AbsEngineError, InputFileError, ModelFormatError
from abs_engine.io.arrays import check_arrays, index, of_json, real, text, truth, whole
from abs_engine.io.inputs import MOST, parse_json, read_json, read_toml, to_number
from abs_engine.io.pictures import read_image

EVERY = settings(deadline=None, database=None, derandomize=True)
FEW, MORE = settings(EVERY, max_examples=10), settings(EVERY, max_examples=40)


@pytest.mark.parametrize("reader", READERS, ids=lambda reader: reader.name)
def test_a_file_that_was_changed_is_refused_or_still_one_of_its_kind(
    reader: Reader, tmp_path: Path
) -> None:
    path, content = reader.put(tmp_path)
    found = reader.read(path)
    assert "*" in reader.unread or problem(found, reader.gaps) == ""

    @FEW
    @given(seed=st.integers(0, 2**32 - 1))
    def holds(seed: int) -> None:
        change = mutation(content, path.suffix[1:], np.random.default_rng(seed))
        assert came_of(reader, path, change) in ("refused", "accepted"), change.what

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        holds()


def _hangs(*_: object) -> None:
    raise AssertionError("it waits for a pipe")


OTHERS = [reader for reader in READERS if reader.file != "frames.journal"]
"""All but what is our own, in a folder that is locked."""


@pytest.mark.parametrize("reader", OTHERS, ids=lambda reader: reader.name)
def test_what_is_no_ordinary_file_is_never_waited_for(reader: Reader, tmp_path: Path) -> None:
    path, _ = reader.put(tmp_path)
    path.unlink()
    os.mkfifo(path)
    before = signal.signal(signal.SIGALRM, _hangs)
    signal.alarm(5)
    try:
        with suppress(AbsEngineError):
            reader.read(path)
        assert signal.alarm(0)  # seconds were left
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, before)


NEEDED = [reader for reader in OTHERS if "*" not in reader.unread]


@pytest.mark.parametrize("reader", NEEDED, ids=lambda reader: reader.name)
def test_a_file_that_may_not_be_read_is_not_called_damaged(
    reader: Reader, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path, _ = reader.put(tmp_path)
    plain = Path.open

    def locked(self: Path, *words: Any, **more: Any) -> Any:  # root may read everything
        if self.samefile(path):
            raise PermissionError(13, "Permission denied")
        return plain(self, *words, **more)

    monkeypatch.setattr(Path, "open", locked)
    with pytest.raises(InputFileError, match=r"cannot be read \(Permission denied\)"):
        reader.read(path)


def test_text_is_read_with_a_byte_order_mark_and_in_utf_8_alone(tmp_path: Path) -> None:
    path = tmp_path / "a.toml"
    path.write_bytes("\ufeffname = 'ä'\r\n".encode())
    assert read_toml(path, "check it") == {"name": "ä"}
    path.write_bytes('\ufeff{"name": "ä"}'.encode())
    assert read_json(path) == {"name": "ä"}
    for coding in ("latin-1", "utf-16"):
        path.write_bytes("name = 'ä'".encode(coding))
        with pytest.raises(InputFileError, match=r"a.toml is not text in UTF-8; save it as UTF-8"):
            read_toml(path, "check it")
    with pytest.raises(ValueError, match="it is not text in UTF-8"):
        read_json(path)
    path.write_bytes(b"\x89PNG\0")
    with pytest.raises(InputFileError, match=r"a.toml is not text; check it"):
        read_toml(path, "check it")


ANY = arrays_of.arrays(
    st.one_of(
        arrays_of.floating_dtypes(), arrays_of.integer_dtypes(), arrays_of.boolean_dtypes(),
        arrays_of.complex_number_dtypes(), arrays_of.unicode_string_dtypes(max_len=3),
        arrays_of.byte_string_dtypes(max_len=3), arrays_of.datetime64_dtypes(),
    ),
    arrays_of.array_shapes(min_dims=0, max_dims=3, min_side=0, max_side=3),
)  # fmt: skip
LAYOUT = {
    "vertices": real("V", 3, dtype=np.float32),
    "faces": index("V", "F*", 3),
    "seen": truth("F*"),
    "names": text("V"),
    "gap": real("V?", gaps=True),
    "count": whole(low=0, high=9),
}


@MORE
@given(st.dictionaries(st.sampled_from(sorted(LAYOUT)), ANY, max_size=2))
def test_arrays_are_what_the_layout_says_or_refused(changed: dict[str, np.ndarray]) -> None:
    good = {
        "vertices": np.zeros((2, 3)), "faces": np.zeros((1, 3), int), "seen": np.ones(1, bool),
        "names": np.array(["a", "b"]), "gap": np.array([np.nan, 1]), "count": np.array(3),
    }  # fmt: skip
    try:
        found = check_arrays(Path("a.npz"), good | changed, LAYOUT, "make it again")
    except ModelFormatError:
        return
    vertices, facets = len(found["vertices"]), len(found["faces"])
    assert found["vertices"].shape == (vertices, 3)
    assert found["faces"].shape == (facets, 3)
    assert found["seen"].shape == (facets,)
    assert found["names"].shape == (vertices,)
    assert found["gap"].shape in ((vertices,), (0,))
    assert ((found["faces"] >= 0) & (found["faces"] < vertices)).all()
    assert (abs(found["vertices"]) <= MOST).all()
    assert not np.isinf(found["gap"]).any()
    assert 0 <= found["count"] <= 9
    kinds = {name: values.dtype.kind for name, values in found.items()}
    assert kinds == {
        "vertices": "f", "faces": "i", "seen": "b", "names": "U", "gap": "f", "count": "i"
    }  # fmt: skip


VALUES = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=4),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=3), inner),
    max_leaves=12,
)


@MORE
@given(VALUES)
def test_json_gives_finite_numbers_or_none(value: object) -> None:
    try:
        found = parse_json(json.dumps(value))
    except ValueError:
        assert not _is_finite(value)
        return
    assert found == value
    assert of_json(found).dtype.kind in "OUbif"


def _is_finite(value: object) -> bool:
    if isinstance(value, float):
        return math.isfinite(value)
    inner = value.values() if isinstance(value, dict) else value
    return not isinstance(value, (dict, list)) or all(map(_is_finite, inner))


@pytest.mark.parametrize("depth", [41, 500, 200_000])
@pytest.mark.parametrize("brackets", ["[]", '{"a":}'])
def test_json_that_nests_too_deep_is_refused(depth, brackets):
    text = brackets[:-1] * depth + "1" + brackets[-1] * depth
    with pytest.raises(ValueError, match="too deep"):
        parse_json(text)


@MORE
@given(st.text(max_size=8) | st.floats().map(repr) | st.integers().map(str))
def test_a_cell_is_a_finite_number_or_refused(cell: str) -> None:
    try:
        assert abs(to_number(cell)) <= MOST
    except ValueError:
        return


def _part(name: str, tmp_path: Path) -> tuple[Reader, Path, bytes]:
    reader = next(r for r in READERS if r.name == name)
    return reader, *reader.put(tmp_path)


def test_a_picture_is_refused_by_its_stated_size_and_by_that_of_a_chunk(tmp_path):
    _, path, content = _part("picture, PNG", tmp_path)
    wide = content[:16] + (60_000).to_bytes(4) * 2 + content[24:]
    at = content.index(b"IDAT")
    long = content[: at - 4] + b"\xff\xff\xff\xff" + content[at:]
    for harmful in (wide, long):
        path.write_bytes(harmful)
        with pytest.raises(InputFileError, match="is not a readable picture"):
            read_image(path)


def test_an_error_is_one_line_that_a_terminal_can_show():
    error = AbsEngineError("it says 'a\n\x1b[2J\ud800'", "look\tat it")
    assert str(error) == "it says 'a ?[2J?'; look at it"


def test_metadata_of_a_video_need_not_be_text(tmp_path):
    reader, path, content = _part("video, what it is", tmp_path)
    assert b"Lavf" in content
    path.write_bytes(content.replace(b"Lavf", b"\xff\xfe\xc3\x28"))
    assert reader.read(path).frames == 6


@pytest.mark.parametrize("processor", [0, 83, 87, 255])
def test_a_c3d_file_of_an_unknown_processor_is_refused(processor, tmp_path):
    reader, path, content = _part("markers, C3D", tmp_path)
    at = (content[0] - 1) * 512 + 3
    assert content[at] == 84
    path.write_bytes(content[:at] + bytes([processor]) + content[at + 1 :])
    with pytest.raises(InputFileError, match="is not a C3D file that can be read"):
        reader.read(path)
