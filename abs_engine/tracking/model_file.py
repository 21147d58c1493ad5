"""Which kind of model a file holds."""

from __future__ import annotations

from pathlib import Path

from abs_engine.core.errors import ModelFormatError
from abs_engine.npz import format_of, read_arrays

KINDS = {"abs_engine.learned_physics": "shell", "abs_engine.talking_face": "talking"}
"""The model that each format of file is of."""


def model_of_file(path: Path) -> str:
    """The kind of model that a file holds, of `core.registry.MODELS`.

    Raises
    ------
    InputFileError
        If it cannot be read.
    ModelFormatError
        If it is of no model.
    """
    found = format_of(read_arrays(path))
    if found not in KINDS:
        raise ModelFormatError(
            f"{path} holds no model but {found}",
            "give what 'train' or 'reproduce 001' wrote: lips.npz or face.npz",
        )
    return KINDS[found]
