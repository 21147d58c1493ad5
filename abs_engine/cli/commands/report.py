"""The `report` command."""

from __future__ import annotations

import shlex

from abs_engine.cli.parts import options as take
from abs_engine.cli.parts.command import Chosen, Done, command
from abs_engine.cli.parts.progress import Progress
from abs_engine.core.errors import ParameterError
from abs_engine.io.files import check_free


@command(
    "Track and look at the result",
    take.argument(
        "results", "RUN...", nargs=-1, required=True,
        text="what 'track -o' made; with --truth also a CSV file of another system, as for "
        "'evaluate'",
    ),
    take.output("FILE", "the HTML file"),
    take.file("--truth", metavar="DIR",
        text="what 'synth -o' made, or DATASET/CLIP/CAMERA; without it nothing is scored"),
    *take.view(),
    take.metrics(),
    take.file("--video",
        "the video that was tracked (default: the truth's, or where the run says it was)"),
    take.file("--speaker", "head that the runs were tracked with (default: the bundled head)"),
    take.seed("the confidence intervals"),
    examples="abs-engine report tracked -o report.html\n"
    "abs-engine report tracked other --truth clip -o compared.html",
)  # fmt: skip
def report(chosen: Chosen) -> Done:
    """Write one HTML file about one or several runs."""
    check_free(chosen.output, ".html")
    if chosen.plugin and chosen.truth is None:
        raise ParameterError("--plugin adds metrics, which need a dataset", "give --truth")

    from abs_engine.core.registry import load_plugins
    from abs_engine.report.gathering import ReportOptions, write_report

    load_plugins(chosen.plugin)
    names = "truth", "clip", "camera", "video", "seed", "speaker"
    options = ReportOptions(**{n: getattr(chosen, n) for n in names}, command=_command_line(chosen))
    with Progress("report") as progress:
        write_report(chosen.results, chosen.output, options, progress.announce)
    lines = [f"wrote {chosen.output}; open it in a browser"]
    return Done(lines, {"output": chosen.output})


def _command_line(chosen: Chosen) -> str:
    words = ["abs-engine", "report", *map(str, chosen.results)]
    for name in ("truth", "clip", "camera", "video", "speaker", "output"):
        value = getattr(chosen, name)
        words += [f"--{name}", str(value)] if value is not None else []
    words += [word for path in chosen.plugin for word in ("--plugin", str(path))]
    words += ["--seed", str(chosen.seed)] if chosen.seed else []
    return shlex.join(words)
