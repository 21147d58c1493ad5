"""The `observe` command: dots in videos, marker files, calibration."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import click
from click.core import ParameterSource

from abs_engine.capture.settings import CAPTURE
from abs_engine.cli.parts import options as take
from abs_engine.cli.parts.calibrate import board_options, calibrate
from abs_engine.cli.parts.command import Chosen, Done, command
from abs_engine.cli.parts.dots import dots_film, views_of
from abs_engine.cli.parts.drawing import note
from abs_engine.cli.parts.progress import Progress
from abs_engine.core.errors import DegenerateViewsError, ParameterError
from abs_engine.core.words import counted
from abs_engine.io.files import check_free, write_new

if TYPE_CHECKING:
    from abs_engine.capture.head import HeadChoice
    from abs_engine.capture.observations import Observations
    from abs_engine.capture.session import Moment
    from abs_engine.capture.view import View

_NOTES = """\
Points and corrections are CSV files with the columns frame, view, point, x, y (or JSON): frames
from 0, views from 1, pixels from 0 at the top left. All dots must be seen in frame 0; corrections
leave x and y empty where one cannot be seen. With a mirror, view 1 is the direct one and view 2
the mirror image. Any names will do, but 'train' learns from 16 points of the lips, which are given
together with the nose, in rows from the subject's right to the left:
  corner_right, upper_outer_1 to _3, corner_left, lower_outer_1 to _3, upper_inner_1 to _4,
  lower_inner_1 to _4, nose
and others as you like. To correct: look at --overlay, edit the lines of --review, and
observe again with --corrections. The head frame needs one of --rigid, --pose and --unturned.
"""
_FOR_VIDEOS, _FOR_FILES, _FOR_BOARDS = "For videos", "For marker files", "For calibrate"
_OF_HEAD = "The head frame, for videos and marker files"
_CALIBRATE = Path("calibrate")
_MARKERS = (".c3d", ".csv")
_NOT_RIGID = 2.0
"""mm RMS of disagreement above which points are not rigid. Chosen: rigid ones have 0.1 to 0.7."""


def _rename(text: str) -> tuple[str, str]:
    old, equals, new = text.partition("=")
    if not (old and equals and new):
        raise click.BadParameter(f"'{text}' is not MARKER=POINT")
    return old, new


@command(
    "Learn faces and lips",
    take.argument("what", "WHAT...", "videos, a marker file, or calibrate and pictures; see above",
        nargs=-1, required=True),
    take.output("FILE", "observations, or camera.json of the calibration"),
    *take.group(
        _FOR_VIDEOS,
        take.file("--calibration", many=True, metavar="FILE...",
            text="camera.json of one camera with a mirror, or of each of two cameras"),
        take.file("--points", "where the dots are in frame 0, in both views"),
        take.file("--corrections", "where they are in other frames"),
        take.file("--review", "write a CSV of the places that a person should check",
            type=take.PATH),
        take.file("--overlay", "write an MP4 of the video with the dots drawn on it",
            type=take.PATH),
        take.option("--largest-error", type=take.positive, default=CAPTURE.largest_error,
            metavar="PX",
            text=f"largest reprojection error of a point (default: {CAPTURE.largest_error:g})"),
    ),
    *take.group(
        _OF_HEAD,
        take.option("--rigid", metavar="NAME,NAME,...", text="three or more points on the skull"),
        take.file("--reference",
            "CSV of point, x, y, z: places of the rigid points in the head frame, mm"),
        take.file("--pose",
            "CSV of the head's pose: frame, rx, ry, rz (radians), tx, ty, tz (mm)"),
        take.option("--unturned", metavar="NAME",
            text="the head never turns; take its shift from this point"),
    ),
    *take.group(
        _FOR_FILES,
        take.option("--rename", many=True, type=_rename, metavar="MARKER=POINT...",
            text="which markers with other names are which points"),
        take.option("--rate", type=take.positive, metavar="HZ",
            text="frame rate, if the file does not state it"),
        take.option("--unit", type=take.Choice(("mm", "cm", "m")),
            text="if the file does not state it (default: mm)"),
    ),
    *take.group(_FOR_BOARDS, *board_options()),
    examples="abs-engine observe left.mp4 right.mp4 --calibration left.json right.json "
    "--points dots.csv \\\n    --rigid nose,brow,temple -o dots.npz\n"
    "abs-engine observe markers.c3d --rigid nose,brow,temple -o dots.npz\n"
    "abs-engine observe calibrate pictures/*.png --squares 9 6 --square 12 -o camera.json",
    notes=_NOTES,
)  # fmt: skip
def observe(chosen: Chosen) -> Done:
    """Turn dots in two views into 3D points, read marker files, or calibrate cameras.

    VIDEO [VIDEO2]         follow dots in two videos, or in one with the face and its mirror image
    MARKERS                read markers of another system, a C3D or CSV file
    calibrate PICTURES...  calibrate a camera with pictures of a board; --second: also a second
                           one, --mirror: a mirror
    """
    first, *others = chosen.what
    check_free(chosen.output, ".json" if first == _CALIBRATE else ".npz")
    if first == _CALIBRATE:
        _check_options(_FOR_BOARDS)
        return calibrate(chosen, others)
    of_markers = first.suffix.lower() in _MARKERS
    _check_options(_FOR_FILES if of_markers else _FOR_VIDEOS, _OF_HEAD)
    return (_markers if of_markers else _videos)(chosen, chosen.what)


def _check_options(*sections: str) -> None:
    """Refuse options of other sections, which would do nothing."""
    context = click.get_current_context()
    for one in observe.params:
        section = getattr(one, "section", "")
        if section not in {_FOR_VIDEOS, _OF_HEAD, _FOR_FILES, _FOR_BOARDS} - set(sections):
            continue
        if context.get_parameter_source(one.name or "") is ParameterSource.COMMANDLINE:
            use = section.lower().partition("for ")[2]
            raise ParameterError(f"{one.opts[0]} is for {use}", "leave it out")


def _videos(chosen: Chosen, videos: Sequence[Path]) -> Done:
    from abs_engine.capture.dot_annotations import initial_places, read_marks, write_marks
    from abs_engine.capture.head_points import ORDER, points_of_head
    from abs_engine.capture.observations import write_observations
    from abs_engine.capture.session import follow_videos, review
    from abs_engine.capture.triangulate import check_sides, triangulate
    from abs_engine.io.video import probe

    for needed in ("calibration", "points"):
        if not getattr(chosen, needed):
            raise ParameterError(f"--{needed} is missing", "see 'abs-engine observe --help'")
    for path, ending in ((chosen.review, ".csv"), (chosen.overlay, ".mp4")):
        if path is not None:
            check_free(path, ending)
    views, points = views_of(chosen.calibration, videos), read_marks(chosen.points)
    corrections = read_marks(chosen.corrections) if chosen.corrections else ()
    info = probe(videos[0])
    head = _head(chosen, info.frames)
    names, places = initial_places(points, len(views))
    head.check(names)
    check_sides(views, triangulate(views, places).points)  # what is wrong, before the long work
    with Progress("observing") as progress, dots_film(chosen.overlay, info.rate) as film:

        def watch(moment: Moment) -> None:
            progress(moment.frame + 1, info.frames)
            film(moment)

        tracks = follow_videos(videos, points, corrections, watch=watch)
        source = " ".join(["dots in", *(v.name for v in videos)])
        observed = points_of_head(tracks, views, head, chosen.largest_error, source=source)
        rows = list(review(tracks, observed))
        write_observations(chosen.output, observed)
        if chosen.review is not None:
            write_new(chosen.review, write_marks(rows).encode())
    lines = [f"{len(rows)} of {tracks.scores.size} places should be looked at by a person"]
    agreed = observed.error <= chosen.largest_error  # with a head or without; NaN for a lost dot
    if 2 * agreed.sum() <= agreed.size:
        doubt = "warning: most points were not found, because dots were lost or the views disagree "
        lines.insert(0, f"{doubt}by more than --largest-error: check {ORDER}")
    return _done(chosen, observed, views, lines)


def _head(chosen: Chosen, frames: int, first: int = 0) -> HeadChoice:
    from abs_engine.capture.head import HeadChoice, read_head_poses, read_reference

    rigid = tuple(n.strip() for n in (chosen.rigid or "").split(",") if n.strip())
    if chosen.reference is not None and not rigid:
        raise ParameterError("--reference goes with --rigid", "name the rigid points")
    reference = None if chosen.reference is None else read_reference(chosen.reference)
    motion = None if chosen.pose is None else read_head_poses(chosen.pose, frames, first)
    return HeadChoice(rigid, reference, motion, chosen.unturned)


def _markers(chosen: Chosen, files: Sequence[Path]) -> Done:
    from abs_engine.capture.head_points import points_of_markers
    from abs_engine.capture.markers import read_markers
    from abs_engine.capture.observations import write_observations

    if len(files) > 1:
        raise ParameterError("several marker files were given", "give one")
    markers = read_markers(files[0], chosen.rate, chosen.unit, note).renamed(dict(chosen.rename))
    head = _head(chosen, len(markers.points), markers.first)
    observed = points_of_markers(markers, head, source=f"markers of {files[0].name}")
    write_observations(chosen.output, observed)
    return _done(chosen, observed)


def _done(
    chosen: Chosen, observed: Observations, views: Sequence[View] = (), more: Sequence[str] = ()
) -> Done:
    import numpy as np

    found, missing = observed.found, observed.found.size - int(observed.found.sum())
    uncertain = int(observed.uncertain.sum())
    lines = [
        f"{counted(observed.frames, 'frame')} of {len(observed.names)} points at "
        f"{observed.rate:g} frames/s; {missing} of {found.size} not found, {uncertain} uncertain"
    ]
    if len(observed.pixels) and found.any():
        error = np.sqrt(np.mean(observed.error[found] ** 2))
        lines.append(f"reprojection error {error:.2f} px RMS")
    if chosen.rigid:
        rigid = np.sqrt(np.nanmean(observed.rigid_error**2))
        lines.append(f"rigid points agree to {rigid:.2f} mm RMS")
        if rigid > _NOT_RIGID:
            lines.append(
                "warning: these points are not rigid: name others, or look for frames in which one "
                "was lost or mistaken for another"
            )
    lines += _doubts(observed, views)
    head = int((~np.isfinite(observed.rotations).all(axis=1)).sum())
    lines += [f"{counted(head, 'frame')} without the head"] if head else []
    lines += [*more, f"wrote {chosen.output}"]
    facts = {"frames": observed.frames, "missing": missing, "uncertain": uncertain}
    return Done(lines, {"output": chosen.output, **facts, "frames_without_head": head})


def _doubts(observed: Observations, views: Sequence[View]) -> list[str]:
    """A warning if the dots do not lie as those of lips do: 'train' would refuse them."""
    import numpy as np

    from abs_engine.capture.dot_annotations import LIPS16
    from abs_engine.capture.exchanged import crossed
    from abs_engine.io.assets import load_speaker
    from abs_engine.learn.correspondence import check_dots

    if not set(LIPS16) <= set(observed.names):
        return []
    dots = observed.of(LIPS16)
    dots = dots[np.isfinite(dots).all(axis=(1, 2))]
    if not len(dots):
        return []
    try:
        swapped = crossed(observed, views, LIPS16) if views else None
        check_dots(load_speaker(), dots.mean(axis=0), swapped)
    except (DegenerateViewsError, ParameterError) as error:
        return [f"warning: {error}"]
    return []
