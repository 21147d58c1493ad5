"""Words of messages."""

from __future__ import annotations

from collections.abc import Collection

_MOST = 60  # names in a line: every face unit of a head, but not all 700 targets of a film's


def counted(count: int, what: str) -> str:
    """A count and its noun, given in the singular: "1 frame", "2 frames"."""
    return f"{count} {what}" if count == 1 else f"{count} {what}s"


def listed(names: Collection[str]) -> str:
    """Names one behind the other; of very many, how many more there are."""
    more = f" and {len(names) - _MOST} more" if len(names) > _MOST else ""
    return ", ".join(list(names)[:_MOST]) + more
