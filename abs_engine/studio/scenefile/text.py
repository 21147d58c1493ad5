"""Writes scene files: the scene as it was understood, with all its defaults."""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Mapping
from typing import Any

from abs_engine.studio.scenefile.scene import SceneFile


def scene_text(scene: SceneFile) -> str:
    """A scene as the text of a scene file; reading it gives the same scene."""
    values = _given(scene)
    lists = {
        k: v
        for k, v in values.items()
        if isinstance(v, tuple) and v and dataclasses.is_dataclass(v[0])
    }
    lines = [f"{key} = {_value(value)}" for key, value in values.items() if key not in lists]
    for key, tables in lists.items():
        for table in tables:
            lines += ["", f"[[{key}]]"]
            lines += [f"{name} = {_value(value)}" for name, value in _given(table).items()]
    return "\n".join(lines) + "\n"


def _given(table: Any) -> dict[str, Any]:
    """Fields that say something; an absent key means None or an empty list."""
    values = {field.name: getattr(table, field.name) for field in dataclasses.fields(table)}
    return {k: v for k, v in values.items() if v is not None and v != {}}


def _value(value: Any) -> str:
    """A value on one line."""
    if dataclasses.is_dataclass(value):
        value = _given(value)
    if isinstance(value, Mapping):
        pairs = ", ".join(f"{json.dumps(key)} = {_value(item)}" for key, item in value.items())
        return f"{{ {pairs} }}"
    if isinstance(value, tuple):
        return f"[{', '.join(_value(item) for item in value)}]"
    if isinstance(value, bool):
        return "true" if value else "false"
    # JSON's strings are TOML's, but for a character that JSON may leave as it is.
    return json.dumps(value).replace("\x7f", "\\u007f")
