"""The `import` command."""

from __future__ import annotations

from typing import TYPE_CHECKING

from abs_engine.cli.parts import options as take
from abs_engine.cli.parts.command import Chosen, Done, command
from abs_engine.cli.parts.drawing import opened, print_hints
from abs_engine.cli.parts.progress import Progress
from abs_engine.core.words import joined, listed
from abs_engine.face.schema import Pair, Unit, units_of
from abs_engine.io.files import check_free

if TYPE_CHECKING:
    from abs_engine.learn.heads.build import ImportedHead


_LIPS = {
    "rounded": units_of(Unit.MOUTH_FUNNEL, Unit.MOUTH_PUCKER),
    "pressed": units_of(Pair.MOUTH_PRESS),
    "closed over an open jaw": units_of(Unit.MOUTH_CLOSE),
}
"""What lips do in speech, and the face units that they need for it beside `jawOpen`."""


@command(
    "Learn faces and lips",
    take.argument("head", "HEAD",
        "a GLB or glTF file with morph targets, an OBJ file, or the folder of ICT's face model",
        type=take.INPUT),
    take.output("FILE", "the head, for 'track --model' and every '--speaker'"),
    take.file("--table", "what names do not say: landmarks, regions, units, people (TOML)"),
    take.file("--deltas", "OBJ files of the morph targets of an OBJ head", metavar="FOLDER"),
    take.renderer(),
    examples="abs-engine import ICT-FaceKit/FaceXModel -o ict.face\n"
    "abs-engine import head.glb -o head.face --table head.toml\n"
    "abs-engine import head.obj --deltas shapes -o head.face --table head.toml\n"
    "abs-engine render postures -o sheet.png --speaker head.face --person neutral\n"
    "abs-engine track talk.mp4 -o tracked --model head.face",
)  # fmt: skip
def import_(chosen: Chosen) -> Done:
    """Make a head from a mesh with morph targets."""
    check_free(chosen.output, take.FACE)
    from abs_engine.io.head_file import write_head
    from abs_engine.io.morphs import read_morphs
    from abs_engine.learn.heads.build import build_head
    from abs_engine.learn.heads.table import HeadTable, read_table
    from abs_engine.tracking.landmark.rendered_landmarks import with_network

    table = HeadTable() if chosen.table is None else read_table(chosen.table)
    made = build_head(read_morphs(chosen.head, chosen.deltas), table)
    with opened(chosen.renderer) as renderer, Progress("importing") as progress:
        print_hints(renderer)
        progress.announce("drawing the head, looking for its landmarks")
        head = with_network(made.speaker, renderer)
    write_head(chosen.output, head)
    facts = {
        "output": chosen.output,
        "vertices": len(head.vertices),
        "facets": len(head.faces),
        "opening_mm": made.opening,
        "people": list(head.people),
        "missing": list(made.missing),
        "exchanged": list(made.exchanged),
        "inside_out": made.inside_out,
        "twice": made.twice,
        "unused": list(made.unused),
        "added": list(made.added),
        "hidden": list(made.hidden),
    }
    return Done([*report(made), f"wrote {chosen.output}"], facts)


def report(made: ImportedHead) -> list[str]:
    """Lines about a head that was made."""
    head = made.speaker
    moving = len(head.unit_names) - len(made.missing)
    lines = [
        f"{len(head.vertices)} vertices, {len(head.faces)} triangles, {moving} of "
        f"{len(head.unit_names)} face units; jawOpen opens the lips by {made.opening:.0f} mm",
        f"people: {', '.join(head.people)}",
    ]
    if made.missing:
        lines.append(f"face units that it lacks, which move nothing: {listed(made.missing)}")
    shut = [name for name in made.missing if any(name in units for units in _LIPS.values())]
    if shut:
        done = [what for what, units in _LIPS.items() if set(units) & set(shut)]
        lines.append(
            f"warning: without {listed(shut)}, tracked lips cannot be {joined(done, 'or')} as they "
            "are in speech"
        )
    if made.exchanged:
        lines.append(
            "left and right were exchanged, as the names give them as a viewer sees them: "
            f"{listed(made.exchanged)}"
        )
    if made.twice:
        lines.append(f"{made.twice} facets were left out, as they lie on others")
    if made.inside_out:
        lines.append("facets were turned round, as they faced into the head")
    if made.unused:
        lines.append(f"morph targets that are not used: {listed(made.unused)}")
    if made.added:
        lines.append(f"added, as the mesh has none: {listed(made.added)}")
    if made.hidden:
        lines.append(
            f"parts that are not drawn, by their names or [regions]: {listed(made.hidden)}"
        )
    return lines
