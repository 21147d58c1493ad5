"""The table that says of a head what its names do not."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from abs_engine.core.errors import ParameterError
from abs_engine.core.registry import nearest
from abs_engine.face.schema import FACE_UNITS, REGION_WORDS
from abs_engine.io.inputs import read_toml

MARKS = ("outer_lip", "inner_lip", "nose_tip", "chin", "eye_corners")
"""The landmarks that a table has to give; see `learn.heads.marks`."""
SIXTY_EIGHT = "landmark_68"
"""All 68 usual landmarks, which may be given in their place."""
_FILES = ("people", "textures")
EYES_MM = 88.0, 65.0, 115.0
"""Distance of the eyes' outer corners of adults, the least and the greatest that is believed."""
UNITS = {"m": 1000.0, "dm": 100.0, "cm": 10.0, "mm": 1.0, "in": 25.4}
"""Millimetres of the lengths that a file may be in."""


@dataclass(frozen=True)
class HeadTable:
    """Description of a head by its table.

    Parameters
    ----------
    length : str or None
        Unit of length, of `UNITS`; by default it follows from the eyes' distance.
    units : mapping of str to tuple of str
        Face units by the morph targets that make them up.
    regions : mapping of str to str
        Parts by a piece of their name, to one of `REGION_WORDS`.
    landmarks : mapping of str to list
        Of `MARKS`, or `SIXTY_EIGHT`: vertices by number from 0, or places [x, y, z].
    people : mapping of str to Path
        People of the same mesh, each an OBJ file.
    textures : mapping of str to Path
        People whose looks are known, too: pictures, laid by the file's places on its texture.
    """

    length: str | None = None
    units: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    regions: Mapping[str, str] = field(default_factory=dict)
    landmarks: Mapping[str, list[Any]] = field(default_factory=dict)
    people: Mapping[str, Path] = field(default_factory=dict)
    textures: Mapping[str, Path] = field(default_factory=dict)


def read_table(path: Path) -> HeadTable:
    """Read a TOML table.

    Raises `InputFileError` if the file is missing or no TOML, `ParameterError` if a name or a value
    in it is wrong.
    """
    data = read_toml(path, "see docs/import.md")
    known = HeadTable.__dataclass_fields__
    _known(path, "section", data, known)
    parts = {name: data.get(name, {}) for name in known if name != "length"}
    for name, part in parts.items():
        if not isinstance(part, dict):
            raise ParameterError(f"{path}: [{name}] is no table", "see docs/import.md")
    units, regions = parts["units"], parts["regions"]
    _known(path, "face unit", units, FACE_UNITS)
    _known(path, "region", map(str, regions.values()), REGION_WORDS)
    _known(path, "landmark", parts["landmarks"], (*MARKS, SIXTY_EIGHT))
    if data.get("length") is not None:
        _known(path, "length", [str(data["length"])], UNITS)
    return HeadTable(
        data.get("length"),
        {k: tuple(map(str, v if isinstance(v, list) else [v])) for k, v in units.items()},
        {str(k): str(v) for k, v in regions.items()},
        {k: v if isinstance(v, list) else [v] for k, v in parts["landmarks"].items()},
        *({str(k): path.parent / str(v) for k, v in parts[name].items()} for name in _FILES),
    )


def _known(path: Path, what: str, names: Any, known: Any) -> None:
    for name in names:
        if name not in known:
            raise ParameterError(f"{path}: there is no {what} '{name}'", nearest(name, known))
