"""The engine's release."""

from __future__ import annotations

from functools import cache
from importlib import metadata


@cache
def engine_version() -> str:
    """The installed version, or "source" where the package runs without being installed."""
    try:
        return metadata.version("abs-engine")
    except metadata.PackageNotFoundError:
        return "source"
