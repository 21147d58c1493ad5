"""Things that come before the face (hand, microphone, calibration board), and how they move."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal, get_args

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import PchipInterpolator
from scipy.spatial import cKDTree

from abs_engine.capture.board import Board
from abs_engine.core.errors import ParameterError
from abs_engine.core.geometry import Pose
from abs_engine.io.assets import Speaker
from abs_engine.studio.board_mesh import printed
from abs_engine.studio.prop_mesh import Prop, hand, microphone

Kind = Literal["hand", "microphone", "board"]
Place = tuple[float, float, float]
Keys = tuple[tuple[float, Place], ...]

BOARD = Board("charuco", 7, 5, 18.0)
"""What is held where a board is asked for and nothing is said of it."""

_HELD: dict[str, Place] = {
    "hand": (2.0, -15.0, 24.0),
    "microphone": (0.0, -22.0, 48.0),
    "board": (0.0, 20.0, 60.0),
}
_AWAY: dict[str, Place] = {
    "hand": (-150.0, -330.0, 90.0),
    "microphone": (-40.0, -330.0, 150.0),
    "board": (0.0, -330.0, 90.0),
}
_TURN: dict[str, Place] = {
    "hand": (0.0, 0.0, 0.45),
    "microphone": (-0.75, 0.0, 0.12),
    "board": (0.0, 0.0, 0.0),
}
_BETWEEN = 7
"""Times between two keys at which an occluder is kept off the face."""
_SWAY = np.array([0.31, 0.47, 0.83])


@dataclass(frozen=True)
class Occluder:
    """A thing that is moved before the face for a while.

    It rises from below the picture, is held, and leaves the way it came.

    Parameters
    ----------
    kind : {"hand", "microphone", "board"}
    start, end : float
        Seconds; outside of them it is not there.
    travel : float
        Seconds that it takes to come, and again to go.
    offset : tuple of float, optional
        Where it is held: mm from the middle of the mouth, head frame (to the subject's left, up,
        out of the face). By default over the mouth (hand), below it (microphone) or before the
        face (board).
    away : tuple of float, optional
        Where it comes from, likewise; by default some 35 cm below the mouth.
    turn : tuple of float, optional
        Rotation vector of the prop against the head frame, radians.
    keyframes : tuple of (float, tuple of float)
        Further places while it is held: seconds and offset, in order of time. Between them it
        moves along monotone cubics.
    turns : tuple of (float, tuple of float)
        Likewise: seconds and rotation vectors, in order of time.
    sway : float
        Amplitude of the small motion of whoever holds it, mm.
    colour : tuple of int, optional
        sRGB of the hand's skin, of the microphone's body, or of the board's paper.
    follows : bool
        Whether it moves with the head; otherwise it keeps to where the head was at `start`.
    seed : int
        Of the sway.
    board : Board, optional
        Which board is held; by default `BOARD`.

    Raises
    ------
    ParameterError
        If the kind is unknown, the times are not in order, a number is not finite, or a board is
        described where none is held.
    """

    kind: Kind
    start: float
    end: float
    travel: float = 0.4
    offset: Place | None = None
    away: Place | None = None
    turn: Place | None = None
    keyframes: Keys = ()
    turns: Keys = ()
    sway: float = 1.0
    colour: tuple[int, int, int] | None = None
    follows: bool = True
    seed: int = 0
    board: Board | None = None

    def __post_init__(self) -> None:
        if self.kind not in get_args(Kind):
            raise ParameterError(
                f"there is no occluder '{self.kind}'", f"choose one of {', '.join(get_args(Kind))}"
            )
        if self.board is not None and self.kind != "board":
            raise ParameterError(f"the {self.kind} is not a board", "leave the board out")
        for name in ("offset", "away", "turn"):
            if getattr(self, name) is None:
                default = {"offset": _HELD, "away": _AWAY, "turn": _TURN}[name]
                object.__setattr__(self, name, default[self.kind])
        later = [place for _, place in (*self.keyframes, *self.turns)]
        places = np.array([self.offset, self.away, self.turn, *later])
        if (
            not np.isfinite(places).all()
            or not np.isfinite([self.start, self.end, self.sway]).all()
        ):
            raise ParameterError(
                f"the {self.kind} is at no finite place or time", "check its numbers"
            )
        come, go = self.start + self.travel, self.end - self.travel
        times = [[come, *(t for t, _ in keys), go] for keys in (self.keyframes, self.turns)]
        late = any(np.any(np.diff(row) < 0) for row in times)
        if not self.travel > 0 or not self.start < self.end or late:
            raise ParameterError(
                f"the {self.kind} comes at {self.start:g} s, goes at {self.end:g} s and needs "
                f"{self.travel:g} s for each way",
                "let it end later, travel faster, and keep keyframes in order in between",
            )

    def prop(self) -> Prop:
        """The mesh, in its own frame."""
        if self.kind == "hand":
            return hand(self.colour or (205, 155, 125))
        if self.kind == "board":
            return printed(self.board or BOARD, self.colour or (225, 225, 222))
        return microphone(self.colour or (38, 39, 42))

    def offset_at(self, seconds: float) -> NDArray[np.float64]:
        """Offset (3,) float64 from the mouth, mm, head frame, at a time between start and end."""
        held = self.held_at(seconds)
        near = smooth((seconds - self.start) / self.travel)
        near *= smooth((self.end - seconds) / self.travel)
        phase = np.random.default_rng(self.seed).uniform(0, 2 * np.pi, 3)
        swayed = held + self.sway * np.sin(2 * np.pi * _SWAY * seconds + phase)
        return np.asarray(self.away + near * (swayed - np.asarray(self.away)), np.float64)

    def held_at(self, seconds: float) -> NDArray[np.float64]:
        """Offset (3,) at which it is held, without sway; the first before it has come."""
        return self._held(self.offset or (0.0, 0.0, 0.0), self.keyframes, seconds)

    def turn_at(self, seconds: float) -> NDArray[np.float64]:
        """Rotation vector (3,) float64 against the head frame, at a time between start and end."""
        return self._held(self.turn or (0.0, 0.0, 0.0), self.turns, seconds)

    def _held(self, first: Place, keys: Keys, seconds: float) -> NDArray[np.float64]:
        """Value of the keys (3,); `first` from when it has come, the last one until it goes."""
        come, go = self.start + self.travel, self.end - self.travel
        path = {come: first, **dict(keys)}
        path.setdefault(go, list(path.values())[-1])
        times, places = np.array(list(path)), np.array(list(path.values()), np.float64)
        if len(times) == 1:
            return np.asarray(places[0])
        at = np.clip(seconds, times[0], times[-1])
        return np.asarray(PchipInterpolator(times, places)(at), np.float64)

    def pose_at(self, seconds: float, mouth: NDArray[np.floating]) -> Pose | None:
        """Prop frame to head frame, or None while it is not there.

        Parameters
        ----------
        mouth : (3,), mm, head frame
            See `mouth_of`.
        """
        if not self.start <= seconds <= self.end:
            return None
        place = np.asarray(mouth, np.float64) + self.offset_at(seconds)
        return Pose.from_vectors(self.turn_at(seconds), place)


def smooth(share: float) -> float:
    """Rise from 0 at 0 to 1 at 1 without jerk: Flash and Hogan's minimum-jerk curve (1985)."""
    t = min(max(share, 0.0), 1.0)
    return t**3 * (10 - 15 * t + 6 * t * t)


def mouth_of(speaker: Speaker, neutral: NDArray[np.floating]) -> NDArray[np.float64]:
    """Middle (3,) of the lips of a person at rest, mm, head frame."""
    return np.asarray(neutral[speaker.lip_ring].mean(axis=0), np.float64)


def clear_of(
    occluder: Occluder, speaker: Speaker, neutral: NDArray[np.floating], gap: float = 6.0
) -> Occluder:
    """Hold the occluder farther out where it would be less than `gap` mm before the face.

    It is looked at when it has come, at all keys, and at `_BETWEEN` times from one to the next.

    Parameters
    ----------
    neutral : (V, 3), mm, head frame
        The person at rest. Lips that are pushed forward come some 5 mm nearer.
    gap : float
        mm, along the direction out of the face.

    Returns
    -------
    Occluder
        Its `offset` and all `keyframes` moved outwards by the same length, or unchanged.
    """
    front = neutral[neutral[:, 2] > 0]
    near = cKDTree(front[:, :2])
    mouth, vertices = mouth_of(speaker, neutral), occluder.prop().vertices.astype(np.float64)
    missing = 0.0
    keys = {t for t, _ in (*occluder.keyframes, *occluder.turns)}
    knots = sorted({occluder.start + occluder.travel, *keys})
    steps = np.arange((len(knots) - 1) * (_BETWEEN + 1) + 1) / (_BETWEEN + 1)
    for seconds in np.interp(steps, np.arange(len(knots)), knots).tolist():
        pose = Pose.from_vectors(occluder.turn_at(seconds), mouth + occluder.held_at(seconds))
        points = pose.apply(vertices)
        away, who = near.query(points[:, :2], k=6, distance_upper_bound=4.0)
        faced = np.isfinite(away)
        depth = np.append(front[:, 2], -np.inf)[who]
        behind = np.where(faced, depth - points[:, 2:], -np.inf).max()
        missing = max(missing, float(behind) + gap)
    if missing == 0.0:
        return occluder

    def out(place: Place) -> Place:
        return place[0], place[1], place[2] + missing

    moved = tuple((t, out(p)) for t, p in occluder.keyframes)
    return replace(occluder, offset=out(occluder.offset or (0, 0, 0)), keyframes=moved)
