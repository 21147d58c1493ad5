"""Things that come before the face (hand, microphone, calibration board), and how they move."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

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
from abs_engine.studio.scenefile import OccluderEntry
from abs_engine.studio.scenefile.values import Vector as Place

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

    It rises from below the picture, is held, and leaves the way it came. While it is held it moves
    along monotone cubics through the keys of its entry.

    Parameters
    ----------
    out : float
        How much farther out of the face it is held than the entry says, mm.

    Raises
    ------
    ParameterError
        If the kind is unknown, the times are not in order, a number is not finite, or a board is
        described where none is held.
    """

    entry: OccluderEntry
    out: float = 0.0

    def __post_init__(self) -> None:
        entry = self.entry
        kinds = tuple(_HELD)
        if entry.kind not in kinds:
            raise ParameterError(
                f"there is no occluder '{entry.kind}'", f"choose one of {', '.join(kinds)}"
            )
        if entry.board is not None and entry.kind != "board":
            raise ParameterError(f"the {entry.kind} is not a board", "leave the board out")
        later = [place for _, place in (*self.keyframes, *self.turns)]
        places = np.array([self.offset, self.away, self.turn, *later])
        if not (
            np.isfinite(places).all() and np.isfinite([entry.start, entry.end, entry.sway]).all()
        ):
            raise ParameterError(
                f"the {entry.kind} is at no finite place or time", "check its numbers"
            )
        times = [
            [self.come, *(t for t, _ in keys), self.go] for keys in (self.keyframes, self.turns)
        ]
        late = any(np.any(np.diff(row) < 0) for row in times)
        if not entry.travel > 0 or not entry.start < entry.end or late:
            raise ParameterError(
                f"the {entry.kind} comes at {entry.start:g} s, goes at {entry.end:g} s and needs "
                f"{entry.travel:g} s for each way",
                "let it end later, travel faster, and keep keyframes in order in between",
            )

    @property
    def come(self) -> float:
        """Seconds at which it has come."""
        return self.entry.start + self.entry.travel

    @property
    def go(self) -> float:
        """Seconds at which it goes."""
        return self.entry.end - self.entry.travel

    @cached_property
    def offset(self) -> Place:
        """Place where it is held: mm from the middle of the mouth, head frame."""
        return self._outwards(self.entry.offset or _HELD[self.entry.kind])

    @cached_property
    def away(self) -> Place:
        """Place that it comes from, likewise."""
        return self.entry.away or _AWAY[self.entry.kind]

    @cached_property
    def turn(self) -> Place:
        """Rotation vector of the prop against the head frame, radians."""
        degrees = self.entry.turn_degrees
        return _TURN[self.entry.kind] if degrees is None else _radians(degrees)

    @cached_property
    def keyframes(self) -> Keys:
        """Seconds and offsets of the keys that have one."""
        keys = self.entry.keys
        return tuple((k.time, self._outwards(k.offset)) for k in keys if k.offset is not None)

    @cached_property
    def turns(self) -> Keys:
        """Seconds and rotation vectors, radians, of the keys that have one."""
        keys = self.entry.keys
        return tuple((k.time, _radians(k.turn_degrees)) for k in keys if k.turn_degrees is not None)

    def _outwards(self, place: Place) -> Place:
        return place[0], place[1], place[2] + self.out

    def prop(self) -> Prop:
        """The mesh, in its own frame."""
        entry = self.entry
        if entry.kind == "hand":
            return hand(entry.colour or (205, 155, 125))
        if entry.kind == "board":
            return printed(entry.board or BOARD, entry.colour or (225, 225, 222))
        return microphone(entry.colour or (38, 39, 42))

    def offset_at(self, seconds: float) -> NDArray[np.float64]:
        """Offset (3,) float64 from the mouth, mm, head frame, at a time between start and end."""
        held, entry = self.held_at(seconds), self.entry
        near = smooth((seconds - entry.start) / entry.travel)
        near *= smooth((entry.end - seconds) / entry.travel)
        phase = np.random.default_rng(entry.seed).uniform(0, 2 * np.pi, 3)
        swayed = held + entry.sway * np.sin(2 * np.pi * _SWAY * seconds + phase)
        return np.asarray(self.away + near * (swayed - np.asarray(self.away)), np.float64)

    def held_at(self, seconds: float) -> NDArray[np.float64]:
        """Offset (3,) at which it is held, without sway; the first before it has come."""
        return self._held(self.offset, self.keyframes, seconds)

    def turn_at(self, seconds: float) -> NDArray[np.float64]:
        """Rotation vector (3,) float64 against the head frame, at a time between start and end."""
        return self._held(self.turn, self.turns, seconds)

    def _held(self, first: Place, keys: Keys, seconds: float) -> NDArray[np.float64]:
        """Value of the keys (3,); `first` from when it has come, the last one until it goes."""
        path = {self.come: first, **dict(keys)}
        path.setdefault(self.go, list(path.values())[-1])
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
        if not self.entry.start <= seconds <= self.entry.end:
            return None
        place = np.asarray(mouth, np.float64) + self.offset_at(seconds)
        return Pose.from_vectors(self.turn_at(seconds), place)


def _radians(degrees: Place) -> Place:
    x, y, z = np.radians(degrees).tolist()
    return x, y, z


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
        Moved outwards, or unchanged.
    """
    front = neutral[neutral[:, 2] > 0]
    near = cKDTree(front[:, :2])
    mouth, vertices = mouth_of(speaker, neutral), occluder.prop().vertices.astype(np.float64)
    missing = 0.0
    keys = {t for t, _ in (*occluder.keyframes, *occluder.turns)}
    knots = sorted({occluder.come, *keys})
    steps = np.arange((len(knots) - 1) * (_BETWEEN + 1) + 1) / (_BETWEEN + 1)
    for seconds in np.interp(steps, np.arange(len(knots)), knots).tolist():
        pose = Pose.from_vectors(occluder.turn_at(seconds), mouth + occluder.held_at(seconds))
        points = pose.apply(vertices)
        away, who = near.query(points[:, :2], k=6, distance_upper_bound=4.0)
        faced = np.isfinite(away)
        depth = np.append(front[:, 2], -np.inf)[who]
        behind = np.where(faced, depth - points[:, 2:], -np.inf).max()
        missing = max(missing, float(behind) + gap)
    return occluder if missing == 0.0 else replace(occluder, out=missing)
