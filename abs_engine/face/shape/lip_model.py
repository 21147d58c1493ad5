"""The shell of learned physics as something that can be drawn: lips, skin, and what is between.

The paper draws the shell alone. Its score (eq. 9) then grows with the area that the shell covers,
whatever lies under it. Here the skin goes on beyond the shell, moved along with its border, and the
opening is filled, so that every pixel around the mouth belongs to a facet of some class. Lips bulge
between the shell's three rings, and where an opening ends in the picture is their crest, not the
inner ring: they are drawn with more rings, which are the person's own at rest and follow.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.arrays import FloatArray, IntArray
from abs_engine.core.errors import ModelFormatError
from abs_engine.core.scene import Scene
from abs_engine.face.shape.dots import ShellPoints
from abs_engine.face.shape.lip_shell import COLUMNS, LIP_ROWS, LipShell, lips_besides, skin_around
from abs_engine.face.shape.modal import LearnedPhysics
from abs_engine.io.assets import Speaker

SKIN, LIPS, INTERIOR = 1, 2, 3
COLOUR_OF: tuple[str | None, ...] = (None, "skin", "lips", "interior")
"""Colour class of each facet class of the drawn shell."""
_SKIRT = (24.0, 42.0, 62.0)  # mm beyond the outer contour at which the rings around the shell lie

INSIDE = 2  # rings of the lips behind their inner contour
_BETWEEN = 3  # rings of the lips in each gap between the shell's
_FACING = (-np.arange(COLUMNS)) % COLUMNS  # the column of the other lip that each one meets


def leaders(nodes: FloatArray) -> FloatArray:
    """Leading points of the rings: (..., 4, 34, 3) of shell nodes (..., N, 3).

    The shell's rings of the lips from the inner to the outer one, and the inner one of the lip
    that faces them.
    """
    rings = nodes[..., : 3 * COLUMNS, :].reshape(*nodes.shape[:-2], 3, COLUMNS, 3)
    return np.concatenate([rings, rings[..., :1, _FACING, :]], axis=-3)


def followed(
    speaker: Speaker, shell: LipShell, rings: ShellPoints, chords: FloatArray
) -> FloatArray:
    """Share that each ring has in the motion of each of its `leaders`.

    A ring that keeps its distance from the shell's facets moves too far: what lies within a lip is
    held back by what it is joined to, so that a mouth which opens is drawn 0.6 mm too wide open.
    How far it is held back follows from the head's own face units.

    The shell's first three rings are the lips'; of R rings of 34 points these are (R, 4), by least
    squares over all points of a ring and all face units. Each row sums to 1, so that lips which
    move as a whole take all their rings along. `chords` (R, 4) keep a ring at its place on the
    shell's facets: where the units do not tell otherwise, these are kept.
    """
    units = speaker.unit_matrix(speaker.unit_names).astype(np.float64)
    lead = leaders(shell.nodes(units))
    moved = rings.at(units).reshape(len(units), -1, COLUMNS, 3)
    stretched = np.stack([(lead[:, k] - lead[:, 0]).ravel() for k in range(1, 4)], axis=1)
    kept = np.einsum("rk,ukcd->rucd", chords, lead)
    missing = (np.moveaxis(moved, 1, 0) - kept).reshape(len(chords), -1)
    shares = np.linalg.lstsq(stretched, missing.T, rcond=None)[0].T
    return np.asarray(chords + np.column_stack([-shares.sum(axis=1), shares]))


@dataclass(frozen=True, eq=False)
class LipModel:
    """Lips that move by learned physics of the shell's nodes.

    Parameters
    ----------
    skirt : (S, 3) float64, mm, head frame
        Rings of skin around the shell at rest, each with as many points as the shell has columns.
    bulge : (D, 3) float64, mm, head frame
        The lips' other rings at rest: `INSIDE` behind the inner contour, from the deepest, then
        those between the shell's, equally many in each gap.
    follow : (R, 4) float64
        Share that each ring of the bulge has in the motion of its `leaders`.

    Raises
    ------
    ModelFormatError
        If the physics is of another shell, or the shares are not of the bulge.
    """

    shell: LipShell
    physics: LearnedPhysics
    skirt: FloatArray
    bulge: FloatArray
    follow: FloatArray

    def __post_init__(self) -> None:
        if len(self.physics.rest) != len(self.shell):
            raise ModelFormatError(
                f"the physics has {len(self.physics.rest)} nodes, the shell {len(self.shell)}",
                "train it again with this speaker",
            )
        rings = len(self.bulge) // COLUMNS
        if np.shape(self.follow) != (rings, 4):
            raise ModelFormatError(
                f"shares of shape {np.shape(self.follow)} are not of {rings} rings",
                "give four for each",
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
        """Vertices (..., V, 3) of `scene` of shell nodes (..., N, 3): all others follow.

        Linear, so that it serves displacements as well; what skirt and bulge are at rest is left
        out of it.
        """
        border = nodes[..., -COLUMNS:, :]
        middle = nodes[..., :COLUMNS, :].mean(axis=-2, keepdims=True)
        bulge = np.einsum("rk,...kcd->...rcd", self.follow, leaders(nodes))
        bulge = bulge.reshape(*nodes.shape[:-2], -1, 3)
        return np.concatenate([nodes, *([border] * self._skirts), bulge, middle], axis=-2)

    def scene(self) -> Scene:
        """The family of meshes that is drawn; weights are in standard deviations of the modes.

        Vertices are the shell's nodes, the skirt's points, the bulge's, and the middle of the
        opening. Classes are those of `COLOUR_OF`; there is no texture.
        """
        at_rest = self.surrounded(self.physics.rest)
        skirt = slice(len(self.shell), len(self.shell) + len(self.skirt))
        at_rest[skirt] = self.skirt
        at_rest[skirt.stop : -1] = self.bulge
        at_rest[-1] = self.bulge[:COLUMNS].mean(axis=0)
        mean = at_rest + self.surrounded(self.physics.mean)
        modes = self.surrounded(self.deviations[:, None, None] * self.physics.modes)
        faces, classes = self._facets()
        return Scene(
            np.asarray(mean, np.float32), np.asarray(modes, np.float32), faces,
            np.zeros((len(mean), 2), np.float32), classes, np.zeros((1, 1, 3), np.uint8),
        )  # fmt: skip

    def _facets(self) -> tuple[NDArray[np.int32], NDArray[np.int32]]:
        """Facets of the lips, the skin, the skirt and the opening, and their classes."""
        here, first = np.arange(COLUMNS), len(self.shell) + len(self.skirt)
        places = [(float(r), COLUMNS * r) for r in range(len(LIP_ROWS))]
        for number, (low, share) in enumerate(_chords(len(self.bulge) // COLUMNS)):
            depth = number - INSIDE if number < INSIDE else low + share
            places.append((depth, first + COLUMNS * number))
        rings = [start + here for _, start in sorted(places)]
        lips = [_band(a, b) for a, b in itertools.pairwise(rings)]
        around = [len(self.shell) - COLUMNS + COLUMNS * r + here for r in range(self._skirts + 1)]
        skirt = [_band(a, b) for a, b in itertools.pairwise(around)]
        middle = np.full(COLUMNS, first + len(self.bulge))
        opening = np.stack([middle, np.roll(rings[0], -1), rings[0]], axis=1)
        parts: list[NDArray[np.integer]]
        parts = [np.concatenate(lips), self.shell.faces[~self.shell.lip], *skirt, opening]
        classes = [LIPS, SKIN, *[SKIN] * len(skirt), INTERIOR]
        faces = np.concatenate(parts).astype(np.int32)
        return faces, np.repeat(np.array(classes, np.int32), [len(p) for p in parts])

    @property
    def _skirts(self) -> int:
        """Number of rings of the skirt."""
        return len(self.skirt) // COLUMNS


def _chords(rings: int) -> list[tuple[int, float]]:
    """The shell's ring within each ring of a bulge, and the share of the way to the next."""
    gaps = len(LIP_ROWS) - 1
    each = (rings - INSIDE) // gaps
    between = [(low, (k + 1) / (each + 1)) for low in range(gaps) for k in range(each)]
    return [(0, 0.0)] * INSIDE + between


def _band(inner: IntArray, outer: IntArray) -> IntArray:
    """Facets (2 C, 3) between two rings of vertices (C,), counter-clockwise from the front."""
    after, out_after = np.roll(inner, -1), np.roll(outer, -1)
    return np.concatenate(
        [np.stack([inner, after, out_after], axis=1), np.stack([inner, out_after, outer], axis=1)]
    )


def lip_model(
    speaker: Speaker, shell: LipShell, physics: LearnedPhysics, vertices: NDArray[np.floating]
) -> LipModel:
    """The model of a person whose neutral head is `vertices` (V, 3), mm."""
    skirt = skin_around(speaker, _SKIRT).at(vertices)
    rings = lips_besides(speaker, _BETWEEN, INSIDE)
    chords = np.zeros((len(rings) // COLUMNS, 4))
    for ring, (low, share) in zip(chords, _chords(len(chords)), strict=True):
        ring[low : low + 2] = 1 - share, share
    follow = followed(speaker, shell, rings, chords)
    return LipModel(shell, physics, skirt, rings.at(vertices), follow)
