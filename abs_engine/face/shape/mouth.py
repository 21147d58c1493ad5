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

# a unit, or both of a pair: largest weight, and how often it takes part
_ACTIONS: dict[str, tuple[float, float]] = {
    Unit.MOUTH_FUNNEL: (0.7, 0.3),
    Unit.MOUTH_PUCKER: (0.9, 0.35),
    Pair.MOUTH_SMILE: (0.5, 0.3),
    Pair.MOUTH_STRETCH: (0.6, 0.3),
    Pair.MOUTH_FROWN: (0.4, 0.2),
    Pair.MOUTH_PRESS: (0.5, 0.15),
    Pair.MOUTH_DIMPLE: (0.4, 0.15),
    Pair.MOUTH_UPPER_UP: (0.7, 0.35),
    Pair.MOUTH_LOWER_DOWN: (0.8, 0.35),
    Unit.MOUTH_ROLL_UPPER: (0.6, 0.15),
    Unit.MOUTH_ROLL_LOWER: (0.7, 0.2),
    Unit.MOUTH_SHRUG_UPPER: (0.3, 0.15),
    Unit.MOUTH_SHRUG_LOWER: (0.3, 0.15),
    Unit.MOUTH_LEFT: (0.5, 0.15),
    Unit.MOUTH_RIGHT: (0.5, 0.15),
    Unit.JAW_LEFT: (0.4, 0.12),
    Unit.JAW_RIGHT: (0.4, 0.12),
    Unit.JAW_FORWARD: (0.3, 0.15),
}
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
    speaker: Speaker,
    neutral: NDArray[np.float32],
    n_modes: int,
    anybody: bool = False,
) -> LinearShape:
    """Principal components over mouth postures of a real person and others that are authored.

    The recorded ones, a share `SHAPE.recorded`, are large and move together as a face does; the
    authored ones have every action of speech, closures and one-sided ones among them.

    The bundled head's units were made by an artist, MakeHuman's; ICT FaceKit's, which were made
    after scans, move lips otherwise, and farther from front to back. Where the person may be
    `anybody`, these move the face in a share `SHAPE.scanned_units` of the postures.

    Parameters
    ----------
    speaker : Speaker
    neutral : (V, 3) float32, mm
        The person's neutral vertices.
    n_modes : int
    anybody : bool
        Whether this is not the person's own head; only the bundled head, or one of its mesh and
        size, may be anybody's.

    Returns
    -------
    LinearShape
        Its generators are the units of `mouth_units` and, for `anybody`, how those of scans differ.

    Raises
    ------
    ParameterError
        If the postures do not span so many modes.
    InputFileError, ModelFormatError
        If the recorded postures or, for `anybody`, the units of scans cannot be read.
    """
    names = mouth_units()
    units = speaker.unit_matrix(names)
    authored = Postures.of(sample_postures(4000, seed=0))
    postures = recorded_postures(names).pooled(authored, SHAPE.recorded)
    if anybody:
        units = np.concatenate([units, unit_differences(names)])
        postures = postures.partly_again(SHAPE.scanned_units)
    return principal_shapes(neutral, units, postures, n_modes, _importance(speaker))


def mouth_units() -> tuple[str, ...]:
    """Names of the face units that move the mouth, in the order of the generators."""
    return units_of(Unit.JAW_OPEN, Unit.MOUTH_CLOSE, *_ACTIONS)


def sample_postures(count: int, seed: int) -> FloatArray:
    """Random unit weights (count, N): each action now and then, jaw and closure always.

    A third of the postures have the lips closed by `mouthClose`, as in /p b m/, the others open.
    """
    rng = np.random.default_rng(seed)
    columns = {name: np.zeros(count) for name in mouth_units()}
    jaw = SHAPE.widest_jaw * rng.beta(1.0, 1.8, count)
    closing = np.where(rng.random(count) < 0.35, rng.uniform(0.7, 1.0, count), 0.0)
    columns[Unit.MOUTH_CLOSE] = jaw * np.maximum(closing, 0.25 * rng.random(count))
    for name, (largest, share) in _ACTIONS.items():
        amount = largest * rng.random(count) * (rng.random(count) < share)
        sides = units_of(name)
        for side in sides:
            columns[side] = amount * rng.uniform(0.85, 1.15, count)
        weaker = rng.integers(len(sides), size=count)
        lone = (rng.random(count) < SHAPE.one_sided) * (len(sides) == 2)
        for k, side in enumerate(sides):
            columns[side] *= 1 - lone * (weaker == k) * rng.random(count)
        jaw = jaw + _PRESSING.get(name, 0.0) * amount
    columns[Unit.JAW_OPEN] = jaw
    return np.stack([columns[name] for name in mouth_units()], axis=1)


def _importance(speaker: Speaker) -> FloatArray:
    """Lips count five times as much as skin; what lies inside of the mouth does not count."""
    weight = np.zeros(len(speaker.vertices))
    weight[speaker.faces[speaker.facet_class == speaker.class_id("skin")]] = 1.0
    for lip in ("upper_lip", "lower_lip"):
        weight[speaker.faces[speaker.facet_class == speaker.class_id(lip)]] = 5.0
    return weight
