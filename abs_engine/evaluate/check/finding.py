"""Findings of the checker about a dataset."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace


@dataclass(frozen=True)
class Finding:
    """Something wrong in a dataset.

    Parameters
    ----------
    file : str
        File or folder, relative to the dataset.
    how_much : str
        The number that was measured and what it should be; may be empty.
    frame : int, optional
        The first frame in which it was seen.
    frames : int
        In how many of the frames that were looked at.
    """

    file: str
    what: str
    how_much: str = ""
    frame: int | None = None
    frames: int = 1

    def __str__(self) -> str:
        """One line."""
        others = f" and {self.frames - 1} more" if self.frames > 1 else ""
        where = "" if self.frame is None else f" frame {self.frame}{others}:"
        amount = f" ({self.how_much})" if self.how_much else ""
        return f"{self.file}:{where} {self.what}{amount}"


def merged(findings: Iterable[Finding]) -> list[Finding]:
    """The same finding in several frames of the same file or folder as one, in order."""
    first: dict[tuple[str, str, bool], Finding] = {}
    for finding in findings:
        key = finding.file, finding.what, finding.frame is None
        if key in first:
            first[key] = replace(first[key], frames=first[key].frames + finding.frames)
        else:
            first[key] = finding
    return list(first.values())
