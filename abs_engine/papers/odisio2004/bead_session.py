"""Visemes filmed for their articulation: a speaker with dots of ink before two cameras.

A board in front of the face, in several places, calibrates the cameras; then the speaker
bites on a plate that has the board's print, which shows where the upper teeth are; then they say
the visemes one after the other.
"""

from __future__ import annotations

from collections.abc import Sequence as Several
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from abs_engine.core.arrays import FloatArray
from abs_engine.core.camera import Camera
from abs_engine.core.geometry import FACING, Pose, compose, pose_vectors
from abs_engine.dataset.codec import BOARD as BOARD_CODE
from abs_engine.learn.spoken import SpokenCorpus, bite_plane_of
from abs_engine.papers.odisio2004.filmed import with_beads
from abs_engine.studio.appearance.look import Light, Look
from abs_engine.studio.board_mesh import printed
from abs_engine.studio.corpus import viseme_weights
from abs_engine.studio.dressing import prop_of
from abs_engine.studio.filming import plan_of
from abs_engine.studio.make import Crew, Order, make
from abs_engine.studio.plan import ClipPlan, Prop, View
from abs_engine.studio.props import BOARD, mouth_of
from abs_engine.studio.sequence import Sequence, portrait, wander

BEADS = "corpus"
"""The set of dots that the speaker wears."""
BOARDS, SAID = "boards", "visemes"
"""Clips: the board in its places and, in the last frame, the plate; the visemes."""
_YAW = 0.22
_SIDES = (("left", -_YAW), ("right", _YAW))
"""Cameras, and from where they see the face, radians from straight ahead."""
CAMERAS = tuple(name for name, _ in _SIDES)
RATE, HELD, WAY = 25.0, 1, 3
"""Frames per second; frames that a viseme is held; frames from one viseme to the next."""
PARTED = "preph"
"""The viseme before all others."""
PLACES = 14
"""Of the board."""
_SIZE, _FOCAL, _LENS = (480, 480), 1400.0, (-0.08, 0.03)
_CLOSER, _LOWER = 1.35, 20.0
"""The picture shows the face from chin to brows: factor of the focal length, and mm from where a
portrait has its middle."""
_LOOK = Look(
    lights=(
        Light("low", (0.1, 0.45, -1.0), 2.4),  # the upper lip must not lie in the dark
        Light("side", (-0.6, 0.05, -1.0), 1.2),
    )
)
_REACH = 0.5
"""How far the head moves, as of `studio.sequence.wander`: the speaker tries to keep it still."""
_PLATE = Pose(np.eye(3), np.array([0.0, -12.0, 45.0]))
"""The plate's print, its middle, in the frame of the upper teeth: so it was made."""


def moments(count: int) -> list[tuple[int, int]]:
    """First and last frame of so many visemes of `SAID`, which begins with parted lips.

    So all dots are seen in frame 0, where a person points at them.
    """
    step = HELD + WAY
    return [(k * step, k * step + HELD - 1) for k in range(1, count + 1)]


def plate_places() -> FloatArray:
    """Corners (K, 3) of the plate's print, mm, in the frame of the upper teeth."""
    return _PLATE.apply(_to_print().apply(BOARD.places))


def _to_print() -> Pose:
    """The frame of `Board.places`, y down from a corner, to that of the mesh, about its middle."""
    half = np.array([BOARD.columns, -BOARD.rows, 0.0]) * BOARD.square / 2
    return Pose(FACING, -half)


@dataclass(frozen=True, eq=False)
class BeadSession:
    """Plans of a session.

    Parameters
    ----------
    spoken : SpokenCorpus
        What is said.
    seed : int
        Of the head's motion, the board's places and the sensor's noise.
    """

    spoken: SpokenCorpus
    person: str
    seed: int = 0

    def film(self, folder: Path, command: str) -> None:
        """Film it into a data set; errors as `make`."""
        order = Order(command, self.seed, (), keep_frames=False)
        plans = self.plans(command)
        make(plans, len(plans), folder, self.spoken.speaker, order, Crew())

    def plans(self, command: str = "") -> list[ClipPlan]:
        """The two clips."""
        still = np.zeros((PLACES + 1, len(self.spoken.speaker.unit_names)))
        boards = self._plan(BOARDS, still, 0.0, command)
        board = self._board(Pose.from_vectors(boards.rotations[0], boards.translations[0]))
        speaker, neutral = self.spoken.speaker, self.spoken.neutral
        parted = viseme_weights(speaker, neutral, PARTED, self.seed)
        said = self._plan(SAID, joined([parted, *self.spoken.weights]), _REACH, command)
        return [replace(boards, props=(*boards.props, board)), replace(said, number=1)]

    def _plan(self, name: str, weights: FloatArray, reach: float, command: str) -> ClipPlan:
        speaker, rng = self.spoken.speaker, np.random.default_rng([self.seed, 3])
        base = portrait(Camera.ideal(_SIZE, _FOCAL), speaker, speaker.named(self.person))
        base = Pose(base.rotation, base.translation - [0.0, _LOWER, 0.0])
        close = Camera.ideal(_SIZE, _CLOSER * _FOCAL)
        camera = Camera(close.matrix, _SIZE, np.array(_LENS))
        count = len(weights)
        rotations, shifts = wander(np.arange(count) / RATE, base, rng, reach)
        act = Sequence(self.person, name, RATE, weights, rotations, shifts, ("",) * count)
        plan = plan_of(speaker, act, camera, _LOOK, self.seed, command)
        middle = Pose.from_vectors(plan.rotations[0], plan.translations[0]).apply(
            mouth_of(speaker, plan.neutral)
        )
        views = tuple(_turned(plan.views[0], *side, middle) for side in _SIDES)
        return replace(with_beads(speaker, plan, BEADS), name=name, views=views)

    def _board(self, head: Pose) -> Prop:
        """The board in its places before the head, then the plate between the teeth."""
        mesh, rng = printed(BOARD, (236, 236, 230)), np.random.default_rng([self.seed, 4])
        mouth = mouth_of(self.spoken.speaker, self.spoken.neutral)
        teeth = bite_plane_of(self.spoken.speaker, self.spoken.neutral)
        held = [
            Pose.from_vectors(
                rng.uniform(-0.45, 0.45, 3),
                mouth + rng.uniform([-15.0, -5.0, 75.0], [15.0, 45.0, 135.0]),
            )
            for _ in range(PLACES)
        ]
        poses = [compose(head, own) for own in [*held, compose(teeth.inverse, _PLATE)]]
        return prop_of(BOARD_CODE, mesh, poses, np.ones(len(poses), np.bool_))


def _turned(view: View, name: str, yaw: float, middle: FloatArray) -> View:
    """A view from another side of a place (3,), mm, world frame."""
    turn = Pose.from_vectors([0.0, yaw, 0.0], np.zeros(3)).rotation
    about = Pose(turn, middle - turn @ middle)
    rotations, translations = pose_vectors([compose(view.pose(0), about)])
    return replace(view, name=name, rotations=rotations, translations=translations, crf=10)


def joined(postures: Several[FloatArray]) -> FloatArray:
    """Weights (T, 52) of postures (V, 52), held for `HELD` frames and joined smoothly."""
    share = 0.5 - 0.5 * np.cos(np.pi * np.arange(1, WAY + 1) / (WAY + 1))[:, None]
    out: list[FloatArray] = []
    for now, then in zip(postures, [*postures[1:], None], strict=True):
        out += [now] * HELD
        if then is not None:
            out += list(now + share * (then - now))
    return np.array(out)
