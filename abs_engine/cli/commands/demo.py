"""The `demo` command."""

from __future__ import annotations

from contextlib import nullcontext
from dataclasses import replace
from pathlib import Path

from abs_engine.cli.parts import options as take
from abs_engine.cli.parts.command import Chosen, Done, command
from abs_engine.cli.parts.drawing import opened, print_hints
from abs_engine.cli.parts.progress import Progress
from abs_engine.cli.parts.summary import summary_lines
from abs_engine.io.files import next_free, parent_folder
from abs_engine.io.unfinished import check_output


@command(
    "Track and look at the result",
    take.output("DIR", "report folder, must not exist (default: runs/demo, runs/demo-2, ...); "
        "after an interruption the same command resumes", required=False),
    take.option("--frames", type=take.count, metavar="N", text="length of the clip (default: 50)"),
    take.option("--average-head", is_flag=True,
        text="track with the average head (default: with the filmed person's own)"),
    take.renderer(),
    examples="abs-engine demo\nabs-engine demo -o shown --frames 25 --average-head --renderer cpu",
)  # fmt: skip
def demo(chosen: Chosen) -> Done:
    """Film the bundled head, track it, compare with the truth."""
    folder: Path = chosen.output or next_free(Path("runs/demo"))
    with nullcontext() if chosen.output else parent_folder(folder):
        check_output(folder)
        return _demo(folder, chosen)


def _demo(folder: Path, chosen: Chosen) -> Done:
    from abs_engine.evaluate.score_table import as_values
    from abs_engine.report.demo import DemoOptions, run_demo, score_lines

    options = DemoOptions(person_known=not chosen.average_head)
    if chosen.frames is not None:
        options = replace(options, frames=chosen.frames)
    with (
        opened(chosen.renderer) as renderer,
        Progress("filming") as filming,
        Progress("tracking") as tracking,
    ):
        print_hints(renderer)
        filming.announce("starting the studio")

        def stage(name: str) -> None:
            filming.finish()
            tracking.announce(name)

        done = run_demo(folder, renderer, options, filming, tracking, tracking.restart, stage)
    lines = [
        *summary_lines(done.run["summary"], done.run["timing"]),
        done.remarks[0],
        *score_lines(done.scores),
        *done.remarks[1:],
        f"wrote {folder}; open {folder / 'index.html'}",
    ]
    return Done(lines, {"output": folder, "run": done.run, "scores": as_values(done.scores)})
