"""The setting of a tracked clip, which stays the same, and the result of one of its frames."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Protocol, runtime_checkable

from abs_engine.core.arrays import FloatArray
from abs_engine.core.camera import Camera
from abs_engine.core.clock import Clock
from abs_engine.core.geometry import Pose
from abs_engine.core.objective import Evaluation
from abs_engine.core.scene import Renderer
from abs_engine.face.base import Face
from abs_engine.fit.belief import Belief
from abs_engine.fit.evidence import Term
from abs_engine.fit.problem import Problem
from abs_engine.fit.seal import Seal
from abs_engine.fit.search import Again, Minimiser
from abs_engine.optimise.base import Solution
from abs_engine.optimise.drivers import SIMPLEX
from abs_engine.tracking.frame.frame_state import HeadFrame, Memory, Motion
from abs_engine.tracking.frame.frame_times import evenly_spaced
from abs_engine.tracking.frame.mouth_landmarks import Landmarked, MouthLandmarks
from abs_engine.tracking.settings.frames import FRAME_LOOP

NO_FACE, NO_POSE = "face not found", "no pose given"
UNLIKE, UNEXPLAINED = "no lips where the face is", "the picture is not explained"
"""Status of a frame whose fit is not accepted: too little of what is drawn as lips is lips; too
little of all that is compared is explained."""
GREY = "no colour: landmarks alone"
"""Status of a frame without colour in a clip that has it."""
HELD, AGAIN = "held to the landmarks", "started again"
"""Status of a frame whose evidence led off the landmarks, twice: these alone are reported; and of
one that was begun again from postures that are known."""
FRAME_SOLVER: Minimiser = SIMPLEX.minimiser()


@dataclass(frozen=True, eq=False)
class FrameResult:
    """Results of one frame.

    Parameters
    ----------
    index : int
    found : bool
        Whether the lips were followed; if not, the numbers are NaN.
    vector : (6 + P,) float64
        Correction of the pose about the one that the head's motion gives, then posture.
    pose : Pose or None
        Head to camera.
    lips : (N, 3) float64, mm, head frame
        Outer contour, upper and lower inner contour.
    width, aperture : float, mm
        Between the mouth's corners; between the inner lips at their middle, 0 when they touch.
    value : float
        -log posterior, up to a constant.
    score : float
        How much of the picture is explained, 0 to 1: of colours the mean probability of the drawn
        classes, eq. 9 over the compared pixels; else the share of what a wrong match costs.
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
    unit : float
        The scale of `value`: 1 where it is in nats.
    terms : mapping of str to float
        What `value` is the sum of: each kind of evidence, and the priors.
    highest : Solution or None
        The least value of all searches, over all parameters.
    protrusion : float, mm
        How far the middle of the lips lies in front of the head frame's origin.
    belief : Belief or None
        How sure all of it is; None where the evidence cannot say.
    disagreement : float, joint standard deviations
        Of `aperture` and `landmark_aperture`, see `run_warnings.disagreement`.
    cut : bool
        Whether the frame begins another shot; False where cuts are not looked for.
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
    unit: float = 1.0
    terms: Mapping[str, float] = field(default_factory=dict)
    highest: Solution | None = None
    protrusion: float = float("nan")
    belief: Belief | None = None
    disagreement: float = float("nan")
    cut: bool = False

    @property
    def contradicted(self) -> bool:
        """Whether the landmarks contradict the aperture."""
        return self.disagreement > FRAME_LOOP.contradicted


@dataclass(frozen=True, eq=False)
class Work:
    """A frame as it is fitted.

    Parameters
    ----------
    starts : (K, 6 + P) float64
        Of which the best is gone on from.
    explained : callable
        How much of the picture is explained, 0 to 1, by the terms of a value.
    again : Again or None
        Where a search starts again if it comes to little.
    tried : int
        How many of the starts are all gone on with; then the mean of where they lead is found.
    doubt : callable, optional
        Why what was found (6 + P,), that explains so much, is not accepted; empty where it is.
    seal : Seal, optional
        How often the lips touch, where that is known of the speaker.
    """

    problem: Problem
    starts: FloatArray
    explained: Callable[[Evaluation], float]
    landmarks: Landmarked | None = None
    again: Again | None = None
    tried: int = 1
    doubt: Callable[[FloatArray, float], str] | None = None
    seal: Seal | None = None


class Binder(Protocol):
    """Makes the problem of a frame: binds the evidence to the face and the view."""

    def work(self, frame: HeadFrame, pose: Pose, memory: Memory) -> Work:
        """The work of a frame whose head is about a pose."""
        ...


@runtime_checkable
class BindsAhead(Protocol):
    """Binder that can bind evidence before the previous frame is fitted."""

    def ahead(self, frame: HeadFrame, pose: Pose) -> Mapping[str, Term] | None:
        """The evidence of a frame whose head is near a pose; None if it needs the previous fit."""
        ...


class Visibility(Protocol):
    """Test of whether the mouth can be seen."""

    def hidden(self, frame: HeadFrame, pose: Pose) -> str:
        """Reason why it cannot; empty where it can."""
        ...


@dataclass(frozen=True, eq=False)
class ClipSetting:
    """Values that stay the same over a clip.

    Parameters
    ----------
    rate : float, frames per second
    visibility : Visibility, optional
        Without it no mouth counts as covered.
    times : tuple of float
        When each frame is shown, seconds; empty where only the rate is known.
    why_lost : str
        What the status of a frame without a pose says.
    charged : bool
        Whether a driver's limit on evaluations counts those of the starts, too.
    pose_held : bool
        Whether the head's poses are taken as they are, and only postures are fitted.
    landmarks : MouthLandmarks or None
        How landmarks are weighed, where the network is asked.
    learned_lips : bool
        Whether the mouth moves as lips of learned physics alone, which may be unable to open.
    others : bool
        Whether faces besides the followed one are looked for, as nobody has chosen it.
    warnings : tuple of str
        What a user should know before believing the run, whatever its frames show.
    hint : str
        What may be wrong if the run is doubtful, such as colours from another run; or empty.
    """

    face: Face
    camera: Camera
    renderer: Renderer
    rate: float
    motion: Motion
    binder: Binder
    driver: Minimiser = FRAME_SOLVER
    visibility: Visibility | None = None
    times: tuple[float, ...] = ()
    why_lost: str = NO_FACE
    charged: bool = False
    pose_held: bool = False
    landmarks: MouthLandmarks | None = None
    learned_lips: bool = False
    others: bool = False
    warnings: tuple[str, ...] = ()
    hint: str = ""
    clock: Clock = field(default_factory=lambda: Clock(time.thread_time))

    @cached_property
    def uneven_times(self) -> tuple[float, ...]:
        """Times of the frames, s; empty where they are evenly spaced, or not known."""
        return () if evenly_spaced(self.times, self.rate) else self.times

    def time_of(self, index: int) -> float:
        """Time of a frame, s; NaN where frames are evenly spaced, or it is not known."""
        return self.uneven_times[index] if index < len(self.uneven_times) else float("nan")
