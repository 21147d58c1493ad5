"""The `render` command."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from abs_engine.cli.parts import options as take
from abs_engine.cli.parts.command import Chosen, Done, command
from abs_engine.cli.parts.drawing import opened
from abs_engine.cli.parts.progress import Progress
from abs_engine.io.files import check_free

if TYPE_CHECKING:
    from abs_engine.report.inspect.request import Request

KINDS = {
    "portrait": "one picture of a posture; MP4: from all sides (the default)",
    "postures": "the face units, each alone",
    "nomogram": "rows of a face unit or a mode (--modes, or RUN's) from low to high",
    "turntable": "a posture from all sides",
    "overlay": "the tracked head of RUN over its video; --truth or --video say where that is",
    "ids": "facet ids, of a posture, of RUN or of --truth; also classes, depth, normals",
    "classes": "classes of facets",
    "depth": "depth in mm",
    "normals": "normals, red to the right, green up, blue to the camera",
    "albedo": "colour without light, of --truth",
    "flow": "optical flow, of --truth",
    "error": "mm painted on the face, of --values FILE or of RUN --truth DIR",
}
_NOTES = "Kinds:\n" + "".join(f"  {kind:10} {text}\n" for kind, text in KINDS.items())


def _unit(text: str) -> tuple[str, float]:
    name, _, weight = text.partition("=")
    try:
        return name, float(weight)
    except ValueError:
        raise click.BadParameter(f"'{text}' is not NAME=WEIGHT") from None


@command(
    "Track and look at the result",
    take.argument("kind", "[KIND]", "what is drawn, see below (default: portrait)",
        type=take.Choice(tuple(KINDS)), default="portrait"),
    take.argument("run", "[RUN]", "what 'track -o' made", required=False, type=take.INPUT),
    take.output("FILE", "a PNG or an MP4"),
    *take.group(
        "What is shown",
        take.file("--truth", "a dataset, or its clip and camera", metavar="DIR"),
        *take.view(),
        take.option("--frame", type=int, metavar="N",
            text="frame of the run or the dataset (default: all as MP4, 20 as PNG)"),
        take.person("who is drawn (default: clara, or the first of --speaker's people)"),
        take.file("--speaker", "head.npz of another speaker"),
        take.option("--unit", "units", multiple=True, type=_unit, metavar="NAME=WEIGHT",
            text="a face unit of the posture, such as jawOpen=0.4; may be repeated"),
        take.option("--rows", many=True, type=take.Named(take.unit_names), metavar="UNIT...",
            text="face units to show (default: all)"),
        take.option("--weight", type=take.number, default=1.0, metavar="WEIGHT",
            text="weight of the face unit in postures (default: 1)"),
        take.option("--modes", type=take.count, metavar="N",
            text="show N modes of the mouth's shape model, or of RUN's head"),
        take.file("--video", "the run's video, if it has moved"),
        take.file("--values", ".npy or .npz, one number for each vertex"),
    ),
    *take.group(
        "How it is shown",
        take.option("--palette", type=take.Choice(("colour", "clay", "classes")),
            text="what the head's surface shows"),
        take.option("--crop", type=take.Choice(("head", "mouth")),
            text="what is shown (default: the mouth for modes, else the head)"),
        take.option("--size", type=take.count, nargs=2, metavar="WIDTH HEIGHT",
            text="size of one picture, pixels"),
        take.option("--turn", type=take.number, default=0.0, metavar="DEGREES",
            text="turn towards the head's left"),
        take.option("--views", type=take.count, metavar="N",
            text="pictures of a turntable (default: 8; 100 as MP4)"),
        take.option("--columns", type=take.count, metavar="N",
            text="columns of a nomogram (default: 5; 7 for modes)"),
        take.option("--style", type=take.Choice(("wireframe", "contour", "blend")),
            default="wireframe", text="style of an overlay (default: wireframe)"),
        take.option("--max", "largest", type=take.number, metavar="VALUE",
            text="end of the colour scale of error (mm) or flow (pixels)"),
        take.option("--range", "limits", type=take.number, nargs=2, metavar="LOW HIGH",
            text="ends of the colour scale of depth, mm"),
        take.renderer(),
    ),
    examples="abs-engine render -o smile.png --unit mouthSmileLeft=1 --unit mouthSmileRight=1\n"
    "abs-engine render overlay tracked -o overlay.mp4 --style contour\n"
    "abs-engine render error tracked --truth clip -o error.png",
    notes=_NOTES,
)  # fmt: skip
def render(chosen: Chosen) -> Done:
    """Draw postures, nomograms, overlays, labels or errors: a picture or a film."""
    from abs_engine.report.inspect.output import is_film

    check_free(chosen.output)
    is_film(chosen.output)
    request = request_of(chosen)

    from abs_engine.report.inspect.draw import render_to_file

    with opened(chosen.renderer) as renderer, Progress("drawing") as progress:
        render_to_file(request, renderer, progress)
    return Done([f"wrote {chosen.output}"], {"output": chosen.output})


def request_of(chosen: Chosen) -> Request:
    """The typed options as a request; a wrong name or head is refused before anything is opened."""
    from abs_engine.io.assets import load_speaker
    from abs_engine.report.inspect.body import check_person
    from abs_engine.report.inspect.request import Request

    typed = {name: getattr(chosen, name) for name in Request.__dataclass_fields__}
    request = Request(**typed | {"units": dict(chosen.units)})
    if request.run is None and request.truth is None:
        check_person(request.person, request.speaker)
    elif request.speaker is not None:
        load_speaker(request.speaker)
    return request
