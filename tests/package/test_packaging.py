"""The built wheel works by itself: from an empty folder, with the repository out of sight.

The wheel is made from the sdist, so that this also shows the sdist to be complete. It is installed
without its dependencies into a fresh environment that sees those of the one the tests run in:
quick, and nothing is fetched.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import sysconfig
import tarfile
import tomllib
import zipfile
from dataclasses import dataclass
from pathlib import Path

import pytest
from pages import blocks_of

from abs_engine.io.assets import read_image
from abs_engine.io.video import Frame as Image
from abs_engine.io.video import VideoWriter
from abs_engine.tracking.runs.record import load_run

ROOT = Path(__file__).resolve().parents[2]
VERSION = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]["version"]
OWN_LOOPS = "pixel_kernels.py"
UNSEEN = "av", "cv2", "dask", "distributed", "matplotlib", "numba", "plotly", "scipy", "skimage"
"""Packages whose types no result of `track` has; to read them takes half of mypy's time."""


def _run(*command: str | Path, cwd: Path) -> subprocess.CompletedProcess[str]:
    environment = {k: v for k, v in os.environ.items() if not k.startswith("PYTHON")}
    return subprocess.run(
        [str(word) for word in command],
        cwd=cwd,
        env=environment,
        capture_output=True,
        text=True,
        check=False,
    )


def _succeed(*command: str | Path, cwd: Path) -> str:
    done = _run(*command, cwd=cwd)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


@dataclass(frozen=True)
class Installed:
    """An environment that holds the wheel, and an empty folder to stand in."""

    environment: Path
    empty: Path
    wheel: Path
    sdist: Path

    def python(self, code: str) -> str:
        return _succeed(self.environment / "bin/python", "-c", code, cwd=self.empty).strip()


@pytest.fixture(scope="module")
def installed(tmp_path_factory) -> Installed:
    base = tmp_path_factory.mktemp("packaging")
    dist, environment, empty = base / "dist", base / "environment", base / "empty"
    empty.mkdir()
    _succeed(sys.executable, "-m", "build", "--no-isolation", "--outdir", dist, ROOT, cwd=empty)
    (wheel,), (sdist,) = dist.glob("*.whl"), dist.glob("*.tar.gz")

    _succeed(sys.executable, "-m", "venv", "--without-pip", environment, cwd=empty)
    python = environment / "bin/python"
    pip = [sys.executable, "-m", "pip", "--python", python, "--disable-pip-version-check"]
    _succeed(*pip, "install", "--no-deps", "--no-index", wheel, cwd=empty)
    # A .pth line adds a folder without reading the .pth files in it: the dependencies are seen,
    # the editable installation of the repository is not.
    (packages,) = environment.glob("lib/python3*/site-packages")
    (packages / "dependencies.pth").write_text(sysconfig.get_path("purelib") + "\n")
    return Installed(environment, empty, wheel, sdist)


def test_what_is_imported_is_the_wheel(installed):
    where = Path(installed.python("import abs_engine; print(abs_engine.__file__)"))
    assert where.is_relative_to(installed.environment)
    assert str(ROOT) not in installed.python("import sys; print(sys.path)").replace(
        sysconfig.get_path("purelib"), ""
    )


def test_every_module_of_the_wheel_can_be_imported(installed):
    code = (
        "import importlib, pkgutil, abs_engine\n"
        "names = [m.name for m in pkgutil.walk_packages(abs_engine.__path__, 'abs_engine.')]\n"
        "for name in names:\n"
        "    if not name.endswith('__main__'):\n"
        "        importlib.import_module(name)\n"
        "print(len(names))"
    )
    assert int(installed.python(code)) > 10


def test_shaders_are_loaded_from_the_wheel(installed):
    code = (
        "from abs_engine.render import shaders\n"
        "folder = shaders.shader_folder()\n"
        "print(folder)\n"
        "for file in folder.iterdir():\n"
        "    assert shaders.load(file.name).text\n"
    )
    assert Path(installed.python(code)).is_relative_to(installed.environment)


def shipped_folders():
    """The folders that the wheel is to hold besides the package."""
    wheel = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["hatch"]["build"]
    folders = list(wheel["targets"]["wheel"]["force-include"])
    assert {"shaders", "assets/speaker", "assets/population"} <= set(folders)
    return folders


def test_the_wheel_holds_shaders_and_assets_as_they_are_in_the_repository(installed):
    with zipfile.ZipFile(installed.wheel) as wheel:
        for folder in shipped_folders():
            files = [file for file in (ROOT / folder).rglob("*") if file.is_file()]
            assert files
            for file in files:
                packed = wheel.read(f"abs_engine/_data/{file.relative_to(ROOT).as_posix()}")
                assert packed == file.read_bytes()
        names = wheel.namelist()
        for licence in (
            "LICENSE",
            "assets/detector/LICENSE.txt",
            "assets/population/LICENSE.txt",
            "assets/postures/LICENSE.txt",
            "assets/speaker/LICENSE.txt",
        ):
            assert f"abs_engine-{VERSION}.dist-info/licenses/{licence}" in names
        assert not [n for n in names if "__pycache__" in n or n.startswith(("tests", "shaders"))]


def test_the_sdist_holds_all_that_the_readme_speaks_of(installed):
    with tarfile.open(installed.sdist) as sdist:
        names = {name.partition("/")[2] for name in sdist.getnames()}
    for name in (
        ".ci/run",
        "CHANGELOG.md",
        "CITATION.cff",
        "CONTRIBUTING.md",
        "LICENSE",
        "README.md",
        "bootstrap.py",
        "constraints.txt",
        "docs/demo.jpg",
        "docs/measured.md",
        "examples/new_term.py",
        "mkdocs.yml",
        "pyproject.toml",
        "run",
        "tests/package/test_packaging.py",
    ):
        assert name in names
    assert not [name for name in names if name.startswith((".venv", "runs/"))]


def test_ten_lines_of_a_user_pass_mypy_strict(installed, tmp_path):
    """Errors in other lines are found: the wheel's types are not Any."""
    (block,) = [b for b in blocks_of(ROOT / "README.md") if b.language == "python"]
    assert len(block.text.splitlines()) <= 10
    wrong = 'import abs_engine\nwidth: str = abs_engine.track("a.mp4").width\n'
    for name, text in {"own.py": block.text, "wrong.py": wrong}.items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    aside = "".join(f"[mypy-{name}.*]\nfollow_imports = skip\n" for name in UNSEEN)
    (tmp_path / "mypy.ini").write_text(f"[mypy]\n{aside}", encoding="utf-8")
    words = ["--strict", "--python-executable", installed.environment / "bin/python"]
    done = _run(sys.executable, "-m", "mypy", *words, "own.py", "wrong.py", cwd=tmp_path)
    error, found = done.stdout.splitlines()
    assert error.startswith("wrong.py:2: error: Incompatible types in assignment")
    assert found == "Found 1 error in 1 file (checked 2 source files)"


def test_version_is_that_of_the_project(installed):
    program = installed.environment / "bin/abs-engine"
    assert _succeed(program, "--version", cwd=installed.empty).strip() == f"abs-engine {VERSION}"


def test_the_bundled_speaker_is_loaded_from_the_wheel(installed):
    code = (
        "from abs_engine import load_speaker\n"
        "speaker = load_speaker()\n"
        "print(len(speaker.people), speaker.texture('clara').shape[2])"
    )
    people, channels = installed.python(code).split()
    assert int(people) >= 3
    assert channels == "3"


@pytest.fixture(scope="module")
def compiled(installed) -> Path:
    """The folder of the wheel's package; most loops that the repository has compiled lie there.

    They are not compiled again, but for those over pixels, so that the wheel compiles some of its
    own. numba takes what was compiled from a source of the same time and size; here it also has the
    same bytes.
    """
    (wheel,) = installed.environment.glob("lib/python3*/site-packages/abs_engine")
    for index in (ROOT / "abs_engine").rglob("__pycache__/*.nbi"):
        sources, folder = index.parents[1], index.parents[1].relative_to(ROOT / "abs_engine")
        source = sources / f"{index.name.partition('.')[0]}.py"
        own = wheel / folder / source.name
        if source.name == OWN_LOOPS or not source.is_file():
            continue
        if own.read_bytes() != source.read_bytes():
            continue
        os.utime(own, ns=(source.stat().st_atime_ns, source.stat().st_mtime_ns))
        (wheel / folder / "__pycache__").mkdir(exist_ok=True)
        for file in index.parent.glob(f"{index.stem}.*.nb?"):
            shutil.copy(file, wheel / folder / "__pycache__")
        shutil.copy(index, wheel / folder / "__pycache__")
    return wheel


@pytest.fixture(scope="module")
def picture(installed, compiled, tmp_path_factory) -> Image:
    """A face that the wheel has drawn."""
    program, file = installed.environment / "bin/abs-engine", tmp_path_factory.mktemp("p") / "p.png"
    words = ["-o", file, "--size", "256", "256", "--renderer", "cpu"]
    _succeed(program, "render", *words, cwd=installed.empty)
    return read_image(file)


def test_a_picture_is_rendered_without_the_repository(installed, compiled, picture):
    assert picture.shape == (256, 256, 3)
    assert picture.std() > 20  # a head before a background
    assert list(compiled.rglob(f"{Path(OWN_LOOPS).stem}.*.nbi"))
    assert not list(installed.empty.iterdir())


def test_a_clip_is_tracked_without_the_repository(installed, picture, tmp_path):
    """The whole way on frames that stand still, not its precision."""
    with VideoWriter(tmp_path / "clip.mp4", (256, 256), 25.0) as writer:
        for _ in range(3):
            writer.write(picture)
    program, run = installed.environment / "bin/abs-engine", tmp_path / "run"
    words = [tmp_path / "clip.mp4", "-o", run, "--renderer", "cpu", "--person", "clara"]
    _succeed(program, "track", *words, cwd=installed.empty)
    assert {"results.csv", "results.npz", "run.json", "overlay.mp4", "contact_sheet.png"} <= {
        path.name for path in run.iterdir()
    }
    assert load_run(run)["found"].all()
    assert not list(installed.empty.iterdir())


def test_doctor_runs_without_the_repository(installed):
    done = _run(installed.environment / "bin/abs-engine", "doctor", cwd=installed.empty)
    assert "Traceback" not in done.stderr
    assert "usage:" not in done.stderr
    assert done.stdout.strip()
    assert not list(installed.empty.iterdir())
