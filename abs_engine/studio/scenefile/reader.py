"""Reads scene files; a key that is misspelt is answered with the nearest one."""

from __future__ import annotations

import dataclasses
import difflib
import re
import types
import typing
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

from abs_engine.core.errors import InputFileError, ModelFormatError, ParameterError
from abs_engine.core.kinds import to_path
from abs_engine.io.inputs import MOST, parse_toml, read_text
from abs_engine.studio.scenefile.scene import FORMAT, VERSION, SceneFile

OTHER_NAMES: dict[str, tuple[str, ...]] = {
    **dict.fromkeys(("fps", "framerate", "framespersecond", "hz"), ("rate",)),
    **dict.fromkeys(("resolution", "width", "height", "imagesize"), ("size",)),
    **dict.fromkeys(("person", "actor", "people", "face", "head", "who", "talker"), ("speaker",)),
    **dict.fromkeys(("text", "phonemes", "speech", "words", "says", "ipa", "xsampa"), ("say",)),
    **dict.fromkeys(("duration", "length", "nframes", "seconds"), ("frames", "end")),
    **dict.fromkeys(("fov", "angle", "hfov", "fieldofview"), ("field_of_view_degrees",)),
    **dict.fromkeys(("color", "rgb", "tint"), ("colour", "skin")),
    **dict.fromkeys(("brightness", "strength", "power"), ("intensity", "exposure", "amount")),
    **dict.fromkeys(("principalpoint", "center"), ("centre",)),
    **dict.fromkeys(("rotation", "turn", "angles"), ("turn_degrees", "roll_degrees")),
    **dict.fromkeys(("lookat", "lookingat", "aim"), ("target",)),
    **dict.fromkeys(("translation", "shift", "place", "location"), ("shift", "position")),
    **dict.fromkeys(("lamp", "lamps", "lights"), ("light", "lights")),
    **dict.fromkeys(("speakers",), ("speaker",)),
    **dict.fromkeys(("quality", "bitrate", "compression"), ("crf",)),
    **dict.fromkeys(("livelink", "blendshapes", "csv"), ("arkit",)),
    **dict.fromkeys(("shape", "morph", "targets", "weights"), ("identity",)),
    **dict.fromkeys(("noise",), ("sensor", "shot", "read")),
    **dict.fromkeys(("dots", "markers", "marks"), ("beads",)),
    **dict.fromkeys(("begin", "from"), ("start",)),
    **dict.fromkeys(("stop", "until", "to"), ("end",)),
}
"""What else keys may be called, in small letters without '_' and '-', and the keys meant."""

_BEGIN = f'begin it with format = "{FORMAT}" and version = {VERSION}'


def read_scene(path: Path) -> SceneFile:
    """Read a scene file.

    Raises
    ------
    InputFileError
        If it is missing or no TOML; the line is named.
    ModelFormatError
        If it has another format or version.
    ParameterError
        If a key is unknown (the nearest is named), missing, or has a wrong value.
    """
    path = to_path("path", path)
    return parse_scene(read_text(path, "give a TOML file"), str(path))


def parse_scene(text: str, name: str = "the scene") -> SceneFile:
    """A scene from the text of a scene file; errors as `read_scene`."""
    try:
        table = parse_toml(text)
    except ValueError as error:
        raise InputFileError(f"{name} is not TOML: {error}", "correct that line") from error
    lacking = [key for key in ("format", "version") if key not in table]
    if lacking:
        raise ModelFormatError(f"{name} has no line {' or '.join(lacking)}", _BEGIN)
    found = table["format"], table["version"]
    if found != (FORMAT, VERSION) or isinstance(found[1], bool):  # true == 1
        raise ModelFormatError(
            f"{name} is {found[0]} version {found[1]}, wanted {FORMAT} version {VERSION}",
            _BEGIN,
        )
    scene: SceneFile = build(SceneFile, table, name)
    return scene


def build(kind: Any, table: Any, where: str) -> Any:
    """A value of a dataclass, whose fields are the keys of a table; `where` is for errors.

    Raises
    ------
    ParameterError
        If a key is unknown, missing, or has a wrong value.
    """
    if not isinstance(table, Mapping):
        raise ParameterError(f"{where} is not a table but {_show(table)}", "give keys and values")
    fields = {field.name: field for field in dataclasses.fields(kind)}
    for key in table:
        if key not in fields:
            raise ParameterError(
                f"{where} has no key '{key}'{nearest(key, fields)}", f"keys: {', '.join(fields)}"
            )
    for name, field in fields.items():
        bare = field.default is dataclasses.MISSING and field.default_factory is dataclasses.MISSING
        if bare and name not in table:
            raise ParameterError(f"{where} lacks the key '{name}'", f"add {name} = ...")
    kinds = typing.get_type_hints(kind)
    values = {key: convert(kinds[key], value, f"{where}, {key}") for key, value in table.items()}
    try:
        return kind(**values)
    except ParameterError as error:
        raise ParameterError(f"{where}: {error.problem}", error.remedy) from error


def nearest(word: str, known: typing.Iterable[str]) -> str:
    """Such as " (nearest: 'focal')"; empty where nothing is alike.

    What has another name elsewhere comes first, then what is spelt alike, then what is a part of
    the word or has it as a part.
    """
    names = list(known)
    plain = re.sub(r"[^a-z0-9]", "", word.lower())
    by_plain = {re.sub(r"[^a-z0-9]", "", name.lower()): name for name in reversed(names)}
    alike = [name for name in OTHER_NAMES.get(plain, ()) if name in names]
    alike += [by_plain[n] for n in difflib.get_close_matches(plain, by_plain, n=1, cutoff=0.75)]
    parts = [n for n in by_plain if min(len(n), len(plain)) > 2 and (n in plain or plain in n)]
    alike += [by_plain[n] for n in sorted(parts, key=lambda n: abs(len(n) - len(plain)))]
    alike += [by_plain[n] for n in difflib.get_close_matches(plain, by_plain, n=1, cutoff=0.5)]
    return f" (nearest: '{alike[0]}')" if alike else ""


def convert(kind: Any, value: Any, where: str) -> Any:
    """A TOML value as a value of the annotated type; `ParameterError` if it is of another."""
    origin, inner = typing.get_origin(kind), typing.get_args(kind)
    if origin in (typing.Union, types.UnionType):
        return _convert_any(inner, value, where)
    if dataclasses.is_dataclass(kind):
        return build(kind, value, where)
    if origin is typing.Literal:
        if value not in inner:
            near = nearest(value, inner) if isinstance(value, str) else ""
            raise ParameterError(
                f"{where} is {_show(value)}{near}", f"give one of {', '.join(map(str, inner))}"
            )
        return value
    if origin is tuple:
        return _convert_list(inner, value, where)
    if origin is not None and issubclass(origin, Mapping):
        if not isinstance(value, Mapping):
            raise ParameterError(f"{where} is {_show(value)}", "give a table")
        return {key: convert(inner[1], item, f"{where}.{key}") for key, item in value.items()}
    return _convert_plain(kind, value, where)


def _convert_any(kinds: tuple[Any, ...], value: Any, where: str) -> Any:
    """The value as the first of some types that it fits; the last one's error if it fits none."""
    *others, last = (kind for kind in kinds if kind is not types.NoneType)
    for kind in others:
        with suppress(ParameterError):
            return convert(kind, value, where)
    return convert(last, value, where)


def _convert_list(kinds: tuple[Any, ...], value: Any, where: str) -> tuple[Any, ...]:
    if not isinstance(value, list):
        tables = dataclasses.is_dataclass(kinds[0]) and isinstance(value, Mapping)
        remedy = "write its name in [[ ]]" if tables else "give a list in [ ]"
        raise ParameterError(f"{where} is {_show(value)}", remedy)
    if len(kinds) == 2 and kinds[1] is ...:
        kinds = (kinds[0],) * len(value)
    if len(value) != len(kinds):
        raise ParameterError(f"{where} has {len(value)} entries", f"give {len(kinds)}")
    names = [f"{where} {_name(item, n)}" for n, item in enumerate(value, start=1)]
    return tuple(convert(k, v, n) for k, v, n in zip(kinds, value, names, strict=True))


def _name(item: Any, number: int) -> str:
    """A table by its own name, anything else by its number."""
    own = item.get("name") if isinstance(item, Mapping) else None
    return f"'{own}'" if isinstance(own, str) else str(number)


def _convert_plain(kind: Any, value: Any, where: str) -> Any:
    if kind is float and type(value) is int and abs(value) <= MOST:
        value = float(value)
    wanted = {
        float: "a number",
        int: "a whole number",
        str: "text in quotes",
        bool: "true or false",
    }
    if type(value) is not kind or (kind is float and not abs(value) <= MOST):
        raise ParameterError(f"{where} is {_show(value)}", f"give {wanted[kind]}")
    return value


def _show(value: Any) -> str:
    text = repr(value)
    return text if len(text) < 60 else text[:57] + "..."
