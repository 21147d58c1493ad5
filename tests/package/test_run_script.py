"""What `./run` decides on machines that lack something, without installing anything."""

from __future__ import annotations

import importlib.util
import json
import os
import shutil
import subprocess
import sys
import threading
from collections.abc import Sequence
from pathlib import Path

import pytest
from conftest import FIRST, TESTS

ROOT = Path(__file__).resolve().parents[2]


def _load_bootstrap():
    spec = importlib.util.spec_from_file_location("bootstrap", ROOT / "bootstrap.py")
    module = importlib.util.module_from_spec(spec)
    sys.modules["bootstrap"] = module
    spec.loader.exec_module(module)
    return module


bootstrap = _load_bootstrap()


class SimulatedMachine(bootstrap.Machine):
    """A bare machine whose commands are written down instead of run."""

    def __init__(self, root: Path, *, rights: bool, lacks: Sequence[str] = (), apt: bool = True):
        super().__init__(root)
        shutil.copy(ROOT / "pyproject.toml", root)
        shutil.copy(ROOT / "constraints.txt", root)
        self.rights = rights
        self.apt = apt
        self.lacks = set(lacks)  # "ensurepip", libraries, or "context"
        self.cannot_install: set[str] = set()
        self.interrupt_pip = False
        self.commands: list[str] = []
        self.pip_settings = "global.extra-index-url='https://example.org/more'"
        self.complains: set[str] = set()  # linters, or "pytest"

    def show(self, command, *without):
        self.without = without
        self.commands.append(" ".join(command))
        return int("pytest" in self.complains)

    def run(self, command, **environment):
        line = " ".join(str(word) for word in command)
        self.commands.append(line)
        if Path(command[0]).name in self.complains:
            return 1, "a complaint"
        if "-m venv" in line:
            python = self.venv / "bin/python"
            python.parent.mkdir(parents=True, exist_ok=True)
            python.touch()
        if "pip config" in line:
            return 0, self.pip_settings
        if "-m uv" in line and "uv" in self.cannot_install:
            return 2, "no network"
        if "-m pip" in line:
            (self.venv / "half-installed").touch()
            if self.interrupt_pip:
                raise KeyboardInterrupt
            if "pip" in self.cannot_install:
                return 1, "no network"
        if "apt-get" in line and " install " in line:
            if any(name in line for name in self.cannot_install):
                return 100, "E: Unable to locate package"
            self.lacks.clear()
        return 0, ""

    def can_make_venv(self):
        return "ensurepip" not in self.lacks

    def loads(self, library):
        return library not in self.lacks

    def finds(self, program):
        return program not in self.lacks

    def context_error(self):
        return "cannot open a display" if "context" in self.lacks else ""

    def has_apt(self):
        return self.apt

    def becomes_root(self):
        return [] if self.rights else None

    def count(self, part: str) -> int:
        return sum(part in line for line in self.commands)


NO_GL = bootstrap.GL_LIBRARIES
ALL_PACKAGES = " ".join([bootstrap.VENV_PACKAGE, *bootstrap.GL_PACKAGES])


@pytest.mark.parametrize(
    ("lacks", "packages"),
    [
        (["ensurepip"], bootstrap.VENV_PACKAGE),
        (NO_GL, " ".join(bootstrap.GL_PACKAGES)),
        (["libGL.so.1"], " ".join(bootstrap.GL_PACKAGES)),
        (["ensurepip", *NO_GL], ALL_PACKAGES),
    ],
)
def test_without_rights_the_one_line_to_type_is_given_and_nothing_made(tmp_path, lacks, packages):
    machine = SimulatedMachine(tmp_path, rights=False, lacks=lacks)
    with pytest.raises(bootstrap.SetupError) as stop:
        bootstrap.prepare(machine, dev=False)
    assert stop.value.status == 2
    line = f"sudo apt-get update && sudo apt-get install -y {packages}"
    assert str(stop.value).splitlines()[1:] == [line]
    assert not machine.venv.exists()
    assert machine.commands == []


@pytest.fixture(autouse=True)
def what_is_compiled_is_kept(monkeypatch):
    monkeypatch.delenv("PYTHONDONTWRITEBYTECODE", raising=False)


def test_with_rights_everything_is_installed_in_order(tmp_path):
    machine = SimulatedMachine(tmp_path, rights=True, lacks=["ensurepip", *NO_GL])
    bootstrap.prepare(machine, dev=False)
    update, install, venv, _, pip, uv = machine.commands
    assert update.endswith("update")
    assert install.endswith(f"install -y --no-install-recommends {ALL_PACKAGES}")
    assert "-m venv" in venv
    assert pip.endswith("--only-binary=uv uv")
    assert uv.endswith("-b constraints.txt -e .")
    assert bootstrap.is_ready(machine, dev=False)


@pytest.mark.parametrize("tool", ["uv", "pip"])
@pytest.mark.parametrize("keeps", [True, False])
def test_it_is_compiled_at_once_only_where_python_keeps_nothing(tmp_path, monkeypatch, tool, keeps):
    monkeypatch.setenv("PYTHONDONTWRITEBYTECODE", "" if keeps else "1")
    machine = SimulatedMachine(tmp_path, rights=True)
    machine.cannot_install = {"uv"} if tool == "pip" else set()
    bootstrap.prepare(machine, dev=False)
    own = [line for line in machine.commands if line.endswith("-m compileall -q abs_engine")]
    *_, installing = (line for line in machine.commands if line not in own)
    assert ("--no-compile" in installing) == (tool == "pip" and keeps)
    assert ("--compile-bytecode" in installing) == (tool == "uv" and not keeps)
    assert len(own) == (not keeps)


def test_second_call_installs_nothing(tmp_path):
    machine = SimulatedMachine(tmp_path, rights=True)
    bootstrap.prepare(machine, dev=True)
    machine.commands.clear()
    bootstrap.prepare(machine, dev=True)
    bootstrap.prepare(machine, dev=False)
    assert machine.commands == []


def test_tests_after_the_demo_only_add_the_developers_tools(tmp_path):
    machine = SimulatedMachine(tmp_path, rights=True)
    bootstrap.prepare(machine, dev=False)
    assert not bootstrap.is_ready(machine, dev=True)
    bootstrap.prepare(machine, dev=True)
    assert machine.count("-m venv") == 1
    assert machine.commands[-1].endswith("-e .[dev]")


@pytest.mark.parametrize(
    ("file", "old", "new", "stays"),
    [
        ("constraints.txt", "numpy==", "numpy==0.", False),
        ("pyproject.toml", "numpy>=", "numpy>=0.", False),
        ("pyproject.toml", "line-length = 100", "line-length = 99", True),
    ],
)
def test_environment_is_made_again_when_the_packages_change(tmp_path, file, old, new, stays):
    machine = SimulatedMachine(tmp_path, rights=True)
    bootstrap.prepare(machine, dev=False)
    text = (tmp_path / file).read_text()
    assert old in text
    (tmp_path / file).write_text(text.replace(old, new))
    assert bootstrap.is_ready(machine, dev=False) == stays
    if not stays:
        (machine.venv / "leftover").touch()
        bootstrap.prepare(machine, dev=False)
        assert not (machine.venv / "leftover").exists()


def test_an_environment_that_was_moved_is_not_taken_for_complete(tmp_path):
    first, second = tmp_path / "first", tmp_path / "second"
    first.mkdir()
    bootstrap.prepare(SimulatedMachine(first, rights=True), dev=False)
    first.rename(second)
    assert not bootstrap.is_ready(SimulatedMachine(second, rights=True), dev=False)


@pytest.mark.parametrize("had_demo", [False, True])
def test_interrupted_setup_starts_again(tmp_path, had_demo):
    machine = SimulatedMachine(tmp_path, rights=True)
    if had_demo:
        bootstrap.prepare(machine, dev=False)
    machine.interrupt_pip = True
    with pytest.raises(KeyboardInterrupt):
        bootstrap.prepare(machine, dev=True)
    assert not bootstrap.is_ready(machine, dev=False)
    (machine.venv / "leftover").touch()
    machine.interrupt_pip = False
    bootstrap.prepare(machine, dev=True)
    assert bootstrap.is_ready(machine, dev=True)
    assert not (machine.venv / "leftover").exists()


def test_an_environment_without_its_python_is_made_again(tmp_path):
    machine = SimulatedMachine(tmp_path, rights=True)
    bootstrap.prepare(machine, dev=False)
    (machine.venv / "bin/python").unlink()
    assert not bootstrap.is_ready(machine, dev=False)


@pytest.mark.parametrize("text", ["", "unfinished\n", "[]", "{}", '{"fingerprint": 3}'])
def test_a_damaged_stamp_is_no_stamp(tmp_path, text):
    machine = SimulatedMachine(tmp_path, rights=True)
    bootstrap.prepare(machine, dev=False)
    machine.stamp.write_text(text)
    assert not bootstrap.is_ready(machine, dev=False)


def test_somebody_elses_environment_is_left_alone(tmp_path):
    machine = SimulatedMachine(tmp_path, rights=True)
    theirs = machine.venv / "bin/python"
    theirs.parent.mkdir(parents=True)
    theirs.write_text("theirs")
    with pytest.raises(bootstrap.SetupError, match="mv '"):
        bootstrap.prepare(machine, dev=False)
    assert theirs.read_text() == "theirs"
    assert machine.commands == []


def test_pip_installs_where_uv_cannot(tmp_path, capsys):
    machine = SimulatedMachine(tmp_path, rights=True)
    machine.cannot_install.add("uv")
    bootstrap.prepare(machine, dev=False)
    assert machine.commands[-1].endswith("-m pip install --quiet --no-compile -e .")
    assert bootstrap.is_ready(machine, dev=False)
    assert "uv could not install; pip does" in capsys.readouterr().out


@pytest.mark.parametrize(
    "setting", ["global.index-url='https://example.org/own'", ":env:.no-index='1'"]
)
def test_pip_installs_where_it_knows_another_registry(tmp_path, setting):
    machine = SimulatedMachine(tmp_path, rights=True)
    machine.pip_settings = setting
    bootstrap.prepare(machine, dev=False)
    assert machine.count("uv") == 0
    assert machine.commands[-1].endswith("-m pip install --quiet --no-compile -e .")


def test_failed_pip_shows_its_message_and_leaves_no_stamp(tmp_path):
    machine = SimulatedMachine(tmp_path, rights=True)
    machine.cannot_install.add("pip")
    with pytest.raises(bootstrap.SetupError, match="no network") as stop:
        bootstrap.prepare(machine, dev=False)
    assert stop.value.status == 1
    assert not bootstrap.is_ready(machine, dev=False)


def test_failed_apt_shows_its_message_and_the_line(tmp_path):
    machine = SimulatedMachine(tmp_path, rights=True, lacks=NO_GL)
    machine.cannot_install.add("libegl1")
    with pytest.raises(bootstrap.SetupError, match="Unable to locate") as stop:
        bootstrap.prepare(machine, dev=False)
    assert "sudo apt-get install -y libegl1" in str(stop.value)


def test_without_apt_the_packages_are_named(tmp_path):
    machine = SimulatedMachine(tmp_path, rights=True, lacks=NO_GL, apt=False)
    with pytest.raises(bootstrap.SetupError, match="no apt-get") as stop:
        bootstrap.prepare(machine, dev=False)
    assert "libegl1 libgl1-mesa-dri libgl1" in str(stop.value)


def test_tests_go_on_without_osmesa(tmp_path):
    machine = SimulatedMachine(tmp_path, rights=True, lacks=[bootstrap.OSMESA_LIBRARY])
    machine.cannot_install.add(bootstrap.OSMESA_PACKAGE)
    bootstrap.prepare(machine, dev=True)
    assert machine.count(bootstrap.OSMESA_PACKAGE) == 1
    machine.commands.clear()
    bootstrap.prepare(machine, dev=True)
    assert machine.commands == []  # it is not tried at each call


def test_the_demo_does_not_ask_for_osmesa(tmp_path):
    machine = SimulatedMachine(tmp_path, rights=True, lacks=[bootstrap.OSMESA_LIBRARY])
    bootstrap.prepare(machine, dev=False)
    assert machine.count("apt-get") == 0


def test_with_rights_chromium_is_installed_for_the_tests_only(tmp_path):
    machine = SimulatedMachine(tmp_path, rights=True, lacks=bootstrap.BROWSER)
    bootstrap.prepare(machine, dev=False)
    assert machine.count("apt-get") == 0
    bootstrap.prepare(machine, dev=True)
    assert machine.count("install -y --no-install-recommends chromium chromium-driver") == 1


@pytest.mark.parametrize("lacks", bootstrap.BROWSER)
def test_tests_go_on_without_chromium(tmp_path, lacks, capsys):
    machine = SimulatedMachine(tmp_path, rights=False, lacks=[lacks])
    bootstrap.prepare(machine, dev=True)
    assert machine.count("apt-get") == 0
    assert "in a browser are left out" in capsys.readouterr().out
    assert bootstrap.is_ready(machine, dev=True)


def test_linters_need_no_chromium(tmp_path):
    machine = SimulatedMachine(tmp_path, rights=True, lacks=bootstrap.BROWSER)
    bootstrap.prepare(machine, dev=True, gl=False)
    assert machine.count("apt-get") == 0


def test_libraries_that_load_but_give_no_context_bring_mesa(tmp_path):
    machine = SimulatedMachine(tmp_path, rights=True, lacks=["context"])
    bootstrap.prepare(machine, dev=False)
    assert machine.count("install -y --no-install-recommends libegl1") == 1


def test_no_context_even_with_mesa_points_to_the_doctor(tmp_path):
    machine = SimulatedMachine(tmp_path, rights=True)
    machine.context_error = lambda: "cannot open a display"
    with pytest.raises(bootstrap.SetupError, match="abs-engine doctor"):
        bootstrap.prepare(machine, dev=False)


def test_linters_need_no_opengl(tmp_path):
    machine = SimulatedMachine(tmp_path, rights=False, lacks=["context", *NO_GL])
    bootstrap.prepare(machine, dev=True, gl=False)
    assert bootstrap.is_ready(machine, dev=True)


def test_a_stop_is_told_in_lines_and_not_in_a_traceback(tmp_path, capsys):
    machine = SimulatedMachine(tmp_path, rights=False, lacks=NO_GL)
    assert bootstrap.main(["demo"], machine) == 2
    shown = capsys.readouterr().err
    assert shown.startswith("run: no OpenGL loads. Type this line")
    assert len(shown.splitlines()) == 2


def test_linters_all_run_although_one_complains(tmp_path, capsys):
    machine = SimulatedMachine(tmp_path, rights=False)
    machine.complains.add("mypy")
    assert bootstrap.lint(bootstrap.check(machine, one) for one in bootstrap.LINTERS) == 1
    shown = capsys.readouterr().out
    assert shown.count(": ok") == len(bootstrap.LINTERS) - 1
    assert "mypy: FAILED\na complaint" in shown


@pytest.mark.parametrize("complains", ["mypy", "pytest"])
def test_linters_run_beside_the_tests_and_either_may_fail(tmp_path, complains):
    machine = SimulatedMachine(tmp_path, rights=False)
    assert bootstrap.test(machine, ["-x"]) == 0
    assert machine.count("-m pytest") == 1
    assert sum(machine.count(f"bin/{tool}") for tool in ("ruff", "mypy")) == 3
    machine.complains.add(complains)
    assert bootstrap.test(machine, []) == 1
    machine.commands.clear()
    assert bootstrap.test(machine, ["--fast"]) == int(complains == "pytest")
    assert len(machine.commands) == 1


def test_a_linter_that_is_missing_has_failed(tmp_path):
    name, status, output = bootstrap.check(bootstrap.Machine(tmp_path), ("ruff", "check"))
    assert (name, status) == ("ruff check", 1)
    assert "bin/ruff" in output


def test_files_that_begin_first_are_there():
    assert [name for name in FIRST if not (TESTS / name).is_file()] == []


def test_tests_keep_what_python_compiles(tmp_path, monkeypatch, capfd):
    monkeypatch.setenv("PYTHONDONTWRITEBYTECODE", "1")
    command = [sys.executable, "-c", "import sys; print(sys.dont_write_bytecode)"]
    machine = bootstrap.Machine(tmp_path)
    assert machine.show(command) == 0
    assert machine.show(command, "PYTHONDONTWRITEBYTECODE") == 0
    assert capfd.readouterr().out.split() == ["True", "False"]
    simulated = SimulatedMachine(tmp_path, rights=False)
    assert bootstrap.test(simulated, []) == 0
    assert simulated.without == ("PYTHONDONTWRITEBYTECODE",)


def test_no_linter_starts_once_the_tests_were_stopped(tmp_path):
    machine, began = SimulatedMachine(tmp_path, rights=False), threading.Event()

    def run(command):
        machine.commands.append(str(command[0]))
        began.wait(10)
        return 0, ""

    def stop(_command, *_without):
        began.set()
        raise KeyboardInterrupt

    machine.run, machine.show = run, stop
    with pytest.raises(KeyboardInterrupt):
        bootstrap.test(machine, [])
    assert len(machine.commands) < len(bootstrap.LINTERS)


def test_docs_are_built_strictly_and_need_no_opengl(tmp_path, capsys):
    machine = SimulatedMachine(tmp_path, rights=False, lacks=["context", *NO_GL])
    assert bootstrap.main(["docs"], machine) == 0
    assert "mkdocs build --strict" in machine.commands[-1]
    assert capsys.readouterr().out.rstrip().endswith("index.html")


def test_a_warning_of_the_docs_is_shown_and_fails(tmp_path, capsys):
    machine = SimulatedMachine(tmp_path, rights=False)
    machine.run = lambda command, **_: (1, "WARNING -  a page is missing")
    assert bootstrap.docs(machine) == 1
    assert "a page is missing" in capsys.readouterr().out


def test_stamp_holds_no_more_than_it_says(tmp_path):
    machine = SimulatedMachine(tmp_path, rights=True)
    bootstrap.prepare(machine, dev=True)
    stamp = json.loads(machine.stamp.read_text())
    assert stamp == {"fingerprint": bootstrap.fingerprint(machine), "dev": True}
    assert not machine.stamp.with_suffix(".new").exists()


def _run_script(folder: Path, *words: str, **environment: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [str(ROOT / "run"), *words],
        cwd=folder,
        env=os.environ | environment,
        capture_output=True,
        text=True,
        check=False,
    )


@pytest.mark.parametrize("words", [(), ("dmeo",), ("--version",)])
def test_unknown_words_give_the_usage_from_any_folder(tmp_path, words):
    done = _run_script(tmp_path, *words)
    assert done.returncode == 2
    assert done.stderr.startswith("usage: ./run demo")
    assert done.stdout == ""


def test_help_is_no_error(tmp_path):
    done = _run_script(tmp_path, "--help")
    assert done.returncode == 0
    assert done.stdout.startswith("usage: ./run demo")


def test_script_is_found_through_a_link(tmp_path):
    (tmp_path / "linked").symlink_to(ROOT / "run")
    done = subprocess.run(
        [str(tmp_path / "linked"), "--help"], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0


def test_an_old_python_is_told(tmp_path):
    tools = tmp_path / "tools"
    tools.mkdir()
    for name in ("sh", "dirname", "readlink"):
        (tools / name).symlink_to(shutil.which(name))
    old = tools / "python3"
    old.write_text("#!/bin/sh\nexit 1\n")  # as the version check of the script sees 3.10
    old.chmod(0o755)
    done = _run_script(tmp_path, "demo", PATH=str(tools), PYTHON="")
    assert done.returncode == 2
    assert "Python 3.11 or newer is needed" in done.stderr
    assert len(done.stderr.splitlines()) == 1
