"""What the commands do. Each imports what it needs, so that errors and help come at once."""

from __future__ import annotations

import json
import logging
import shlex
from argparse import Namespace
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from abs_engine.cli.progress import Progress
from abs_engine.files import check_free, write_new

if TYPE_CHECKING:
    from abs_engine.render.select import OpenRenderer


def doctor(_chosen: Namespace) -> int:
    """Report the state of the machine; 1 where only the CPU rasteriser works."""
    from abs_engine.render.diagnose import diagnose, report_lines

    diagnosis = diagnose()
    print("\n".join(report_lines(diagnosis)))
    return diagnosis.exit_status


def synth(chosen: Namespace) -> int:
    """Film a person."""
    from abs_engine.systems.demo import film_clip

    check_free(chosen.output)
    with Progress("filming") as progress:
        film_clip(
            chosen.output,
            chosen.sentence,
            person=chosen.person,
            size=tuple(chosen.size),
            frames=chosen.frames,
            seed=chosen.seed,
            lossless=chosen.lossless,
            command=_command_line("synth", chosen),
            progress=progress,
        )
    print(f"wrote {chosen.output}")
    return 0


def track(chosen: Namespace) -> int:
    """Track the lips in a video."""
    from abs_engine.video import probe

    check_free(chosen.output)
    probe(chosen.video)

    from abs_engine.systems.lips import LipOptions
    from abs_engine.systems.run import track_video
    from abs_engine.truth import load_camera

    options = LipOptions(
        person=chosen.person,
        mouth=None if chosen.mouth is None else tuple(chosen.mouth),
        camera=None if chosen.camera is None else load_camera(chosen.camera),
        speaker=chosen.speaker,
    )
    with _renderer(chosen.renderer) as renderer, Progress("tracking") as progress:
        progress.announce("looking for the face, fitting the mouth")
        told = track_video(
            chosen.video, chosen.output, renderer, options, progress, progress.restart
        )
    _print_summary(told["summary"])
    print(f"wrote {chosen.output}")
    return 0


def evaluate(chosen: Namespace) -> int:
    """Compare a run with its ground truth."""
    from abs_engine.evaluate.truth_report import report
    from abs_engine.files import NewFolder
    from abs_engine.systems.demo import score_lines
    from abs_engine.track.record import load_run
    from abs_engine.truth import load_truth

    run, truth = load_run(chosen.folder), load_truth(chosen.truth)
    with NewFolder(chosen.output or chosen.folder / "evaluation") as made:
        scores = report(run, truth, made.work)
        folder = made.finish()
    print("\n".join(score_lines(scores)))
    print(f"wrote {folder}")
    return 0


def demo(chosen: Namespace) -> int:
    """Film, track, evaluate and report."""
    from abs_engine.systems.demo import DemoOptions, run_demo, score_lines
    from abs_engine.systems.demo_page import head_given

    output = check_free(chosen.output or _next_free(Path("runs/demo")))
    options = DemoOptions(person_known=not chosen.average_head)
    if chosen.frames is not None:
        options = replace(options, frames=chosen.frames)
    with (
        _renderer(chosen.renderer) as renderer,
        Progress("filming") as filming,
        Progress("tracking") as tracking,
    ):

        def prepared(seconds: float) -> None:
            filming.finish()
            tracking.restart(seconds)

        done = run_demo(output, renderer, options, filming, tracking, prepared)
    _print_summary(done.run["summary"])
    print(head_given(options.person, options.person_known))
    print("\n".join(score_lines(done.scores)))
    print(f"wrote {output}; open {output / 'index.html'}")
    return 0


def bench(chosen: Namespace) -> int:
    """Time one evaluation."""
    from abs_engine.evaluate.bench import DEFAULT_ROUNDS, run_bench

    if chosen.json is not None:
        check_free(chosen.json)
    result = run_bench(chosen.rounds or DEFAULT_ROUNDS)
    print("\n".join(result.as_lines()))
    if chosen.json is not None:
        write_new(chosen.json, (json.dumps(result.as_json(), indent=1) + "\n").encode())
    return 0


def render(chosen: Namespace) -> int:
    """Draw a posture."""
    from abs_engine.files import png
    from abs_engine.systems.portrait import draw_portrait

    check_free(chosen.output)
    with _renderer(chosen.renderer) as renderer:
        picture = draw_portrait(
            renderer,
            chosen.person,
            dict(chosen.units),
            size=tuple(chosen.size),
            palette=chosen.palette,
            turn=chosen.turn,
        )
    write_new(chosen.output, png(picture))
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


def _print_summary(summary: dict[str, Any]) -> None:
    print(
        f"{summary['frames']} frames, {summary['lost_frames']} lost, "
        f"{summary['closed_frames']} with closed lips; "
        f"{summary['mean_evaluations']:.0f} evaluations and "
        f"{summary['seconds_per_frame']:.3f} s a frame"
    )


def _next_free(path: Path) -> Path:
    """The path, or the first of path-2, path-3, ... that does not exist; its parent is made."""
    from abs_engine.files import unwritable

    try:
        path.parent.mkdir(exist_ok=True)
    except OSError as error:
        raise unwritable(path, error) from error
    free, number = path, 1
    while free.exists():
        number += 1
        free = path.with_name(f"{path.name}-{number}")
    return free


def _command_line(name: str, chosen: Namespace) -> str:
    """The command that makes the same clip again, without the place where it is put."""
    words = ["abs-engine", name, chosen.sentence, "--person", chosen.person]
    words += ["--size", *map(str, chosen.size), "--seed", str(chosen.seed)]
    words += ["--frames", str(chosen.frames)] if chosen.frames is not None else []
    words += ["--lossless"] if chosen.lossless else []
    return shlex.join(words)
