"""Borders of classes as drawn, and the gain of the facet likelihood as they move.

The sum of eq. 9 changes only where a pixel turns from one class to another: at the borders between
drawn classes. Across a border the gain of moving it is the integral of the difference of the two
classes' maps along its normal, exactly; its slope is a force, and its curvature a stiffness.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from abs_engine.compare import border_lines
from abs_engine.compare.settings import COMPARISON
from abs_engine.core.arrays import FloatArray
from abs_engine.core.buffers import Outlines


@dataclass(frozen=True, eq=False)
class Groups:
    """Facet classes by what they show.

    Parameters
    ----------
    of : (C,) int32
        Group of each class, from 1 on; 0 for a background whose borders gain nothing. Classes with
        the same map are one.
    maps : (G, H, W) float32
        What a pixel gives to each group.
    parts : (C,) int32
        1 and 2 for the two lips, whose facets may part where they touch; 0 for all others.
    inside : int
        Group of what shows between them; 0 where none parts.
    """

    of: NDArray[np.int32]
    maps: NDArray[np.float32]
    parts: NDArray[np.int32]
    inside: int = 0

    def total(self, shown: NDArray[np.int32]) -> float:
        """The sum of eq. 9 over an image of classes (H, W)."""
        return float(border_lines.total(self.of, shown, self.maps))

    @classmethod
    def by(
        cls,
        maps: NDArray[np.float32],
        lips: tuple[int, int] | None = None,
        inside: int = 0,
        *,
        background: bool = False,
    ) -> Groups:
        """Of maps (C, H, W), with the classes of the two lips and of what is between them.

        With a `background` what is not drawn is a group, too, and gains `maps[0]`.
        """
        of, kept = np.zeros(len(maps), np.int32), [np.zeros_like(maps[0])]
        for k in range(0 if background else 1, len(maps)):
            same = (g for g in range(1, len(kept)) if np.array_equal(kept[g], maps[k]))
            of[k] = next(same, len(kept))
            if of[k] == len(kept):
                kept.append(maps[k])
        parts = np.zeros(len(maps), np.int32)
        if lips is None:
            return cls(of, np.ascontiguousarray(kept, np.float32), parts)
        parts[list(lips)] = 1, 2
        return cls(of, np.ascontiguousarray(kept, np.float32), parts, int(of[inside]))


@dataclass(frozen=True, eq=False)
class Borders:
    """The borders of a drawing, K of them, each with what the sum gains as it moves.

    Parameters
    ----------
    facet : (K,) int32
        The facet whose outline each is.
    weights : (K, 3) float64
        Barycentrics of the place in that facet.
    normal : (K, 2) float64, drawn pixels
    gain : (K,) float64
        Of the sum for a pixel of motion along the normal.
    curve : (K,) float64
        By how much the gain falls with each pixel.
    """

    facet: NDArray[np.int32]
    weights: FloatArray
    normal: FloatArray
    gain: FloatArray
    curve: FloatArray

    def times(self, factor: float) -> Borders:
        """The same with gains in other units."""
        return replace(self, gain=factor * self.gain, curve=factor * self.curve)

    @classmethod
    def of(
        cls,
        drawn: Outlines,
        groups: Groups,
        reach: int,
        local: bool,
        floor: float = COMPARISON.least_curvature,
    ) -> Borders:
        """The borders of a drawing, looked for so many drawn pixels, `reach`, to either side.

        If `local`, only the slope where a border is counts, not where it would gain most.
        Curvatures are no less than `floor`.
        """
        return cls(
            *border_lines.borders(
                drawn.class_id, groups.of, groups.parts, groups.maps, drawn.facet_id, drawn.depth,
                drawn.barycentrics, groups.inside, min(reach, border_lines.MOST), floor,
                local,
            )
        )  # fmt: skip
