"""Reads head poses that are known: of a run, of filmed truth, or measured by something else.

A CSV file has a line of names and a line for each frame, with the columns ``head_rx`` to
``head_rz``, the rotation vector in radians, and ``head_tx`` to ``head_tz``, the translation in mm:
what ``results.csv`` of a run has. Perhaps ``index`` or ``frame`` counts the lines; other columns
are not looked at. The six cells of a frame without a pose are empty.

An NPZ file has ``rotation``, (T, 3) rotation vectors or (T, 3, 3) matrices, and ``translation``
(T, 3): what ``results.npz`` has. A frame without a pose is NaN in all of them, or False in
``found`` if that is there. In a run, a frame that is True in ``covered`` is not found, but has the
head's pose.

All are from the head frame (x to the subject's left, y up, z out of the face) to the camera's (x
right, y down, z forward), x_cam = R x_head + t: a face that looks into the camera is turned by half
a turn about x.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.arrays import BoolArray, FloatArray
from abs_engine.core.camera import Camera
from abs_engine.core.errors import InputFileError, ModelFormatError, ParameterError
from abs_engine.core.geometry import Pose, rotations
from abs_engine.dataset import load_truth
from abs_engine.dataset.codec import FORMAT as TRUTH_FORMAT
from abs_engine.io.csv_table import read_table
from abs_engine.io.inputs import MOST
from abs_engine.io.npz import check_format, format_of, read_arrays
from abs_engine.tracking.frame.external_poses import other_count
from abs_engine.tracking.runs.record import FORMAT, RESULTS, VERSION, camera_of

COLUMNS = ("head_rx", "head_ry", "head_rz", "head_tx", "head_ty", "head_tz")
HELP = "see 'abs-engine track --help' for what a file of poses holds"

_ROTATION_ERROR = 1e-3
"""How far R'R of a matrix may be from one: six digits of a text file stay well below."""

_PIXELS_APART = 0.5
"""How far two cameras may picture a point from each other and still be taken for the same."""


@dataclass(frozen=True, eq=False)
class GivenPoses:
    """Poses of a file.

    Parameters
    ----------
    poses : tuple of (Pose or None)
        Head to camera in each frame; None where it is not known.
    camera : Camera or None
        What they refer to, where the file knows it.
    average_head : bool
        Whether they are known to be of a run that fitted the average head.
    """

    path: Path
    poses: tuple[Pose | None, ...]
    camera: Camera | None = None
    average_head: bool = False

    def check(self, frames: int, camera: Camera, mouth: FloatArray, *, held: bool = False) -> None:
        """Refuse poses of other frames than the video's, camera or head, in other axes or units.

        The mouth is (3,) float64, mm, head frame. If `held`, they will be taken as they are, for a
        known head.

        Raises
        ------
        ParameterError
            With what to do.
        """
        if len(self.poses) != frames:
            raise other_count(len(self.poses), f"the video's {frames}")
        if self.camera is not None and not _alike(self.camera, camera):
            raise ParameterError(
                f"the poses of {self.path} are of another camera than the video's",
                "give the camera that they refer to with --camera",
            )
        if held and self.average_head:
            raise ParameterError(
                f"{self.path} has poses of the average head, whose origin is not the person's",
                "leave out --person, or give poses of a run with --person",
            )
        there = [(k, pose) for k, pose in enumerate(self.poses) if pose is not None]
        if not there:
            raise ParameterError(f"no frame of {self.path} has a pose", "leave out --poses")
        behind = [k for k, pose in there if pose.apply(mouth)[2] <= 0]
        if behind:
            raise ParameterError(
                f"{self.path} puts the face of frame {behind[0]} behind the camera",
                "give translations in mm, in OpenCV's camera axes (z forward)",
            )
        if all(pose.rotation[2, 2] > 0 for _, pose in there):
            raise ParameterError(
                f"{self.path} has no frame in which the face looks towards the camera",
                "give rotations from the head's axes to the camera's, in which a face that looks "
                "into the camera is turned by half a turn about x",
            )


def read_poses(path: Path) -> GivenPoses:
    """Read head poses.

    Parameters
    ----------
    path : Path
        A CSV or NPZ file as the module describes, the folder of a run, or that of filmed truth:
        a dataset of one clip and camera, or DATASET/CLIP/CAMERA.

    Raises
    ------
    InputFileError, ModelFormatError
        If it cannot be read, lacks columns or arrays, or is filmed truth of another kind.
    ParameterError
        If a pose is not finite, incomplete, or no rotation.
    """
    path = Path(path)
    if path.is_dir():
        if (path / RESULTS).is_file():
            return _from_npz(path / RESULTS)
        truth = load_truth(path)
        return GivenPoses(path, _poses(path, truth.rotations, truth.translations), truth.camera)
    return _from_npz(path) if path.suffix.lower() == ".npz" else _from_csv(path)


def _from_csv(path: Path) -> GivenPoses:
    table = read_table(path, empty_lines=True)
    table.require(COLUMNS, HELP)
    for name in ("index", "frame"):
        if name in table.columns:
            _check_order(path, table.numbers([name])[:, 0], name)
    cells = table.numbers(COLUMNS)
    return GivenPoses(path, _poses(path, cells[:, :3], cells[:, 3:]))


def _check_order(path: Path, numbers: FloatArray, name: str) -> None:
    """Raise `InputFileError` unless the frames are counted from 0 or 1 without a gap."""
    if numbers[0] in (0, 1) and np.array_equal(numbers, numbers[0] + np.arange(len(numbers))):
        return
    raise InputFileError(
        f"the column {name} of {path} does not count the frames one by one from 0 or 1",
        "give a line for every frame, in order, with empty cells where the pose is not known",
    )


def _from_npz(path: Path) -> GivenPoses:
    arrays: dict[str, NDArray[Any]] = read_arrays(path)
    if format_of(arrays) == TRUTH_FORMAT:
        raise ModelFormatError(
            f"{path} holds the head's poses in the world, not those relative to a camera",
            "give the folder of the camera, DATASET/CLIP/CAMERA",
        )
    of_run = format_of(arrays) == FORMAT
    if of_run:
        check_format(path, arrays, FORMAT, VERSION)
    turn, shift = _motion(path, arrays)
    found = _marks(path, arrays, "found", len(shift), missing=True)
    there = found
    if of_run:
        there = found | _marks(path, arrays, "covered", len(shift), missing=False)
    turn[~there] = shift[~there] = np.nan
    poses = _poses(path, turn, shift)
    lacking = [k for k, pose in enumerate(poses) if pose is None and found[k]]
    if "found" in arrays and lacking:
        raise ParameterError(
            f"{path} has no finite pose in frame {lacking[0]}, which is marked as found",
            "mark it as not found, or give its pose",
        )
    if not of_run:
        return GivenPoses(path, poses)
    # Only the average head leaves a person's mouth to be fitted
    average = "person_weights" in arrays and arrays["person_weights"].size > 0
    return GivenPoses(path, poses, _camera_of(path, arrays), average)


def _motion(path: Path, arrays: dict[str, NDArray[Any]]) -> tuple[FloatArray, FloatArray]:
    """Rotations (T, 3) or (T, 3, 3), translations (T, 3); `ModelFormatError` if they are none."""
    missing = [name for name in ("rotation", "translation") if name not in arrays]
    if missing:
        raise ModelFormatError(f"{path} lacks the array {missing[0]}", HELP)
    turn, shift = arrays["rotation"], arrays["translation"]
    frames = shift.shape[:1]  # () of a single number
    if shift.shape != (*frames, 3) or turn.shape not in ((*frames, 3), (*frames, 3, 3)):
        raise ModelFormatError(
            f"{path} has rotations of shape {turn.shape} and translations of {shift.shape}", HELP
        )
    if not _real(turn, shift):
        raise ModelFormatError(
            f"the rotations or translations of {path} are not real numbers", HELP
        )
    return turn.astype(np.float64), shift.astype(np.float64)


def _real(*arrays: NDArray[Any]) -> bool:
    """Whether all of them hold real numbers; truth values are none."""
    return all(array.dtype.kind in "fiu" for array in arrays)


def _marks(
    path: Path, arrays: dict[str, NDArray[Any]], name: str, frames: int, *, missing: bool
) -> BoolArray:
    """Flag of each frame in an array (T,), bool; `missing` in all of them where it is not there.

    Raises
    ------
    ModelFormatError
        If it says something else.
    """
    marks = arrays.get(name, np.full(frames, missing))
    if marks.shape != (frames,) or marks.dtype.kind not in "biu":
        raise ModelFormatError(
            f"the array {name} of {path} does not say yes or no of each of {frames} frames",
            "give True or False for each, or leave it out",
        )
    return marks.astype(np.bool_)


def _camera_of(path: Path, arrays: dict[str, NDArray[Any]]) -> Camera | None:
    """The camera that a run used; None where it does not tell."""
    names = ("camera_matrix", "camera_distortion", "camera_size")
    if not set(names) <= arrays.keys():
        return None
    matrix, distortion, size = (arrays[name] for name in names)
    shaped = (matrix.shape, size.shape) == ((3, 3), (2,)) and size.dtype.kind in "iu"
    if not shaped or not _real(matrix, distortion):
        raise ModelFormatError(f"{path} holds no camera", "track the video again")
    return camera_of(arrays)


def _poses(path: Path, turns: FloatArray, shifts: FloatArray) -> tuple[Pose | None, ...]:
    """Poses of rotations (T, 3) or (T, 3, 3) and translations (T, 3); None for rows of NaN."""
    if len(shifts) == 0:
        raise InputFileError(f"{path} has no frames", "give a pose for each frame of the video")
    numbers = np.hstack([np.reshape(turns, (len(turns), -1)), shifts]).astype(np.float64)
    lost = np.asarray(np.isnan(numbers).all(axis=1))
    bad = np.flatnonzero(~(np.abs(numbers) <= MOST).all(axis=1) & ~lost)
    if len(bad):
        raise ParameterError(
            f"the pose of frame {bad[0]} in {path} is not complete, or not finite",
            "give all of its numbers, or leave all of them empty or NaN for a frame without a pose",
        )
    turn = numbers[:, :-3]
    matrices = (
        turn.reshape(-1, 3, 3)
        if turn.shape[1] == 9
        else rotations(np.where(lost[:, None], 0.0, turn))
    )
    for k in np.flatnonzero(~lost):
        _check_turn(path, int(k), turn[k], matrices[k])
    return tuple(
        None if lost[k] else Pose(matrices[k], numbers[k, -3:]) for k in range(len(numbers))
    )


def _check_turn(path: Path, frame: int, given: FloatArray, matrix: FloatArray) -> None:
    """Raise `ParameterError` for a matrix that is no rotation, or a vector of degrees."""
    if len(given) == 3 and np.linalg.norm(given) > 2 * np.pi:
        raise ParameterError(
            f"{path} turns the head of frame {frame} by {np.linalg.norm(given):.0f} rad",
            "give rotation vectors in radians",
        )
    off = np.abs(matrix.T @ matrix - np.eye(3)).max()
    if off > _ROTATION_ERROR or np.linalg.det(matrix) < 0:
        raise ParameterError(
            f"the matrix of frame {frame} in {path} is not a rotation",
            "give orthonormal matrices of determinant 1",
        )


def _alike(one: Camera, other: Camera) -> bool:
    """Whether two cameras picture the middle of the view and its corners alike."""
    if one.size != other.size:
        return False
    width, height = one.size
    across = np.array([[x, y] for x in (-0.4, 0.0, 0.4) for y in (-0.4, 0.0, 0.4)])
    points = np.c_[across * [width, height] / one.matrix[0, 0], np.ones(len(across))]
    return bool(np.abs(one.project(points) - other.project(points)).max() < _PIXELS_APART)
