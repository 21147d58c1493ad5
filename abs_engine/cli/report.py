"""The `report` command."""

from __future__ import annotations

import shlex
from argparse import ArgumentParser, Namespace
from pathlib import Path

from abs_engine.cli.progress import Progress
from abs_engine.io.files import check_free


def add_arguments(command: ArgumentParser) -> None:
    """What can be typed after `report`."""
    command.add_argument(
        "results", type=Path, nargs="+", metavar="RUN",
        help="what 'track -o' made; with --truth also a CSV file of another system, as for "
        "'evaluate'",
    )  # fmt: skip
    command.add_argument(
        "-o", "--output", type=Path, metavar="FILE", required=True,
        help="the HTML file, must not exist",
    )  # fmt: skip
    command.add_argument(
        "--truth", type=Path, metavar="DIR",
        help="what 'synth -o' made, or DATASET/CLIP/CAMERA; without it nothing is scored",
    )  # fmt: skip
    command.add_argument("--clip", metavar="NAME", help="clip of the dataset, if it has several")
    command.add_argument("--camera", metavar="NAME", help="camera of the clip, if it has several")
    command.add_argument(
        "--video", type=Path, metavar="FILE",
        help="the video that was tracked (default: the truth's, or that beside the run)",
    )  # fmt: skip
    command.add_argument(
        "--seed", type=int, default=0, help="seed of the confidence intervals (default: 0)"
    )


def report(chosen: Namespace) -> int:
    """Write one HTML file about one run or several."""
    check_free(chosen.output, ".html")

    from abs_engine.report.gathering import ReportOptions, write_report

    options = ReportOptions(
        truth=chosen.truth,
        clip=chosen.clip,
        camera=chosen.camera,
        video=chosen.video,
        seed=chosen.seed,
        command=_command_line(chosen),
    )
    with Progress("report") as progress:
        write_report(chosen.results, chosen.output, options, progress.announce)
    print(f"wrote {chosen.output}; open it in a browser")
    return 0


def _command_line(chosen: Namespace) -> str:
    words = ["abs-engine", "report", *map(str, chosen.results)]
    for name in ("truth", "clip", "camera", "video", "output"):
        value = getattr(chosen, name)
        words += [f"--{name}", str(value)] if value is not None else []
    words += ["--seed", str(chosen.seed)] if chosen.seed else []
    return shlex.join(words)
