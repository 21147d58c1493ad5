"""Views of the videos in which dots are followed, by their calibrations."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from abs_engine.core.errors import ParameterError

if TYPE_CHECKING:
    from abs_engine.capture.view import View


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
