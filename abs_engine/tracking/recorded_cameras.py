"""The camera that a speaker's face is learned by, and that recordings were tracked with."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from abs_engine.core.camera import Camera
from abs_engine.core.errors import ParameterError
from abs_engine.tracking.option_checks import check_camera
from abs_engine.tracking.record import camera_of
from abs_engine.tracking.recordings import Recording


def camera_used(
    recordings: Iterable[Recording], given: Camera | None, size: tuple[int, int]
) -> Camera:
    """The given camera, or the ideal one of videos of a size (width, height).

    Raises
    ------
    ParameterError
        If the given one is of another picture size, or a recording was tracked with another camera.
    """
    check_camera(given, size)
    camera = given or Camera.ideal(size)
    for one in recordings:
        own = camera_of(one.run)
        if not (
            np.allclose(own.matrix, camera.matrix)
            and np.allclose(own.distortion, camera.distortion)
        ):
            raise ParameterError(
                f"{one.path} was tracked with another camera than is used here",
                "give the camera that it was tracked with, or its video in place of the run",
            )
    return camera
