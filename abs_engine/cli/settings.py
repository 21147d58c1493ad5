"""A settings file: the options of a command as TOML, as a run writes them and takes them again."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import click
import tomli_w

from abs_engine.cli import options as take
from abs_engine.cli.command import Command
from abs_engine.core.errors import InputFileError, ParameterError
from abs_engine.core.registry import nearest
from abs_engine.core.release import engine_version
from abs_engine.io.inputs import check_file, parse_toml

SETTINGS = "settings.toml"
"""The file of a run."""
_LEFT_OUT = ("output", "settings", "json", "quiet", "help")


def settings_option() -> take.Option:
    """`--settings`, read before the other options, which have precedence."""
    return take.file(
        "--settings",
        f"options as a TOML file, such as {SETTINGS} of a run; those typed have precedence",
        is_eager=True,
        callback=_take,
    )


def settings_text(command: Command, typed: Mapping[str, Any], folder: Path) -> str:
    """What was chosen, as a settings file.

    Parameters
    ----------
    command : Command
    typed : mapping of str to value
        By the names of the parameters; those without a value are left out.
    folder : Path
        Where the file will lie: its paths are relative to that.
    """
    kept = {
        name: _each(typed[one.name or ""], lambda value, one=one: _written(value, one, folder))
        for name, one in _known(command).items()
        if typed[one.name or ""] not in (None, (), False)
    }
    head = f"# abs-engine {engine_version()}: {command.name} VIDEO -o RUN --settings {SETTINGS}\n"
    return f"{head}# Paths are relative to the folder of this file.\n{tomli_w.dumps(kept)}"


def read_settings(path: Path, command: Command) -> dict[str, Any]:
    """The values of a settings file, by the names of the parameters.

    Raises
    ------
    InputFileError
        If there is no such file, or it is no TOML.
    ParameterError
        If the command has no option of a name; the nearest is given.
    """
    check_file(path)
    try:
        found = parse_toml(path.read_text(encoding="utf-8"))
    except ValueError as error:
        raise InputFileError(f"{path} is not TOML ({error})", "correct it") from error
    known = _known(command)
    for name in found:
        if name not in known:
            raise ParameterError(
                f"{path} has the key '{name}', which is no option of {command.name}",
                nearest(name, known),
            )
    return {
        known[name].name or "": _each(value, lambda v, one=known[name]: _read(v, one, path.parent))
        for name, value in found.items()
    }


def _take(ctx: click.Context, _param: click.Parameter, path: Path | None) -> Path | None:
    if path is not None and isinstance(ctx.command, Command):
        ctx.default_map = read_settings(path, ctx.command)
    return path


def _known(command: Command) -> dict[str, take.Option]:
    """The options that a file may hold, by their names in it."""
    return {
        one.opts[0].lstrip("-"): one
        for one in command.params
        if isinstance(one, take.Option) and one.name not in _LEFT_OUT
    }


def _each(value: Any, change: Any) -> Any:
    return [change(v) for v in value] if isinstance(value, list | tuple) else change(value)


def _written(value: Any, option: take.Option, folder: Path) -> Any:
    """A value for the file; a path relative to where it will lie."""
    is_path = isinstance(value, Path) or (_may_be_file(option) and Path(value).is_file())
    return Path(os.path.relpath(value, folder)).as_posix() if is_path else value


def _read(value: Any, option: take.Option, folder: Path) -> Any:
    """A value of the file; a path as it is from here."""
    if not isinstance(value, str):
        return value
    there = folder / value
    is_path = isinstance(option.type, click.Path) or (_may_be_file(option) and there.is_file())
    return str(there) if is_path else value


def _may_be_file(option: take.Option) -> bool:
    return isinstance(option.type, take.Named) and option.type.or_file
