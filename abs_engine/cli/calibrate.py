"""``abs-engine observe calibrate``: cameras and mirrors from pictures of a board."""

from __future__ import annotations

import argparse
from argparse import Namespace
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from abs_engine.cli.progress import Progress
from abs_engine.core.errors import ParameterError
from abs_engine.io.files import check_free, write_new

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from abs_engine.capture.board import Board, Corners
    from abs_engine.core.camera import Camera

    FloatArray = NDArray[np.float64]


def add_calibrate(group: argparse._ArgumentGroup) -> None:
    """Add the options of a calibration."""
    add = group.add_argument
    add("--board", choices=("charuco", "chessboard"), default="charuco", help="(default: charuco)")
    add(
        "--squares",
        type=int,
        nargs=2,
        metavar=("COLUMNS", "ROWS"),
        help="number of squares of the board",
    )
    add("--square", type=float, metavar="MM", help="side of a square")
    add("--marker", type=float, metavar="MM", help="side of a marker (default: 0.75 squares)")
    add(
        "--dictionary",
        default="4X4_50",
        metavar="NAME",
        help="dictionary of the markers (default: 4X4_50)",
    )
    add("--mirror", action="store_true", help="the pictures show the board and its mirror image")
    add("--second", type=Path, nargs="+", metavar="PICTURE",
        help="a second camera's pictures, of the same moments in the same order")  # fmt: skip
    add("--second-output", type=Path, metavar="FILE", help="the second camera's calibration")


def calibrate(chosen: Namespace, pictures: list[Path]) -> int:
    """Calibrate one camera, with a mirror or without, or two."""
    from abs_engine.capture.board import Board
    from abs_engine.capture.calibrate import calibrate_camera, calibrate_stereo
    from abs_engine.dataset import camera_json

    if chosen.squares is None or chosen.square is None or not pictures:
        raise ParameterError(
            "pictures, --squares COLUMNS ROWS and --square MM are needed",
            "see 'abs-engine observe --help'",
        )
    if (chosen.second is None) != (chosen.second_output is None) or (
        chosen.second and chosen.mirror
    ):
        raise ParameterError(
            "--second goes with --second-output, and not with --mirror", "give both or neither"
        )
    if chosen.mirror and chosen.board != "charuco":
        raise ParameterError(
            "a chessboard looks the same as its mirror image", "use a ChArUco board"
        )
    if chosen.second_output is not None:
        check_free(chosen.second_output, ".json")
    columns, rows = chosen.squares
    board = Board(chosen.board, columns, rows, chosen.square, chosen.marker, chosen.dictionary)
    with Progress("calibrating") as progress:
        found, size = _corners(board, pictures, chosen.mirror, progress)
        own = calibrate_camera([c for pair in found for c in pair if c is not None], size)
        print(f"{own.error:.2f} px RMS, focal length {own.camera.matrix[0, 0]:.1f} "
              f"+- {own.focal_deviation:.1f} px, principal point +- {own.centre_deviation:.1f} px"
              )  # fmt: skip
        if chosen.second is None:
            mirror = _mirror(found, own.camera) if chosen.mirror else None
            write_new(chosen.output, camera_json(own.camera, mirror=mirror).encode())
            print(f"wrote {chosen.output}")
            return 0
        if len(chosen.second) != len(pictures):
            raise ParameterError(
                f"{len(pictures)} and {len(chosen.second)} pictures were given",
                "give as many of each camera, of the same moments",
            )
        there, other_size = _corners(board, chosen.second, False, progress)
    other = calibrate_camera([c for c, _ in there if c is not None], other_size)
    both = [(a, b) for (a, _), (b, _) in zip(found, there, strict=True) if a and b]
    stereo = calibrate_stereo(both, own.camera, other.camera)
    print(f"second: {other.error:.2f} px RMS; both together {stereo.error:.2f} px RMS")
    vectors = [stereo.pose.rotation_vector], [stereo.pose.translation]
    write_new(chosen.output, camera_json(own.camera).encode())
    try:
        write_new(chosen.second_output, camera_json(other.camera, *vectors).encode())
    except BaseException:
        chosen.output.unlink()
        raise
    print(f"wrote {chosen.output} and {chosen.second_output}")
    return 0


def _corners(
    board: Board, pictures: Sequence[Path], mirror: bool, progress: Progress
) -> tuple[list[tuple[Corners | None, Corners | None]], tuple[int, int]]:
    """The board in each picture, and its mirror image; and the pictures' size."""
    from abs_engine.io.assets import read_image

    found: list[tuple[Corners | None, Corners | None]] = []
    size: tuple[int, int] | None = None
    for number, path in enumerate(pictures):
        image = read_image(path)
        size = size or (image.shape[1], image.shape[0])
        if (image.shape[1], image.shape[0]) != size:
            raise ParameterError(
                f"{path} is {image.shape[1]}x{image.shape[0]}, the first picture {size[0]}x"
                f"{size[1]}", "give pictures of one camera at one size"
            )  # fmt: skip
        found.append((board.find(image), board.find(image, True) if mirror else None))
        if found[-1] == (None, None):
            print(f"no board in {path}")
        progress(number + 1, len(pictures))
    return found, size or (0, 0)


def _mirror(found: Sequence[tuple[Corners | None, Corners | None]], camera: Camera) -> FloatArray:
    from abs_engine.capture.mirror import calibrate_mirror

    both = [(a, b) for a, b in found if a is not None and b is not None]
    mirror = calibrate_mirror(both, camera)
    print(f"mirror in {len(both)} pictures: {mirror.error:.2f} px RMS, "
          f"{mirror.plane.distance:.0f} mm from the camera")  # fmt: skip
    return mirror.rectangle
