"""The `bench` command."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING

from abs_engine.cli.parts import options as take
from abs_engine.cli.parts.command import Chosen, Done, command
from abs_engine.cli.parts.progress import Progress
from abs_engine.core.errors import ParameterError
from abs_engine.io.files import check_free, write_new

if TYPE_CHECKING:
    from abs_engine.evaluate.bench_clip import ClipBench
    from abs_engine.evaluate.bench_result import BenchResult


@command(
    "This machine, and published results",
    take.option("--json", type=take.PATH, metavar="FILE", is_flag=False, flag_value="-",
        text="also write the results to this file, as JSON; without FILE, print only the JSON"),
    take.option("--rounds", type=take.count, metavar="N",
        text="repetitions of each measurement (default: 50; 3 with --clip)"),
    take.file("--clip", metavar="VIDEO",
        text="time the tracking of this video instead of one evaluation"),
    take.file("--peer-python", metavar="PYTHON", type=take.PATH,
        text="with --clip: a Python with mediapipe installed, whose face mesh is timed in turn"),
    take.renderer("with --clip: the renderer, such as cpu (default: auto)", default=None),
    examples="abs-engine bench --json bench.json\n"
    "abs-engine bench --clip talk.mp4 --renderer cpu --rounds 2",
)  # fmt: skip
def bench(chosen: Chosen) -> Done:
    """Time one evaluation, or the tracking of a clip."""
    file = None if chosen.json in (None, take.STDOUT) else chosen.json
    if file is not None:
        check_free(file)
    result = _clip_bench(chosen) if chosen.clip is not None else _evaluation_bench(chosen)
    if file is not None:
        write_new(file, (json.dumps(result.as_json(), indent=1) + "\n").encode())
    return Done(result.as_lines(), result.as_json())


def _evaluation_bench(chosen: Chosen) -> BenchResult:
    from abs_engine.evaluate.bench import DEFAULT_ROUNDS, run_bench

    for name in ("renderer", "peer-python"):
        if getattr(chosen, name.replace("-", "_")) is not None:
            raise ParameterError(f"--{name} goes with --clip", "name a video, or leave it out")
    return run_bench(chosen.rounds or DEFAULT_ROUNDS)


def _clip_bench(chosen: Chosen) -> ClipBench:
    from abs_engine.evaluate.bench_clip import TURNS, bench_clip

    with Progress("bench") as progress:
        progress.announce("tracking the clip, by turns")
        renderer = chosen.renderer or "auto"
        return bench_clip(chosen.clip, renderer, chosen.peer_python, chosen.rounds or TURNS)
