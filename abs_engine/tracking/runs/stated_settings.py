"""Settings that a run's ``run.json`` states; a summary beside them may hold numbers not known."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from abs_engine.tracking.runs.record import stated


def stated_settings(folder: Path) -> dict[str, Any]:
    """Settings of a run, by its folder.

    Raises
    ------
    OSError
        If ``run.json`` cannot be read.
    ValueError
        If it is no JSON object.
    KeyError
        If it states none.
    """
    settings = stated(folder).get("settings")
    if not isinstance(settings, dict):
        raise KeyError("settings")
    return settings


def run_settings(folder: Path) -> dict[str, Any]:
    """The same; none where there is no such file that can be read."""
    try:
        return stated_settings(Path(folder))
    except (OSError, ValueError, KeyError):
        return {}
