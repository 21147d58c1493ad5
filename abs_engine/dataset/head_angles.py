"""The head's angles in Live Link Face's files and packets: about Unreal's left-handed axes.

Epic's plug-in for ARKit makes of a rotation (x, y, z, w), a quaternion in ARKit's right-handed
axes, the rotation (-z, x, y, -w) in Unreal's, and of that yaw, pitch and roll. Yaw is then positive
to the side that the face units name right, pitch for a lowered chin, and roll towards the shoulder
that they name left. In a recording of the app, the eyes' angles correlate with the units that move
eyes by 0.999 (yaw) and 0.996 (pitch) in this sense.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from abs_engine.core.arrays import FloatArray

_SENSE = np.array([-1.0, 1.0, -1.0])
"""Sense of yaw, pitch and roll about the head frame's axes y, x and z, which point as ARKit's."""


def live_link_angles(rotation: Rotation) -> FloatArray:
    """Yaw, pitch and roll, (..., 3) radians, of rotations about the head frame's axes."""
    return np.asarray(_SENSE * rotation.as_euler("YXZ"), np.float64)


def rotation_by(angles: NDArray[np.floating]) -> Rotation:
    """Rotations about the head frame's axes, of yaw, pitch and roll (..., 3), radians."""
    return Rotation.from_euler("YXZ", _SENSE * angles)
