"""The `cameras` command."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from typing import TYPE_CHECKING

from abs_engine.cli.parts import options as take
from abs_engine.cli.parts.command import Chosen, Done, command

if TYPE_CHECKING:
    from abs_engine.learn.reconstruction import CameraGain

_NOTES = """\
A yaw is in degrees towards the subject's left: 0 is frontal, 90 the left profile. The column
"remains" is the RMS error to expect at a node of the lips, from the variance of the modes that the
camera leaves undetermined.
"""


@command(
    "Learn faces and lips",
    take.argument("physics", "LIPS", "what 'train -o' wrote"),
    take.option("--yaw", type=take.number, many=True, metavar="DEGREES...",
        text="possible camera positions (default: from -90 to 90 in steps of 15)"),
    take.option("--have", type=take.number, many=True, metavar="DEGREES...",
        text="cameras that are there already (default: none)"),
    take.option("--noise", type=take.number, metavar="MM",
        text="error of a coordinate that a camera measures (default: the dots' own)"),
    take.file("--speaker", "head.npz of another speaker"),
    examples="abs-engine cameras lips.npz\nabs-engine cameras lips.npz --yaw -60 0 60 --have 0",
    notes=_NOTES,
)  # fmt: skip
def cameras(chosen: Chosen) -> Done:
    """Rank camera positions by what they would reveal of trained lips."""
    from abs_engine.face.shape.modal import load_physics
    from abs_engine.io.assets import load_speaker
    from abs_engine.learn.cameras import YAWS, rank_yaws

    physics = load_physics(chosen.physics)
    gains = rank_yaws(
        physics,
        load_speaker(chosen.speaker),
        chosen.yaw or YAWS,
        have=chosen.have,
        noise=chosen.noise,
    )
    return Done(gain_lines(gains, chosen.have), {"cameras": [asdict(gain) for gain in gains]})


def gain_lines(gains: list[CameraGain], have: Sequence[float]) -> list[str]:
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
