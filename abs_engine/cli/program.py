"""The program: finds its commands in `abs_engine.cli.commands`, and imports only what is typed."""

from __future__ import annotations

from importlib import import_module
from keyword import iskeyword
from pkgutil import iter_modules

import click

from abs_engine.cli import commands
from abs_engine.cli.parts.command import WIDTH, Command
from abs_engine.core.registry import nearest
from abs_engine.core.release import engine_version

NAME = "abs-engine"
SECTIONS = (
    "Track and look at the result",
    "Film ground truth and score against it",
    "Learn faces and lips",
    "This machine, and published results",
)
"""In the order of the help; the first argument of `command` is one of them."""
_NOTES = """\
Type 'abs-engine COMMAND --help' for the options of a command, with examples.

Examples:
  abs-engine track talk.mp4 -o tracked
  abs-engine report tracked -o report.html
  eval "$(_ABS_ENGINE_COMPLETE=bash_source abs-engine)"    completion; also zsh_source, fish_source

Exit status: 0 on success; 1 if doctor finds no OpenGL, check a fault, or live's camera is
unplugged; 2 if the input or the machine is at fault; 130 if interrupted.
"""


class Program(click.Group):
    """The commands, by the modules that are there."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        """Their names."""
        modules = (module.name for module in iter_modules(commands.__path__))
        return sorted(name.rstrip("_") for name in modules)  # of import_, a word of Python's

    def get_command(self, ctx: click.Context, cmd_name: str) -> Command | None:
        """A command, whose module is imported."""
        if cmd_name not in self.list_commands(ctx):
            return None
        own = f"{cmd_name}_" if iskeyword(cmd_name) else cmd_name
        found: Command = getattr(import_module(f"{commands.__name__}.{own}"), own)
        return found

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Section by section."""
        every = [self.get_command(ctx, name) for name in self.list_commands(ctx)]
        for title in SECTIONS:
            rows = [
                (c.name or "", c.summary) for c in every if c is not None and c.section == title
            ]
            with formatter.section(title):
                formatter.write_dl(rows)

    def format_epilog(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """As it is written."""
        formatter.write(f"\n{self.epilog}")


PROGRAM = Program(
    NAME,
    help="Recovers 3D face and lip motion from video, by rendering and comparing.",
    epilog=_NOTES,
    subcommand_metavar="COMMAND ...",
    context_settings={"max_content_width": WIDTH, "help_option_names": ["--help", "-h"]},
)
click.version_option(engine_version(), message="abs-engine %(version)s")(PROGRAM)


def complaint(error: click.ClickException) -> str:
    """One line for what was typed wrongly; it names the command's own help."""
    if isinstance(error, click.NoSuchCommand):
        known = PROGRAM.list_commands(click.Context(PROGRAM))
        said = f"there is no command '{error.command_name}'; {nearest(error.command_name, known)}"
    elif isinstance(error, click.NoSuchOption):
        said = f"there is no option '{error.option_name}'"
        said += f"; did you mean '{error.possibilities[0]}'?" if error.possibilities else ""
    else:
        said = error.format_message().rstrip(".")
        said = said[:1].lower() + said[1:]
        if isinstance(error, click.MissingParameter) and isinstance(error.param, click.Option):
            said += f", {(error.param.help or '').partition('; ')[0]}"
    context = getattr(error, "ctx", None)
    where = NAME if context is None else context.command_path
    return f"{' '.join(said.split())}; see '{where} --help'"
