"""The commands. No mathematics here."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from importlib.metadata import version


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command; the exit status."""
    parser = argparse.ArgumentParser(prog="abs-engine", description=__doc__)
    parser.add_argument(
        "--version", action="version", version=f"abs-engine {version('abs-engine')}"
    )
    parser.parse_args(arguments)
    parser.print_help()
    return 2
