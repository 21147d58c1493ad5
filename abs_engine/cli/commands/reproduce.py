"""The `reproduce` command."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import nullcontext
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from abs_engine.cli import options as take
from abs_engine.cli.command import Chosen, Done, command
from abs_engine.cli.drawing import opened
from abs_engine.cli.progress import Progress, say
from abs_engine.core.provenance import code_digest
from abs_engine.io.files import check_free, next_free, parent_folder
from abs_engine.io.unfinished import NewFolder, Unfinished

if TYPE_CHECKING:
    from abs_engine.core.scene import Renderer

Tell = Callable[[str], None]
PAGE = "index.html"
RESUMED = ("001",)
"""Papers whose full run takes hours."""


def _lips_by_physics(chosen: Chosen, folder: Path, renderer: Renderer, tell: Tell) -> list[str]:
    """Fill the folder; the main numbers beside the paper's."""
    from abs_engine.papers.basu1998.reproduce import reproduce as make
    from abs_engine.papers.basu1998.scores import score_lines

    return score_lines(make(folder, renderer, quick=chosen.quick, seed=chosen.seed, tell=tell))


def _talking_faces(chosen: Chosen, folder: Path, renderer: Renderer, tell: Tell) -> list[str]:
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


PAPERS: dict[str, Callable[[Chosen, Path, Renderer, Tell], list[str]]] = {
    "000": _lips_by_physics,
    "001": _talking_faces,
}
"""By the paper's number: what fills a new folder, and returns lines for a terminal."""


@command(
    "This machine, and published results",
    take.argument("paper", "PAPER", type=take.Choice(sorted(PAPERS)),
        text="000: 3D lips by learned physics (Basu, Oliver and Pentland 1998); 001: talking "
        "faces by articulatory parameters and appearance (Odisio and Bailly 2003)"),
    take.output("DIR", "report folder, must not exist (default: runs/reproduce-000, "
        "runs/reproduce-000-2, ..., or the same with 001)", required=False),
    take.option("--quick", is_flag=True, text="one person and few frames: takes a few minutes"),
    take.seed("filming and learning"),
    take.person("for 001: whose face, one of the bundled people (default: clara)", "clara"),
    take.option("--sentences", type=take.count, metavar="N",
        text="for 001: only N of the 77 sentences, evenly spread"),
    take.option("--twins", type=take.count, metavar="N",
        text="for 001: the constant models on only N of these sentences"),
    take.option("--workers", type=take.count, metavar="N", default=1,
        text="for 001: processes that track sentences (default: 1)"),
    take.renderer(),
    examples="abs-engine reproduce 000 --quick\n"
    "abs-engine reproduce 001 --sentences 10 --workers 2",
)  # fmt: skip
def reproduce(chosen: Chosen) -> Done:
    """Make a paper's tables and figures on our own data."""
    from abs_engine.report.inspect.body import check_person

    check_person(chosen.person, None)
    folder = chosen.output or next_free(Path(f"runs/reproduce-{chosen.paper}"))
    with nullcontext() if chosen.output else parent_folder(folder):
        check_free(folder)
        with (
            opened(chosen.renderer) as renderer,
            Progress(f"reproduce {chosen.paper}") as progress,
            _folder(chosen, folder, renderer) as made,
        ):
            lines = PAPERS[chosen.paper](chosen, made.work, renderer, progress.announce)
            made.finish()
    lines.append(f"wrote {folder}; open {folder / PAGE}")
    return Done(lines, {"output": folder, "lines": lines})


def _folder(chosen: Chosen, output: Path, renderer: Renderer) -> NewFolder | Unfinished:
    """A folder that an interrupted run leaves only where the same command goes on with it."""
    if chosen.quick or chosen.paper not in RESUMED:
        return NewFolder(output)
    words = chosen.paper, chosen.seed, chosen.person, renderer.description
    folder = Unfinished(output, "\n".join(map(str, (*words, code_digest()))))
    if folder.resumed:
        say(f"resuming {folder.partial}")
    return folder
