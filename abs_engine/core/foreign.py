"""Code that is not the engine's: which that is, and what is said where it fails."""

from __future__ import annotations

import os
import subprocess
import traceback
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import IO, Any

from abs_engine.core.errors import AbsEngineError, PluginError

FAILURES = Exception, SystemExit
"""What a plugin may raise: one that ends the program has failed, too."""
_ENGINE = str(Path(__file__).resolve().parents[1]) + os.sep


def last_words(process: subprocess.Popen[Any], complaints: IO[bytes]) -> str:
    """Wait for a process that has ended: the last line of its complaints, or its exit status."""
    code = process.wait()
    complaints.seek(0)
    lines = complaints.read().decode(errors="replace").strip().splitlines()
    return lines[-1].strip()[:200] if lines else f"exit status {code}"


def own(made: object) -> bool:
    """Whether a class or function, or what a partial calls, is the engine's, and no plugin's."""
    made = getattr(made, "func", made)
    return str(getattr(made, "__module__", "")).startswith("abs_engine.")


def named(error: BaseException) -> str:
    """An error by its kind and message, on one line."""
    return " ".join(f"{type(error).__name__}: {error}".split())


def reason(error: BaseException) -> str:
    """An error by its kind and message, and the last line of a plugin's file that led to it.

    The file is the first outside the engine that was entered.
    """
    entered = [
        frame for frame in traceback.extract_tb(error.__traceback__)
        if not frame.filename.startswith((_ENGINE, "<"))
    ]  # fmt: skip
    theirs = entered[0].filename if entered else ""
    lines = [frame.lineno for frame in entered if frame.filename == theirs]
    where = f" in {Path(theirs).name}, line {lines[-1]}" if lines else ""
    return f"({named(error)}){where}"


@contextmanager
def blamed(
    what: str, kind: type[AbsEngineError] = PluginError, remedy: str = "correct its plugin"
) -> Iterator[None]:
    """Raise errors of a plugin's part, `what`, as one of a kind that names it; named ones stay."""
    try:
        yield
    except AbsEngineError:
        raise
    except FAILURES as error:
        raise kind(f"{what} fails {reason(error)}", remedy) from error
