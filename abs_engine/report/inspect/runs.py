"""A run as something to look at: its head and its camera, frame by frame."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.arrays import FloatArray, Image
from abs_engine.core.camera import Camera, Window
from abs_engine.core.errors import ParameterError
from abs_engine.core.geometry import Pose
from abs_engine.core.kinds import checked_frame
from abs_engine.core.pose import POSE_NAMES
from abs_engine.io.assets import Speaker
from abs_engine.io.video import read_frames
from abs_engine.report.drawing.view import View
from abs_engine.report.inspect.body import Body
from abs_engine.tracking.frame.frame_times import evenly_spaced
from abs_engine.tracking.results.run_mesh import RunMesh
from abs_engine.tracking.runs.record import camera_of, load_whole_run


@dataclass(frozen=True, eq=False)
class RunHead:
    """The tracked head of a run.

    Parameters
    ----------
    arrays : dict
        See `abs_engine.tracking.runs.record.Record`.
    """

    folder: Path
    speaker: Speaker
    arrays: dict[str, NDArray[Any]]
    mesh: RunMesh
    camera: Camera

    def __len__(self) -> int:
        """Return the number of frames."""
        return len(self.mesh)

    @property
    def rate(self) -> float:
        """Frames per second."""
        return float(self.arrays["rate"])

    @property
    def times(self) -> FloatArray:
        """Time at which each frame is shown, (T,) float64, seconds."""
        return np.asarray(self.arrays["time"], np.float64)

    @property
    def uneven_times(self) -> FloatArray | None:
        """The same where frames are not evenly spaced in time; else None."""
        return None if evenly_spaced(self.times, self.rate) else self.times

    @property
    def mode_names(self) -> tuple[str, ...]:
        """Parameters that the mesh's modes are of, P; none where the run does not name them all."""
        names = tuple(map(str, self.arrays.get("parameter_names", ())))[len(POSE_NAMES) :]
        return names if len(names) == len(self.mesh.modes) else ()

    def found(self, frame: int) -> bool:
        """Whether the head was found in a frame."""
        return bool(self.arrays["found"][frame])

    def body(self, frame: int) -> Body:
        """The head in a frame.

        Raises
        ------
        ParameterError
            If it was not found there.
        """
        if not self.found(checked_frame(frame, len(self))):
            raise ParameterError(f"the head was not found in frame {frame}", "give another frame")
        return Body(self.speaker, self.mesh.vertices(frame))

    def view(self, frame: int, scale: float = 1.0) -> View:
        """Picture of the run's camera, drawn `scale` times as large."""
        pose = Pose.from_vectors(self.arrays["rotation"][frame], self.arrays["translation"][frame])
        return View(self.camera, pose, Window(0, 0, *self.camera.size, scale))


def load_run_head(folder: Path, speaker: Speaker) -> RunHead:
    """Read a run with its mesh; raises as `load_whole_run`."""
    arrays, mesh = load_whole_run(folder, speaker)
    return RunHead(Path(folder), speaker, arrays, mesh, camera_of(arrays))


def run_pictures(video: Path, wanted: list[int]) -> Iterator[tuple[int, Image]]:
    """Frames of the run's video, with their numbers.

    Raises
    ------
    VideoError
        If the video breaks off.
    ParameterError
        If it ends before the run does.
    """
    left, last = set(wanted), max(wanted)
    for number, picture in enumerate(read_frames(video)):
        if number in left:
            left.discard(number)
            yield number, picture
        if number == last:
            return
    raise ParameterError(
        f"{video} ends before frame {min(left)} of the run", "give the video that was tracked"
    )
