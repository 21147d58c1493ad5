"""The search for the mouth before anything is known of the person: by faces, then by colour."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from abs_engine.compare.prior import GaussianPrior
from abs_engine.core.arrays import FloatArray, Image
from abs_engine.core.camera import Camera
from abs_engine.core.geometry import Pose
from abs_engine.core.pose import PoseFrame, no_correction
from abs_engine.core.scene import Renderer
from abs_engine.face.appearance.colour import ColourClasses
from abs_engine.face.head import MouthModel
from abs_engine.fit.head_frame import class_maps, likelihood_of, mouth_window
from abs_engine.tracking.face_detection import find_face
from abs_engine.tracking.initial_pose import face_marks, pose_of_face
from abs_engine.tracking.settings.preparation import PREPARATION


@dataclass(frozen=True, eq=False)
class CalibrationFrame:
    """A frame that the person is fitted on.

    Parameters
    ----------
    image : (H, W, 3) uint8 RGB
    pose : Pose
        The head's pose by its rigid motion from the reference frame.
    """

    image: Image
    pose: Pose


def shifted(pose: Pose, shift: FloatArray, pivot: FloatArray) -> Pose:
    """A pose after a step (6,) of it: radians about the camera's axes, and mm of the pivot."""
    return PoseFrame(pose, pivot).pose(shift)


def moved(
    frames: Sequence[CalibrationFrame], shift: FloatArray, pivot: FloatArray
) -> list[CalibrationFrame]:
    """The frames with the constant correction `shift` (6,) of their poses."""
    return [replace(f, pose=shifted(f.pose, shift, pivot)) for f in frames]


def shift_of_faces(
    model: MouthModel, frames: Sequence[CalibrationFrame], camera: Camera
) -> FloatArray | None:
    """Places of several frames' faces, less where the first one's was followed to.

    The median of several wanders less than one. Other faces, far from where the head was followed
    to, do not count.

    Returns
    -------
    (6,) float64, or None
        Constant correction of the poses, radians and mm; None where fewer than half of the frames
        show the face.
    """
    marks, shifts = face_marks(model), []
    for frame in frames:
        face = find_face(frame.image)
        if face is None:
            continue
        pose, mouth = pose_of_face(face, camera, marks), frame.pose.apply(model.pivot)
        move = pose.apply(model.pivot) - mouth
        near = np.abs(move[:2]).max() < PREPARATION.elsewhere
        if near and abs(move[2]) < PREPARATION.elsewhere_depth * mouth[2]:
            turn = Pose(pose.rotation @ frame.pose.rotation.T, np.zeros(3)).rotation_vector
            shifts.append(np.concatenate([turn, move]))
    return np.median(shifts, axis=0) if 2 * len(shifts) >= len(frames) else None


def place_mouth(
    model: MouthModel,
    frames: Sequence[CalibrationFrame],
    classes: ColourClasses,
    camera: Camera,
    renderer: Renderer,
    deviation: FloatArray,
    person: FloatArray,
) -> FloatArray:
    """Coarse search of a person's mouth's place and size about where the poses put it.

    What the drawn mouth of the person (Q,) covers is compared with what skin would explain there:
    nothing is gained by drawing it larger than the part of the picture that is looked at, or beside
    it. `deviation` (6,), radians and mm, is how far the poses may be off.

    Returns
    -------
    (6,) float64
        Constant correction of the poses, radians and mm.
    """
    across, down = PREPARATION.searched * deviation[3:5]
    grid = np.array(
        [
            [0, 0, 0, dx, dy, dz * deviation[5]]
            for dx in _to_both_sides(across, PREPARATION.search_steps[0])
            for dy in _to_both_sides(down, PREPARATION.search_steps[1])
            for dz in PREPARATION.search_depths
        ]
    )
    # closed, open and widely open: the coarsest choice of what a mouth may look like
    postures = np.hstack([model.prototypes, np.tile(person, (len(model.prototypes), 1))])
    total = np.zeros(len(grid))
    for frame in frames:
        base = PoseFrame(frame.pose, model.pivot)
        window = mouth_window(model, frame.pose, camera, person, PREPARATION.searched_more)
        maps = class_maps(classes, model.colour_classes, window, frame.image)
        skin = maps.maps[model.colour_classes.index("skin")]
        term = replace(likelihood_of(renderer, model.scene, camera, window, maps), outside=skin)
        values = [
            term.negative_log(base.candidates(grid, np.tile(b, (len(grid), 1))))
            for b in postures[[0, 2, 4]]
        ]
        total += np.min(values, axis=0)
    prior = GaussianPrior(no_correction(), deviation)
    total = total * PREPARATION.frames_together / len(frames) + np.array(
        [prior.negative_log(g) for g in grid]
    )
    return np.asarray(grid[int(np.argmin(total))])


def _to_both_sides(reach: float, step: float) -> FloatArray:
    """Steps to `reach` and from it, 0 among them."""
    count = np.ceil(reach / step)
    return np.asarray(step * np.arange(-count, count + 1))
