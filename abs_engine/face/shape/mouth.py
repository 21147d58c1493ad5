"""A lip and lower-face shape model: principal components over the face units of the mouth."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.arrays import FloatArray
from abs_engine.face.schema import Pair, Unit, units_of
from abs_engine.face.settings.shape import SHAPE
from abs_engine.face.shape.linear import LinearShape, principal_shapes
from abs_engine.face.shape.postures import Postures, recorded_postures
from abs_engine.face.shape.scanned_units import unit_differences
from abs_engine.io.assets import Speaker

ACTIONS: tuple[str, ...] = (
    Unit.MOUTH_FUNNEL, Unit.MOUTH_PUCKER, Pair.MOUTH_SMILE, Pair.MOUTH_STRETCH, Pair.MOUTH_FROWN,
    Pair.MOUTH_PRESS, Pair.MOUTH_DIMPLE, Pair.MOUTH_UPPER_UP, Pair.MOUTH_LOWER_DOWN,
    Unit.MOUTH_ROLL_UPPER, Unit.MOUTH_ROLL_LOWER, Unit.MOUTH_SHRUG_UPPER, Unit.MOUTH_SHRUG_LOWER,
    Unit.MOUTH_LEFT, Unit.MOUTH_RIGHT, Unit.JAW_LEFT, Unit.JAW_RIGHT, Unit.JAW_FORWARD,
)  # fmt: skip
"""The mouth's actions: a face unit, or both of a pair."""
SIDEWAYS = units_of(Unit.MOUTH_LEFT, Unit.MOUTH_RIGHT, Unit.JAW_LEFT, Unit.JAW_RIGHT)
"""Units that move the whole mouth to one side."""
# jaw opening, per unit of weight, that keeps the lips of this head from passing into each other
_PRESSING: dict[str, float] = {
    Unit.MOUTH_PUCKER: 0.08,
    Pair.MOUTH_PRESS: 0.08,
    Pair.MOUTH_SMILE: 0.09,
    Unit.MOUTH_ROLL_LOWER: 0.10,
    Unit.MOUTH_ROLL_UPPER: 0.045,
    Unit.MOUTH_SHRUG_LOWER: 0.15,
}


def mouth_shape(
    speaker: Speaker, neutral: NDArray[np.float32], n_modes: int, anybody: bool = False
) -> LinearShape:
    """Principal components over mouth postures of a real person and others that are authored.

    The recorded ones, a share `SHAPE.recorded`, are large and move together as a face does; the
    authored ones have every action of speech, closures and one-sided ones among them.

    The bundled head's units were made by an artist, MakeHuman's; ICT FaceKit's, which were made
    after scans, move lips otherwise, and farther from front to back. Where the person may be
    `anybody`, units move the face from front to back as scans do, and across it as they do in a
    share `SHAPE.scanned_units` of the postures; and the mouth goes less far to a side than in the
    postures, which are made to show how far it can go. Generators are the units of `mouth_units`
    and, for anybody, how those of scans differ across the face.

    Parameters
    ----------
    neutral : (V, 3) float32, mm
        The person's neutral vertices.
    anybody : bool
        Whether this is not the person's own head; only the `average_person`, or it at another
        size, may be anybody's.

    Raises
    ------
    ParameterError
        If the postures do not span so many modes.
    InputFileError, ModelFormatError
        If the recorded postures or, for `anybody`, the units of scans cannot be read.
    """
    names = mouth_units()
    units = speaker.unit_matrix(names)
    authored = Postures.of(sample_postures(SHAPE.authored, seed=0))
    postures = recorded_postures(names).pooled(authored, SHAPE.recorded)
    if anybody:
        units = _partly_scanned(units, unit_differences(names))
        less = np.where(np.isin(names, SIDEWAYS), SHAPE.sideways, 1.0)
        postures = postures.scaled(less).partly_again(SHAPE.scanned_units)
    return principal_shapes(neutral, units, postures, n_modes, _importance(speaker))


def _partly_scanned(
    units: NDArray[np.float32], differences: NDArray[np.float32]
) -> NDArray[np.float32]:
    """Generators (2 N, V, 3): units as deep as those of scans; how these differ across the face."""
    depth = np.array([0.0, 0.0, 1.0], np.float32)
    return np.concatenate([units + depth * differences, (1 - depth) * differences])


def mouth_units() -> tuple[str, ...]:
    """Names of the face units that move the mouth, in the order of the generators."""
    return units_of(Unit.JAW_OPEN, Unit.MOUTH_CLOSE, *ACTIONS)


def sample_postures(count: int, seed: int) -> FloatArray:
    """Random unit weights (count, N): each action now and then, jaw and closure always.

    Some of the postures have the lips closed by `mouthClose`, as in /p b m/, the others open.
    """
    rng = np.random.default_rng(seed)
    columns = {name: np.zeros(count) for name in mouth_units()}
    jaw = SHAPE.widest_jaw * rng.beta(*SHAPE.jaw_form, count)
    shut = rng.random(count) < SHAPE.lips_closed
    closing = np.where(shut, rng.uniform(SHAPE.least_closed, 1.0, count), 0.0)
    columns[Unit.MOUTH_CLOSE] = jaw * np.maximum(closing, SHAPE.half_closed * rng.random(count))
    drawn = zip(ACTIONS, SHAPE.action_weights, SHAPE.action_shares, strict=True)
    for name, largest, share in drawn:
        amount = largest * rng.random(count) * (rng.random(count) < share)
        sides = units_of(name)
        for side in sides:
            columns[side] = amount * rng.uniform(1 - SHAPE.uneven, 1 + SHAPE.uneven, count)
        weaker = rng.integers(len(sides), size=count)
        lone = (rng.random(count) < SHAPE.one_sided) * (len(sides) == 2)
        for k, side in enumerate(sides):
            columns[side] *= 1 - lone * (weaker == k) * rng.random(count)
        jaw = jaw + _PRESSING.get(name, 0.0) * amount
    columns[Unit.JAW_OPEN] = jaw
    return np.stack([columns[name] for name in mouth_units()], axis=1)


def _importance(speaker: Speaker) -> FloatArray:
    """Lips count more than skin; what lies inside of the mouth does not count."""
    weight = np.zeros(len(speaker.vertices))
    weight[speaker.vertices_of("skin")] = 1.0
    weight[speaker.vertices_of("upper_lip", "lower_lip")] = SHAPE.lip_weight
    return weight
