"""The `reproduce` command."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from collections.abc import Callable
from contextlib import nullcontext
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from abs_engine.cli.commands import _next_free, _renderer
from abs_engine.cli.progress import Progress
from abs_engine.cli.render import _count
from abs_engine.core.release import engine_version
from abs_engine.io.files import NewFolder, check_free, parent_folder
from abs_engine.io.unfinished import Unfinished

if TYPE_CHECKING:
    from abs_engine.core.scene import Renderer

Tell = Callable[[str], None]
PAGE = "index.html"
RESUMED = ("001",)
"""Papers whose full run takes hours."""


def add_reproduce(command: ArgumentParser) -> None:
    """Add what is typed after `reproduce`, but for the renderer."""
    add = command.add_argument
    add("paper", choices=sorted(PAPERS),
        help="000: 3D lips by learned physics (Basu, Oliver and Pentland 1998); 001: talking "
        "faces by articulatory parameters and appearance (Odisio and Bailly 2003)")  # fmt: skip
    add("-o", "--output", type=Path, metavar="DIR",
        help="report folder, must not exist (default: runs/reproduce-000, "
        "runs/reproduce-000-2, ..., or the same with 001)")  # fmt: skip
    add("--quick", action="store_true", help="one person and few frames: takes a few minutes")
    add("--seed", type=int, default=0, help="seed of filming and learning (default: 0)")
    add("--person", metavar="NAME", default="clara",
        help="for 001: whose face, one of the bundled people (default: clara)")  # fmt: skip
    add("--sentences", type=_count, metavar="N",
        help="for 001: only N of the 77 sentences, evenly spread")  # fmt: skip
    add("--twins", type=_count, metavar="N",
        help="for 001: the constant models on only N of these sentences")  # fmt: skip
    add("--workers", type=_count, metavar="N", default=1,
        help="for 001: processes that track sentences (default: 1)")  # fmt: skip


def reproduce(chosen: Namespace) -> int:
    """Make a paper's tables and figures."""
    output = chosen.output or _next_free(Path(f"runs/reproduce-{chosen.paper}"))
    with nullcontext() if chosen.output else parent_folder(output):
        check_free(output)
        with (
            _renderer(chosen.renderer) as renderer,
            Progress(f"reproduce {chosen.paper}") as progress,
            _folder(chosen, output, renderer) as made,
        ):
            lines = PAPERS[chosen.paper](chosen, made.work, renderer, progress.announce)
            made.finish()
    print("\n".join(lines))
    print(f"wrote {output}; open {output / PAGE}")
    return 0


def _folder(chosen: Namespace, output: Path, renderer: Renderer) -> NewFolder | Unfinished:
    """A folder that an interrupted run leaves only where the same command goes on with it."""
    if chosen.quick or chosen.paper not in RESUMED:
        return NewFolder(output)
    words = chosen.paper, chosen.seed, chosen.person, renderer.description
    folder = Unfinished(output, "\n".join(map(str, (*words, engine_version()))))
    if folder.resumed:
        print(f"resuming {folder.work}", flush=True)
    return folder


def _lips_by_physics(chosen: Namespace, folder: Path, renderer: Renderer, tell: Tell) -> list[str]:
    """Fill the folder; the main numbers beside the paper's."""
    from abs_engine.papers.basu1998.reproduce import reproduce as make
    from abs_engine.papers.basu1998.scores import score_lines

    return score_lines(make(folder, renderer, quick=chosen.quick, seed=chosen.seed, tell=tell))


def _talking_faces(chosen: Namespace, folder: Path, renderer: Renderer, tell: Tell) -> list[str]:
    """Fill the folder; the main numbers beside the goals."""
    from abs_engine.io.assets import load_speaker
    from abs_engine.papers.odisio2004.gathered import FULL, QUICK, Report
    from abs_engine.papers.odisio2004.goals import score_lines
    from abs_engine.papers.odisio2004.reproduce import reproduce as make
    from abs_engine.papers.odisio2004.sentences_parts import PARTS

    usual = QUICK if chosen.quick else FULL
    amount = replace(usual, sentences=chosen.sentences or usual.sentences, twins=chosen.twins)
    report = Report(
        folder, renderer, load_speaker(), chosen.person, chosen.seed, chosen.quick, tell, amount,
        chosen.workers, chosen.renderer,
    )  # fmt: skip
    return score_lines(make(report, PARTS))


PAPERS: dict[str, Callable[[Namespace, Path, Renderer, Tell], list[str]]] = {
    "000": _lips_by_physics,
    "001": _talking_faces,
}
"""By the paper's number: what fills a new folder, and returns lines for a terminal."""
