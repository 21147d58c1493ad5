"""Dots in videos: the views of them by their calibrations, and a film for a person who checks."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING

from abs_engine.core.errors import ParameterError
from abs_engine.io.files import write_new

if TYPE_CHECKING:
    from abs_engine.capture.session import Moment
    from abs_engine.capture.view import View


@contextmanager
def dots_film(path: Path | None, rate: float) -> Iterator[Callable[[Moment], None]]:
    """Takes frames for a film of the dots, whole or not at all; nothing where no path is given."""
    from abs_engine.capture.overlay import draw_views
    from abs_engine.io.video import VideoWriter

    with TemporaryDirectory() as folder, ExitStack() as stack:
        made = Path(folder) / "overlay.mp4"
        writer: VideoWriter | None = None

        def add(moment: Moment) -> None:
            nonlocal writer
            if path is None:
                return
            picture = draw_views(moment.images, moment.sightings, moment.names)
            if writer is None:
                size = picture.shape[1], picture.shape[0]
                writer = stack.enter_context(VideoWriter(made, size, rate))
            writer.write(picture)

        yield add
        stack.close()
        if path is not None and writer is not None:
            write_new(path, made.read_bytes())


def views_of(files: Sequence[Path], videos: Sequence[Path]) -> list[View]:
    """The views of two calibrated cameras, or of one directly and by its mirror, in this order."""
    from abs_engine.capture.view import Plane, View
    from abs_engine.dataset import load_placed_camera
    from abs_engine.dataset.sums import check_distinct
    from abs_engine.io.video import probe

    placed = [load_placed_camera(path) for path in files]
    if len(placed) != len(videos):
        raise ParameterError(
            f"{len(videos)} videos and {len(placed)} calibrations were given",
            "give one video and a camera with a mirror, or two of each",
        )
    for path, one, video in zip(files, placed, videos, strict=True):
        if len(one.rotations) > 1:
            raise ParameterError(f"the camera of {path} moves", "give one that stands still")
        size = probe(video).size
        if one.camera.size != size:
            raise ParameterError(
                "{} is for pictures of {}x{} pixels, {} has {}x{}".format(
                    path, *one.camera.size, video, *size
                ),
                "calibrate with pictures of the video's size",
            )
    check_distinct([(video, video) for video in videos], "give the other camera's video")
    firsts = [one.at_origin for one in placed]
    if firsts == [True, True]:
        raise ParameterError(
            f"{files[0]} and {files[1]} are both of a first or single camera",
            "calibrate the two together, with the second camera's pictures as --second",
        )
    if firsts == [False, True]:
        raise ParameterError(
            f"{files[1]} is the first camera of its pair, but {files[0]} was given before it",
            "exchange the two, and give videos and views in the same order",
        )
    views = [View(one.camera, one.pose(0)) for one in placed]
    if len(placed) == 1:
        if placed[0].mirror is None:
            raise ParameterError(
                f"{files[0]} has no mirror, and one view leaves depth open",
                "give a second video with its calibration, or calibrate with --mirror",
            )
        views.append(View(placed[0].camera, placed[0].pose(0), Plane.through(placed[0].mirror)))
    return views
