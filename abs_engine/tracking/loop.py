"""The loop over frames: where is the head, is the mouth seen, where to start, fit, believe it."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace

import numpy as np

from abs_engine.core.arrays import FloatArray, Image
from abs_engine.core.blocks import POSTURE
from abs_engine.core.errors import OutOfPictureError
from abs_engine.core.geometry import Pose
from abs_engine.core.numpy_errors import as_usual
from abs_engine.core.pose import at_base
from abs_engine.core.threads import DEPTH, ahead, closed_after, made_within, one_thread, workers
from abs_engine.face.base import Face
from abs_engine.fit.answers import check_value
from abs_engine.fit.belief import belief_of, share_of_landmarks
from abs_engine.fit.problem import Problem
from abs_engine.fit.seal import sealed
from abs_engine.fit.search import Found, averaged, search
from abs_engine.tracking.frame.blob_visibility import OUTSIDE
from abs_engine.tracking.frame.clip_setting import (
    AGAIN,
    FRAME_SOLVER,
    HELD,
    NO_FACE,
    BindsAhead,
    ClipSetting,
    FrameResult,
    Work,
)
from abs_engine.tracking.frame.frame_state import HeadFrame, Memory, Shot
from abs_engine.tracking.frame.mouth_landmarks import Landmarked
from abs_engine.tracking.results.frame_journal import FrameJournal
from abs_engine.tracking.results.run_warnings import disagreement
from abs_engine.tracking.settings.frames import FRAME_LOOP

NOTHING = Memory()
READING, FOLLOWING, EVIDENCE, FITTING = "reading", "head pose", "evidence", "fit"
BELIEVING = "measures, belief"
"""What frames cost, by part."""


def track(
    setting: ClipSetting,
    images: Iterable[Image],
    memory: Memory = NOTHING,
    journal: FrameJournal | None = None,
) -> Iterator[tuple[Image, FrameResult]]:
    """Fit every frame of a clip; see `track_shots`.

    `memory` is what is known before the first frame. Frames that a journal has were fitted before:
    in these, the head is only followed. The others are added to it.

    Yields each frame (H, W, 3) with what was found in it.
    """
    shots = (Shot(image, k, setting.time_of(k)) for k, image in enumerate(images))
    with closed_after(track_shots(setting, shots, memory, journal)) as found:
        for shot, result in made_within(as_usual, found):
            yield shot.image, result


def track_shots(
    setting: ClipSetting,
    shots: Iterable[Shot],
    memory: Memory = NOTHING,
    journal: FrameJournal | None = None,
    depth: int = DEPTH,
) -> Iterator[tuple[Shot, FrameResult]]:
    """Fit every frame, each with what is carried on from the one before.

    They are of a clip, or of a camera that drops what cannot be tracked in time; for the journal
    see `track`. The head may be followed ahead of the fits in `depth` frames; each of them delays
    results.

    Yields each frame with what was found in it.
    """
    head, clock = setting.motion.follower(), setting.clock
    known = 0 if journal is None else journal.resumed
    apart = bool(getattr(setting.motion, "alone", False))
    bound = apart and workers(setting.renderer) > 1  # evidence may be drawn with it

    def seen(shot: Shot, memory: Memory) -> tuple[Shot, HeadFrame, str, float]:
        with clock.part(FOLLOWING):
            frame = head.step(shot.image, memory)
        with clock.part(EVIDENCE):
            hidden = _hidden(setting, frame)
            fitted = bound and not hidden and shot.index >= known
            frame = _with_terms(setting, frame) if fitted else frame
            return shot, frame, hidden, memory.gap

    read = _with_gaps(setting, clock.over(READING, shots))
    if apart:
        frames = ahead((seen(shot, replace(NOTHING, gap=gap)) for shot, gap in read), depth)
    else:  # each with what is then known
        frames = (seen(shot, replace(memory, gap=gap)) for shot, gap in read)
    with one_thread(), closed_after(frames):
        for shot, frame, hidden, gap in frames:
            memory = replace(memory, gap=gap)
            if frame.cut:  # the mouth before it is no guide
                memory = replace(memory.lost(), values=())
            earlier = None if journal is None else journal.earlier()
            result, memory = earlier or _step(setting, shot.index, frame, hidden, memory)
            result = replace(result, cut=frame.cut)
            if journal is not None and earlier is None:
                journal.add(result, memory)
            yield shot, result
        head.finish()


def _with_gaps(setting: ClipSetting, shots: Iterable[Shot]) -> Iterator[tuple[Shot, float]]:
    """Each frame with the time since the one before, in frames, at least one.

    1 where that is not known.
    """
    last = float("nan")
    for shot in shots:
        seconds = shot.time - last
        yield shot, max(1.0, seconds * setting.rate) if np.isfinite(seconds) else 1.0
        last = shot.time


def _with_terms(setting: ClipSetting, frame: HeadFrame) -> HeadFrame:
    """The frame with its evidence, if that does not depend on the frame before."""
    if frame.pose is None or not isinstance(setting.binder, BindsAhead):
        return frame
    try:
        return frame._replace(terms=setting.binder.ahead(frame, frame.pose))
    except OutOfPictureError:  # as it will be found out again
        return frame


def _hidden(setting: ClipSetting, frame: HeadFrame) -> str:
    """Reason why a frame's mouth cannot be seen; empty where it can, or no head was found."""
    if setting.visibility is None or frame.pose is None:
        return ""
    return setting.visibility.hidden(frame, frame.pose)


def _step(
    setting: ClipSetting, index: int, frame: HeadFrame, hidden: str, memory: Memory
) -> tuple[FrameResult, Memory]:
    pose = frame.pose
    if pose is None:
        return replace(lost(setting.face, index), status=setting.why_lost), memory.lost()
    if hidden:
        seen = replace(lost(setting.face, index), pose=pose, status=hidden, covered=True)
        return seen, memory.lost()
    try:
        with setting.clock.part(EVIDENCE):
            work = setting.binder.work(frame, pose, memory)
    except OutOfPictureError:
        seen = replace(lost(setting.face, index), pose=pose, status=OUTSIDE, covered=True)
        return seen, memory.lost()
    with setting.clock.part(FITTING):
        found = _accepted(setting, work)
    if found is None:
        return replace(lost(setting.face, index), status=setting.why_lost), memory.lost()
    with setting.clock.part(BELIEVING):
        result = _result(setting, index, work, found)
    doubted = "" if work.doubt is None else work.doubt(found.x, result.score)
    if doubted:
        return replace(lost(setting.face, index), status=doubted), memory.lost()
    move = found.x - work.starts[0]
    value = found.best.value / work.problem.unit
    return result, memory.after(work.problem.frame.pose(result.vector), result.vector, move, value)


def _accepted(setting: ClipSetting, work: Work) -> Found | None:
    """End of the search, over all parameters; None where it leads to no mouth.

    A fit that lies off the landmarks is begun once more from them, then held to them.
    """
    marks = work.landmarks
    if marks is not None and marks.only:
        alone = _minimised(setting, work, marks, alone=True)
        why = marks.why or alone.best.status
        return replace(alone, best=replace(alone.best, status=why))
    found = _searched(setting, work)
    if marks is None or not marks.decide or _off(work, found) <= FRAME_LOOP.most_off:
        return found
    second = _minimised(setting, work, marks)
    count = found.best.n_evaluations + second.best.n_evaluations
    if _off(work, second) <= FRAME_LOOP.most_off:
        return replace(second, best=replace(second.best, n_evaluations=count))
    third = _minimised(setting, work, marks, alone=True)
    if _off(work, third) > FRAME_LOOP.astray:
        return None
    count += third.best.n_evaluations
    return replace(third, best=replace(third.best, n_evaluations=count, status=HELD))


def _searched(setting: ClipSetting, work: Work) -> Found:
    """The search of a frame from its starts; over all parameters."""
    problem = work.problem
    starts = problem.chosen(work.starts)
    if work.tried > 1:
        return _whole(problem, averaged(problem, starts, setting.driver, work.tried))
    found = search(problem, starts, setting.driver, work.again, setting.charged)
    if found.again:
        found = replace(found, best=replace(found.best, status=AGAIN))
    whole = _whole(problem, found)
    return whole if work.seal is None else sealed(problem, whole, work.seal)


def _minimised(setting: ClipSetting, work: Work, marks: Landmarked, alone: bool = False) -> Found:
    """Minimise from the landmarks, and by these alone if told to; over all parameters."""
    problem, driver = (marks.alone, FRAME_SOLVER) if alone else (work.problem, setting.driver)
    return _whole(problem, search(problem, problem.chosen(marks.told)[None], driver))


def _whole(problem: Problem, found: Found) -> Found:
    """The same over all parameters (6 + P,)."""
    best = replace(found.best, x=problem.whole(found.best.x))
    return replace(found, x=problem.whole(found.x), best=best)


def _off(work: Work, found: Found) -> float:
    """Distance of the lips from the landmarks, in standard deviations."""
    return _apart(work, found.x)[1]


def _apart(work: Work, x: FloatArray) -> tuple[float, float]:
    """Distance of the lips from the landmarks at (6 + P,), in mm and standard deviations.

    NaN and 0 where there are none.
    """
    marks, problem = work.landmarks, work.problem
    if marks is None or marks.apart is None:
        return float("nan"), 0.0
    return marks.apart(problem.frame.pose(x), problem.blocks.part(x, POSTURE))


def _result(setting: ClipSetting, index: int, work: Work, found: Found) -> FrameResult:
    problem, face, x, marks = work.problem, setting.face, found.x, work.landmarks
    alone = marks is not None and (marks.only or found.best.status == HELD)
    told_by = marks.alone if marks is not None and alone else problem
    value = problem(problem.chosen(x))
    if not alone and np.array_equal(x, found.best.x):  # no mean of several ends
        check_value(setting.driver, problem, found.best.value, value.value)
    lips, width, aperture = face.measures(problem.blocks.part(x, POSTURE))
    by_landmarks = float("nan")
    if marks is not None:
        told = problem.blocks.part(marks.told, POSTURE)
        by_landmarks = face.measures(told)[2]
    belief = belief_of(told_by, face, x)
    pose = problem.frame.pose(x)
    if belief is not None:
        depth = float(pose.apply(face.pivot)[2])
        belief = belief.seen_in(depth / float(setting.camera.matrix[0, 0]))
    own = belief.aperture if belief else float("nan")
    # Landmarks alone are no second measure beside themselves
    off = float("nan") if alone else disagreement(aperture, own, by_landmarks)
    if belief is not None and marks is not None:
        by_share = share_of_landmarks(face, alone=alone)
        belief = belief.against(off).resting_on_landmarks(by_share)
    return FrameResult(
        index, True, x, pose, lips, width, aperture, value.value,
        work.explained(value), found.best.n_evaluations, found.best.status,
        landmark_distance=_apart(work, x)[0], landmark_aperture=by_landmarks, unit=problem.unit,
        terms=value.terms, highest=found.best,
        protrusion=face.protrusion(problem.blocks.part(x, POSTURE)),
        belief=belief, disagreement=off,
    )  # fmt: skip


def lost(face: Face, index: int) -> FrameResult:
    """A frame in which nothing was found."""
    nothing, nan = np.full(len(face.blocks), np.nan), float("nan")
    lips = np.full((sum(face.ring_sizes), 3), np.nan)
    return FrameResult(index, False, nothing, None, lips, nan, nan, nan, nan, 0, NO_FACE)


def at_rest(pose: Pose, posture: FloatArray) -> Memory:
    """State carried into a first frame whose pose and posture are known."""
    vector = at_base(posture)
    return Memory(vector, pose, np.zeros(len(vector)))
