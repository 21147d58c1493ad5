"""Arguments and options that commands share, and names that the shell completes."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import Any

import click
from click.shell_completion import CompletionItem

from abs_engine.core.errors import InputFileError
from abs_engine.core.kinds import check_no_address
from abs_engine.core.registry import RENDERERS, Registry, nearest
from abs_engine.io.inputs import is_there

STDOUT = Path("-")
DRAWS = "what draws; auto: OpenGL, or the CPU if it does not load. cpu is the fastest for track"


def at_home(word: str | Path) -> str:
    """A word with that home for ~ or ~NAME, where there is one: a shell leaves a quoted ~ alone."""
    return os.path.expanduser(word)  # pathlib's raises an error at a name that nobody has


class _Path(click.Path):
    """A file or folder, which need not be there."""

    def convert(self, value: Any, param: Any, ctx: Any) -> Any:
        """Its path."""
        if not str(value):
            self.fail("a path is empty", param, ctx)
        check_no_address(value)
        return Path(at_home(value))


class _Input(_Path):
    """A file or folder that is there; whatever else is wrong with it is seen as it is read."""

    def convert(self, value: Any, param: Any, ctx: Any) -> Any:
        """Its path."""
        path = super().convert(value, param, ctx)
        if not is_there(path):
            raise InputFileError(f"{path} does not exist", "check the path")
        return path


PATH, INPUT = _Path(), _Input()


class Option(click.Option):
    """An option under a heading of the help; with `many` it takes all words up to the next."""

    section = "Options"
    many = False


class Choice(click.Choice[str]):
    """One of a few words; another is answered with the nearest."""

    def convert(self, value: Any, param: Any, ctx: Any) -> str:
        """The word itself."""
        if value not in self.choices:
            known = list(self.choices)
            self.fail(f"there is no choice '{value}'; {nearest(str(value), known)}", param, ctx)
        return str(value)


class Named(click.ParamType[str]):
    """A name, or names joined by a character, that the shell completes.

    Which names there are is seen once plugins are loaded, so it is not checked here.

    Parameters
    ----------
    names : Registry, or callable that returns strings
    join : str
        What stands between names.
    or_file : bool
        Whether a file can be given instead.
    """

    name = "name"

    def __init__(
        self, names: Registry | Callable[[], Iterable[str]], join: str = "", or_file: bool = False
    ) -> None:
        self._names = names.names if isinstance(names, Registry) else names
        self._join, self.or_file = join, or_file

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> str:
        """The name, or the file's path."""
        return at_home(value) if self.or_file else str(value)

    def shell_complete(
        self, ctx: click.Context, param: click.Parameter, incomplete: str
    ) -> list[CompletionItem]:
        """The names that go on as was typed."""
        before = incomplete[: incomplete.rfind(self._join) + 1] if self._join else ""
        words = [before + name for name in self._names()]
        found = [CompletionItem(word) for word in words if word.startswith(incomplete)]
        return [*found, CompletionItem(incomplete, "file")] if self.or_file else found


def argument(name: str, metavar: str, text: str, **more: Any) -> click.Argument:
    """Argument that is typed without a name: a path, if nothing else is said."""
    return click.Argument([name], metavar=metavar, help=text, **{"type": PATH, **more})


def option(*names: str, text: str, many: bool = False, **more: Any) -> Option:
    """An option as click's; with `many` it takes all words up to the next option."""
    made = Option(names, help=text, multiple=more.pop("multiple", False) or many, **more)
    made.many = many
    return made


def group(title: str, *options: Option) -> Iterator[Option]:
    """Options that stand under a heading of their own."""
    for one in options:
        one.section = title
        yield one


FACE = ".face"
"""Ending of what ``--model`` and ``--speaker`` take."""


def output(metavar: str, text: str, required: bool = True) -> Option:
    """Option for the path of a new output."""
    if "must not exist" not in text:
        what, *more = text.split("; ")
        text = "; ".join([f"{what} (must not exist)", *more])
    return option("-o", "--output", text=text, type=PATH, metavar=metavar, required=required)


def view() -> tuple[Option, Option]:
    """Option for the view of a dataset."""
    return (
        option("--clip", metavar="NAME", text="clip of the dataset, if it has several"),
        option("--camera", metavar="NAME", text="camera of the clip, if it has several"),
    )


def metrics() -> Option:
    """Files that add metrics."""
    return file(
        "--plugin", multiple=True, metavar="FILE.py",
        text="Python file that adds metrics of your own; may be repeated",
    )  # fmt: skip


def seed(what: str) -> Option:
    """The seed of random draws."""
    return option(
        "--seed", type=click.IntRange(0), default=0, metavar="N",
        text=f"seed of {what} (default: 0)",
    )  # fmt: skip


def file(name: str, text: str, metavar: str = "FILE", **more: Any) -> Option:
    """An option whose value is the path of something that is there; or new, with PATH as `type`."""
    return option(name, text=text, metavar=metavar, **{"type": INPUT, **more})


def number(text: str | float) -> float:
    """A number."""
    try:
        return float(text)
    except ValueError:
        raise click.BadParameter(f"'{text}' is not a number") from None


def positive(text: str | float) -> float:
    """A finite number above 0."""
    found = number(text)
    if not 0 < found < float("inf"):
        raise click.BadParameter(f"{text} is not a number above 0")
    return found


def count(text: str | int) -> int:
    """A number from 1 on."""
    try:
        found = int(text)
    except ValueError:
        raise click.BadParameter(f"'{text}' is not a whole number") from None
    if found < 1:
        raise click.BadParameter(f"{text} is not 1 or more")
    return found


def person(text: str, default: str | None = None) -> Option:
    """`--person`: one of the bundled people, or of another speaker's."""
    return option("--person", metavar="NAME", type=Named(people_names), text=text, default=default)


def people_names() -> Iterable[str]:
    """The bundled people."""
    from abs_engine.io.assets import load_speaker

    return load_speaker().people


def scene_names() -> list[str]:
    """Scenes and sentences that are bundled."""
    from abs_engine.io.assets import shipped
    from abs_engine.studio.visemes import SENTENCES

    return [*sorted(path.name for path in shipped("scenes").glob("*.toml")), *SENTENCES]


def unit_names() -> Iterable[str]:
    """Face units of the bundled head."""
    from abs_engine.io.assets import load_speaker

    return load_speaker().unit_names


def renderer(text: str = DRAWS, default: str | None = "auto") -> Option:
    """`--renderer`: what draws."""
    named = Named(renderer_names)
    return option("--renderer", text=text, type=named, metavar="NAME", default=default)


def renderer_names() -> Iterable[str]:
    """Those that `--renderer` takes."""
    from abs_engine.render.select import NAMES

    return *NAMES, *RENDERERS
