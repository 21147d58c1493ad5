"""Provenance of results: release, commit, and whether the code had uncommitted changes."""

from __future__ import annotations

import hashlib
import json
import os
import subprocess
from collections.abc import Mapping
from functools import cache
from pathlib import Path
from typing import Any

from abs_engine.core.release import engine_version
from abs_engine.core.words import listed

FIGURES = "these figures"
"""Name of what a page itself works out, for `caution`."""

_PACKAGE = Path(__file__).resolve().parents[1]
_BUILT = _PACKAGE / "_data" / "commit.json"  # written when a wheel is built
CODE = ("abs_engine", "shaders", "assets", "pyproject.toml", "constraints.txt")
"""What results depend on; changes of pages and tests do not count."""
_DATA = (
    "shaders", "assets/speaker", "assets/detector", "assets/lips", "assets/postures",
    "assets/population",
)  # fmt: skip


@cache
def made_by() -> dict[str, Any]:
    """Provenance of a result: the code that made it.

    `engine_version`; `commit`, its full name, or None where it is not known; `dirty`, whether
    `CODE` had changes that are in no commit, None where that is not known.
    """
    commit, dirty = _of_checkout(_PACKAGE.parent) or _of_wheel() or (None, None)
    return {"engine_version": engine_version(), "commit": commit, "dirty": dirty}


def described(made: Mapping[str, Any]) -> str:
    """A release and its commit in words, from what `made_by` gave, or an older result."""
    release = f"abs_engine {made.get('engine_version', 'of an unknown release')}"
    commit = made.get("commit")
    return f"{release}, commit {commit[:12] if isinstance(commit, str) else 'unknown'}"


def caution(sources: Mapping[str, Mapping[str, Any]]) -> str | None:
    """Reason why a page may not be published; None where it may.

    `sources` are what its figures come from, each in a few words, and the provenance of it: what
    `made_by` gave then, or an older result.
    """
    unknown = [name for name, made in sources.items() if made.get("commit") is None]
    changed = [
        name
        for name, made in sources.items()
        if name not in unknown and made.get("dirty") is not False
    ]
    reasons = [f"it is not known which commit made {listed(unknown)}"] if unknown else []
    if changed:
        reasons.append(f"the code that made {listed(changed)} had changes that are in no commit")
    return f"Not for publication: {'; '.join(reasons)}." if reasons else None


@cache
def code_digest() -> str:
    """SHA-256 of the package's own source and data, for what is kept from one run to the next."""
    seen = hashlib.sha256()
    parts = [folder / part for folder in (_PACKAGE / "_data", _PACKAGE.parent) for part in _DATA]
    data = (path for part in parts for path in part.rglob("*") if path.is_file())
    for path in sorted([*_PACKAGE.rglob("*.py"), *data]):
        seen.update(os.path.relpath(path, _PACKAGE).encode())
        seen.update(path.read_bytes())
    return seen.hexdigest()


def _of_checkout(root: Path) -> tuple[str, bool] | None:
    if not (root / ".git").exists():
        return None
    try:
        commit = _git(root, "rev-parse", "HEAD").strip()
        return commit, bool(_git(root, "status", "--porcelain", "--", *CODE).strip())
    except (OSError, subprocess.SubprocessError):
        return None


def _of_wheel() -> tuple[str | None, bool | None] | None:
    if not _BUILT.is_file():
        return None
    built = json.loads(_BUILT.read_text(encoding="utf-8"))
    return built["commit"], built["dirty"]


def _git(root: Path, *words: str) -> str:
    command = ["git", "--no-optional-locks", "-C", str(root), *words]
    return subprocess.run(command, capture_output=True, text=True, check=True, timeout=30).stdout
