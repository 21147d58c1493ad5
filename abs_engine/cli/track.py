"""What `track` takes."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from abs_engine.core.registry import DRIVERS, MODELS, PRESETS, TERMS

if TYPE_CHECKING:
    from abs_engine.tracking.options import TrackOptions

TRACK_FORMATS = """\
Head poses come from a run or filmed truth (its folder), or from a file:
  CSV   a line of names, then a row for each frame: head_rx head_ry head_rz (rotation vector,
        radians) and head_tx head_ty head_tz (mm), as results.csv of a run; empty where not known
  NPZ   rotation, (T, 3) vectors or (T, 3, 3) matrices, and translation (T, 3), as results.npz of a
        run; NaN, or False in found, where not known
x_cam = R x_head + t, from the head (x to the subject's left, y up, z out of the face) to the camera
(x right, y down, z forward): a face that looks into it is turned by half a turn about x. Poses are
taken as they are with --person, otherwise as a first guess; frames without one are not tracked.
"""


NEEDS = """\
The drivers forces, fixed-step and newton need colour; axes and levenberg need texture or local."""


def leaves() -> str:
    """What can be chosen by name, lines."""
    kinds = ("presets", PRESETS), ("models", MODELS), ("terms", TERMS), ("drivers", DRIVERS)
    lines = [f"{title + ':':<10}{', '.join(registry.names())}" for title, registry in kinds]
    return "\n" + "\n".join(lines) + f"\n{NEEDS}\n"


def add_track(command: argparse.ArgumentParser) -> None:
    """Add what `track` takes to its parser."""
    command.formatter_class = argparse.RawDescriptionHelpFormatter
    command.epilog = TRACK_FORMATS
    command.add_argument(
        "video", type=Path, metavar="VIDEO", help="a video of somebody who speaks to the camera"
    )
    command.add_argument(
        "--mouth", type=float, nargs=4, metavar=("X", "Y", "W", "H"),
        help="box around the mouth to track in the first frame, pixels (default: it is found)",
    )  # fmt: skip
    command.add_argument(
        "--person", metavar="NAME",
        help="a known head: one of the speaker's people (bundled: clara, kofi, mei, walter, "
        "amara, ravi); default: the average head, whose mouth is fitted",
    )  # fmt: skip
    _add_parts(command)
    command.add_argument(
        "--start", choices=("landmarks", "blobs"),
        help="how an unknown head is placed: by a landmark network, or by colour as in the papers "
        "(default: landmarks)",
    )  # fmt: skip
    command.add_argument(
        "--face", type=count, metavar="N",
        help="which face to track, counted from 1, the largest first (default: the largest)",
    )  # fmt: skip
    command.add_argument(
        "--pupil-distance", type=float, metavar="MM",
        help="distance between the person's pupils; sets the scale (default: 63.4, adults' mean)",
    )  # fmt: skip
    command.add_argument(
        "--evidence", choices=("both", "rendering", "landmarks"), default="both",
        help="kinds of evidence to use in each frame (default: both)",
    )  # fmt: skip
    command.add_argument(
        "--camera", type=Path, metavar="FILE", help="camera.json of the camera's calibration"
    )
    command.add_argument("--speaker", type=Path, metavar="FILE", help="head.npz of another speaker")
    command.add_argument(
        "--colours", type=Path, metavar="FILE",
        help="colours.npz of a run of the same person and light (default: learn them)",
    )  # fmt: skip
    command.add_argument(
        "--physics", type=Path, metavar="FILE", help="how the lips move, as 'train' learned it"
    )
    command.add_argument(
        "--poses", type=Path, metavar="FILE",
        help="known head poses, see below; no face is then looked for or followed",
    )  # fmt: skip


def _add_parts(command: argparse.ArgumentParser) -> None:
    """Add what is chosen by name."""
    command.add_argument(
        "--preset",
        metavar="NAME",
        help="a model, evidence, driver and start that belong together; names below",
    )
    command.add_argument(
        "--model",
        metavar="NAME",
        help="what is tracked: a name below, or the file of a model (default: head)",
    )
    command.add_argument(
        "--terms",
        metavar="NAME+NAME",
        help="evidence that is rendered and compared, names joined by + (default: colour)",
    )
    command.add_argument(
        "--driver",
        metavar="NAME",
        help="what moves the parameters (default: newton for a head seen by colour, else simplex)",
    )
    command.add_argument(
        "--plugin", type=Path, action="append", default=[], metavar="FILE.py",
        help="Python file that adds models, terms, drivers or renderers of your own; may be "
        "repeated",
    )  # fmt: skip


def count(text: str) -> int:
    """A number from 1 on."""
    number = int(text)
    if number < 1:
        raise argparse.ArgumentTypeError(f"{text} is not 1 or more")
    return number


def track_options(chosen: argparse.Namespace) -> TrackOptions:
    """What was chosen on the command line, as the tracker takes it.

    Raises
    ------
    InputFileError, ModelFormatError
        If the camera's file cannot be read.
    """
    from abs_engine.dataset import load_camera
    from abs_engine.tracking.options import TrackOptions

    return TrackOptions(
        person=chosen.person,
        mouth=None if chosen.mouth is None else tuple(chosen.mouth),
        camera=None if chosen.camera is None else load_camera(chosen.camera),
        speaker=chosen.speaker,
        colours=chosen.colours,
        physics=chosen.physics,
        poses=chosen.poses,
        start=chosen.start,
        face=chosen.face,
        pupil_distance=chosen.pupil_distance,
        evidence=chosen.evidence,
        model=chosen.model,
        terms=chosen.terms,
        driver=chosen.driver,
        preset=chosen.preset,
    )
