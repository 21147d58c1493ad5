"""Words of messages."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence

_MOST = 60  # names in a line: every face unit of a head, but not all 700 targets of a film's
_LONGEST = 80  # characters of a value in a line; arrays of a run would fill the terminal


def counted(count: int, what: str) -> str:
    """A count and its noun, given in the singular: "1 frame", "2 frames"."""
    return f"{count} {what}" if count == 1 else f"{count} {what}s"


def shown(value: object) -> str:
    """A value as Python writes it; of a long one, the beginning."""
    written = repr(value)
    return written if len(written) <= _LONGEST else f"{written[:_LONGEST]} ..."


def legible(name: str) -> str:
    """A name as text in UTF-8: bytes of a file's name that are none are written as escapes."""
    return name.encode("utf-8", "backslashreplace").decode("utf-8")


def joined(names: Sequence[str], last: str) -> str:
    """Names in a sentence, a word before the last: "a, b or c"."""
    return f" {last} ".join(filter(None, (", ".join(names[:-1]), *names[-1:])))


def each_counted(counts: Mapping[str, int]) -> str:
    """Reasons and in how many each: "mouth covered in 16, face not found in 2"."""
    return ", ".join(f"{reason} in {count}" for reason, count in counts.items())


def listed(names: Collection[str]) -> str:
    """Names one behind the other; of very many, how many more there are."""
    more = f" and {len(names) - _MOST} more" if len(names) > _MOST else ""
    return ", ".join(list(names)[:_MOST]) + more
