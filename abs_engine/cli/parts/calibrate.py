"""``abs-engine observe calibrate``: cameras and mirrors from pictures of a board."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from abs_engine.cli.parts import options as take
from abs_engine.cli.parts.command import Chosen, Done
from abs_engine.cli.parts.progress import Progress, say
from abs_engine.core.errors import ParameterError
from abs_engine.core.words import counted, listed
from abs_engine.io.files import check_free, write_new

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from abs_engine.capture.board import Board, Corners
    from abs_engine.core.camera import Camera

    FloatArray = NDArray[np.float64]


def board_options() -> tuple[take.Option, ...]:
    """The options of a calibration."""
    return (
        take.option("--board", type=take.Choice(("charuco", "chessboard")), default="charuco",
            text="kind of the board (default: charuco)"),
        take.option("--squares", type=int, nargs=2, metavar="COLUMNS ROWS",
            text="number of squares of the board"),
        take.option("--square", type=take.number, metavar="MM", text="side of a square"),
        take.option("--marker", type=take.number, metavar="MM",
            text="side of a marker (default: 0.75 squares)"),
        take.option("--dictionary", default="4X4_50", metavar="NAME",
            text="dictionary of the markers (default: 4X4_50)"),
        take.option("--mirror", is_flag=True,
            text="the pictures show the board and its mirror image"),
        take.file("--second", many=True, metavar="PICTURE...",
            text="a second camera's pictures, of the same moments in the same order"),
        take.file("--second-output", "the second camera's calibration", type=take.PATH),
    )  # fmt: skip


def calibrate(chosen: Chosen, pictures: list[Path]) -> Done:
    """Calibrate one camera, with a mirror or without, or two."""
    from abs_engine.capture.board import Board
    from abs_engine.capture.calibrate import calibrate_camera, calibrate_stereo
    from abs_engine.dataset import camera_json

    if chosen.squares is None or chosen.square is None or not pictures:
        raise ParameterError(
            "pictures, --squares COLUMNS ROWS and --square MM are needed",
            "see 'abs-engine observe --help'",
        )
    if (not chosen.second) != (chosen.second_output is None) or (chosen.second and chosen.mirror):
        raise ParameterError(
            "--second goes with --second-output, and not with --mirror", "give both or neither"
        )
    if chosen.mirror and chosen.board != "charuco":
        raise ParameterError(
            "a chessboard looks the same as its mirror image", "use a ChArUco board"
        )
    if chosen.second_output is not None:
        check_free(chosen.second_output, ".json")
        if chosen.second_output.resolve() == chosen.output.resolve():
            raise ParameterError("-o and --second-output name one file", "give two names")
    columns, rows = chosen.squares
    board = Board(chosen.board, columns, rows, chosen.square, chosen.marker, chosen.dictionary)
    with Progress("calibrating") as progress:
        found, size = _corners(board, pictures, chosen.mirror, progress)
        own = calibrate_camera([c for pair in found for c in pair if c is not None], size)
        say(f"{own.error:.2f} px RMS, focal length {own.camera.matrix[0, 0]:.1f} "
              f"+- {own.focal_deviation:.1f} px, principal point +- {own.centre_deviation:.1f} px"
              )  # fmt: skip
        if not chosen.second:
            mirror = _mirror(found, own.camera) if chosen.mirror else None
            write_new(chosen.output, camera_json(own.camera, mirror=mirror).encode())
            facts = {"output": chosen.output, "error_px": own.error}
            return Done([f"wrote {chosen.output}"], facts)
        if len(chosen.second) != len(pictures):
            raise ParameterError(
                f"{len(pictures)} and {len(chosen.second)} pictures were given",
                "give as many of each camera, of the same moments",
            )
        there, other_size = _corners(board, chosen.second, False, progress)
    other = calibrate_camera([c for c, _ in there if c is not None], other_size)
    both = [(a, b) for (a, _), (b, _) in zip(found, there, strict=True) if a and b]
    stereo = calibrate_stereo(both, own, other)
    say(
        f"second: {other.error:.2f} px RMS; both together {stereo.error:.2f} px RMS, "
        f"{stereo.distance:.0f} mm apart"
    )
    vectors = [stereo.pose.rotation_vector], [stereo.pose.translation]
    write_new(chosen.output, camera_json(own.camera).encode())
    try:
        write_new(chosen.second_output, camera_json(other.camera, *vectors).encode())
    except BaseException:
        chosen.output.unlink()
        raise
    outputs = {"output": chosen.output, "second_output": chosen.second_output}
    lines = [f"wrote {chosen.output} and {chosen.second_output}"]
    return Done(lines, {**outputs, "error_px": own.error})


def _corners(
    board: Board, pictures: Sequence[Path], mirror: bool, progress: Progress
) -> tuple[list[tuple[Corners | None, Corners | None]], tuple[int, int]]:
    """The board in each picture, and its mirror image; and the pictures' size."""
    from abs_engine.io.pictures import read_image

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
        progress(number + 1, len(pictures))
    lacking = [str(path) for path, pair in zip(pictures, found, strict=True) if not any(pair)]
    if lacking:
        say(f"no board in {len(lacking)} of {counted(len(pictures), 'picture')}: {listed(lacking)}")
    return found, size or (0, 0)


def _mirror(found: Sequence[tuple[Corners | None, Corners | None]], camera: Camera) -> FloatArray:
    from abs_engine.capture.mirror import calibrate_mirror

    both = [(a, b) for a, b in found if a is not None and b is not None]
    mirror = calibrate_mirror(both, camera)
    say(f"mirror in {len(both)} pictures: {mirror.error:.2f} px RMS, "
          f"{mirror.plane.distance:.0f} mm from the camera")  # fmt: skip
    return mirror.rectangle
