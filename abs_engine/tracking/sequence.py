"""Tracking head and articulation through a sequence, one frame after the other (section 4).

As in the paper the best parameters of a frame are where the search of the next one starts. Beyond
it: the start is predicted from the two frames before, and a search that ends with an unusually
large epsilon starts again from the best of the corpus' postures.
"""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.camera import Camera
from abs_engine.core.errors import ParameterError
from abs_engine.core.geometry import Pose
from abs_engine.core.scene import Renderer
from abs_engine.face.talking import TalkingFace
from abs_engine.fit.axes import Found, Held, descend, polish
from abs_engine.fit.talking import Problem, problem
from abs_engine.optimise.simplex import Simplex

FloatArray = NDArray[np.float64]
Image = NDArray[np.uint8]
_SPEEDS = (0.0, 0.5, 1.0)
"""Shares of the last movement that are tried for the next one."""
_RECENT = 25
"""Frames whose epsilon says what is usual."""


@dataclass(frozen=True)
class Settings:
    """How a frame is searched.

    Parameters
    ----------
    method : {"axes", "simplex"}
        Gauss-Newton steps and a simplex along their axes; or the paper's: Nelder-Mead from a
        simplex of the parameters' own scales, from the frame before.
    predict : bool
        Whether the start is predicted from the last movement. For "axes" also whether an
        unusual epsilon makes it start again.
    limit : int
        Largest number of evaluations of a frame.
    coarse, tolerance : float
        Where the descent, and where the simplex, stops; in what a wrong match costs.
    inertia : float
        See `sequence_search.Held`.
    unusual : float
        Times the median epsilon of the last frames.
    pose_known : bool
        Whether the head stands still before the camera, as before one that it wears: only the
        articulation is sought.
    """

    method: str = "axes"
    predict: bool = True
    limit: int = 200
    coarse: float = 1e-4
    tolerance: float = 1e-4
    inertia: float = 1e-4
    unusual: float = 1.25
    pose_known: bool = False

    def __post_init__(self) -> None:
        if self.method not in ("axes", "simplex") or self.limit < 1:
            raise ParameterError(
                f"there is no search '{self.method}' of {self.limit} evaluations",
                "choose axes or simplex, and at least 1",
            )


PAPER = Settings(method="simplex", predict=False, limit=300, inertia=0.0)
"""Plain warm start, as in the paper."""


@dataclass(frozen=True, eq=False)
class Tracked:
    """Parameters of all frames of a sequence.

    Parameters
    ----------
    alpha : (T, P) float64, standard deviations
    poses : tuple of Pose, T
        Head to camera.
    value : (T,) float64
        Epsilon in what a wrong match costs.
    evaluations : (T,) int64
    restarted : (T,) bool
        Whether the search started again from the corpus' postures.
    seconds : float
        All together.
    """

    alpha: FloatArray
    poses: tuple[Pose, ...]
    value: FloatArray
    evaluations: NDArray[np.int64]
    restarted: NDArray[np.bool_]
    seconds: float = 0.0

    def __len__(self) -> int:
        """Return the number of frames, T."""
        return len(self.alpha)


@dataclass
class _State:
    """What is carried from frame to frame."""

    pose: Pose
    alpha: FloatArray
    move: FloatArray
    usual: deque[float] = field(default_factory=lambda: deque(maxlen=_RECENT))


def track(
    face: TalkingFace,
    name: str,
    pictures: Iterable[Image],
    camera: Camera,
    pose: Pose,
    alpha: FloatArray,
    renderer: Renderer,
    settings: Settings | None = None,
    postures: FloatArray | None = None,
    progress: Callable[[int], None] | None = None,
) -> Tracked:
    """Track a sequence.

    Parameters
    ----------
    face : TalkingFace
    name : str
        Of the appearance model, of `models.MODELS`.
    pictures : iterable of (H, W, 3) uint8 RGB
    camera : Camera
    pose : Pose
        Head to camera in the first frame, about; from `tracking.prepare.HeadMotion` or given.
    alpha : (P,) float64
        Posture in the first frame, about.
    renderer : Renderer
    settings : Settings, optional
    postures : (V, P) float64, optional
        Of the corpus, from which a search may start again.
    progress : callable, optional
        Told the number of frames done.

    Raises
    ------
    ParameterError
        If there is no such model, no picture, or the face leaves the picture.
    PictureError
        If a pixel is not finite.
    """
    how, started = settings or Settings(), time.perf_counter()
    state = _State(
        pose, np.asarray(alpha, np.float64), np.zeros((0 if how.pose_known else 6) + len(alpha))
    )
    rows: list[tuple[FloatArray, Pose, float, int, bool]] = []
    for picture in pictures:
        rows.append(_step(face, name, picture, camera, renderer, state, how, postures))
        if progress is not None:
            progress(len(rows))
    if not rows:
        raise ParameterError("the sequence has no picture", "give at least one")
    alphas, poses, values, counts, again = zip(*rows, strict=True)
    return Tracked(
        np.array(alphas), tuple(poses), np.array(values), np.array(counts, np.int64),
        np.array(again), time.perf_counter() - started,
    )  # fmt: skip


def _step(
    face: TalkingFace,
    name: str,
    picture: Image,
    camera: Camera,
    renderer: Renderer,
    state: _State,
    how: Settings,
    postures: FloatArray | None,
) -> tuple[FloatArray, Pose, float, int, bool]:
    """One frame; the state goes on to the next."""
    made = problem(
        face, name, picture, camera, state.pose, state.alpha, renderer, pose_known=how.pose_known
    )
    last = state.alpha if how.pose_known else np.concatenate([np.zeros(6), state.alpha])
    again = False
    if how.method == "simplex":
        found = _plain(made, last, state.move, how)
    else:
        found, again = _by_axes(made, last, state, how, postures)
    share = found.value / made.wrong
    state.move = found.x - last
    state.pose, state.alpha = made.pose(found.x), made.alpha(found.x)
    state.usual.append(share)
    return state.alpha, state.pose, share, found.evaluations, again


def _plain(made: Problem, last: FloatArray, move: FloatArray, how: Settings) -> Found:
    """The paper's search, from the last place or from the predicted one."""
    start, spent, free = last, 0, Held(made, last, 0.0)
    if how.predict:
        starts = last + np.outer(_SPEEDS, move)
        start, spent = starts[int(free.values(starts).argmin())], len(starts)
    simplex = Simplex(how.tolerance * made.wrong, how.limit - spent)
    best = simplex.minimise(made, start, made.spec)
    return Found(best.x, best.value, np.eye(len(last)), spent + best.n_evaluations)


def _by_axes(
    made: Problem, last: FloatArray, state: _State, how: Settings, postures: FloatArray | None
) -> tuple[Found, bool]:
    """Descent from the predicted place; where epsilon stays unusual, again from the corpus."""
    start, spent, spec, free = last, 0, made.spec, Held(made, last, 0.0)
    if how.predict and state.move.any():
        starts = np.array([spec.clip(row) for row in last + np.outer(_SPEEDS, state.move)])
        start, spent = starts[int(free.values(starts).argmin())], len(starts)
    held = Held(made, start, how.inertia)
    found = descend(held, start, how.limit - spent, how.coarse)
    spent += found.evaluations
    usual = float(np.median(state.usual)) if state.usual else np.inf
    bad = found.value > how.unusual * usual * made.wrong
    room = how.limit - spent - (0 if postures is None else len(postures))
    again = bool(how.predict and bad and postures is not None and room > len(start))
    if again and postures is not None:
        rows = np.tile(found.x, (len(postures), 1))
        rows[:, -postures.shape[1] :] = postures
        first = rows[int(free.values(rows).argmin())]
        other = descend(Held(made, first, 0.0), first, room, how.coarse)
        spent += len(postures) + other.evaluations
        found = other if other.value < found.value else found
    left = Found(found.x, found.value, found.matrix, spent)
    return polish(held, left, how.limit - spent, how.tolerance), again
