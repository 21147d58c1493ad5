"""A frame of a shell as it is fitted: placed by the centroid of the lips' blob, and believed."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from abs_engine.compare.facets import FacetLikelihood
from abs_engine.compare.prior import Prior
from abs_engine.core.arrays import FloatArray
from abs_engine.core.camera import Window
from abs_engine.core.geometry import Pose
from abs_engine.core.pose import PoseFrame, at_base, joined, parted
from abs_engine.core.scene import Candidates
from abs_engine.face.base import Face
from abs_engine.face.shape.lip_model import LIPS
from abs_engine.fit.head_frame import COLOUR
from abs_engine.fit.problem import Problem
from abs_engine.fit.shell import ShellSetting, centred, problem_of, shell_window
from abs_engine.fit.terms import TermKind, bound
from abs_engine.fit.view import View
from abs_engine.tracking.frame.blob_visibility import OUTSIDE
from abs_engine.tracking.frame.clip_setting import UNEXPLAINED, UNLIKE, Work
from abs_engine.tracking.frame.frame_state import HeadFrame, Memory
from abs_engine.tracking.frame.head_frame import explained
from abs_engine.tracking.frame.mouth_landmarks import MouthLandmarks
from abs_engine.tracking.settings.blobs import BLOB_START


@dataclass(frozen=True, eq=False)
class ShellBinder:
    """Starts the shell from the frame before, placed by the centroid of the lips' blob.

    Parameters
    ----------
    tried : int
        How many of the starts are all gone on with where there is no frame before.
    alone : bool
        Whether each frame is fitted by itself, as if there were none before.
    priors : tuple of Prior
        What else is likely beforehand, over (6 + P): that lips do not pass into each other.
    judged : bool
        Whether a mouth may not be there; else everything found is believed.
    """

    setting: ShellSetting
    face: Face
    kinds: Mapping[str, TermKind]
    landmarks: MouthLandmarks
    tried: int = 1
    alone: bool = False
    priors: tuple[Prior, ...] = ()
    judged: bool = True

    def work(self, frame: HeadFrame, pose: Pose, memory: Memory) -> Work:
        """Objective of a frame whose head is about a pose, and the start of its search."""
        marks = self.landmarks
        last = None if self.alone else memory.vector
        postures = self.face.starts if last is None else parted(last)[1][None]
        starts = at_base(postures)
        if frame.blob is not None:
            pose, starts = self._centred(pose, frame.blob.centre, postures)
        told = marks.told(frame)
        starts = starts if told is None else np.vstack([starts, told])
        problem = self._problem(frame, pose, starts[0])
        undrawn = problem_of(self.setting, pose, {})
        said = marks.marked(frame, replace(undrawn, priors=(*undrawn.priors, *self.priors)))
        doubt = partial(self._doubt, problem) if self.judged else None
        tried = self.tried if last is None else 1
        return Work(
            problem, starts, partial(explained, problem.terms), said, tried=tried, doubt=doubt
        )

    def _problem(self, frame: HeadFrame, pose: Pose, start: FloatArray) -> Problem:
        setting = self.setting
        base, window = PoseFrame(pose, self.face.pivot), shell_window(setting, pose)
        view = View(frame.in_usual_light, setting.camera, setting.renderer, base, window, start)
        made = problem_of(setting, pose, bound(self.kinds, self.face, view))
        beside = self.landmarks.beside(frame, setting.classes.outdoing)
        return replace(made, priors=(*made.priors, *self.priors, *beside))

    def _centred(
        self, pose: Pose, centre: FloatArray, postures: FloatArray
    ) -> tuple[Pose, FloatArray]:
        """The pose with the first posture's lips at the blob, and a start of each (K, 6 + P)."""
        pose = centred(self.setting, pose, centre, postures[0])
        shifts = np.zeros((len(postures), 6))
        for k, posture in enumerate(postures if len(postures) > 1 else ()):
            moved = centred(self.setting, pose, centre, posture, rounds=1)
            shifts[k, 3:] = moved.translation - pose.translation
        return pose, joined(shifts, postures)

    def _doubt(self, problem: Problem, x: FloatArray, score: float) -> str:
        """Reason why this is no mouth; empty if it is in the picture and explained."""
        window = shell_window(self.setting, problem.frame.base)
        if _share_inside(window, self.setting.camera.size) < BLOB_START.in_picture:
            return OUTSIDE
        if score < BLOB_START.explained:
            return UNEXPLAINED
        colours = problem.terms.get(COLOUR)
        if not isinstance(colours, FacetLikelihood):
            return ""
        shown = lips_shown(colours, problem.frame.candidates(x[None]))
        return "" if shown >= BLOB_START.lips_shown else UNLIKE


def lips_shown(like: FacetLikelihood, candidate: Candidates) -> float:
    """Mean probability of lips where they are drawn, 0 to 1.

    A picture of skin alone is well explained by a mouth whose lips are small.
    """
    drawn = like.renderer.draw(like.scene, candidate, like.camera, like.window)[0]
    lips = drawn.class_id == LIPS
    if like.compared is not None:
        lips &= like.compared
    return float(like.maps.maps[LIPS][lips].mean()) if lips.any() else 0.0


def _share_inside(window: Window, size: tuple[int, int]) -> float:
    """Share of a window that lies in the picture."""
    across = min(window.x + window.width, size[0]) - max(window.x, 0.0)
    down = min(window.y + window.height, size[1]) - max(window.y, 0.0)
    return max(0.0, across) * max(0.0, down) / (window.width * window.height)
