"""The `export` command."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import asdict
from typing import TYPE_CHECKING

from abs_engine.cli.parts import options as take
from abs_engine.cli.parts.command import Chosen, Done, command
from abs_engine.core.registry import EXPORTERS, load_plugins

if TYPE_CHECKING:
    from abs_engine.export.exporter import Loss


def _notes() -> str:
    entries, _ = EXPORTERS.working()
    texts = {name: f"{e.text}{e.suffix and f' ({e.suffix})'}" for name, e in entries.items()}
    rows = (f"  {name:12}{texts.get(name, 'cannot be imported')}\n" for name in EXPORTERS)
    return "Formats:\n" + "".join(rows)


def _loss_lines(lost: Sequence[Loss]) -> Iterator[str]:
    """Lines about a file that was read back; what is exact but for rounding is in one of them."""
    for one in lost:
        if not one.rounded:
            yield f"loss: {one}" if one.by else f"read back, {one}"
    exact = [one.of for one in lost if one.rounded]
    if exact:
        yield f"read back, exact but for rounding: {', '.join(exact)}"


@command(
    "Track and look at the result",
    take.argument("run", "RUN", text="what 'track -o' made"),
    take.option("--to", "to", metavar="NAME", type=take.Named(EXPORTERS), required=True,
        text="the format; see below"),
    take.output("PATH", "the file, or the folder if the format has several files"),
    take.option("--smooth", metavar="FILTER:N",
        text="smooth before writing, by butterworth:HZ (the cutoff) or savitzky-golay:FRAMES "
        "(the window) (default: nothing is smoothed)"),
    take.file("--speaker", text="head.npz that it was tracked with (default: the bundled head)"),
    take.file("--plugin", multiple=True, metavar="FILE.py",
        text="Python file that adds formats of your own; may be repeated"),
    examples="abs-engine export tracked --to praat -o praat\n"
    "abs-engine export tracked --to gltf -o head.glb\n"
    "abs-engine export tracked --to arkit -o face.csv\n"
    "abs-engine export tracked --to praat -o smooth --smooth butterworth:8",
    notes=_notes,
)  # fmt: skip
def export(chosen: Chosen) -> Done:
    """Write a run in another program's format, and report what is lost."""
    from abs_engine.export.writing import export_run

    load_plugins(chosen.plugin)
    lost = export_run(chosen.run, chosen.to, chosen.output, chosen.speaker, chosen.smooth)
    moved, read = (lost[:1], lost[1:]) if chosen.smooth else ((), lost)
    notes = [one.note for one in lost if one.note]
    smooth = [f"smoothed, {one}" for one in moved]
    lines = [*smooth, *_loss_lines(read), *notes, f"wrote {chosen.output}"]
    known = [one.value if math.isfinite(one.value) else None for one in lost]
    facts = [asdict(one) | {"value": value} for one, value in zip(lost, known, strict=True)]
    return Done(lines, {"output": chosen.output, "loss": facts})
