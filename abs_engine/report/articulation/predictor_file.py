"""Predictors as a file: a list of tables in TOML, one for each parameter, in their order."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from abs_engine.core.errors import ModelFormatError, ParameterError
from abs_engine.face.shape.predictors import Predictor
from abs_engine.io.inputs import read_toml
from abs_engine.studio.scenefile import nearest
from abs_engine.studio.scenefile.reader import build

FORMAT, VERSION = "abs_engine.predictors", 1
_KEYS = ("format", "version", "predictor")
_HEAD = """\
# Each parameter is the first principal component of some coordinates of some points, of what those
# before it have not explained. points: groups of the table of points, or single points;
# coordinates: of x (to the left), y (up) and z (forward); positive: where these points go as the
# parameter grows.
"""


def read_predictors(path: Path) -> tuple[Predictor, ...]:
    """Read what `predictors_text` wrote, or a person wrote like it.

    Raises
    ------
    InputFileError
        If the file is missing, or no TOML.
    ModelFormatError
        If it has another format or version.
    ParameterError
        If a key is unknown (the nearest is named), missing or wrong; if there is no predictor, or
        two have one name.
    """
    told = read_toml(Path(path), "correct that line")
    for key in told:
        if key not in _KEYS:
            raise ParameterError(
                f"{path} has no key '{key}'{nearest(key, _KEYS)}", f"keys: {', '.join(_KEYS)}"
            )
    found = told.get("format", "unknown"), told.get("version", 0)
    if found != (FORMAT, VERSION) or isinstance(found[1], bool):  # true == 1
        raise ModelFormatError(
            f"{path} is {found[0]} version {found[1]}, wanted {FORMAT} version {VERSION}",
            f'begin it with format = "{FORMAT}" and version = {VERSION}',
        )
    rows = told.get("predictor", [])
    if not isinstance(rows, list) or not rows:
        raise ParameterError(f"{path} has no predictors", "give tables [[predictor]]")
    return _distinct(path, [build(Predictor, r, _where(path, k, r)) for k, r in enumerate(rows, 1)])


def _where(path: Path, number: int, row: Any) -> str:
    own = row.get("name") if isinstance(row, dict) else None
    return f"{path}, predictor {repr(own) if isinstance(own, str) else number}"


def _distinct(path: Path, predictors: Sequence[Predictor]) -> tuple[Predictor, ...]:
    names = [p.name for p in predictors]
    twice = [name for k, name in enumerate(names) if name in names[:k]]
    if twice:
        raise ParameterError(f"{path}: two predictors are named '{twice[0]}'", "name each once")
    return tuple(predictors)


def predictors_text(predictors: Sequence[Predictor]) -> str:
    """Predictors as TOML that `read_predictors` reads."""
    lines = [_HEAD, f'format = "{FORMAT}"', f"version = {VERSION}"]
    for p in predictors:
        told = {
            "name": p.name, "points": list(p.points), "coordinates": p.coordinates,
            "positive": p.positive,
        }  # fmt: skip
        # JSON's texts and lists are TOML's, too
        lines += ["", "[[predictor]]", *(f"{k} = {json.dumps(v)}" for k, v in told.items())]
    return "\n".join(lines) + "\n"
