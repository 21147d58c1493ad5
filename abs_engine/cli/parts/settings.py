"""A settings file: the options of a command as TOML, as a run writes them and takes them again."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import click
import tomli_w

from abs_engine.cli.parts import options as take
from abs_engine.cli.parts.command import Command
from abs_engine.core.errors import ParameterError
from abs_engine.core.registry import nearest
from abs_engine.core.release import engine_version
from abs_engine.io.inputs import read_toml
from abs_engine.io.naming import path_from

SETTINGS = "settings.toml"
"""The file of a run."""
_LEFT_OUT = ("output", "settings", "workers", "scheduler", "json", "quiet", "help")


def settings_option() -> take.Option:
    """`--settings`, read before the other options, which have precedence."""
    return take.file(
        "--settings",
        f"TOML file of options, such as {SETTINGS} of a run; those typed take precedence",
        is_eager=True,
        callback=_take,
    )


def settings_text(command: Command, typed: Mapping[str, Any], folder: Path) -> str:
    """Chosen options, as a settings file.

    Parameters
    ----------
    typed : mapping of str to value
        By the names of the parameters; those without a value are left out.
    folder : Path
        Where the file will lie: its paths are relative to that.

    Raises
    ------
    ParameterError
        If a path is not UTF-8, as TOML is.
    """
    kept = {}
    for name, one in _known(command).items():
        value = typed[one.name or ""]
        several = value if isinstance(value, tuple) else (value,)
        given = [v for v in several if v is not None and not (v is False and _off(one))]
        values = [_written(v, one, folder) for v in given]
        if values:
            kept[name] = values if isinstance(value, tuple) else values[0]
    head = f"# abs-engine {engine_version()}: {command.name} ... -o RUN --settings {SETTINGS}\n"
    return f"{head}# Paths are relative to the folder of this file.\n{tomli_w.dumps(kept)}"


def _off(option: take.Option) -> bool:
    """Whether an option is a flag that says nothing where it is not given."""
    return option.is_flag and not option.secondary_opts


def read_settings(path: Path, command: Command) -> dict[str, Any]:
    """The values of a settings file, by the names of the parameters.

    Raises
    ------
    InputFileError
        If there is no such file, or it is no TOML.
    ParameterError
        If the command has no option of a name; the nearest is given. Or if there are several
        values where it takes one.
    """
    found = read_toml(path, "give a settings file, such as a run's settings.toml")
    known, values = _known(command), {}
    for name, value in found.items():
        if name not in known:
            raise ParameterError(
                f"{path} has the key '{name}', which is no option of {command.name}",
                nearest(name, known),
            )
        one = known[name]
        several = value if isinstance(value, list) else [value]
        if isinstance(value, list) > (one.multiple or one.nargs > 1) or isinstance(value, dict):
            raise ParameterError(f"{path} has more than one value for '{name}'", "give one")
        if one.is_flag and not isinstance(value, bool):
            raise ParameterError(f"{path} gives '{name}' the value {value!r}", "give true or false")
        read = [_read(str(v), one, path.parent) for v in several]
        values[one.name or ""] = read if one.multiple or one.nargs > 1 else read[0]
    return values


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


def _written(value: Any, option: take.Option, folder: Path) -> Any:
    """A value for the file; a path relative to where it will lie."""
    is_path = isinstance(value, Path) or (_may_be_file(option) and Path(value).is_file())
    if not is_path:
        return value
    path = path_from(folder, Path(value))
    try:
        path.encode()
    except UnicodeEncodeError as error:
        raise ParameterError(
            f"{path} is not UTF-8, and {SETTINGS} cannot name it", "rename it"
        ) from error
    return path


def _read(value: str, option: take.Option, folder: Path) -> str:
    """A value of the file as it would be typed; a path as it is from here."""
    there = folder / take.at_home(value)
    is_path = isinstance(option.type, click.Path) or (_may_be_file(option) and there.is_file())
    return str(there) if is_path else value


def _may_be_file(option: take.Option) -> bool:
    return isinstance(option.type, take.Named) and option.type.or_file
