"""An authored talk, frame by frame: face units, head motion, and what the lips do."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import PchipInterpolator

from abs_engine.core.arrays import FloatArray
from abs_engine.core.camera import Camera
from abs_engine.core.errors import ParameterError
from abs_engine.core.geometry import FACING, Pose
from abs_engine.face.schema import Pair, Unit, units_of
from abs_engine.io.assets import Speaker
from abs_engine.studio.speech.articulate import Speech
from abs_engine.studio.speech.contact import ContactSolver
from abs_engine.studio.speech.lips import Lips
from abs_engine.studio.visemes import Viseme, parse

MOST_FRAMES = 1_000_000
"""Of a clip: eleven hours at 25 frames a second."""
_VISIBLE_HEIGHT = 240.0
"""Millimetres that the picture's height shows at the depth of the lips."""


@dataclass(frozen=True, eq=False)
class Sequence:
    """Actions of a person in a clip.

    Parameters
    ----------
    text : str
        The sentence's name or its visemes, as given.
    rate : float
        Frames per second.
    weights : (T, 52) float64
        Face-unit weights, in the speaker's order.
    rotations : (T, 3) float64
        Rotation vectors, head frame to camera frame, radians.
    translations : (T, 3) float64, mm, camera frame
    visemes : tuple of str
        The nearest viseme of each frame.
    intervals : tuple of (str, float, float)
        Visemes, and when each begins and ends, seconds.
    """

    person: str
    text: str
    rate: float
    weights: FloatArray
    rotations: FloatArray
    translations: FloatArray
    visemes: tuple[str, ...]
    intervals: tuple[tuple[str, float, float], ...] = ()

    def __len__(self) -> int:
        """Return the number of frames, T."""
        return len(self.weights)

    def pose(self, frame: int) -> Pose:
        """Head to camera in a frame."""
        return Pose.from_vectors(self.rotations[frame], self.translations[frame])


def utter(
    text: str,
    speaker: Speaker,
    neutral: NDArray[np.floating],
    rate: float,
    frames: int | None = None,
) -> Speech:
    """Face units of a sentence of visemes of a person with neutral vertices (V, 3), mm.

    Parameters
    ----------
    text : str
        Name of a built-in sentence, or viseme symbols between spaces.
    frames : int, optional
        Length; the sentence is stretched to it. By default as long as the sentence takes.

    Raises
    ------
    ParameterError
        If a viseme is unknown, or rate or length are not positive, or beyond `MOST_FRAMES`.

    Notes
    -----
    In f the lower lip goes to the upper teeth.
    In p, b and m that fall between two frames the lips are closed in the nearest.
    """
    if rate <= 0 or (frames is not None and frames < 1):
        raise ParameterError("rate and length must be positive", "give at least one frame")
    visemes = tuple(_at_teeth(v, speaker, neutral) if v.name == "f" else v for v in parse(text))
    natural = sum(v.seconds for v in visemes)
    frames = max(1, round(natural * rate)) if frames is None else frames
    check_length(frames)
    times = np.arange(frames) / rate
    spoken = np.minimum(times * natural * rate / frames, natural)
    ends = np.cumsum([v.seconds for v in visemes]) * (frames / rate / natural)
    starts = [0.0, *ends[:-1].tolist()]
    intervals = tuple(
        (v.name, a, b) for v, a, b in zip(visemes, starts, ends.tolist(), strict=True)
    )
    weights = articulate(visemes, spoken, speaker.unit_names)
    for viseme, start, end in zip(visemes, starts, ends.tolist(), strict=True):
        if viseme.name in "pbm" and np.ceil(start * rate) >= np.ceil(end * rate):
            nearest = np.abs(times - (start + end) / 2).argmin()
            weights[nearest] = viseme.weights(speaker.unit_names)
    return Speech(weights, _nearest(visemes, spoken), intervals, rate, text=text)


def _at_teeth(viseme: Viseme, speaker: Speaker, neutral: NDArray[np.floating]) -> Viseme:
    """The viseme with the lower lip of a person at the upper teeth."""
    solver = ContactSolver(Lips.of(speaker, neutral), speaker.unit_names)
    bitten = solver.bite(viseme.weights(speaker.unit_names))
    return replace(viseme, units=dict(zip(speaker.unit_names, bitten.tolist(), strict=True)))


def deform(speaker: Speaker, weights: FloatArray) -> NDArray[np.float16]:
    """Offsets (V, 3), mm, that face-unit weights (52,) add to a person's neutral vertices.

    They are rounded to float16, as the ground truth stores them, and filmed rounded.
    """
    used = np.flatnonzero(weights)
    sums = np.zeros(speaker.vertices.shape, np.float32)
    for index in used:
        sums += np.float32(weights[index]) * speaker.units[index].astype(np.float32)
    return sums.astype(np.float16)


def check_length(frames: int) -> None:
    """Raise `ParameterError` for more than `MOST_FRAMES`."""
    if frames > MOST_FRAMES:
        raise ParameterError(f"{frames} frames are too many", f"give {MOST_FRAMES} at most")


def articulate(
    visemes: tuple[Viseme, ...], times: FloatArray, unit_names: tuple[str, ...]
) -> FloatArray:
    """Weights (T, N) at `times`: held postures joined by monotone cubics.

    The joints have a continuous velocity, and no weight leaves the range of its neighbours.
    """
    knots, values, start = [], [], 0.0
    for viseme in visemes:
        middle, half = start + viseme.seconds / 2, viseme.hold / 2
        knots += [middle - half, middle + half]
        values += [viseme.weights(unit_names)] * 2
        start += viseme.seconds
    curve = PchipInterpolator(np.array(knots), np.array(values))
    return np.asarray(curve(np.clip(times, knots[0], knots[-1])), np.float64)


def expression(
    times: FloatArray, unit_names: tuple[str, ...], rng: np.random.Generator
) -> FloatArray:
    """Weights (T, N) of blinks, every two to three seconds, and of slowly moving brows."""
    out = np.zeros((len(times), len(unit_names)))
    lids = np.zeros(len(times))
    at = float(rng.uniform(0.4, 1.0))
    while times[-1] > at:
        lids = np.maximum(lids, _bump((times - at) / 0.16))
        at += float(rng.uniform(2.0, 3.2))
    brows = 0.12 * (1 + np.sin(2 * np.pi * (0.35 * times + rng.uniform())))
    for movement, curve in (
        (Pair.EYE_BLINK, lids),
        (Unit.BROW_INNER_UP, brows),
        (Pair.BROW_OUTER_UP, 0.6 * brows),
    ):
        for name in units_of(movement):
            out[:, unit_names.index(name)] = curve
    return out


def _bump(x: FloatArray) -> FloatArray:
    """Raised cosine: 1 at 0, 0 from -1 and 1 on."""
    return np.where(np.abs(x) < 1, 0.5 + 0.5 * np.cos(np.pi * x), 0.0)


def portrait(camera: Camera, speaker: Speaker, neutral: NDArray[np.float32]) -> Pose:
    """Pose in which the face looks into the camera and fills most of the picture's height."""
    lips = neutral[speaker.lip_ring].mean(axis=0)
    top, chin = neutral[:, 1].max(), float(neutral[speaker.landmarks["chin"][0], 1])
    height = camera.size[1]
    depth = camera.matrix[1, 1] * _VISIBLE_HEIGHT / height
    middle = np.array([0.0, 0.46 * top + 0.54 * chin - 6.0, lips[2]])
    target = np.linalg.inv(camera.matrix) @ [*((np.array(camera.size) - 1) / 2), 1.0] * depth
    return Pose(FACING, target - FACING @ middle)


def wander(
    times: FloatArray, base: Pose, rng: np.random.Generator, reach: float = 1.0
) -> tuple[FloatArray, FloatArray]:
    """Small smooth head motion about `base`, a pose before a camera that the face looks into.

    Parameters
    ----------
    times : (T,) float64
        Seconds.
    reach : float
        Factor of the motion.

    Returns
    -------
    rotations : (T, 3) float64
        Rotation vectors; pitch, yaw and roll stay within `reach` times 5, 8 and 4 degrees.
    translations : (T, 3) float64, mm
        Within `reach` times 6, 4 and 8 mm of the base.
    """
    angles, shifts = (reach * part for part in sway(times, rng))
    turned = [base.rotation @ Pose.from_vectors(row, np.zeros(3)).rotation for row in angles]
    vectors = [Pose(matrix, np.zeros(3)).rotation_vector for matrix in turned]
    return np.array(vectors), base.translation + shifts @ FACING.T


def sway(times: FloatArray, rng: np.random.Generator) -> tuple[FloatArray, FloatArray]:
    """Small smooth head motion: rotation vectors (T, 3), head frame, and shifts (T, 3), mm."""
    angles = np.radians([5.0, 8.0, 4.0]) * _sway(times, rng)
    return angles, np.array([6.0, -4.0, -8.0]) * _sway(times, rng)


def _sway(times: FloatArray, rng: np.random.Generator) -> FloatArray:
    """Three curves (T, 3) within -1 and 1: slow sines of seeded phase."""
    rates = np.array([0.23, 0.41, 0.77]) * rng.uniform(0.85, 1.15, (3, 3))
    phases = rng.uniform(0, 2 * np.pi, (3, 3))
    waves = np.sin(2 * np.pi * rates * times[:, None, None] + phases)
    return np.asarray(waves @ np.array([0.55, 0.3, 0.15]), np.float64)


def _nearest(visemes: tuple[Viseme, ...], times: FloatArray) -> tuple[str, ...]:
    ends = np.cumsum([v.seconds for v in visemes])
    index = np.minimum(np.searchsorted(ends, times, side="right"), len(visemes) - 1)
    return tuple(visemes[i].name for i in index)
