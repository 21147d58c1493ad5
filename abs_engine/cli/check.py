"""The `check` command."""

from __future__ import annotations

from argparse import ArgumentParser, ArgumentTypeError, Namespace
from pathlib import Path

from abs_engine.cli.progress import Progress

CLEAN, FAULTY = 0, 1
_FRAMES = 40


def add_arguments(command: ArgumentParser) -> None:
    """What can be typed after `check`."""
    command.epilog = "Exit status: 0 where nothing is wrong, 1 otherwise; 2 for what is no dataset."
    command.add_argument("dataset", type=Path, metavar="DATASET", help="what 'synth -o' made")
    command.add_argument(
        "--frames", type=_frames, default=_FRAMES, metavar="N",
        help=f"look into N frames of each view, evenly spread, or 'all' (default: {_FRAMES}); "
        "checksums, files and arrays are checked for all frames",
    )  # fmt: skip


def check(chosen: Namespace) -> int:
    """Verify a dataset; print what is wrong, one finding a line."""
    from abs_engine.evaluate.check import check_dataset

    with Progress("checking") as progress:
        progress.announce("checksums")
        found = check_dataset(chosen.dataset, frames=chosen.frames or None, progress=progress)
    for finding in found:
        print(finding)
    print("nothing wrong" if not found else f"{len(found)} findings")
    return FAULTY if found else CLEAN


def _frames(text: str) -> int:
    """A number of frames; 0 stands for all."""
    if text == "all":
        return 0
    if not text.isdecimal() or int(text) < 1:
        raise ArgumentTypeError(f"{text} is neither 'all' nor 1 or more")
    return int(text)
