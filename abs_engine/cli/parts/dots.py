"""Dots in videos: the views of them by their calibrations, and a film for a person who checks."""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from abs_engine.core.errors import ParameterError
from abs_engine.io.files import write_new

if TYPE_CHECKING:
    from abs_engine.capture.session import Moment
    from abs_engine.capture.view import View
    from abs_engine.io.video import VideoWriter


class DotsFilm:
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

    def __enter__(self) -> DotsFilm:
        return self

    def __exit__(self, *_: object) -> None:
        if self._writer is not None:
            self._writer.close()
        self._folder.cleanup()


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
