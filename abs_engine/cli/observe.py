"""``abs-engine observe``: calibration, dots in videos, marker files."""

from __future__ import annotations

import argparse
import tempfile
from argparse import Namespace
from collections.abc import Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING

from abs_engine.cli.calibrate import add_calibrate, calibrate
from abs_engine.cli.progress import Progress
from abs_engine.core.errors import ParameterError
from abs_engine.io.files import check_free, write_new

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from abs_engine.capture.head import HeadChoice
    from abs_engine.capture.observations import Observations
    from abs_engine.capture.session import Moment
    from abs_engine.capture.view import View
    from abs_engine.io.video import VideoWriter

    FloatArray = NDArray[np.float64]

EPILOG = """\
three uses:
  observe VIDEO [VIDEO2] --calibration FILE [FILE2] --points FILE -o OBS.npz
        follow dots in two videos, or in one that shows the face and its mirror image
  observe MARKERS.c3d -o OBS.npz         (or .csv) read markers of another system
  observe calibrate PICTURES... --squares 9 6 --square 12 -o camera.json
        calibrate a camera with pictures of a board; --second: also a second one, --mirror: a mirror

Points and corrections are CSV files with the columns frame, view, point, x, y (or JSON): frames
from 0, views from 1, pixels from 0 at the top left; leave x and y empty where the dot cannot be
seen. The
points are 16 of the lips and the nose, in rows from the subject's right to the left:
  corner_right, upper_outer_1 to _3, corner_left, lower_outer_1 to _3, upper_inner_1 to _4,
  lower_inner_1 to _4, nose
and others on the skull. To correct: look at --overlay, edit the lines of --review, and
observe again with --corrections. The head frame needs one of --rigid, --pose and --unturned.
"""
_MARKERS = (".c3d", ".csv")


def add_observe(command: argparse.ArgumentParser) -> None:
    """Add what is typed after `observe`."""
    command.formatter_class = argparse.RawDescriptionHelpFormatter
    command.epilog = EPILOG
    add = command.add_argument
    add("what", nargs="+", metavar="VIDEO|MARKERS|calibrate PICTURE", help="see below")
    add("-o", "--output", type=Path, metavar="FILE", required=True,
        help="observations, or camera.json of the calibration; must not exist")  # fmt: skip
    _add_videos(command.add_argument_group("for videos"))
    _add_head(command.add_argument_group("the head frame, for videos and marker files"))
    _add_markers(command.add_argument_group("for marker files"))
    add_calibrate(command.add_argument_group("for calibrate"))


def _add_videos(group: argparse._ArgumentGroup) -> None:
    add = group.add_argument
    add("--calibration", type=Path, nargs="+", metavar="FILE",
        help="camera.json of one camera with a mirror, or of each of two cameras")  # fmt: skip
    add("--points", type=Path, metavar="FILE", help="where the dots are in frame 0, in both views")
    add("--corrections", type=Path, metavar="FILE", help="where they are in other frames")
    add(
        "--review",
        type=Path,
        metavar="FILE",
        help="write the places that a person should check, a CSV",
    )
    add(
        "--overlay",
        type=Path,
        metavar="FILE",
        help="write the video with the dots drawn on it, an MP4",
    )
    add("--largest-error", type=float, default=1.5, metavar="PX",
        help="largest reprojection error of a point (default: 1.5)")  # fmt: skip


def _add_head(group: argparse._ArgumentGroup) -> None:
    add = group.add_argument
    add("--rigid", metavar="NAME,NAME,...", help="three or more points on the skull")
    add("--reference", type=Path, metavar="FILE",
        help="CSV of point, x, y, z: places of the rigid points in the head frame, mm")  # fmt: skip
    add("--pose", type=Path, metavar="FILE",
        help="CSV of the head's pose: frame, rx, ry, rz (radians), tx, ty, tz (mm)")  # fmt: skip
    add("--unturned", metavar="NAME", help="the head never turns; take its shift from this point")


def _add_markers(group: argparse._ArgumentGroup) -> None:
    add = group.add_argument
    add("--rename", nargs="+", default=[], type=_rename, metavar="MARKER=POINT")
    add("--rate", type=float, metavar="HZ", help="frame rate, if the file does not state it")
    add("--unit", choices=("mm", "cm", "m"), help="if the file does not state it (default: mm)")


def observe(chosen: Namespace) -> int:
    """Observe points, or calibrate."""
    check_free(chosen.output, ".json" if chosen.what[0] == "calibrate" else ".npz")
    if chosen.what[0] == "calibrate":
        return calibrate(chosen, [Path(p) for p in chosen.what[1:]])
    files = [Path(p) for p in chosen.what]
    if files[0].suffix.lower() in _MARKERS:
        return _markers(chosen, files)
    return _videos(chosen, files)


def _videos(chosen: Namespace, videos: list[Path]) -> int:
    from abs_engine.capture.dot_annotations import initial_places, read_marks, write_marks
    from abs_engine.capture.observations import write_observations
    from abs_engine.capture.session import follow_videos, points_of_head, review
    from abs_engine.capture.triangulate import triangulate
    from abs_engine.io.video import probe

    for option in ("calibration", "points"):
        if getattr(chosen, option) is None:
            raise ParameterError(f"--{option} is missing", "see 'abs-engine observe --help'")
    for path, ending in ((chosen.review, ".csv"), (chosen.overlay, ".mp4")):
        if path is not None:
            check_free(path, ending)
    views, points = _views(chosen.calibration, videos), read_marks(chosen.points)
    corrections = read_marks(chosen.corrections) if chosen.corrections else ()
    info = probe(videos[0])
    head = _head(chosen, info.frames)
    names, places = initial_places(points, len(views))
    head.check(names)
    triangulate(views, places)  # complains of views that leave depth open before the long work
    with ExitStack() as stack:
        progress = stack.enter_context(Progress("observing"))
        overlay = stack.enter_context(_Overlay(chosen.overlay, info.rate))

        def watch(moment: Moment) -> None:
            progress(moment.frame + 1, info.frames)
            overlay.add(moment)

        tracks = follow_videos(videos, points, corrections, watch=watch)
        source = " ".join(["dots in", *(v.name for v in videos)])
        observed = points_of_head(tracks, views, head, chosen.largest_error, source=source)
        rows = list(review(tracks, observed))
        write_observations(chosen.output, observed)
        if chosen.review is not None:
            write_new(chosen.review, write_marks(rows).encode())
        overlay.finish()
    _tell(observed, bool(chosen.rigid))
    print(f"{len(rows)} of {tracks.scores.size} places should be looked at by a person")
    print(f"wrote {chosen.output}")
    return 0


def _views(files: Sequence[Path], videos: Sequence[Path]) -> list[View]:
    from abs_engine.capture.view import Plane, View
    from abs_engine.dataset import load_placed_camera

    placed = [load_placed_camera(path) for path in files]
    if len(placed) != len(videos):
        raise ParameterError(
            f"{len(videos)} videos and {len(placed)} calibrations were given",
            "give one video and a camera with a mirror, or two of each",
        )
    for path, one in zip(files, placed, strict=True):
        if len(one.rotations) > 1:
            raise ParameterError(f"the camera of {path} moves", "give one that stands still")
    views = [View(one.camera, one.pose(0)) for one in placed]
    if len(placed) == 1:
        if placed[0].mirror is None:
            raise ParameterError(
                f"{files[0]} has no mirror, and one view leaves depth open",
                "give a second video with its calibration, or calibrate with --mirror",
            )
        views.append(View(placed[0].camera, placed[0].pose(0), Plane.through(placed[0].mirror)))
    return views


def _head(chosen: Namespace, frames: int) -> HeadChoice:
    from abs_engine.capture.head import HeadChoice
    from abs_engine.capture.headfiles import read_head_poses, read_reference

    rigid = tuple(n.strip() for n in (chosen.rigid or "").split(",") if n.strip())
    if chosen.reference is not None and not rigid:
        raise ParameterError("--reference goes with --rigid", "name the rigid points")
    reference = None if chosen.reference is None else read_reference(chosen.reference)
    motion = None if chosen.pose is None else read_head_poses(chosen.pose, frames)
    return HeadChoice(rigid, reference, motion, chosen.unturned)


def _markers(chosen: Namespace, files: list[Path]) -> int:
    from abs_engine.capture.markers import read_markers
    from abs_engine.capture.observations import write_observations
    from abs_engine.capture.session import points_of_markers

    if len(files) > 1:
        raise ParameterError("several marker files were given", "give one")
    markers = read_markers(files[0], chosen.rate, chosen.unit).renamed(dict(chosen.rename))
    head = _head(chosen, len(markers.points))
    observed = points_of_markers(markers, head, source=f"markers of {files[0].name}")
    write_observations(chosen.output, observed)
    _tell(observed, bool(chosen.rigid))
    print(f"wrote {chosen.output}")
    return 0


def _tell(observed: Observations, rigid: bool) -> None:
    import numpy as np

    missing = observed.found.size - int(observed.found.sum())
    print(
        f"{observed.frames} frames of {len(observed.names)} points at {observed.rate:g} frames/s; "
        f"{missing} of {observed.found.size} not found, {int(observed.uncertain.sum())} uncertain"
    )
    if len(observed.pixels) and observed.found.any():
        error = np.sqrt(np.mean(observed.error[observed.found] ** 2))
        print(f"reprojection error {error:.2f} px RMS")
    head = int((~np.isfinite(observed.rotations).all(axis=1)).sum())
    if rigid:
        print(f"rigid points agree to {np.sqrt(np.nanmean(observed.rigid_error**2)):.2f} mm RMS")
    print(f"{head} frames without the head")


class _Overlay:
    """A film of the dots, whole or not at all; nothing where no path is given."""

    def __init__(self, path: Path | None, rate: float) -> None:
        self._path, self._rate = path, rate
        self._folder = tempfile.TemporaryDirectory()
        self._writer: VideoWriter | None = None

    def add(self, moment: Moment) -> None:
        """Append a frame."""
        if self._path is None:
            return
        from abs_engine.capture.overlay import draw_views
        from abs_engine.io.video import VideoWriter

        picture = draw_views(moment.images, moment.sightings, moment.names)
        if self._writer is None:
            size = picture.shape[1], picture.shape[0]
            self._writer = VideoWriter(self._file, size, self._rate)
        self._writer.write(picture)

    def finish(self) -> None:
        """Close the film and put it in its place."""
        if self._path is not None and self._writer is not None:
            self._writer.close()
            self._writer = None
            write_new(self._path, self._file.read_bytes())

    @property
    def _file(self) -> Path:
        return Path(self._folder.name) / "overlay.mp4"

    def __enter__(self) -> _Overlay:
        return self

    def __exit__(self, *_: object) -> None:
        if self._writer is not None:
            self._writer.close()
        self._folder.cleanup()


def _rename(text: str) -> tuple[str, str]:
    old, equals, new = text.partition("=")
    if not (old and equals and new):
        raise argparse.ArgumentTypeError(f"'{text}' is not MARKER=POINT")
    return old, new
