"""The `reproduce` command."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import nullcontext, suppress
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import click
from click.core import ParameterSource

from abs_engine.cli.parts import options as take
from abs_engine.cli.parts.command import Chosen, Done, command
from abs_engine.cli.parts.drawing import opened
from abs_engine.cli.parts.progress import Progress, say
from abs_engine.core.errors import InputFileError, ParameterError
from abs_engine.core.provenance import code_digest
from abs_engine.io.files import next_free, parent_folder
from abs_engine.io.unfinished import Unfinished, check_output, kept_if_of_use

if TYPE_CHECKING:
    from abs_engine.core.scene import Renderer

Tell = Callable[[str], None]
PAGE = "index.html"
KEPT = "kept"
"""Beside the report in the making: what an interrupted run is resumed from."""


def _lips_by_physics(chosen: Chosen, made: Unfinished, renderer: Renderer, tell: Tell) -> list[str]:
    """Fill the folder; the main numbers beside the paper's."""
    from abs_engine.papers.basu1998.reproduce import reproduce as make
    from abs_engine.papers.basu1998.scores import score_lines

    folders = made.work, made.partial / KEPT
    return score_lines(make(*folders, renderer, quick=chosen.quick, seed=chosen.seed, tell=tell))


def _talking_faces(chosen: Chosen, made: Unfinished, renderer: Renderer, tell: Tell) -> list[str]:
    """Fill the folder; the main numbers beside the goals."""
    from abs_engine.io.assets import load_speaker
    from abs_engine.papers.odisio2004.gathered import FULL, QUICK, Report
    from abs_engine.papers.odisio2004.goals import score_lines
    from abs_engine.papers.odisio2004.reproduce import reproduce as make
    from abs_engine.papers.odisio2004.sentences_parts import PARTS

    usual = QUICK if chosen.quick else FULL
    amount = replace(usual, sentences=chosen.sentences or usual.sentences, twins=chosen.twins)
    report = Report(
        made.work, made.partial / KEPT, renderer, load_speaker(), chosen.seed, tell,
        chosen.person, chosen.quick, amount, chosen.workers, chosen.renderer,
    )  # fmt: skip
    return score_lines(make(report, PARTS))


PAPERS: dict[str, Callable[[Chosen, Unfinished, Renderer, Tell], list[str]]] = {
    "000": _lips_by_physics,
    "001": _talking_faces,
}
"""By the paper's number: what fills a new folder, and returns lines for a terminal."""
_SENTENCES = 77
"""Those of 001, counted here as help needs no studio."""
_OF_001 = ("person", "sentences", "twins", "workers")
"""Options that the other paper does not have."""


@command(
    "This machine, and published results",
    take.argument("paper", "PAPER", type=take.Choice(sorted(PAPERS)),
        text="000: 3D lips by learned physics (Basu, Oliver and Pentland 1998); 001: talking "
        "faces by articulatory parameters and appearance (Odisio and Bailly 2003)"),
    take.output("DIR", "report folder, must not exist (default: runs/reproduce-000, "
        "runs/reproduce-000-2, ..., or the same with 001); after an interruption the same command "
        "resumes", required=False),
    take.option("--quick", is_flag=True, text="one person and few frames: takes a few minutes"),
    take.seed("filming and learning"),
    take.person("for 001: whose face, one of the bundled people (default: clara)", "clara"),
    take.option("--sentences", type=click.IntRange(1, _SENTENCES), metavar="N",
        text=f"for 001: only N of the {_SENTENCES} sentences, evenly spread"),
    take.option("--twins", type=click.IntRange(1, _SENTENCES), metavar="N",
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

    _check_options(chosen)
    check_person(chosen.person, None)
    folder = chosen.output or next_free(Path(f"runs/reproduce-{chosen.paper}"))
    with nullcontext() if chosen.output else parent_folder(folder):
        check_output(folder)
        with (
            opened(chosen.renderer) as renderer,
            Progress(f"reproduce {chosen.paper}") as progress,
            _folder(chosen, folder, renderer) as made,
            kept_if_of_use(made, made.partial / KEPT),
        ):
            lines = PAPERS[chosen.paper](chosen, made, renderer, progress.announce)
            made.finish()
    lines.append(f"wrote {folder}; open {folder / PAGE}")
    return Done(lines, {"output": folder, "lines": lines})


def _check_options(chosen: Chosen) -> None:
    """Refuse options that would do nothing."""
    source = click.get_current_context().get_parameter_source
    for name in () if chosen.paper == "001" else _OF_001:
        if source(name) is ParameterSource.COMMANDLINE:
            raise ParameterError(f"--{name} is for 001", "leave it out")
    if chosen.quick and chosen.twins:
        raise ParameterError("--quick tracks its sentences with all models", "leave out --twins")
    if chosen.sentences and chosen.twins and chosen.twins > chosen.sentences:
        raise ParameterError(
            f"--twins {chosen.twins} is more than --sentences {chosen.sentences}",
            "give at most as many twins, or leave out --twins",
        )


def _folder(chosen: Chosen, output: Path, renderer: Renderer) -> Unfinished:
    """A folder that an interrupted run leaves for the same command, also with more sentences.

    What takes hours is not removed for other choices.
    """
    words = chosen.paper, chosen.quick, chosen.seed, chosen.person, renderer.description
    choices = "\n".join(map(str, (*words, code_digest())))
    also = f"{chosen.sentences} {chosen.twins} {chosen.workers} {_recordings(chosen)}"
    folder = Unfinished(output, choices, anew="reproduce" if chosen.quick else "", also=also)
    if folder.resumed:
        say(f"resuming {folder.partial}")
    (folder.partial / KEPT).mkdir(exist_ok=True)
    return folder


def _recordings(chosen: Chosen) -> list[str]:
    """Digests of what is read that is not shipped."""
    if chosen.paper != "000" or chosen.quick:
        return []
    from abs_engine.dataset.sums import digest
    from abs_engine.papers.basu1998.motion import recording_path
    from abs_engine.papers.basu1998.real_clips import labelled_clips

    recordings = labelled_clips()
    with suppress(InputFileError):
        recordings.append(recording_path())
    return [digest(path) for path in recordings]
