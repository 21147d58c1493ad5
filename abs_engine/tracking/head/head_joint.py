"""One head to several frames: by landmarks, pupils, outlines, and where its texture lies in each.

Gauss-Newton over the identity, the network's error of this person, and each frame's pose and
posture. Rounds carry the texture over with the head as it is by then.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from abs_engine.core.arrays import FloatArray
from abs_engine.core.scene import Renderer
from abs_engine.core.threads import in_threads, workers
from abs_engine.tracking.detection.landmarks import SeenRays
from abs_engine.tracking.detection.mouth_search import shifted
from abs_engine.tracking.head.head_outline import Outline, outline, outline_equations
from abs_engine.tracking.head.head_problem import HeadFrameSeen, HeadProblem, JointHead, views_of
from abs_engine.tracking.head.match_equations import linearised
from abs_engine.tracking.landmark.head_equations import (
    Equations,
    landmark_equations,
    pupil_equations,
)
from abs_engine.tracking.landmark.landmark_fit import looking_ahead
from abs_engine.tracking.settings.head import HEAD_POSE
from abs_engine.tracking.texture.head_texture import HeadView, Matches, match

_DAMPING = 1e-6


def fit_jointly(
    problem: HeadProblem,
    frames: Sequence[HeadFrameSeen],
    renderer: Renderer,
    rounds: int | None = None,
) -> JointHead:
    """The most probable head; with 0 `rounds` its texture is not looked at."""
    if rounds is None:
        rounds = HEAD_POSE.known_rounds if problem.known else HEAD_POSE.rounds
    k, q, m = problem.sizes
    seen = [SeenRays.of(f.landmarks, problem.camera) for f in frames]
    poses = tuple(looking_ahead(problem.shape, s) for s in seen)
    head = JointHead(np.zeros(k), np.zeros(q), poses, np.zeros((len(frames), m)))
    head = _settled(problem, frames, seen, head, {}, {}, HEAD_POSE.first_steps)
    for _ in range(rounds):
        views = views_of(problem.body, frames, head)
        pairs = _pairs(problem, views, renderer)
        outlines = _outlines(problem, frames, views, renderer)
        head = _settled(problem, frames, seen, head, pairs, outlines, HEAD_POSE.steps)
    return head


_Pairs = dict[tuple[int, int], Matches]
_Placed = tuple[Equations, tuple[slice, ...]]
"""Equations, and the slices of their parameters in those of all frames."""


def _outlines(
    problem: HeadProblem,
    frames: Sequence[HeadFrameSeen],
    views: Sequence[HeadView],
    renderer: Renderer,
) -> dict[int, Outline]:
    """Outlines of the frames that show one."""

    def looked_for(one: tuple[HeadFrameSeen, HeadView]) -> Outline | None:
        frame, view = one
        if frame.image is None:
            return None
        return outline(problem.body, view, frame.image, problem.camera, renderer)

    found = in_threads(looked_for, list(zip(frames, views, strict=True)), workers(renderer))
    return {k: one for k, one in enumerate(found) if one is not None}


def _pairs(problem: HeadProblem, views: Sequence[HeadView], renderer: Renderer) -> _Pairs:
    """Matches of each frame with those that face most alike."""
    near = HEAD_POSE.known_near if problem.known else HEAD_POSE.near
    pairs: list[tuple[int, int]] = []
    for second, view in enumerate(views):
        away = np.array([v.pose.angle_to(view.pose) for v in views])
        away[second] = np.inf
        pairs += [(int(k), second) for k in np.argsort(away)[: min(near, len(views) - 1)]]

    def matched(pair: tuple[int, int]) -> Matches | None:
        first, second = pair
        return match(problem.body, views[first], views[second], problem.camera, renderer)

    found = in_threads(matched, pairs, workers(renderer))
    return {pair: one for pair, one in zip(pairs, found, strict=True) if one is not None}


def _settled(
    problem: HeadProblem,
    frames: Sequence[HeadFrameSeen],
    seen: Sequence[SeenRays],
    head: JointHead,
    pairs: _Pairs,
    outlines: Mapping[int, Outline],
    steps: int,
) -> JointHead:
    """Some steps of Gauss-Newton, fewer where it settles.

    With texture and outlines it may diverge, as their equations take some of what moves as fixed:
    a step that is longer than the one before it is not taken, and ends them.
    """
    last = np.inf
    for _ in range(steps):
        system = _System.of(problem, head)
        told = partial(system.told_by, seen=seen, frames=frames)
        for each in in_threads(told, range(len(frames))):
            system.add(*each)
        if pairs or outlines:
            views = views_of(problem.body, frames, head)
            compared = partial(system.compared, views=views)
            system.add(*in_threads(compared, pairs.items()))
            system.add(*(system.outlined(k, one, views[k]) for k, one in outlines.items()))
        stepped, moved = system.step()
        if moved > last and (pairs or outlines):
            break
        head, last = stepped, moved
        if moved < HEAD_POSE.settled:
            break
    return head


@dataclass(frozen=True, eq=False)
class _System:
    """Normal equations over identity, the person's error, and each frame's pose and posture."""

    problem: HeadProblem
    head: JointHead
    information: FloatArray
    gradient: FloatArray

    @classmethod
    def of(cls, problem: HeadProblem, head: JointHead) -> _System:
        """The priors: unit Gaussians of all but the poses, and the pupils' distance."""
        k, q, m = problem.sizes
        n = len(head.poses)
        own = np.concatenate([np.zeros((n, 6)), head.postures], axis=1)
        gradient = np.concatenate([head.identity, head.error, own.ravel()])
        each = np.r_[np.full(6, _DAMPING), np.ones(m)]
        information = np.diag(np.concatenate([np.ones(k + q), np.tile(each, n)]))
        pupils, modes = problem.eyes(head.identity)
        across = pupils[1] - pupils[0]
        apart = float(np.linalg.norm(across))
        slope = (modes[:, 1] - modes[:, 0]) @ across / apart
        information[:k, :k] += np.outer(slope, slope) / problem.held**2
        gradient[:k] += slope * (apart - problem.apart) / problem.held**2
        return cls(problem, head, information, gradient)

    @property
    def _identity(self) -> slice:
        return slice(0, self.problem.sizes[0])

    def _at(self, frame: int) -> tuple[slice, slice]:
        """Slices of a frame's pose and posture."""
        k, q, m = self.problem.sizes
        first = k + q + frame * (6 + m)
        return slice(first, first + 6), slice(first + 6, first + 6 + m)

    def _above(self, frame: int) -> tuple[slice, slice]:
        """Slices of a frame's pose and of its upper face's posture."""
        pose, posture = self._at(frame)
        return pose, slice(posture.stop - self.problem.body.upper, posture.stop)

    def add(self, *given: _Placed) -> None:
        """Add equations whose parameters, block after block, have these slices."""
        for equations, where in given:
            ends = np.cumsum([0, *(s.stop - s.start for s in where)])
            blocks = list(zip(where, map(slice, ends[:-1], ends[1:]), strict=True))
            for there, here in blocks:
                self.gradient[there] += equations.gradient[here]
                for across, beside in blocks:
                    self.information[there, across] += equations.information[here, beside]

    def told_by(
        self, frame: int, seen: Sequence[SeenRays], frames: Sequence[HeadFrameSeen]
    ) -> list[_Placed]:
        """Equations of a frame's landmarks and pupils."""
        p, guess, pupils = self.problem, self.head.guess(frame), frames[frame].pupils
        pose, posture = self._at(frame)
        k, q, _ = p.sizes
        by_landmarks = landmark_equations(
            p.shape, p.noise, seen[frame], guess, HEAD_POSE.joint_alike
        )
        found: list[_Placed] = [(by_landmarks, (pose, self._identity, posture, slice(k, k + q)))]
        if pupils is not None:
            own, modes = p.eyes(self.head.identity)
            axes = seen[frame].axes
            told = pupil_equations(own, modes, p.body.pivot, pupils, p.camera, guess.pose, axes)
            found.append((told, (pose, self._identity)))
        return found

    def compared(self, pair: tuple[tuple[int, int], Matches], views: Sequence[HeadView]) -> _Placed:
        """Equations of matches of the same skin in two frames."""
        (first, second), matches = pair
        p = self.problem
        told = linearised(p.body, matches, views[first], views[second], p.camera).normal
        return told, (*self._above(first), *self._above(second), self._identity)

    def outlined(self, frame: int, found: Outline, view: HeadView) -> _Placed:
        """Equations of a frame's outline."""
        pose, posture = self._at(frame)
        told = outline_equations(self.problem.body, found, view, self.problem.camera)
        return told, (pose, self._identity, posture)

    def step(self) -> tuple[JointHead, float]:
        """The head after a step, and how far the poses turned, or the identity moved, in it."""
        head, (k, q, _) = self.head, self.problem.sizes
        held = self.information + _DAMPING * np.diag(np.diag(self.information))
        step = -np.asarray(np.linalg.solve(held, self.gradient), np.float64)
        each = step[k + q :].reshape(len(head.poses), -1)
        each[:, :3] = np.clip(each[:, :3], -HEAD_POSE.most_turn, HEAD_POSE.most_turn)
        pivot = self.problem.shape.pivot
        poses = tuple(shifted(p, s, pivot) for p, s in zip(head.poses, each, strict=True))
        new = replace(
            head, identity=head.identity + step[:k], error=head.error + step[k : k + q],
            poses=poses, postures=head.postures + each[:, 6:],
        )  # fmt: skip
        moved = HEAD_POSE.identity_counts * np.abs(step[:k]).max(initial=0.0)
        return new, float(max(np.abs(each[:, :3]).max(), moved))
