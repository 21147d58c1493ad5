"""The kind of model that a file holds."""

from __future__ import annotations

from pathlib import Path

from abs_engine.core.errors import ModelFormatError
from abs_engine.io.npz import read_kind

KINDS = {
    "abs_engine.learned_physics": "shell",
    "abs_engine.talking_face": "talking",
    "abs_engine.speaker_face": "speaker",
    "abs_engine.speaker": "head",
    "abs_engine.worn_mouths": "worn",
}
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
    found = read_kind(path)
    if found not in KINDS:
        raise ModelFormatError(
            f"{path} holds no model but {found}",
            "give a face that 'speaker' learned, or another of the files in docs/parts.md",
        )
    return KINDS[found]
