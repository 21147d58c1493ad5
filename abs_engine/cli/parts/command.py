"""The decorator that makes a command: its parameters, its help, and how its answer is printed."""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from inspect import cleandoc
from itertools import pairwise
from textwrap import indent
from types import SimpleNamespace
from typing import Any

import click

from abs_engine.cli.parts.options import STDOUT, Option
from abs_engine.core.errors import SameOutputError

Chosen = SimpleNamespace
"""What was typed, by the names of arguments and options."""
WIDTH = 100


@dataclass(frozen=True)
class Done:
    """Outcome of a command: lines for a reader, the same as facts for `--json`, the exit status."""

    lines: Sequence[str]
    facts: Mapping[str, Any] = field(default_factory=dict)
    status: int = 0


class Command(click.Command):
    """A command with sections in its help, and an answer for a reader or a program.

    Parameters
    ----------
    run : callable
        Given what was typed; its docstring begins the help.
    section : str
        Of the program's help, one of `program.SECTIONS`.
    notes : callable that returns str
        The end of the help: formats of files, say. Called when help is asked for.
    """

    def __init__(
        self,
        run: Callable[[Chosen], Done],
        section: str,
        params: list[click.Parameter],
        examples: str,
        notes: Callable[[], str],
    ) -> None:
        self.run, self.section, self._examples, self._notes = run, section, examples, notes
        settings = {"max_content_width": WIDTH}
        super().__init__(run.__name__.rstrip("_"), settings, params=params, help=run.__doc__)

    @property
    def summary(self) -> str:
        """The first line of its help, for the list of commands."""
        return (self.help or "").partition("\n")[0].rstrip(".")

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """As click's; but some options take several words."""
        many = {n for p in self.params if isinstance(p, Option) and p.many for n in p.opts}
        try:
            self._check_values(ctx, args, many)
            return super().parse_args(ctx, list(_one_by_one(args, many)))
        except click.MissingParameter as error:
            self._hint(ctx, error)
            raise
        except click.UsageError as error:
            error.ctx = ctx  # some are raised without it
            raise

    def _hint(self, ctx: click.Context, error: click.MissingParameter) -> None:
        """Name the option that may have taken an argument that is missing."""
        several = (p for p in self.params if isinstance(p, Option) and p.many)
        took = [p.opts[0] for p in several if len(ctx.params.get(p.name or "") or ()) > 1]
        if took and isinstance(error.param, click.Argument):
            name = error.param.get_error_hint(ctx)
            error.param_hint = f"{name} before {took[0]}, which takes all words up to an option"

    def _check_values(self, ctx: click.Context, args: Sequence[str], many: set[str]) -> None:
        """Refuse an option after which the next one stands, in place of a value."""
        options = [p for p in self.get_params(ctx) if isinstance(p, click.Option)]
        names = {n for p in options for n in (*p.opts, *p.secondary_opts)}
        bare = {n for p in options if p.is_flag or p._flag_needs_value for n in p.opts}
        for one, after in pairwise(args[: args.index("--")] if "--" in args else args):
            if one in names - bare - many and after in names:
                raise click.BadOptionUsage(one, f"option '{one}' needs a value before '{after}'")

    def invoke(self, ctx: click.Context) -> int:
        """Run it, print what it found, and return the exit status."""
        try:
            done = self.run(Chosen(**ctx.params))
        except SameOutputError as same:
            done = Done([str(same)], {"output": ctx.params["output"], "made_before": True})
        if not done.lines and not done.facts:
            return done.status
        if ctx.params["json"] in (True, STDOUT):
            print(json.dumps(done.facts, indent=1, default=str))
        else:
            print("\n".join(done.lines))
        return done.status

    def format_help_text(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """The docstring as it is written."""
        formatter.write("\n" + indent(cleandoc(self.help or ""), "  ") + "\n")

    def format_options(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Options under their headings."""
        rows: dict[str, list[tuple[str, str]]] = {}
        for param in self.get_params(ctx):
            record = param.get_help_record(ctx)
            if record is not None and not isinstance(param, click.Argument):
                rows.setdefault(getattr(param, "section", "For every command"), []).append(record)
        for title, records in rows.items():
            with formatter.section(title):
                formatter.write_dl(records)

    def format_epilog(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Examples and notes, as they are written."""
        lines = "".join(f"  {line}\n" for line in self._examples.strip().splitlines())
        notes = self._notes()
        formatter.write(f"\nExamples:\n{lines}" + (f"\n{notes}" if notes else ""))


def command(
    section: str, *params: click.Parameter, examples: str, notes: str | Callable[[], str] = ""
) -> Callable[[Callable[[Chosen], Done]], Command]:
    """Make a function the command of its name; see `Command`."""

    def decorate(run: Callable[[Chosen], Done]) -> Command:
        given = {param.name for param in params}
        every = [*params, *(common for common in _COMMON if common.name not in given)]
        return Command(
            run, section, every, examples, (lambda: notes) if isinstance(notes, str) else notes
        )

    return decorate


_COMMON = (
    click.Option(["--json"], is_flag=True, help="print the result as JSON, all else on stderr"),
    click.Option(["--quiet"], is_flag=True, help="do not show progress"),
)


def _one_by_one(words: list[str], many: set[str]) -> Iterator[str]:
    """The words with an option before each of its values: -a 1 2 as -a 1 -a 2."""
    current = ""
    for k, word in enumerate(words):
        if word == "--":
            yield from words[k:]
            return
        if not _OPTION.match(word):
            yield from (current, word) if current else (word,)
            continue
        current = word if word in many else ""
        if not current or _OPTION.match(" ".join(words[k + 1 : k + 2]) or "--"):
            yield word


_OPTION = re.compile(r"-[^\d.]")
"""Begins an option, and no negative number."""
