"""``SHA256SUMS``: what a folder's files were when it was written, as ``sha256sum -c`` reads it.

What the folder took to make, ``timing.json``, is not among them: it differs from time to time. Nor
is the record of the choices that made it, which is written last.
"""

from __future__ import annotations

import hashlib
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path

from abs_engine.core.clock import TIMING
from abs_engine.core.errors import InputFileError, ModelFormatError, ParameterError
from abs_engine.dataset.picture import AGAIN
from abs_engine.io.inputs import check_file
from abs_engine.io.naming import RECORD

SUMS = "SHA256SUMS"
_LATER = SUMS, TIMING, RECORD
_LINE = re.compile("(?P<digest>[0-9a-f]{64})  (?P<name>.+)")


def digest(path: Path) -> str:
    """SHA-256 of a file, in hexadecimal."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def check_distinct(videos: Sequence[tuple[Path, Path]], remedy: str = "give it once") -> None:
    """Raise `ParameterError` if a video comes twice; each item is what was given, and its video."""
    known: dict[str, Path] = {}
    for given, video in videos:
        content = digest(video)
        if content in known:
            raise ParameterError(f"{known[content]} and {given} come from the same video", remedy)
        known[content] = given


def write_sums(folder: Path) -> None:
    """Write the list of all other files of a folder but the timing and the record."""
    lines = [f"{digest(folder / name)}  {name}\n" for name in file_names(folder)]
    (folder / SUMS).write_text("".join(lines), encoding="utf-8")


def file_names(folder: Path) -> list[str]:
    """Names of all files below a folder but `_LATER`, sorted, with '/' between."""
    paths = (p for p in folder.rglob("*") if p.is_file())
    return sorted(n for n in (p.relative_to(folder).as_posix() for p in paths) if n not in _LATER)


def read_sums(folder: Path) -> dict[str, str]:
    """Digests by name.

    Raises
    ------
    InputFileError
        If there is no list.
    ModelFormatError
        If a line of it is no digest and the name of a file within the folder.
    """
    listed = folder / SUMS
    if not listed.is_file():
        raise InputFileError(f"{folder} is not a dataset: {SUMS} is missing", "check the path")
    check_file(listed)
    text = listed.read_text(encoding="utf-8", errors="replace")
    lines = [_LINE.fullmatch(line) for line in text.split("\n")[:-1]]
    sums = {line["name"]: line["digest"] for line in lines if line}
    outside = any(name.startswith("/") or ".." in name.split("/") for name in sums)
    if outside or len(sums) < len(lines) or not text.endswith("\n"):
        raise ModelFormatError(f"{listed} is not a list of digests of files within", AGAIN)
    return sums


def wrong_sums(
    folder: Path, sums: Mapping[str, str], names: Iterable[str]
) -> Iterator[tuple[str, str]]:
    """Files that are not what they were: name, and "missing", "altered" or "not listed"."""
    for name in names:
        if not (folder / name).is_file():
            yield name, "missing"
        elif name not in sums:
            yield name, "not listed"
        elif digest(folder / name) != sums[name]:
            yield name, "altered"


def check_sums(folder: Path, only: Iterable[str] | None = None) -> None:
    """Compare files of a folder with its ``SHA256SUMS``.

    Parameters
    ----------
    only : iterable of str, optional
        Names of the files to check, by default all that are listed.

    Raises
    ------
    InputFileError
        If the list or a file is missing.
    ModelFormatError
        If a file differs from what was written, or is not listed.
    """
    folder = Path(folder)
    sums = read_sums(folder)
    for name, problem in wrong_sums(folder, sums, sums if only is None else only):
        if problem == "missing":
            raise InputFileError(f"{folder / name} does not exist", AGAIN)
        said = "was altered after it was written" if problem == "altered" else "is not listed"
        raise ModelFormatError(f"{folder / name} {said}", AGAIN)
