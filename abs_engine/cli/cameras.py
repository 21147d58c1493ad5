"""The `cameras` command."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from abs_engine.learn.reconstruction import CameraGain

_EPILOG = (
    "A yaw is in degrees to the subject's left of the face: 0 is frontal, 90 the left profile. "
    "What remains is the root mean square distance by which a node of the lips is expected to be "
    "off, from the variance of the modes that the camera leaves open."
)


def add_cameras(command: ArgumentParser) -> None:
    """Add what is typed after `cameras`."""
    command.epilog = _EPILOG
    add = command.add_argument
    add("physics", type=Path, metavar="LIPS", help="what 'train -o' wrote")
    add("--yaw", type=float, nargs="+", metavar="DEGREES",
        help="possible camera positions (default: from -90 to 90 in steps of 15)")  # fmt: skip
    add("--have", type=float, nargs="+", default=[], metavar="DEGREES",
        help="cameras that are there already (default: none)")  # fmt: skip
    add("--noise", type=float, metavar="MM",
        help="error of a coordinate that a camera measures (default: the dots' own)")  # fmt: skip
    add("--speaker", type=Path, metavar="FILE", help="head.npz of another speaker")


def cameras(chosen: Namespace) -> int:
    """Rank camera positions by what they would reveal of trained lips."""
    from abs_engine.face.shape.modal import load_physics
    from abs_engine.io.assets import load_speaker
    from abs_engine.learn.cameras import YAWS, rank_yaws

    physics = load_physics(chosen.physics)
    gains = rank_yaws(
        physics,
        load_speaker(chosen.speaker),
        YAWS if chosen.yaw is None else chosen.yaw,
        have=chosen.have,
        noise=chosen.noise,
    )
    print("\n".join(gain_lines(gains, chosen.have)))
    return 0


def gain_lines(gains: list[CameraGain], have: list[float]) -> list[str]:
    """A line for each camera in the order of their yaws, and which helps most."""
    from abs_engine.learn.cameras import yaw_name

    best = gains[0]
    known = f"with cameras at {', '.join(map(yaw_name, have))}" if have else "with no camera"
    lines = [f"{known}, the lips are expected to be {best.before:.2f} mm off; with one more"]
    lines.append(f"{'at':>6}{'dots seen':>12}{'remains':>12}")
    lines += [
        f"{gain.name:>6}{gain.points:>12}{gain.expected:>9.3f} mm{'  best' * (gain is best)}"
        for gain in sorted(gains, key=lambda gain: float(gain.name))
    ]
    return lines
