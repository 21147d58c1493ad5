"""What can be typed."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from pathlib import Path
from typing import NoReturn

from abs_engine.cli import commands
from abs_engine.release import engine_version

RENDERERS = ("auto", "egl-device", "egl-surfaceless", "osmesa", "cpu")
Run = Callable[[argparse.Namespace], int]


class Parser(argparse.ArgumentParser):
    """A parser whose complaints take one line."""

    def error(self, message: str) -> NoReturn:
        """End with status 2."""
        line = " ".join(message.split())
        self.exit(2, f"abs-engine: error: {line}; see '{self.prog} --help'\n")


def build_parser() -> Parser:
    """The parser of the whole command line; `run` of what it returns is the command."""
    parser = Parser(
        prog="abs-engine",
        description="Tracks 3D face and lip motion in video by rendering the face and comparing.",
        epilog="Exit status: 0; 2 when the input or the machine is at fault; 130 when interrupted.",
    )
    parser.add_argument("--version", action="version", version=f"abs-engine {engine_version()}")
    parser.set_defaults(command=None)
    commands_of = parser.add_subparsers(dest="command", metavar="COMMAND")

    def add(name: str, run: Run, text: str) -> argparse.ArgumentParser:
        command: argparse.ArgumentParser = commands_of.add_parser(name, help=text, description=text)
        command.set_defaults(run=run)
        return command

    add("doctor", commands.doctor, "say which OpenGL this machine gives, and how to mend it")
    _demo(add("demo", commands.demo, "film the bundled head, track it, compare with the truth"))
    _synth(add("synth", commands.synth, "film a bundled person, with ground truth"))
    _track(add("track", commands.track, "track the lips in a video"))
    _evaluate(add("evaluate", commands.evaluate, "compare a run with the ground truth of its clip"))
    _bench(add("bench", commands.bench, "time one evaluation beside pyrender and NumPy"))
    _render(add("render", commands.render, "draw a posture of a bundled person as PNG"))
    return parser


def _demo(command: argparse.ArgumentParser) -> None:
    command.add_argument(
        "-o", "--output", type=Path, metavar="DIR",
        help="report folder, must not exist; by default runs/demo, runs/demo-2, ...",
    )  # fmt: skip
    command.add_argument("--frames", type=_count, help="length of the clip (default: 50)")
    command.add_argument(
        "--average-head",
        action="store_true",
        help="track with the average head (default: with the filmed person's own)",
    )
    _renderer(command)


def _synth(command: argparse.ArgumentParser) -> None:
    command.add_argument(
        "sentence", metavar="SENTENCE",
        help="demo, wolves, vowels, closures, or viseme symbols in quotes: '_ m a p i _'",
    )  # fmt: skip
    _output(command, "DIR", "folder of the clip and its ground truth")
    command.add_argument("--person", default="clara", help="who is filmed (default: clara)")
    command.add_argument(
        "--size", type=_count, nargs=2, default=(320, 240), metavar=("WIDTH", "HEIGHT"),
        help="even numbers of pixels (default: 320 240)",
    )  # fmt: skip
    command.add_argument("--frames", type=_count, help="length (default: as the sentence takes)")
    command.add_argument(
        "--seed", type=int, default=0, help="of head motion and noise (default: 0)"
    )
    command.add_argument("--lossless", action="store_true", help="also write lossless.mp4")


def _track(command: argparse.ArgumentParser) -> None:
    command.add_argument("video", type=Path, metavar="VIDEO")
    _output(command, "RUN", "folder of the results")
    command.add_argument(
        "--mouth", type=float, nargs=4, metavar=("X", "Y", "W", "H"),
        help="box around the mouth in the first frame, pixels; by default it is found",
    )  # fmt: skip
    command.add_argument(
        "--person", metavar="NAME", help="a known head: one of the speaker's people"
    )
    command.add_argument(
        "--camera", type=Path, metavar="FILE", help="camera.json of its calibration"
    )
    command.add_argument("--speaker", type=Path, metavar="FILE", help="head.npz of another speaker")
    _renderer(command)


def _evaluate(command: argparse.ArgumentParser) -> None:
    command.add_argument("folder", type=Path, metavar="RUN", help="what 'track -o' made")
    command.add_argument(
        "--truth", type=Path, metavar="DIR", required=True, help="what 'synth -o' made"
    )
    command.add_argument(
        "-o", "--output", type=Path, metavar="DIR",
        help="folder of the scores, must not exist (default: RUN/evaluation)",
    )  # fmt: skip


def _bench(command: argparse.ArgumentParser) -> None:
    command.add_argument("--json", type=Path, metavar="FILE", help="also write the numbers there")
    command.add_argument("--rounds", type=_count, help="turns of every way (default: 50)")


def _render(command: argparse.ArgumentParser) -> None:
    _output(command, "FILE", "the PNG")
    command.add_argument("--person", default="clara", help="who is drawn (default: clara)")
    command.add_argument(
        "--unit", action="append", default=[], metavar="NAME=WEIGHT", type=_unit, dest="units",
        help="a face unit of the posture, such as jawOpen=0.4; may be repeated",
    )  # fmt: skip
    command.add_argument(
        "--palette", choices=("colour", "classes"), default="colour", help="what is shown"
    )
    command.add_argument(
        "--size", type=_count, nargs=2, default=(512, 512), metavar=("WIDTH", "HEIGHT"),
        help="pixels (default: 512 512)",
    )  # fmt: skip
    command.add_argument(
        "--turn", type=float, default=0.0, metavar="DEGREES", help="to the head's left"
    )
    _renderer(command)


def _output(command: argparse.ArgumentParser, what: str, text: str) -> None:
    command.add_argument(
        "-o", "--output", type=Path, metavar=what, required=True, help=f"{text}; must not exist"
    )


def _renderer(command: argparse.ArgumentParser) -> None:
    command.add_argument(
        "--renderer", choices=RENDERERS, default="auto",
        help="what draws; auto: OpenGL, or the CPU where none loads",
    )  # fmt: skip


def _count(text: str) -> int:
    number = int(text)
    if number < 1:
        raise argparse.ArgumentTypeError(f"{text} is not 1 or more")
    return number


def _unit(text: str) -> tuple[str, float]:
    name, _, weight = text.partition("=")
    try:
        return name, float(weight)
    except ValueError:
        raise argparse.ArgumentTypeError(f"'{text}' is not NAME=WEIGHT") from None
