"""Compiled loops find a folder that may be written to."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import pytest

from abs_engine.core import compile_cache

VARIABLE, PYCACHE = "NUMBA_CACHE_DIR", "__pycache__"


@pytest.fixture
def writable(monkeypatch, tmp_path):
    """Folders that may be written to; numba is not imported."""
    allowed = set()
    monkeypatch.setattr(compile_cache, "_writable", lambda folder: folder in allowed)
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    monkeypatch.setenv(VARIABLE, "")  # so that it is put back
    monkeypatch.delenv(VARIABLE)
    monkeypatch.setitem(sys.modules, "numba", SimpleNamespace(config=SimpleNamespace(CACHE_DIR="")))
    return allowed


def test_what_numba_would_find_is_left_alone(writable, tmp_path):
    for folder in (tmp_path / "cache" / "numba", Path(compile_cache.__file__).parent / PYCACHE):
        writable.clear()
        writable.add(folder)
        compile_cache.find_cache()
        assert VARIABLE not in os.environ


def test_what_a_user_has_chosen_is_left_alone(writable, tmp_path, monkeypatch):
    writable.add(tmp_path / "own")
    monkeypatch.setenv(VARIABLE, str(tmp_path / "own"))
    compile_cache.find_cache()
    assert os.environ[VARIABLE] == str(tmp_path / "own")


def test_a_user_without_a_home_is_no_error(writable, tmp_path, monkeypatch):
    monkeypatch.delenv("XDG_CACHE_HOME")
    monkeypatch.setattr("os.path.expanduser", lambda path: path)
    compile_cache.find_cache()
    assert os.environ[VARIABLE] == str(tmp_path / f"abs_engine-{os.getuid()}")


def test_without_any_folder_the_package_can_still_be_imported(writable, monkeypatch):
    def fails():
        raise FileNotFoundError(2, "No usable temporary directory found")

    monkeypatch.setattr("tempfile.gettempdir", fails)
    compile_cache.find_cache()
    assert VARIABLE not in os.environ


def test_a_folder_of_ones_own_is_made_where_there_is_none(writable, tmp_path):
    compile_cache.find_cache()
    folder = tmp_path / f"abs_engine-{os.getuid()}"
    assert os.environ[VARIABLE] == str(folder) == sys.modules["numba"].config.CACHE_DIR
    assert folder.stat().st_mode & 0o777 == 0o700
    compile_cache.find_cache()
    assert os.environ[VARIABLE] == str(folder)


@pytest.mark.parametrize("whose", ["open to others", "a link"])
def test_a_folder_that_others_may_write_to_is_not_used(writable, tmp_path, whose):
    folder = tmp_path / f"abs_engine-{os.getuid()}"
    if whose == "a link":
        (tmp_path / "elsewhere").mkdir(mode=0o700)
        folder.symlink_to(tmp_path / "elsewhere")
    else:
        folder.mkdir()
        folder.chmod(0o777)
    compile_cache.find_cache()
    assert os.environ[VARIABLE] != str(folder)
    assert os.stat(os.environ[VARIABLE]).st_mode & 0o077 == 0


def test_a_folder_may_be_written_to_if_it_can_be_made(tmp_path):
    (tmp_path / "file").touch()
    assert compile_cache._writable(tmp_path / "new" / "numba")
    assert not compile_cache._writable(tmp_path / "file" / "numba")


LOOP = """
import numpy as np
from abs_engine.core.facet_loops import unit_normals
print(unit_normals(np.eye(3), np.array([[0, 1, 2]]))[0])
"""


def said(cache: Path, before: str = "") -> str:
    """What a process says that calls a loop."""
    words = [sys.executable, "-c", before + LOOP]
    place = {**os.environ, VARIABLE: str(cache), "PYTHONDONTWRITEBYTECODE": "1"}
    return subprocess.run(words, env=place, check=True, capture_output=True, text=True).stdout


@pytest.mark.parametrize("kind", ["*.nbi", "*.nbc"])
@pytest.mark.parametrize("left", [0, 20])
def test_what_a_crash_left_of_compiled_loops_is_compiled_again(kind, left, tmp_path):
    first = said(tmp_path)
    whole = {path: path.stat().st_size for path in tmp_path.rglob("*.nb?")}
    (damaged,) = tmp_path.rglob(kind)
    damaged.write_bytes(damaged.read_bytes()[:left])
    assert said(tmp_path) == first
    assert {path: path.stat().st_size for path in tmp_path.rglob("*.nb?")} == whole


def test_a_loop_that_the_disk_does_not_take_is_used_all_the_same(tmp_path):
    limit = "import resource; resource.setrlimit(resource.RLIMIT_FSIZE, (9, -1))\n"
    first = said(tmp_path / "full", limit)
    assert not list(tmp_path.rglob("*.nbc"))
    assert said(tmp_path / "other") == first
    assert list(tmp_path.rglob("*.nbc"))


COMPILING = """
import sys
print({"numba.np.arraymath", "scipy.linalg"} & set(sys.modules))
"""


def test_a_loop_that_is_kept_is_loaded_without_what_numba_compiles_with(tmp_path):
    """Half of numba and SciPy's linear algebra took a tenth of a short clip's processor time."""
    place = {**os.environ, VARIABLE: str(tmp_path)}
    words = [sys.executable, "-c", LOOP + COMPILING]
    fresh, kept = (
        subprocess.run(words, env=place, check=True, capture_output=True, text=True).stdout
        for _ in range(2)
    )
    assert "arraymath" in fresh
    assert kept.splitlines() == [fresh.splitlines()[0], "set()"]
