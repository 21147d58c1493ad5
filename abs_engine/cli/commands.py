"""What the commands do. Each imports what it needs, so that errors and help come at once."""

from __future__ import annotations

import json
import logging
from argparse import Namespace
from collections.abc import Iterator
from contextlib import contextmanager, nullcontext
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from abs_engine.cli.progress import Progress
from abs_engine.core.errors import ParameterError
from abs_engine.io.files import check_free, parent_folder, write_new

if TYPE_CHECKING:
    from abs_engine.evaluate.bench_clip import ClipBench
    from abs_engine.evaluate.bench_result import BenchResult
    from abs_engine.render.select import OpenRenderer


def doctor(_chosen: Namespace) -> int:
    """Report the state of the machine; 1 where only the CPU rasteriser works."""
    from abs_engine.render.diagnose import diagnose, report_lines

    with Progress("doctor") as progress:
        progress.announce("trying every renderer")
        diagnosis = diagnose()
    print("\n".join(report_lines(diagnosis)))
    return diagnosis.exit_status


def synth(chosen: Namespace) -> int:
    """Film a scene, or a person who says a sentence."""
    from abs_engine.cli.synth import request_of
    from abs_engine.core.clock import cost_lines
    from abs_engine.studio.filming import film_scene
    from abs_engine.studio.make import Crew

    check_free(chosen.output)
    request = request_of(chosen)
    with Progress("filming") as filming, Progress("encoding") as encoding:

        def stage(name: str) -> None:
            filming.finish()
            encoding.announce(name)
            encoding.restart()

        crew = Crew(chosen.processes or 0, True, stage, filming, encoding)
        done = film_scene(
            request.scene,
            chosen.output,
            beside=request.beside,
            command=request.command,
            crew=crew,
        )
    if done.resumed:
        print(f"{done.resumed} of {done.frames} frames were there from before")
    print("\n".join(["what a frame cost, by part:", *cost_lines(done.seconds, done.frames)]))
    print(f"wrote {done.folder}")
    return 0


def track(chosen: Namespace) -> int:
    """Track the lips in a video."""
    from abs_engine.io.video import probe

    check_free(chosen.output)
    info = probe(chosen.video)  # says what is wrong before anything slow is loaded

    from abs_engine.cli.track import track_options
    from abs_engine.core.registry import load_plugin
    from abs_engine.tracking.output import OVERLAY, SHEET
    from abs_engine.tracking.run import check_options, track_video
    from abs_engine.tracking.scale import scale_line

    for plugin in chosen.plugin:
        load_plugin(plugin)
    options = track_options(chosen)
    check_options(options, info)  # what cannot be is said before a renderer is opened
    with _renderer(chosen.renderer) as renderer, Progress("tracking") as progress:
        _print_hints(renderer)
        told = track_video(
            chosen.video,
            chosen.output,
            renderer,
            options,
            progress,
            progress.restart,
            progress.announce,
            progress.remark,
        )
    _print_summary(told["summary"])
    print(scale_line(told["settings"]["scale"]))
    print(f"wrote {chosen.output}; look at {chosen.output / SHEET} or {chosen.output / OVERLAY}")
    return 0


def evaluate(chosen: Namespace) -> int:
    """Compare results with their ground truth."""
    from abs_engine.report.scoring import default_folder
    from abs_engine.report.scoring import evaluate as score

    folder = chosen.output or default_folder(chosen.results)
    view = chosen.clip, chosen.camera
    done = score(chosen.results, chosen.truth, folder, seed=chosen.seed, view=view)
    print("\n".join(done.lines()))
    print(f"wrote {done.folder}")
    return 0


def demo(chosen: Namespace) -> int:
    """Film, track, evaluate and report."""
    output = chosen.output or _next_free(Path("runs/demo"))
    with nullcontext() if chosen.output else parent_folder(output):
        check_free(output)
        return _demo(output, chosen)


def _demo(output: Path, chosen: Namespace) -> int:
    from abs_engine.report.demo import DemoOptions, run_demo, score_lines

    options = DemoOptions(person_known=not chosen.average_head)
    if chosen.frames is not None:
        options = replace(options, frames=chosen.frames)
    with (
        _renderer(chosen.renderer) as renderer,
        Progress("filming") as filming,
        Progress("tracking") as tracking,
    ):
        _print_hints(renderer)
        filming.announce("starting the studio")

        def stage(name: str) -> None:
            filming.finish()
            tracking.announce(name)

        done = run_demo(output, renderer, options, filming, tracking, tracking.restart, stage)
    _print_summary(done.run["summary"])
    print(done.remarks[0])
    print("\n".join([*score_lines(done.scores), *done.remarks[1:]]))
    print(f"wrote {output}; open {output / 'index.html'}")
    return 0


def bench(chosen: Namespace) -> int:
    """Time one evaluation, or a clip."""
    if chosen.json is not None:
        check_free(chosen.json)
    result = _clip_bench(chosen) if chosen.clip is not None else _evaluation_bench(chosen)
    print("\n".join(result.as_lines()))
    if chosen.json is not None:
        write_new(chosen.json, (json.dumps(result.as_json(), indent=1) + "\n").encode())
    return 0


def _evaluation_bench(chosen: Namespace) -> BenchResult:
    from abs_engine.evaluate.bench import DEFAULT_ROUNDS, run_bench

    for name in ("renderer", "peer_python"):
        if getattr(chosen, name) is not None:
            option = name.replace("_", "-")
            raise ParameterError(f"--{option} goes with --clip", "name a video, or leave it out")
    return run_bench(chosen.rounds or DEFAULT_ROUNDS)


def _clip_bench(chosen: Namespace) -> ClipBench:
    from abs_engine.evaluate.bench_clip import TURNS, bench_clip

    with Progress("bench") as progress:
        progress.announce("tracking the clip, by turns")
        renderer = chosen.renderer or "auto"
        return bench_clip(chosen.clip, renderer, chosen.peer_python, chosen.rounds or TURNS)


def render(chosen: Namespace) -> int:
    """Draw an inspection picture or film."""
    from abs_engine.cli.render import request_of
    from abs_engine.report.inspect.output import is_film

    check_free(chosen.output)
    is_film(chosen.output)
    request = request_of(chosen)

    from abs_engine.report.inspect.draw import render_to_file

    with _renderer(chosen.renderer) as renderer, Progress("drawing") as progress:
        render_to_file(request, renderer, progress)
    print(f"wrote {chosen.output}")
    return 0


@contextmanager
def _renderer(name: str) -> Iterator[OpenRenderer]:
    """Open a renderer and say on one line what it is, and why OpenGL is not used if it failed."""
    from abs_engine.render.select import open_renderer

    notes = _Notes()
    logger = logging.getLogger("abs_engine.render")
    logger.addHandler(notes)
    try:
        opened = open_renderer(name)
    finally:
        logger.removeHandler(notes)
    with opened:
        why = f" ({'; '.join(notes.lines)})" if notes.lines else ""
        print(f"renderer: {opened.description}{why}", flush=True)
        yield opened


class _Notes(logging.Handler):
    """Keeps what is logged, each as one line."""

    def __init__(self) -> None:
        super().__init__(logging.WARNING)
        self.lines: list[str] = []

    def emit(self, record: logging.LogRecord) -> None:
        self.lines.append(" ".join(record.getMessage().split()))


def _print_hints(renderer: OpenRenderer) -> None:
    """What a user should know before a long run."""
    from abs_engine.render.select import draws_by_software

    if draws_by_software(renderer):
        print("hint: no GPU draws here; --renderer cpu is two to three times as fast", flush=True)


_DOUBTFUL = 0.78
"""Mean score below which a run is most likely wrong; those that were right had 0.86 and more."""
_OTHERS = 0.8
"""The same of a talking face: its own speaker's have 0.94, another's 0.64 to 0.88."""


def _print_summary(summary: dict[str, Any]) -> None:
    print(
        f"{summary['frames']} frames, {summary['lost_frames']} lost, "
        f"{summary['closed_frames']} with closed lips; "
        f"{summary['mean_evaluations']:.0f} evaluations and "
        f"{summary['seconds_per_frame']:.3f} s a frame"
    )
    kind, score = summary.get("score_of", "colour"), summary["mean_score"]
    if kind == "colour" and score is not None and score < _DOUBTFUL:
        print(
            f"warning: the drawn mouth explains only {score:.0%} of the picture around it: look at "
            "the overlay"
        )
    if kind in ("texture", "local") and score is not None and score < _OTHERS:
        print(f"warning: the face explains only {score:.0%} of the picture: is it this speaker's?")
    for line in summary.get("warnings", ()):
        print(f"warning: {line}")


def _next_free(path: Path) -> Path:
    """The path, or the first of path-2, path-3, ... that does not exist."""
    free, number = path, 1
    while free.exists():
        number += 1
        free = path.with_name(f"{path.name}-{number}")
    return free
