"""Words of messages."""

from __future__ import annotations


def counted(count: int, what: str) -> str:
    """A count and its noun, given in the singular: "1 frame", "2 frames"."""
    return f"{count} {what}" if count == 1 else f"{count} {what}s"
