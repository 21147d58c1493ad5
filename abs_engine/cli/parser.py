"""What can be typed."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from pathlib import Path
from typing import Any, NoReturn

from abs_engine.cli import check, commands, report
from abs_engine.cli.articulate import add_articulate, articulate
from abs_engine.cli.cameras import add_cameras, cameras
from abs_engine.cli.observe import add_observe, observe
from abs_engine.cli.render import add_render
from abs_engine.cli.reproduce import add_reproduce, reproduce
from abs_engine.cli.track import add_track, count, leaves
from abs_engine.cli.train import add_train, train
from abs_engine.core.registry import nearest
from abs_engine.core.release import engine_version

EVALUATE_FORMATS = """\
CSV files, with the column names in the first line:
  landmarks, a row a point    frame,point,x,y,unit, optionally time,z,space: point 0 to 67 in the
                              order of 300-W, unit px or mm, space camera (default) or head
  landmarks, a row a frame    frame, x_0 to y_67 in px and/or X_0 to Z_67 in mm, camera coordinates;
                              optionally timestamp, success, pose_Tx to pose_Rz (as OpenFace 2)
  ARKit, a row a frame        the 52 face units; optionally Timecode, HeadYaw, HeadPitch, HeadRoll
                              (as Live Link Face)
Every frame of the clip must be there, counted from 0 or 1; cells of lost frames are empty.
Numbers in brackets are 95 % confidence intervals.
"""
Run = Callable[[argparse.Namespace], int]


class Parser(argparse.ArgumentParser):
    """A parser whose complaints take one line, and name the command's own help.

    With `intermixed`, what is named may stand before, between or after the options. `more` makes
    the last lines of its help.
    """

    intermixed = False
    more: Callable[[], str] | None = None
    _within = False

    def format_help(self) -> str:
        """As `argparse`'s; and after it what is found out only if it is asked for."""
        return super().format_help() + ("" if self.more is None else self.more())

    def parse_known_args(self, args: Any = None, namespace: Any = None) -> Any:
        """As `argparse`'s; but optional positionals stand anywhere, if told to.

        And a command complains of what it does not know itself, not the whole program for it.
        """
        if self._within:
            return super().parse_known_args(args, namespace)
        self._within = True  # the intermixed one calls back
        try:
            if self.intermixed:
                found, unknown = self.parse_known_intermixed_args(args, namespace)
            else:
                found, unknown = super().parse_known_args(args, namespace)
        finally:
            self._within = False
        if unknown and " " in self.prog:
            self.error(f"unrecognized arguments: {' '.join(unknown)}")
        return found, unknown

    def _check_value(self, action: argparse.Action, value: Any) -> None:
        """Complain of what is not among the choices, with the nearest of them."""
        if action.choices is not None and value not in action.choices:
            known = [str(choice) for choice in action.choices]
            what = "command" if isinstance(action, argparse._SubParsersAction) else "choice"
            raise argparse.ArgumentError(
                None if what == "command" else action,
                f"there is no {what} '{value}'; {nearest(str(value), known)}",
            )

    def error(self, message: str) -> NoReturn:
        """End with status 2."""
        line = " ".join(message.split())
        self.exit(2, f"abs-engine: error: {line}; see '{self.prog} --help'\n")


def build_parser() -> Parser:
    """The parser of the whole command line; `run` of what it returns is the command."""
    parser = Parser(
        prog="abs-engine",
        description="Recovers 3D face and lip motion from video: it renders and compares.",
        epilog="Exit status: 0 on success; 1 if doctor finds no OpenGL, or check a fault; 2 if the "
        "input or the machine is at fault; 130 if interrupted.",
    )
    parser.add_argument("--version", action="version", version=f"abs-engine {engine_version()}")
    parser.set_defaults(command=None)
    commands_of = parser.add_subparsers(dest="command", metavar="COMMAND")

    def add(name: str, run: Run, text: str) -> Parser:
        command: Parser = commands_of.add_parser(name, help=text, description=text)
        command.set_defaults(run=run)
        return command

    add("doctor", commands.doctor, "report which OpenGL this machine has, and how to repair it")
    _demo(add("demo", commands.demo, "film the bundled head, track it, compare with the truth"))
    _synth(add("synth", commands.synth, "film a scene with ground truth"))
    add_observe(add("observe", observe, "calibrate cameras; turn dots in two views into 3D points"))
    add_train(add("train", train, "learn how lips move from observed dots"))
    add_cameras(
        add("cameras", cameras, "rank camera positions by what they would reveal of trained lips")
    )
    _articulate(add("articulate", articulate, "build an articulatory model of a corpus of visemes"))
    tracking = add("track", commands.track, "track the lips in a video")
    tracking.more = leaves
    _output(tracking, "RUN", "folder of the results")
    add_track(tracking)
    _renderer(tracking)
    _evaluate(
        add("evaluate", commands.evaluate, "score results, ours or others', against ground truth")
    )
    check.add_arguments(add("check", check.check, "look for faults in a dataset with ground truth"))
    report.add_arguments(
        add("report", report.report, "write one HTML file about one or several runs")
    )
    _bench(add("bench", commands.bench, "time one evaluation, or the tracking of a clip"))
    _render(add("render", commands.render, "draw postures, nomograms, overlays, labels, errors"))
    _reproduce(add("reproduce", reproduce, "make a paper's tables and figures on our own data"))
    return parser


def _demo(command: argparse.ArgumentParser) -> None:
    command.add_argument(
        "-o", "--output", type=Path, metavar="DIR",
        help="report folder, must not exist (default: runs/demo, runs/demo-2, ...)",
    )  # fmt: skip
    command.add_argument("--frames", type=count, help="length of the clip (default: 50)")
    command.add_argument(
        "--average-head",
        action="store_true",
        help="track with the average head (default: with the filmed person's own)",
    )
    _renderer(command)


def _synth(command: argparse.ArgumentParser) -> None:
    command.add_argument(
        "what", metavar="SCENE",
        help="a scene file, NAME.toml (bundled: short.toml, speech.toml, session.toml, "
        "ten_thousand.toml, and reference.toml, which has every key); or demo, "
        "wolves, vowels, closures, or viseme symbols in quotes: '_ m a p i _'",
    )  # fmt: skip
    _output(command, "DIR", "folder of the dataset; after an interruption the same command resumes")
    command.add_argument(
        "--processes",
        type=count,
        help="how many processes film at once (default: one for each core)",
    )
    sentence = command.add_argument_group("for a sentence; a scene file has its own")
    sentence.add_argument("--person", help="who is filmed (default: clara)")
    sentence.add_argument(
        "--size", type=count, nargs=2, metavar=("WIDTH", "HEIGHT"),
        help="size of the picture, even numbers of pixels (default: 320 240)",
    )  # fmt: skip
    sentence.add_argument("--frames", type=count, help="length (default: that of the sentence)")
    sentence.add_argument("--seed", type=int, help="seed of head motion and noise (default: 0)")
    sentence.add_argument(
        "--lossless", action="store_true", help="keep every picture before compression, as PNG"
    )


def _evaluate(command: argparse.ArgumentParser) -> None:
    command.formatter_class = argparse.RawDescriptionHelpFormatter
    command.epilog = EVALUATE_FORMATS
    command.add_argument(
        "results", type=Path, nargs="+", metavar="RUN",
        help="what 'track -o' made, or a CSV file of another system",
    )  # fmt: skip
    command.add_argument(
        "--truth", type=Path, nargs="+", metavar="DIR", required=True,
        help="what 'synth -o' made, or DATASET/CLIP/CAMERA; one for all, or one for each RUN, "
        "which are then also pooled as clips",
    )  # fmt: skip
    command.add_argument("--clip", metavar="NAME", help="clip of the dataset, if it has several")
    command.add_argument("--camera", metavar="NAME", help="camera of the clip, if it has several")
    command.add_argument(
        "-o", "--output", type=Path, metavar="DIR",
        help="folder of the scores, must not exist (default: RUN/evaluation)",
    )  # fmt: skip
    command.add_argument(
        "--seed", type=int, default=0, help="seed of the confidence intervals (default: 0)"
    )


def _bench(command: argparse.ArgumentParser) -> None:
    command.add_argument(
        "--json", type=Path, metavar="FILE", help="also write the results to this file, as JSON"
    )
    command.add_argument(
        "--rounds", type=count, help="repetitions of each way (default: 50; 3 with --clip)"
    )
    command.add_argument(
        "--clip",
        type=Path,
        metavar="VIDEO",
        help="time the tracking of this video instead of one evaluation",
    )
    command.add_argument(
        "--peer-python",
        type=Path,
        metavar="PYTHON",
        help="with --clip: a Python with mediapipe installed, whose face mesh is timed by turns",
    )
    command.add_argument(
        "--renderer", metavar="NAME", help="with --clip: the renderer, such as cpu (default: auto)"
    )


def _render(command: Parser) -> None:
    _output(command, "FILE", "a PNG or an MP4")
    add_render(command)
    command.intermixed = True
    _renderer(command)


def _articulate(command: Parser) -> None:
    _output(command, "DIR", "folder of the model, its tables and figures; with --model a CSV")
    add_articulate(command)
    command.intermixed = True
    _renderer(command)


def _reproduce(command: argparse.ArgumentParser) -> None:
    add_reproduce(command)
    _renderer(command)


def _output(command: argparse.ArgumentParser, what: str, text: str) -> None:
    command.add_argument(
        "-o", "--output", type=Path, metavar=what, required=True, help=f"{text}; must not exist"
    )


def _renderer(command: argparse.ArgumentParser) -> None:
    command.add_argument(
        "--renderer", metavar="NAME", default="auto",
        help="what draws; auto: OpenGL, or the CPU if none loads. Without a GPU, cpu is faster",
    )  # fmt: skip
