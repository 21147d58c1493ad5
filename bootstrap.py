"""The work of `./run`: sets this machine up, starts the demo, the tests, the linters or the docs.

Only the standard library is used, since nothing else is there yet. Everything is put into `.venv`
beside this file; what is installed outside is Mesa's OpenGL, only where no OpenGL loads, and for
the tests, where the user may, OSMesa and Chromium.
A stamp in `.venv` says for what it was made, and is written last: a set-up that was interrupted is
started again, one that fits is not touched.
"""

from __future__ import annotations

import ctypes
import fcntl
import hashlib
import importlib.util
import json
import os
import platform
import re
import shutil
import subprocess
import sys
import tomllib
from collections.abc import Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import NoReturn

ROOT = Path(__file__).resolve().parent
USAGE = """usage: ./run demo [ARGUMENTS OF abs-engine demo]
       ./run tests [--fast] [ARGUMENTS OF pytest]    linters and tests; --fast: tests only
       ./run lint
       ./run docs                                  build the documentation in site/"""

GL_LIBRARIES = ("libEGL.so.1", "libGL.so.1")  # moderngl loads the first, the studio also the second
GL_PACKAGES = ("libegl1", "libgl1-mesa-dri", "libgl1")
OSMESA_LIBRARY = "libOSMesa.so.8"
OSMESA_PACKAGE = "libosmesa6"  # Mesa 25.1 dropped it: tested where it exists, never required
BROWSER = ("chromium", "chromedriver")  # what opens the report in its tests, never required
BROWSER_PACKAGES = ("chromium", "chromium-driver")
CONSTRAINTS = "constraints.txt"
OTHER_REGISTRY = r"[.](index-url|no-index)="  # in what `pip config list` prints
VENV_PACKAGE = f"python3.{sys.version_info.minor}-venv"

# In a process of its own: a driver may crash, and this one has no moderngl.
CONTEXT_PROBE = "import moderngl; moderngl.create_standalone_context(backend='egl').release()"

APT_GET = ("env", "DEBIAN_FRONTEND=noninteractive", "apt-get", "-o", "DPkg::Lock::Timeout=120")
LINTERS = (
    ("ruff", "check", "--output-format=concise"),
    ("ruff", "format", "--check", "--output-format=concise"),
    ("mypy",),
    ("lint-imports",),
)
# A process for each core, at most four: each has an OpenGL context of its own, which on a CPU
# keeps more than one core busy. A file's tests stay together, so that what they share is made once;
# in the order of `tests/conftest.py`, since the files with the fewest tests take the longest.
PYTEST = (
    *("-m", "pytest", "-q", "-n", "auto", "--maxprocesses=4"),
    *("--dist=loadfile", "--no-loadscope-reorder"),
)


class SetupError(Exception):
    """The set-up cannot go on; the message says what to type.

    Parameters
    ----------
    message : str
        One line that says what is wrong, and one with what to type.
    status : int
        Exit status: 2 when the user has to do something, 1 when a tool failed.
    """

    def __init__(self, message: str, status: int = 2) -> None:
        super().__init__(message)
        self.status = status


def say(line: str) -> None:
    """Print one step, at once."""
    print(f"run: {line}", flush=True)


class Machine:
    """The machine as the set-up sees it; the tests put a simulated one in its place.

    Parameters
    ----------
    root : Path
        The repository.
    """

    def __init__(self, root: Path = ROOT) -> None:
        self.root = root
        self.venv = root / ".venv"
        self.stamp = self.venv / "abs-engine-setup.json"

    def run(self, command: Sequence[str | Path], **environment: str) -> tuple[int, str]:
        """Run a command in the repository; its exit status, and all that it printed."""
        done = subprocess.run(
            [str(word) for word in command],
            cwd=self.root,
            env=os.environ | environment,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            errors="replace",
            check=False,
        )
        return done.returncode, done.stdout

    def show(self, command: Sequence[str], *without: str) -> int:
        """Run a command in the repository that prints by itself; its exit status.

        Environment variables of these names are not passed on.
        """
        environment = {name: value for name, value in os.environ.items() if name not in without}
        return subprocess.run(command, cwd=self.root, env=environment, check=False).returncode

    def can_make_venv(self) -> bool:
        """Whether this Python has `ensurepip`, which Debian keeps in a package of its own."""
        return importlib.util.find_spec("ensurepip") is not None

    def loads(self, library: str) -> bool:
        """Whether the dynamic loader finds a library."""
        try:
            ctypes.CDLL(library)
        except OSError:
            return False
        return True

    def finds(self, program: str) -> bool:
        """Whether a program is on the path."""
        return shutil.which(program) is not None

    def context_error(self) -> str:
        """Reason why the environment's moderngl gives no OpenGL context; empty if it gives one."""
        status, output = self.run([self.venv / "bin/python", "-c", CONTEXT_PROBE])
        if status == 0:
            return ""
        lines = output.strip().splitlines()
        return lines[-1] if lines else f"the probe ended with status {status}"

    def has_apt(self) -> bool:
        """Whether packages come from apt, as on Debian and Ubuntu."""
        return shutil.which("apt-get") is not None

    def becomes_root(self) -> list[str] | None:
        """Words that make a command run as root without a question; None if none do."""
        if os.geteuid() == 0:
            return []
        if shutil.which("sudo") and self.run(["sudo", "-n", "true"])[0] == 0:
            return ["sudo", "-n"]
        return None


def install(machine: Machine, packages: Sequence[str], reason: str) -> None:
    """Install packages of the system, or say which line does it.

    Raises
    ------
    SetupError
        If the user may not, if apt fails, or if there is no apt.
    """
    names = " ".join(packages)
    if not machine.has_apt():
        raise SetupError(
            f"{reason}, and this system has no apt-get\n     Install what Debian calls: {names}"
        )
    line = f"sudo apt-get update && sudo apt-get install -y {names}"
    root = machine.becomes_root()
    if root is None:
        raise SetupError(f"{reason}. Type this line, then ./run again:\n{line}")
    say(f"{reason}: installing {names}")
    apt = [*root, *APT_GET]
    machine.run([*apt, "update"])  # may fail for one source of many; the install decides
    status, output = machine.run([*apt, "install", "-y", "--no-install-recommends", *packages])
    if status != 0:
        raise SetupError(f"{output}\napt-get failed (see above). Try this line yourself:\n{line}")


def fingerprint(machine: Machine) -> str:
    """Hash of all that decides what `.venv` holds: packages, versions, Python, and the place."""
    project = tomllib.loads((machine.root / "pyproject.toml").read_text("utf-8"))
    parts = [
        json.dumps([project["build-system"], project["project"]], sort_keys=True),
        (machine.root / "constraints.txt").read_text("utf-8"),
        f"{platform.python_implementation()} {platform.python_version()} {platform.machine()}",
        str(machine.root),  # the scripts in .venv/bin hold absolute paths
    ]
    return hashlib.sha256("\0".join(parts).encode()).hexdigest()


def read_stamp(machine: Machine) -> dict[str, object]:
    """The stamp of the last set-up; empty when it never ended or was made for something else."""
    try:
        stamp = json.loads(machine.stamp.read_text("utf-8"))
    except (OSError, ValueError):
        return {}
    fits = isinstance(stamp, dict) and stamp.get("fingerprint") == fingerprint(machine)
    return stamp if fits and (machine.venv / "bin/python").exists() else {}


def is_ready(machine: Machine, dev: bool) -> bool:
    """Whether `.venv` is complete for the demo or, with `dev`, for tests and linters."""
    stamp = read_stamp(machine)
    return bool(stamp) and (not dev or stamp.get("dev") is True)


def make_environment(machine: Machine, dev: bool) -> None:
    """Make `.venv`, or add the developers' tools to it.

    Raises
    ------
    SetupError
        If `.venv` is somebody else's, or venv or pip fails.
    """
    adding = bool(read_stamp(machine))
    if machine.venv.is_dir() and any(machine.venv.iterdir()) and not machine.stamp.exists():
        raise SetupError(
            f"{machine.venv} was not made by ./run. Type this line, then ./run again:\n"
            f"mv '{machine.venv}' '{machine.venv}-old'"
        )
    machine.venv.mkdir(exist_ok=True)
    machine.stamp.write_text("unfinished\n", "utf-8")
    if not adding:
        say("making the virtual environment .venv")
        for entry in machine.venv.iterdir():
            if entry.is_dir() and not entry.is_symlink():
                shutil.rmtree(entry)
            elif entry != machine.stamp:
                entry.unlink()
        status, output = machine.run([Path(sys.executable).resolve(), "-m", "venv", machine.venv])
        if status != 0:
            raise SetupError(f"{output}\nPython could not make .venv (see above)", 1)
    what = "the package and the developers' tools" if dev else "the package"
    say(f"installing {what} into .venv (a minute or two the first time)")
    # Python compiles what it imports as it runs, which takes less than to compile all there is;
    # where it is told to keep nothing, each start would do it again. Tests let it keep.
    compiled = not dev and bool(os.environ.get("PYTHONDONTWRITEBYTECODE"))
    status, output = install_into(machine, ".[dev]" if dev else ".", compiled)
    if status != 0:
        raise SetupError(
            f"{output}\npip failed (see above): check the network, then ./run again", 1
        )
    if compiled:
        # Installers leave out what is used where it lies. It only saves time, so it may fail.
        machine.run([machine.venv / "bin/python", "-m", "compileall", "-q", "abs_engine"])
    unfinished = machine.stamp.with_suffix(".new")
    unfinished.write_text(json.dumps({"fingerprint": fingerprint(machine), "dev": dev}), "utf-8")
    unfinished.replace(machine.stamp)


def install_into(machine: Machine, project: str, compiled: bool) -> tuple[int, str]:
    """Install the project into `.venv`, `compiled` or not; the installer's exit status and output.

    uv takes a third of pip's time, but does not read pip's settings: where these name another
    registry, and where uv fails, pip installs.
    """
    python = str(machine.venv / "bin/python")
    pip = [python, "-m", "pip", "install", "--quiet"]
    # By environment, so that they bind what packages are built with as well; relative, since
    # pip splits the value at blanks. The second is how newer pips call it.
    bound = {
        "PIP_DISABLE_PIP_VERSION_CHECK": "1",
        "PIP_CONSTRAINT": CONSTRAINTS,
        "PIP_BUILD_CONSTRAINT": CONSTRAINTS,
    }
    _, settings = machine.run([python, "-m", "pip", "config", "list"])
    if not re.search(OTHER_REGISTRY, settings):
        status, _ = machine.run([*pip, "--retries=1", "--only-binary=uv", "uv"], **bound)
        if status == 0:
            bounds = ["-c", CONSTRAINTS, "-b", CONSTRAINTS]
            uv = [python, "-m", "uv", "pip", "install", "--quiet", "--python", python, *bounds]
            words = [*uv, *(["--compile-bytecode"] if compiled else []), "-e", project]
            # pip trusts whom the system trusts, where a proxy signs for everybody, too
            status, output = machine.run(words, UV_HTTP_RETRIES="1", UV_SYSTEM_CERTS="1")
        if status == 0:
            return status, output
        say("uv could not install; pip does, which takes longer")
    return machine.run([*pip, *([] if compiled else ["--no-compile"]), "-e", project], **bound)


def prepare(machine: Machine, dev: bool, gl: bool = True) -> None:
    """Bring the machine to where the demo, the tests or (without `gl`) the linters run.

    Raises
    ------
    SetupError
        If something is missing that may not or cannot be installed.
    """
    fresh = not is_ready(machine, dev)
    packages: list[str] = []
    reasons: list[str] = []
    if fresh and not machine.can_make_venv():
        packages.append(VENV_PACKAGE)
        reasons.append("Python cannot make virtual environments")
    if gl and not all(machine.loads(library) for library in GL_LIBRARIES):
        packages.extend(GL_PACKAGES)
        reasons.append("no OpenGL loads")
    if packages:
        install(machine, packages, " and ".join(reasons))
    if fresh:
        make_environment(machine, dev)
    if gl:
        require_context(machine, installed="libegl1" in packages)
        if fresh and dev and not machine.loads(OSMESA_LIBRARY):
            offer_osmesa(machine)
        if fresh and dev and not all(machine.finds(program) for program in BROWSER):
            offer_browser(machine)


def require_context(machine: Machine, installed: bool) -> None:
    """Make a real OpenGL context; install Mesa if there is none and that was not just done.

    Raises
    ------
    SetupError
        If there is none in the end.
    """
    error = machine.context_error()
    if error and not installed:
        install(machine, GL_PACKAGES, f"OpenGL loads but gives no context ({error})")
        error = machine.context_error()
    if error:
        raise SetupError(
            f"Mesa is installed, yet no OpenGL context can be made: {error}\n"
            f"Type: {machine.venv}/bin/abs-engine doctor"
        )


def offer_osmesa(machine: Machine) -> None:
    """Install OSMesa for its tests where that can be done; go on in any case."""
    try:
        install(machine, [OSMESA_PACKAGE], "libOSMesa, the last resort of three, is not here")
    except SetupError:
        say("libOSMesa cannot be installed here; its tests are left out")


def offer_browser(machine: Machine) -> None:
    """Install Chromium for the report's tests where that can be done; go on in any case."""
    try:
        install(machine, BROWSER_PACKAGES, "Chromium, which the report is tested in, is not here")
    except SetupError:
        say("Chromium cannot be installed here; the report's tests in a browser are left out")


def check(machine: Machine, linter: Sequence[str]) -> tuple[str, int, str]:
    """Name, exit status and output of a linter."""
    tool, *arguments = linter
    name = " ".join([tool, *(word for word in arguments if not word.startswith("-"))])
    try:
        return (name, *machine.run([machine.venv / "bin" / tool, *arguments]))
    except OSError as error:
        return name, 1, str(error)


def lint(checked: Iterable[tuple[str, int, str]]) -> int:
    """Print what each linter found, on one line unless it complains; 0 if all are content."""
    failed = 0
    for name, status, output in checked:
        say(f"{name}: {'ok' if status == 0 else 'FAILED'}")
        if status != 0:
            print(output, flush=True)
            failed = 1
    return failed


def test(machine: Machine, arguments: Sequence[str]) -> int:
    """Run tests, and linters beside them, all of them even when one fails; the exit status."""
    selection = [word for word in arguments if word != "--fast"]
    command = [str(machine.venv / "bin/python"), *PYTEST, *selection]
    beside = ThreadPoolExecutor(1)
    try:
        linters = () if "--fast" in arguments else LINTERS
        checked = [beside.submit(check, machine, linter) for linter in linters]
        # The tests start hundreds of commands: each would compile the package anew.
        status = machine.show(command, "PYTHONDONTWRITEBYTECODE")
        failed = lint(one.result() for one in checked)
    finally:
        beside.shutdown(cancel_futures=True)  # stopped by Ctrl-C, no further linter starts
    return status or failed


def docs(machine: Machine) -> int:
    """Build the documentation; a warning is a failure, as in the tests."""
    status, output = machine.run(
        [machine.venv / "bin/mkdocs", "build", "--strict"], NO_MKDOCS_2_WARNING="1"
    )
    if status != 0:
        print(output, flush=True)
        say("the documentation was NOT built")
        return 1
    say(f"the documentation is in {machine.root / 'site' / 'index.html'}")
    return 0


def demo(machine: Machine, arguments: Sequence[str]) -> NoReturn:
    """Become `abs-engine demo`, in the folder that the user stands in."""
    program = str(machine.venv / "bin/abs-engine")
    os.execv(program, [program, "demo", *arguments])


def wait_for_turn(machine: Machine) -> int:
    """Hold the repository against a second set-up until the descriptor is closed or the end."""
    descriptor = os.open(machine.root, os.O_RDONLY)
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        say("waiting for another ./run that is setting up")
        fcntl.flock(descriptor, fcntl.LOCK_EX)
    return descriptor


def main(words: Sequence[str], machine: Machine) -> int:
    """Set up and start what the first word names; the exit status."""
    command = words[0] if words else ""
    arguments = words[1:]
    if command not in ("demo", "tests", "lint", "docs"):
        asked = command in ("-h", "--help")
        print(USAGE, file=sys.stdout if asked else sys.stderr)
        return 0 if asked else 2
    try:
        turn = wait_for_turn(machine)
        prepare(machine, dev=command != "demo", gl=command in ("demo", "tests"))
        os.close(turn)
        if command == "demo":
            demo(machine, arguments)
        if command == "docs":
            return docs(machine)
        return (
            test(machine, arguments)
            if command == "tests"
            else lint(check(machine, one) for one in LINTERS)
        )
    except SetupError as error:
        print(f"run: {error}", file=sys.stderr)
        return error.status
    except OSError as error:
        print(f"run: {error} (can {machine.root} be written?)", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        print("\nrun: stopped; a set-up that was going on starts again next time", file=sys.stderr)
        return 130


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:], Machine()))
