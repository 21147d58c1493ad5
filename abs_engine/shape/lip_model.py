"""The shell of learned physics as something that can be drawn: lips, skin, and what is between.

The paper draws the shell alone. Its score (eq. 9) then grows with the area that the shell covers,
whatever lies under it. Here the skin goes on beyond the shell, moved along with its border, and the
opening is filled, so that every pixel around the mouth belongs to a facet of some class.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from abs_engine.assets import Speaker
from abs_engine.errors import ModelFormatError
from abs_engine.scene import Scene
from abs_engine.shape.lip_shell import COLUMNS, LipShell, skin_around
from abs_engine.shape.modal import LearnedPhysics

FloatArray = NDArray[np.float64]
SKIN, LIPS, INTERIOR = 1, 2, 3
COLOUR_OF: tuple[str | None, ...] = (None, "skin", "lips", "interior")
"""Colour class of each facet class of the drawn shell."""
_SKIRT = (24.0, 42.0, 62.0)  # mm beyond the outer contour at which the rings around the shell lie


@dataclass(frozen=True, eq=False)
class LipModel:
    """Lips that move by learned physics.

    Parameters
    ----------
    shell : LipShell
    physics : LearnedPhysics
        Of the shell's nodes.
    skirt : (S, 3) float64, mm, head frame
        Rings of skin around the shell at rest, each with as many points as the shell has columns.

    Raises
    ------
    ModelFormatError
        If the physics is of another shell.
    """

    shell: LipShell
    physics: LearnedPhysics
    skirt: FloatArray

    def __post_init__(self) -> None:
        if len(self.physics.rest) != len(self.shell):
            raise ModelFormatError(
                f"the physics has {len(self.physics.rest)} nodes, the shell {len(self.shell)}",
                "train it again with this speaker",
            )

    @property
    def n_modes(self) -> int:
        """Number of modes, P."""
        return len(self.physics.modes)

    @property
    def deviations(self) -> FloatArray:
        """Standard deviations of the modes, (P,), mm: what one unit of a weight is."""
        return self.physics.deviations

    def surrounded(self, nodes: FloatArray) -> FloatArray:
        """Vertices (..., V, 3) of `scene` of shell nodes (..., N, 3): skirt and middle follow.

        Linear, so that it serves displacements as well (with `skirt` left out of them).
        """
        border = nodes[..., -COLUMNS:, :]
        rings = len(self.skirt) // COLUMNS
        middle = nodes[..., :COLUMNS, :].mean(axis=-2, keepdims=True)
        return np.concatenate([nodes, *([border] * rings), middle], axis=-2)

    def scene(self) -> Scene:
        """The family of meshes that is drawn; weights are in standard deviations of the modes.

        Vertices are the shell's nodes, the skirt's points, and the middle of the opening. Classes
        are those of `COLOUR_OF`; there is no texture.
        """
        mean = self.surrounded(self.physics.rest + self.physics.mean)
        skirt = slice(len(self.shell), len(self.shell) + len(self.skirt))
        rings = len(self.skirt) // COLUMNS
        mean[skirt] = self.skirt + np.tile(self.physics.mean[-COLUMNS:], (rings, 1))
        modes = self.surrounded(self.deviations[:, None, None] * self.physics.modes)
        faces, classes = self._facets()
        return Scene(
            np.asarray(mean, np.float32), np.asarray(modes, np.float32), faces,
            np.zeros((len(mean), 2), np.float32), classes, np.zeros((1, 1, 3), np.uint8),
        )  # fmt: skip

    def _facets(self) -> tuple[NDArray[np.int32], NDArray[np.int32]]:
        """Facets of the shell, then of the skirt, then of the opening, and their classes."""
        here = np.arange(COLUMNS)
        after = (here + 1) % COLUMNS
        first = len(self.shell) - COLUMNS
        skirt = []
        for ring in range(len(self.skirt) // COLUMNS):
            inner = first + ring * COLUMNS
            outer = inner + COLUMNS
            skirt.append(np.stack([inner + here, inner + after, outer + after], axis=1))
            skirt.append(np.stack([inner + here, outer + after, outer + here], axis=1))
        middle = np.full(COLUMNS, len(self.shell) + len(self.skirt))
        opening = np.stack([middle, after, here], axis=1)
        faces = np.concatenate([self.shell.faces, *skirt, opening]).astype(np.int32)
        classes = np.full(len(faces), SKIN, np.int32)
        classes[: len(self.shell.faces)][self.shell.lip] = LIPS
        classes[-COLUMNS:] = INTERIOR
        return faces, classes


def lip_model(
    speaker: Speaker, shell: LipShell, physics: LearnedPhysics, vertices: NDArray[np.floating]
) -> LipModel:
    """The model of a person whose neutral head is `vertices` (V, 3), mm."""
    skirt = skin_around(speaker, _SKIRT).nodes(vertices)
    return LipModel(shell, physics, skirt)
