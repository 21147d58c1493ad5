"""What can be typed after `render`."""

from __future__ import annotations

import argparse
from argparse import Namespace
from pathlib import Path
from typing import TYPE_CHECKING

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
EPILOG = "kinds:\n" + "\n".join(f"  {kind:10} {text}" for kind, text in KINDS.items())


def add_render(command: argparse.ArgumentParser) -> None:
    """Add what is typed after `render`, but for output and renderer."""
    command.formatter_class = argparse.RawDescriptionHelpFormatter
    command.epilog = EPILOG
    add = command.add_argument
    add("kind", nargs="?", choices=tuple(KINDS), default="portrait", metavar="KIND",
        help="what is drawn, see below (default: portrait)")  # fmt: skip
    add("run_folder", nargs="?", type=Path, metavar="RUN", help="what 'track -o' made")
    add("--truth", type=Path, metavar="DIR", help="a dataset, or its clip and camera")
    add("--clip", metavar="NAME", help="clip of the dataset, if it has several")
    add("--camera", metavar="NAME", help="camera of the clip, if it has several")
    add("--frame", type=int, metavar="N",
        help="frame of the run or the dataset (default: all as MP4, 20 as PNG)")  # fmt: skip
    add("--person", default="clara", help="who is drawn (default: clara)")
    add("--speaker", type=Path, metavar="FILE", help="head.npz of another speaker")
    add("--unit", action="append", default=[], metavar="NAME=WEIGHT", type=_unit, dest="units",
        help="a face unit of the posture, such as jawOpen=0.4; may be repeated")  # fmt: skip
    add("--palette", choices=("colour", "clay", "classes"), help="what the head's surface shows")
    add("--crop", choices=("head", "mouth"),
        help="what is shown (default: the mouth for modes, else the head)")  # fmt: skip
    add(
        "--size",
        type=_count,
        nargs=2,
        metavar=("WIDTH", "HEIGHT"),
        help="size of one picture, pixels",
    )
    add("--turn", type=float, default=0.0, metavar="DEGREES", help="turn towards the head's left")
    add(
        "--views", type=_count, metavar="N", help="pictures of a turntable (default: 8; 100 as MP4)"
    )
    add("--rows", nargs="+", default=[], metavar="UNIT", help="face units to show (default: all)")
    add(
        "--weight", type=float, default=1.0, help="weight of the face unit in postures (default: 1)"
    )
    add("--modes", type=_count, metavar="N", help="show modes of the mouth's shape model")
    add(
        "--columns",
        type=_count,
        metavar="N",
        help="columns of a nomogram (default: 5; 7 for modes)",
    )
    add("--style", choices=("wireframe", "contour", "blend"), default="wireframe",
        help="style of an overlay (default: wireframe)")  # fmt: skip
    add("--video", type=Path, metavar="FILE", help="the run's video, if it is not beside the run")
    add("--values", type=Path, metavar="FILE", help=".npy or .npz, one number for each vertex")
    add("--max", type=float, dest="largest", metavar="VALUE",
        help="end of the colour scale of error (mm) or flow (pixels)")  # fmt: skip
    add("--range", type=float, nargs=2, dest="limits", metavar=("LOW", "HIGH"),
        help="ends of the colour scale of depth, mm")  # fmt: skip


def request_of(chosen: Namespace) -> Request:
    """What was typed, as a request; a wrong name is told before anything is opened."""
    from abs_engine.report.inspect.body import check_person
    from abs_engine.report.inspect.request import Request

    request = Request(
        kind=chosen.kind,
        output=chosen.output,
        run=chosen.run_folder,
        units=dict(chosen.units),
        size=None if chosen.size is None else tuple(chosen.size),
        rows=tuple(chosen.rows),
        limits=None if chosen.limits is None else tuple(chosen.limits),
        **{name: getattr(chosen, name) for name in _AS_TYPED},
    )
    if request.run is None and request.truth is None:
        check_person(request.person, request.speaker)
    return request


_AS_TYPED = (
    *("truth", "clip", "camera", "frame", "person", "speaker", "palette", "crop", "turn"),
    *("views", "weight", "modes", "columns", "style", "video", "values", "largest"),
)


def _count(text: str) -> int:
    number = int(text)
    if number < 1:
        raise argparse.ArgumentTypeError(f"{text} is not 1 or more")
    return number


def _unit(text: str) -> tuple[str, float]:
    name, _, weight = text.partition("=")
    try:
        return name, float(weight)
    except ValueError:
        raise argparse.ArgumentTypeError(f"'{text}' is not NAME=WEIGHT") from None
