"""The `train` command."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from abs_engine.cli.parts import options as take
from abs_engine.cli.parts.command import Chosen, Done, command
from abs_engine.cli.parts.drawing import opened
from abs_engine.cli.parts.progress import Progress
from abs_engine.io.files import check_free

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from abs_engine.io.assets import Speaker
    from abs_engine.learn.further import Further
    from abs_engine.learn.training import Training
    from abs_engine.tracking.speaker.lip_clips import LipRun

_MOST_NAMED = 12
NEGATIVE_LOG = "-log probability"


def _runs(text: str) -> tuple[Path, ...]:
    """Runs that are joined by commas."""
    runs = tuple(Path(part) for part in text.split(",") if part)
    if not runs:
        raise click.BadParameter("it names no run")
    return runs


@command(
    "Learn faces and lips",
    take.argument("observations", "OBSERVATIONS",
        "what 'observe -o' wrote, with 16 dots on the lips"),
    take.output("FILE", "the lips, an NPZ for 'track --physics' and 'cameras'"),
    take.person(
        "who wore the dots, one of the speaker's people; they must be in the frame of that head "
        "(default: the average head is fitted to the dots)"
    ),
    take.file("--speaker", "head.npz of another speaker"),
    take.option("--modes", type=int, default=10, metavar="N",
        text="number of modes to keep (default: 10)"),
    take.option("--train", type=int, default=140, metavar="N",
        text="frames to learn from, of those with 8 or more of the 16 dots (fails if there are "
        "fewer); later ones with all 16 are for testing (default: 140)"),
    take.option("--add", many=True, type=_runs, metavar="RUN[,RUN]...",
        text="learn from runs of videos without dots, too, of this person or others; join those "
        "of cameras that filmed the same moments by commas. What they add is kept if it makes "
        "left-out frames more probable"),
    take.renderer(),
    examples="abs-engine train dots.npz -o lips.npz\n"
    "abs-engine train dots.npz -o lips2.npz --add run-front,run-side run-monday",
)  # fmt: skip
def train(chosen: Chosen) -> Done:
    """Learn how lips move from observed dots."""
    check_free(chosen.output, ".npz")

    from abs_engine.capture.observations import read_observations
    from abs_engine.face.shape.lip_shell import cut_lip_shell
    from abs_engine.io.assets import load_speaker
    from abs_engine.learn.training import train as learn
    from abs_engine.tracking.speaker.lip_clips import load_lip_runs

    observations = read_observations(chosen.observations)
    speaker = load_speaker(chosen.speaker)
    groups = load_lip_runs(chosen.add, speaker, cut_lip_shell(speaker)) if chosen.add else []
    done = learn(observations, speaker, chosen.person, n_modes=chosen.modes, n_train=chosen.train)
    lines, physics = report_lines(done, observations.first), done.physics
    evidence = list[float]()
    if groups:
        further = _further(chosen, done, groups, speaker)
        physics, evidence = further.physics, list(further.evidence)
        lines += further_lines(further)
    physics.save(chosen.output)  # first: whoever reads the lines may stop at any of them
    facts = {
        "output": chosen.output,
        "learned_frames": len(done.used),
        "test_frames": len(done.tested),
        "noise_mm": float(physics.noise),
        "shares": [float(share) for share in physics.shares],
        "left_out_nats": evidence,
    }
    return Done([*lines, f"wrote {chosen.output}"], facts)


def _further(
    chosen: Chosen, done: Training, groups: list[list[LipRun]], speaker: Speaker
) -> Further:
    """Lessons of runs beside the dots."""
    from abs_engine.core.threads import one_thread
    from abs_engine.learn.further import train_further
    from abs_engine.tracking.speaker.lip_clips import lip_clip

    with opened(chosen.renderer) as renderer, one_thread(), Progress("learning") as progress:
        progress.announce("reading the runs")
        clips = [lip_clip(g, speaker, done.shell, done.physics, renderer) for g in groups]
        return train_further(done, clips, tell=progress.announce)


def further_lines(further: Further) -> list[str]:
    """Lines on what further training found, and whether it is kept."""
    nats = ", ".join(f"{value:.1f}" for value in further.evidence)
    kept = f"kept: round {further.kept}" if further.kept else "not kept: nothing new was learned"
    lines = [f"{NEGATIVE_LOG} of a moment that was left out, before and by round: {nats}; {kept}"]
    found = further.sources[1:]
    if found:
        frames = ", ".join(str(len(source)) for source in found)
        lines.append(f"shapes that were added, by clip: {frames}")
    return lines


def report_lines(done: Training, first: int = 0) -> list[str]:
    """Summary of the training data and of the modes, and table 1 if there are test frames.

    `first` is the number of the first frame.
    """
    from abs_engine.learn.reconstruction import table_1

    physics = done.physics
    lacking = len(done.untested)
    few = _named(first + done.left_out, ", as too few dots were found")
    lines = [
        f"correspondence: {done.correspondence.how}",
        f"{len(done.used)} frames learned from, {len(done.tested)} left for testing, "
        + (f"{lacking} more not tested, as a dot is missing, " if lacking else "")
        + f"{len(done.left_out)} left out{few}",
        f"noise: {physics.noise:.3f} mm for each coordinate of a dot, beyond the modes",
        "variance held by the first modes: "
        + "  ".join(f"{k}: {share:.2%}" for k, share in enumerate(physics.shares, 1)),
    ]
    if len(done.incomplete):
        told = _named(first + done.incomplete, "")
        lines.insert(
            2, f"{len(done.incomplete)} of these frames are learned from without some dots{told}"
        )
    if len(done.jumped):
        told = _named(first + done.jumped, ", which were left out")
        lines.insert(2, f"in {len(done.jumped)} frames dots jump{told}")
    if len(done.uncertain):
        told = _named(first + done.uncertain, "; a person should look at them")
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
