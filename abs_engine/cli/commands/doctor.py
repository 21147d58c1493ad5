"""The `doctor` command."""

from __future__ import annotations

from dataclasses import asdict

from abs_engine.cli.parts.command import Chosen, Done, command
from abs_engine.cli.parts.progress import Progress


@command(
    "This machine, and published results",
    examples="abs-engine doctor\nabs-engine doctor --json",
    notes="Exit status: 0 if OpenGL works, 1 if only the CPU rasteriser does.\n",
)
def doctor(_chosen: Chosen) -> Done:
    """Report which OpenGL this machine has, and how to repair it."""
    from abs_engine.render.diagnose import diagnose, report_lines

    with Progress("doctor") as progress:
        progress.announce("trying every renderer")
        found = diagnose()
    return Done(report_lines(found), asdict(found), found.exit_status)
