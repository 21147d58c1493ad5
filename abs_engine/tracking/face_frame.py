"""A frame of any face as it is fitted: evidence, what is likely beforehand, and where to start."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial

import numpy as np

from abs_engine.compare.prior import GaussianPrior, Prior
from abs_engine.core.arrays import FloatArray
from abs_engine.core.camera import Camera
from abs_engine.core.geometry import Pose
from abs_engine.core.pose import PoseFrame, at_base, free_blocks, joined, parted
from abs_engine.core.scene import Renderer
from abs_engine.face.base import Face
from abs_engine.fit.head_frame import lip_window
from abs_engine.fit.problem import Problem
from abs_engine.fit.terms import TermKind, bound
from abs_engine.fit.view import View
from abs_engine.tracking.clip_setting import UNEXPLAINED, Work
from abs_engine.tracking.frame_state import HeadFrame, Memory
from abs_engine.tracking.head_frame import explained, mobility_of, step_deviation
from abs_engine.tracking.identity_fit import POSE_DEVIATION
from abs_engine.tracking.settings.frames import FRAME_LOOP


@dataclass(frozen=True, eq=False)
class FaceBinder:
    """Binds evidence to a face whose head is followed by its motion.

    Parameters
    ----------
    face : Face
    camera : Camera
    renderer : Renderer
    rate : float
        Frames per second.
    kinds : mapping of str to TermKind
        The evidence.
    priors : tuple of Prior
        What is likely of postures beforehand, over (6 + P).
    pose_held : bool
        Whether poses are taken as they are, and only the posture is fitted.
    """

    face: Face
    camera: Camera
    renderer: Renderer
    rate: float
    kinds: Mapping[str, TermKind]
    priors: tuple[Prior, ...]
    pose_held: bool = False

    def work(self, frame: HeadFrame, pose: Pose, memory: Memory) -> Work:
        """Objective of a frame whose head is about a pose, and the start of its search.

        A posture is likely to be near that of the frame before.
        """
        face, count = self.face, len(self.face.posture)
        last = None if memory.vector is None else at_base(parted(memory.vector)[1])
        starts = at_base(face.starts) if last is None else np.vstack([last, at_base(face.starts)])
        base, window = PoseFrame(pose, face.pivot), lip_window(face.border, pose, self.camera)
        given = frame.image, self.camera, self.renderer, base, window, starts[0]
        terms = bound(self.kinds, face, View(*given))
        step = step_deviation(self.rate, memory.gap)
        still = np.full(count, np.inf if last is None else step)
        near = GaussianPrior(starts[0], joined(POSE_DEVIATION, still))
        free, priors = free_blocks(self.pose_held), (*self.priors, near)
        problem = Problem(base, face.blocks, terms, priors, free, mobility=mobility_of(count))
        return Work(problem, starts, partial(explained, terms), doubt=self._doubt)

    def _doubt(self, _x: FloatArray, score: float) -> str:
        return UNEXPLAINED if score < FRAME_LOOP.least_explained else ""
