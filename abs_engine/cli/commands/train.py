"""The `train` command."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from abs_engine.cli import options as take
from abs_engine.cli.command import Chosen, Done, command
from abs_engine.io.files import check_free

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from abs_engine.learn.training import Training

_MOST_NAMED = 12


@command(
    "Learn faces and lips",
    take.argument("observations", "OBSERVATIONS",
        "what 'observe -o' wrote, with 16 dots on the lips"),
    take.output("FILE", "the lips, an NPZ for 'track --physics' and 'cameras'"),
    take.person(
        "who wore the dots, one of the speaker's people (default: the average head is fitted "
        "to the dots)"
    ),
    take.file("--speaker", "head.npz of another speaker"),
    take.option("--modes", type=int, default=10, metavar="N",
        text="number of modes to keep (default: 10)"),
    take.option("--train", type=int, default=140, metavar="N",
        text="complete frames to learn from, all of them required; the rest is for testing "
        "(default: 140)"),
    examples="abs-engine train dots.npz -o lips.npz --person clara",
)  # fmt: skip
def train(chosen: Chosen) -> Done:
    """Learn how lips move from observed dots."""
    check_free(chosen.output, ".npz")

    from abs_engine.capture.observations import read_observations
    from abs_engine.io.assets import load_speaker
    from abs_engine.learn.training import train as learn

    observations = read_observations(chosen.observations)
    speaker = load_speaker(chosen.speaker)
    done = learn(observations, speaker, chosen.person, n_modes=chosen.modes, n_train=chosen.train)
    lines = report_lines(done)
    done.physics.save(chosen.output)  # first: whoever reads the lines may stop at any of them
    facts = {
        "output": chosen.output,
        "learned_frames": len(done.used),
        "test_frames": len(done.tested),
        "noise_mm": float(done.physics.noise),
        "shares": [float(share) for share in done.physics.shares],
    }
    return Done([*lines, f"wrote {chosen.output}"], facts)


def report_lines(done: Training) -> list[str]:
    """Summary of the training data and of the modes, and table 1 if there are test frames."""
    from abs_engine.learn.reconstruction import table_1

    physics = done.physics
    lines = [
        f"correspondence: {done.correspondence.how}",
        f"{len(done.used)} frames learned from, {len(done.tested)} left for testing, "
        f"{len(done.left_out)} left out{_named(done.left_out, ', as dots were lost')}",
        f"noise: {physics.noise:.3f} mm for each coordinate of a dot, beyond the modes",
        "variance held by the first modes: "
        + "  ".join(f"{k}: {share:.2%}" for k, share in enumerate(physics.shares, 1)),
    ]
    if len(done.jumped):
        lines.insert(2, f"{len(done.jumped)} more left out{_named(done.jumped, ', as dots jump')}")
    if len(done.uncertain):
        told = _named(done.uncertain, "; a person should look at them")
        lines.insert(2, f"{len(done.uncertain)} of these frames have uncertain dots{told}")
    if len(done.tested) == 0:
        return lines
    lines.append(
        "reconstruction of the test frames   error per DOF, paper's units   (paper)     mm RMS"
    )
    lines += [
        f"  {row.part.label:34s}{row.error:.2e}{'':23s}({row.part.paper:.2e})"
        f"{row.rms:7.2f} ({row.expected:.2f} expected)"
        for row in table_1(done)
    ]
    return lines


def _named(frames: NDArray[Any], why: str) -> str:
    """Reason and frames, the first of them if they are many; nothing if there are none."""
    if len(frames) == 0:
        return ""
    more = ", ..." if len(frames) > _MOST_NAMED else ""
    return f"{why}: {', '.join(map(str, frames[:_MOST_NAMED]))}{more}"
