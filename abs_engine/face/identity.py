"""The identity prior: the whole head as a Gaussian over shape targets and people's components."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.arrays import FloatArray
from abs_engine.core.threads import kept
from abs_engine.face.schema import COMPONENT, MACRO, PERSON, less_of
from abs_engine.face.settings.shape import SHAPE
from abs_engine.face.shape.population import average_person, expected, load_population
from abs_engine.face.shape.proportions import proportioned
from abs_engine.face.shape.smooth import mirrored_modes
from abs_engine.io.assets import Speaker


@dataclass(frozen=True, eq=False)
class IdentityShape:
    """Directions in which people differ, each one standard deviation long.

    Parameters
    ----------
    names : tuple of str, K
        Of the target that each direction stands for, the one that it adds.
    weights : (K, T) float32
        Weights of the speaker's T targets at one standard deviation.
    """

    names: tuple[str, ...]
    weights: NDArray[np.float32]

    def modes(self, speaker: Speaker) -> NDArray[np.float32]:
        """Displacements (K, V, 3), mm per standard deviation."""
        return np.asarray(
            np.tensordot(self.weights, speaker.identity.astype(np.float32), 1), np.float32
        )


def identity_shape(speaker: Speaker) -> IdentityShape:
    """All targets of a speaker; a pair (more and less of one thing) is one direction."""
    index = {name: k for k, name in enumerate(speaker.identity_names)}
    names, rows = [], []
    for name, row in _directions(index):
        names.append(name)
        rows.append(row)
    return IdentityShape(tuple(names), np.array(rows, np.float32).reshape(len(rows), len(index)))


def head_modes(speaker: Speaker) -> NDArray[np.float32]:
    """Modes by which heads differ: the speaker's targets, and smooth ones for what these leave.

    (K, V, 3) float32, principal directions, mm per standard deviation, the widest first.
    """
    return _principal(speaker, np.concatenate(_own_modes(speaker)))


def _own_modes(speaker: Speaker) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """The speaker's targets, and smooth fields (M, V, 3), mm per standard deviation."""
    targets = identity_shape(speaker).modes(speaker)
    vertices = speaker.vertices.astype(np.float64)
    return targets, mirrored_modes(vertices, SHAPE.asymmetry)


def _principal(speaker: Speaker, modes: NDArray[Any]) -> NDArray[np.float32]:
    """Principal directions of what modes leave once skulls are as alike as people's."""
    flat = modes.reshape(len(modes), -1)
    tied = proportioned(speaker, flat)
    values, vectors = np.linalg.eigh(tied @ (flat @ flat.T) @ tied.T)
    kept = vectors[:, np.argsort(-values)[: SHAPE.identity_modes]].T @ tied
    return np.asarray(kept.astype(np.float32) @ flat).reshape(-1, *modes.shape[1:])


def sized_head(
    speaker: Speaker, factor: float, known: bool = False
) -> tuple[Speaker, NDArray[np.float32]]:
    """A speaker enlarged by a factor, and its `head_modes`; no modes for a `known` person.

    With those of the `average_person`, people's components are pooled. The last result for that is
    kept, as its modes take a third of a second.
    """
    if not known and expected(speaker):
        return _anybody(factor)
    sized = speaker.scaled(factor)
    return sized, np.zeros((0, *sized.vertices.shape), np.float32) if known else head_modes(sized)


@kept
def _anybody(factor: float) -> tuple[Speaker, NDArray[np.float32]]:
    sized = average_person().scaled(factor)
    return sized, _principal(sized, load_population().pooled(_own_modes(sized), factor))


def _directions(index: dict[str, int]) -> Iterator[tuple[str, FloatArray]]:
    less = {name: less_of(name) for name in index}
    for name, k in index.items():
        row = np.zeros(len(index))
        if name.startswith(PERSON):
            continue
        if name.startswith(COMPONENT):
            row[k] = 1.0
            yield name, row
            continue
        if (other := less[name]) in index:
            row[k], row[index[other]] = 0.5 * SHAPE.target_pair, -0.5 * SHAPE.target_pair
        elif name in less.values():
            continue  # the other of a pair
        else:
            row[k] = SHAPE.target_macro if name.startswith(MACRO) else SHAPE.target_alone
        yield name, row
