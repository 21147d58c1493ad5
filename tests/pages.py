"""The README and the pages of docs/ as their readers use them: code blocks, run in a folder.

A shell block is run line by line, each `abs-engine` line in this process, with the CPU renderer
where the command only draws. Python blocks are executed, TOML blocks parsed; `text` is a drawing.
What cannot be run is listed by `unrun`, each line with its reason: its words are parsed by the
program's own parser, and the options of `track` checked as `track` itself checks them before it
begins.

What a reader has of his own is made by `page_inputs`. `synth` and `track` write the same for the
same words and files, and are run once for all pages. All that takes long does less: see `short`.
"""

from __future__ import annotations

import contextlib
import hashlib
import importlib.util
import io
import os
import re
import shlex
import shutil
import tomllib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import click
from page_inputs import BEFORE, CLIP, GIVEN, LATER, pictures_of, write_film
from short import short
from unrun import reason

from abs_engine.cli import main
from abs_engine.cli.parts.command import Chosen
from abs_engine.cli.parts.given_files import track_options
from abs_engine.cli.program import PROGRAM, complaint
from abs_engine.core import registry
from abs_engine.core.errors import InputFileError
from abs_engine.io.video import probe
from abs_engine.render.context import HIDE_VARIABLE
from abs_engine.tracking.option_checks import check_options

ROOT = Path(__file__).resolve().parents[1]
PAGES = (
    *(ROOT / name for name in ("README.md", "CONTRIBUTING.md")),
    *sorted(page for page in (ROOT / "docs").glob("*.md") if not page.is_symlink()),
)
LANGUAGES = ("sh", "python", "toml", "text")
BY_OPENGL = ("synth", "--version")
REPEATABLE = ("synth", "track")
_FENCE = re.compile(r"^```(.*?)\n(.*?)^```$", re.MULTILINE | re.DOTALL)


class PageError(AssertionError):
    """A block of a page does not work; the message names page and line."""


@dataclass(frozen=True)
class Block:
    """A code block.

    Parameters
    ----------
    page : str
        The page's path from the top of the repository.
    line : int
        Where its first line stands on the page, from 1.
    language : str
    text : str
    """

    page: str
    line: int
    language: str
    text: str

    def commands(self) -> list[tuple[int, list[str]]]:
        """The commands of a shell block as words, each with its line on the page."""
        found = []
        for number, line in enumerate(self.text.splitlines(), self.line):
            parts = (shlex.split(part, comments=True) for part in line.split(" && "))
            found += [(number, words) for words in parts if words]
        return found


def blocks_of(page: Path) -> list[Block]:
    """The code blocks of a page, in their order."""
    text, name = page.read_text(encoding="utf-8"), page.relative_to(ROOT).as_posix()
    return [
        Block(name, text.count("\n", 0, m.start(2)) + 1, m[1].strip(), m[2])
        for m in _FENCE.finditer(text)
    ]


class Reader:
    """Somebody who types what the pages say.

    Parameters
    ----------
    kept : Path
        An empty folder for what all pages share.
    """

    def __init__(self, kept: Path) -> None:
        self._kept = kept
        self._done: dict[str, Path] = {}
        self._executed: set[str] = set()
        with contextlib.chdir(kept):
            self._run(["abs-engine", "synth", "vowels", "--frames", "5", "-o", "vowels"])
        filmed = kept / "vowels" / "clip" / "camera"
        write_film(kept / "talk.mp4", pictures_of(filmed / "video.mp4", CLIP))
        shutil.copy(filmed / "camera.json", kept)

    def provide(self, folder: Path, page: Path) -> None:
        """Put there what a page speaks of as the reader's own or as done: a clip, its camera."""
        for name in ("talk.mp4", "camera.json"):
            shutil.copy(self._kept / name, folder)
        for name in ("examples", "tests"):
            (folder / name).symlink_to(ROOT / name)
        name = page.relative_to(ROOT).as_posix()
        for give in GIVEN.get(name, ()):
            give(folder)
        with contextlib.chdir(folder):
            for line in BEFORE.get(name, ()):
                self._run(shlex.split(line))

    def follow(self, page: Path, folder: Path) -> int:
        """Do in a folder what a page says; the number of blocks.

        Raises
        ------
        PageError
            At the first block that does not work.
        """
        blocks = blocks_of(page)
        with contextlib.chdir(folder), registries_restored():
            for block in blocks:
                self._do(block)
        return len(blocks)

    def _do(self, block: Block) -> None:
        if block.language not in LANGUAGES:
            raise PageError(f"{block.page}:{block.line}: there is no language '{block.language}'")
        if block.language == "toml":
            with _named(block, block.line, "TOML"):
                tomllib.loads(block.text)
        if block.language == "python" and block.text not in self._executed:
            with _named(block, block.line, "Python"), hidden_opengl(), short():
                self._execute(block)
        if block.language == "sh":
            for line, words in block.commands():
                with _named(block, line, shlex.join(words)):
                    self._try(words)

    def _execute(self, block: Block) -> None:
        self._executed.add(block.text)
        # Empty lines before it, so that a traceback has the page's line numbers.
        code = compile("\n" * (block.line - 1) + block.text, block.page, "exec")
        with contextlib.redirect_stdout(io.StringIO()):
            exec(code, {"__name__": "__main__"})

    def _try(self, words: list[str]) -> None:
        line = shlex.join(words)
        if reason(line) is not None:
            check(words)
            return
        if line in LATER:
            LATER[line](Path.cwd())
        self._run(words)

    def _run(self, words: list[str]) -> None:
        program, *arguments = words
        if program != "abs-engine":
            raise PageError(f"'{program}' is not run here; tests/unrun.py lists why")
        if arguments[0] not in REPEATABLE or "-o" not in arguments:
            self._type(arguments)
            return
        key, output = _key(arguments), Path(arguments[arguments.index("-o") + 1])
        if key in self._done and not output.exists():
            shutil.copytree(self._done[key], output)
            return
        self._type(arguments)
        self._done[key] = self._kept / f"done{len(self._done)}"
        shutil.copytree(output, self._done[key])

    def _type(self, arguments: list[str]) -> None:
        """Run the program; `doctor` ends with 1, as it finds the CPU rasteriser alone."""
        said, complained = io.StringIO(), io.StringIO()
        opengl = arguments[0] in BY_OPENGL
        with (
            contextlib.nullcontext() if opengl else hidden_opengl(),
            short(),
            contextlib.redirect_stdout(said),
            contextlib.redirect_stderr(complained),
        ):
            status = main(arguments)
        if status != (arguments[0] == "doctor"):
            raise PageError(f"exit status {status}: {complained.getvalue().strip()[-600:]}")


def check(words: list[str]) -> None:
    """Check a command without running it; an error says what is wrong."""
    program, *arguments = words
    if program == "abs-engine":
        try:
            context = PROGRAM.make_context(program, list(arguments))
            name, command, rest = PROGRAM.resolve_command(context, arguments)
            chosen = Chosen(**command.make_context(name, rest, context).params)
        except click.UsageError as error:
            raise PageError(complaint(error)) from error
        except InputFileError:
            if arguments[0] == "track":
                raise
            return  # a file that a line before would have made
        if name == "track":
            for plugin in chosen.plugin:
                registry.load_plugin(plugin)
            for video in chosen.videos:
                check_options(track_options(chosen), probe(video))
    elif program == ".venv/bin/python":
        if importlib.util.find_spec(arguments[arguments.index("-m") + 1]) is None:
            raise PageError("there is no such module")
    elif program == "python" and not Path(arguments[0]).is_file():
        raise PageError(f"there is no {arguments[0]}")


def _key(arguments: list[str]) -> str:
    """The words but for the output's name, files by what they hold."""
    at = arguments.index("-o") + 1
    words = [w for k, w in enumerate(arguments) if k != at]
    return shlex.join(
        hashlib.sha256(Path(w).read_bytes()).hexdigest() if Path(w).is_file() else w for w in words
    )


@contextlib.contextmanager
def _named(block: Block, line: int, what: str) -> Iterator[None]:
    """An error of a block says on which line of which page it stands."""
    try:
        yield
    except Exception as error:
        raise PageError(f"{block.page}:{line}: {what}: {error or type(error).__name__}") from error


@contextlib.contextmanager
def hidden_opengl() -> Iterator[None]:
    """Without OpenGL, whose software renderer is slower than the CPU rasteriser."""
    before = os.environ.get(HIDE_VARIABLE)
    os.environ[HIDE_VARIABLE] = "all"
    try:
        yield
    finally:
        os.environ.pop(HIDE_VARIABLE)
        if before is not None:
            os.environ[HIDE_VARIABLE] = before


@contextlib.contextmanager
def registries_restored() -> Iterator[None]:
    """Take out again what a page adds to the registries."""
    before = [dict(one._added) for one in registry.REGISTRIES]
    plugins = list(registry.PLUGINS)
    try:
        yield
    finally:
        for one, own in zip(registry.REGISTRIES, before, strict=True):
            one._added.clear()
            one._added.update(own)
        registry.PLUGINS[:] = plugins
