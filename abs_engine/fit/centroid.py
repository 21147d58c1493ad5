"""Placing the shell in the picture by the centroid of the lips' blob (Basu et al., section 5.3)."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.arrays import FloatArray
from abs_engine.core.geometry import Pose
from abs_engine.core.scene import Candidates
from abs_engine.face.shape.lip_model import LIPS
from abs_engine.fit.settings import SHELL_FIT
from abs_engine.fit.shell import ShellSetting, shell_window


def centred(
    setting: ShellSetting,
    pose: Pose,
    centre: NDArray[np.floating],
    weights: FloatArray | None = None,
    rounds: int = SHELL_FIT.placed,
) -> Pose:
    """The pose shifted across the line of sight so that the lips' centroid is seen at `centre`.

    Section 5.3: the centroid of the visible area of the lips, as drawn, is brought to that of the
    blob. Depth and rotation stay.

    Parameters
    ----------
    setting : ShellSetting
    pose : Pose
    centre : (2,), px
        Of the blob.
    weights : (P,) float64, optional
        The shape; by default the mean.
    rounds : int
        Times that it is drawn.
    """
    shape = np.zeros(setting.model.n_modes) if weights is None else weights
    focal = np.array([setting.camera.matrix[0, 0], setting.camera.matrix[1, 1]])
    for _ in range(rounds):
        middle = pose.apply(setting.border).mean(axis=0)
        seen = _lip_centroid(setting, pose, shape)
        seen = setting.camera.project(middle) if seen is None else seen
        shift = (np.asarray(centre, np.float64) - seen) / focal * middle[2]
        pose = replace(pose, translation=pose.translation + np.r_[shift, 0.0])
    return pose


def _lip_centroid(setting: ShellSetting, pose: Pose, weights: FloatArray) -> FloatArray | None:
    """Centroid (2,), px, of the drawn lips; None if none are."""
    window = shell_window(setting, pose)
    candidate = Candidates.one(weights, pose)
    drawn = setting.renderer.draw(setting.scene, candidate, setting.camera, window)[0]
    rows, columns = np.nonzero(drawn.class_id == LIPS)
    if len(rows) == 0:
        return None
    return window.to_image(np.array([columns.mean(), rows.mean()]))
