"""What stays the same over a clip that is tracked, and what is found in one of its frames."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.camera import Camera
from abs_engine.core.geometry import Pose
from abs_engine.core.scene import Renderer, Scene
from abs_engine.face.appearance.colour import ColourClasses
from abs_engine.face.head import MouthModel
from abs_engine.optimise.simplex import Simplex
from abs_engine.tracking.covered import UsualMouth
from abs_engine.tracking.lip_landmarks import LipLandmarks
from abs_engine.tracking.mouth_look import UsualLook
from abs_engine.tracking.person import Calibration

FloatArray = NDArray[np.float64]
NO_FACE, NO_POSE = "face not found", "no pose given"
BOTH, RENDERING, LANDMARKS = EVIDENCE = ("both", "rendering", "landmarks")
FRAME_SOLVER = Simplex(tolerance=0.03, limit=400)


@dataclass(frozen=True, eq=False)
class FrameResult:
    """What was found in one frame.

    Parameters
    ----------
    index : int
    found : bool
        Whether the lips were followed; if not, the numbers are NaN.
    vector : (6 + P,) float64
        Pose correction about the rigid motion's pose, then expression.
    pose : Pose or None
        Head to camera.
    lips : (N, 3) float64, mm, head frame
        Outer contour, upper and lower inner contour.
    width, aperture : float, mm
        Between the mouth's corners; between the inner lips at their middle, 0 when they touch.
    value : float
        -log posterior, up to a constant.
    score : float
        Mean probability of the drawn classes, 0 to 1: eq. 9 over the compared pixels.
    evaluations : int
    status : str
        How the solver ended; or why nothing was found.
    covered : bool
        Whether the face is there, but its mouth is hidden or outside of the picture; then nothing
        is found but the head's pose.
    landmark_distance : float, mm
        RMS distance, across the line of sight, of the lips from where the landmark network sees
        them; NaN where it was not asked.
    landmark_aperture : float, mm
        What `aperture` would be by the landmarks alone.
    """

    index: int
    found: bool
    vector: FloatArray
    pose: Pose | None
    lips: FloatArray
    width: float
    aperture: float
    value: float
    score: float
    evaluations: int
    status: str
    covered: bool = False
    landmark_distance: float = float("nan")
    landmark_aperture: float = float("nan")


@dataclass(frozen=True, eq=False)
class TrackerSetting:
    """What stays the same over a clip.

    Parameters
    ----------
    model : MouthModel
    scene : Scene
        The model's scene with the person held.
    calibration : Calibration
    camera : Camera
    renderer : Renderer
    rate : float
        Frames per second.
    solver : Simplex
    times : tuple of float
        When each frame is shown, seconds; empty where only the rate is known.
    usual : UsualMouth, optional
        What the clip's mouth looks like; without it no frame counts as covered.
    poses_given : bool
        Whether the poses were measured elsewhere. A known head's are then held.
    look : UsualLook, optional
        The same by landmarks, which then count in its place.
    lips : LipLandmarks, optional
        Where the landmark network sees the lips of this head; with it the network is asked.
    evidence : str
        What counts: "both", or "rendering" or "landmarks" alone, to tell what each adds.
    """

    model: MouthModel
    scene: Scene
    calibration: Calibration
    camera: Camera
    renderer: Renderer
    rate: float
    solver: Simplex = FRAME_SOLVER
    times: tuple[float, ...] = ()
    usual: UsualMouth | None = None
    poses_given: bool = False
    look: UsualLook | None = None
    lips: LipLandmarks | None = None
    evidence: str = BOTH

    @property
    def pose_held(self) -> bool:
        """Whether poses are taken as they are, and only the posture is fitted.

        Those of another head than the person's own refer to an origin that is not quite its own:
        they are corrected as poses by rigid motion are.
        """
        return self.poses_given and self.model.known

    @property
    def why_lost(self) -> str:
        """What the status of a frame without a pose says."""
        return NO_POSE if self.poses_given else NO_FACE

    @property
    def classes(self) -> ColourClasses:
        """The clip's colour classes."""
        return self.calibration.classes
