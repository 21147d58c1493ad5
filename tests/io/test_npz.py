"""Archives that are damaged end in one named error, wherever they are cut or changed."""

from __future__ import annotations

import io
import lzma
import zipfile
from pathlib import Path

import numpy as np
import pytest

from abs_engine.core.errors import InputFileError, ModelFormatError, OutputError
from abs_engine.io import npz
from abs_engine.io.arrays import text
from abs_engine.io.npz import read_kind, read_npz, write_npz

KIND, VERSION = "abs_engine.test", 3


@pytest.fixture
def whole(tmp_path: Path) -> Path:
    path = tmp_path / "whole.npz"
    write_npz(path, KIND, VERSION, {"numbers": np.random.default_rng(0).normal(size=4000)})
    return path


def test_what_is_written_comes_back_and_is_not_written_over(whole: Path):
    assert read_npz(whole, KIND, VERSION)["numbers"].shape == (4000,)
    with pytest.raises(OutputError, match="exists already"):
        write_npz(whole, KIND, VERSION, {})
    with pytest.raises(ModelFormatError, match="version 3"):
        read_npz(whole, KIND, 4)


def test_text_that_is_no_utf_8_is_written_with_escapes(tmp_path: Path):
    given = {"source": "lat\udce4n.mp4", "names": np.array([["a", "\udcff"]])}
    write_npz(tmp_path / "a.npz", KIND, VERSION, given)
    layout = {"source": text(), "names": text("N", "M")}
    found = read_npz(tmp_path / "a.npz", KIND, VERSION, layout)
    assert str(found["source"]) == r"lat\udce4n.mp4"
    assert found["names"].tolist() == [["a", r"\udcff"]]


@pytest.mark.parametrize("failures", [1, 2])
def test_a_header_that_python_failed_to_parse_is_read_again(whole: Path, monkeypatch, failures):
    parse, failed = npz.np.lib.format.read_array, []

    def rarely(*given, **named):
        if len(failed) < failures:
            failed.append(1)
            raise SystemError("AST constructor recursion depth mismatch (before=90, after=105)")
        return parse(*given, **named)

    monkeypatch.setattr("numpy.lib._npyio_impl.format.read_array", rarely)
    assert read_npz(whole, KIND, VERSION)["numbers"].shape == (4000,)
    assert len(failed) == failures


def _damaged(whole: Path, flag: int | None) -> bytes:
    """The archive with bytes of its packed numbers changed, or its entries said to be of a kind."""
    content = bytearray(whole.read_bytes())
    if flag is None:
        with zipfile.ZipFile(whole) as archive:
            start = archive.getinfo("numbers.npy").header_offset + 120
        content[start : start + 64] = bytes(range(64))
        return bytes(content)
    central = content.index(b"PK\x01\x02")
    content[central + flag] = 1 if flag == 8 else 9
    return bytes(content)


@pytest.mark.parametrize("name", ["head.glb", "Head.OBJ"])
def test_a_mesh_in_place_of_a_head_is_named(tmp_path: Path, name: str):
    (tmp_path / name).write_bytes(b"glTF")
    for read in (read_kind, lambda path: read_npz(path, KIND, VERSION)):
        with pytest.raises(InputFileError, match=f"{name} is a mesh.*; .*'abs-engine import'"):
            read(tmp_path / name)


@pytest.mark.parametrize("flag", [None, 8, 10], ids=["deflate", "encrypted", "method"])
def test_a_damaged_archive_is_named(whole: Path, tmp_path: Path, flag: int | None):
    bad = tmp_path / "bad.npz"
    bad.write_bytes(_damaged(whole, flag))
    with pytest.raises(InputFileError, match=r"bad\.npz is not an NPZ file"):
        read_npz(bad, KIND, VERSION)


def test_an_archive_that_breaks_off_is_named(whole: Path, tmp_path: Path):
    content = whole.read_bytes()
    for share in (0.0, 0.01, 0.5, 0.99):
        cut = tmp_path / "cut.npz"
        cut.write_bytes(content[: int(share * len(content))])
        with pytest.raises(InputFileError, match="is not an NPZ file"):
            read_npz(cut, KIND, VERSION)


def _archive(path: Path, entry: bytes, packed: int = zipfile.ZIP_STORED) -> Path:
    with zipfile.ZipFile(path, "w", packed) as archive:
        archive.writestr("numbers.npy", entry)
    return path


def test_an_archive_that_claims_more_than_memory_holds_is_named(tmp_path: Path):
    for shape in ((10**12,), (10**9, 10**9, 10**9), (10**30,)):
        header = io.BytesIO()
        told = {"descr": "<f8", "fortran_order": False, "shape": shape}
        np.lib.format.write_array_header_1_0(header, told)
        path = _archive(tmp_path / "large.npz", header.getvalue() + bytes(64))
        with pytest.raises(InputFileError, match=r"large\.npz is not an NPZ file"):
            read_npz(path, KIND, VERSION)


def test_an_archive_whose_lzma_is_damaged_is_named(tmp_path: Path):
    numbers = io.BytesIO()
    np.save(numbers, np.random.default_rng(0).normal(size=4000))
    path = _archive(tmp_path / "bad.npz", numbers.getvalue(), zipfile.ZIP_LZMA)
    content = bytearray(path.read_bytes())
    content[50:20_000] = bytes(19_950)
    path.write_bytes(bytes(content))
    with (
        zipfile.ZipFile(path) as archive,
        pytest.raises(lzma.LZMAError),
        archive.open("numbers.npy") as entry,
    ):
        entry.read()
    with pytest.raises(InputFileError, match="is not an NPZ file"):
        read_npz(path, KIND, VERSION)


def test_complex_numbers_are_refused(tmp_path: Path):
    np.savez(tmp_path / "c.npz", format=KIND, version=VERSION, numbers=np.array([1 + 2j]))
    with pytest.raises(ModelFormatError, match=r"'numbers' in .* is complex; give"):
        read_npz(tmp_path / "c.npz", KIND, VERSION)


def test_what_unpacks_to_more_than_is_read_is_refused_by_the_directory(tmp_path, monkeypatch):
    monkeypatch.setattr(npz, "LARGEST", 10_000)
    kind = {"format": KIND, "version": VERSION}
    np.savez(tmp_path / "whole.npz", **kind, numbers=np.zeros(10_000))
    assert read_npz(tmp_path / "whole.npz", KIND, VERSION)["numbers"].size == 10_000
    np.savez_compressed(tmp_path / "bomb.npz", **kind, numbers=np.zeros(10_000))
    monkeypatch.setattr(np, "load", lambda *_, **__: pytest.fail("was unpacked"))
    for read in (lambda p: read_npz(p, KIND, VERSION), npz.read_kind):
        with pytest.raises(InputFileError, match="unpacks to"):
            read(tmp_path / "bomb.npz")


def test_a_header_that_is_not_closed_is_refused(tmp_path):
    path = tmp_path / "open.npz"
    made = io.BytesIO()
    np.save(made, np.zeros(3))
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("numbers.npy", made.getvalue().replace(b"}", b" "))
    with pytest.raises(InputFileError, match="not an NPZ file"):
        read_npz(path, KIND, VERSION)
