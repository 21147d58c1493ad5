"""The `check` command."""

from __future__ import annotations

import os
import shlex
from dataclasses import asdict
from pathlib import Path

import click

from abs_engine.cli.parts import options as take
from abs_engine.cli.parts.command import Chosen, Done, command
from abs_engine.cli.parts.progress import Progress
from abs_engine.core.errors import InputFileError
from abs_engine.core.words import counted

CLEAN, FAULTY = 0, 1
_FRAMES = 40


def _frames(text: str | int) -> int:
    """A number of frames; 0 stands for all."""
    if text == "all":
        return 0
    if not str(text).isdecimal() or int(text) < 1:
        raise click.BadParameter(f"{text} is neither 'all' nor a whole number above 0")
    return int(text)


@command(
    "Film ground truth and score against it",
    take.argument("dataset", "DATASET", "what 'synth -o' made"),
    take.option(
        "--frames", type=_frames, default=_FRAMES, metavar="N",
        text=f"look at N frames of each view, evenly spread, or 'all' (default: {_FRAMES}); "
        "checksums, files and arrays are checked for all frames",
    ),
    examples="abs-engine check data\nabs-engine check data --frames all",
    notes="Exit status: 0 if nothing is wrong, 1 otherwise; 2 if it is not a dataset.\n",
)  # fmt: skip
def check(chosen: Chosen) -> Done:
    """Look for faults in a dataset with ground truth; print a line for each."""
    from abs_engine.evaluate.check import check_dataset

    _check_whole(chosen.dataset)
    with Progress("checking") as progress:
        progress.announce("checksums")
        found = check_dataset(chosen.dataset, frames=chosen.frames or None, progress=progress)
    lines = [*map(str, found), "nothing wrong" if not found else counted(len(found), "finding")]
    return Done(lines, {"findings": [asdict(one) for one in found]}, FAULTY if found else CLEAN)


def _check_whole(folder: Path) -> None:
    """Raise `InputFileError` for a clip or a camera of a dataset, which is checked as a whole."""
    from abs_engine.dataset import codec

    if (folder / codec.DATASET).is_file():
        return
    for root in folder.resolve().parents[:3]:
        if (root / codec.DATASET).is_file():
            shown = min(str(root), os.path.relpath(root), key=len)
            raise InputFileError(
                f"{folder} is a part of the dataset {shown}, which is checked as a whole",
                f"type 'abs-engine check {shlex.quote(shown)}'",
            )
