"""Typed buffers in NumPy: the pictures that a renderer returns."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, eq=False)
class Buffers:
    """The buffers of one drawn window, row 0 at the top. H, W are drawn pixels.

    Parameters
    ----------
    rgb : (H, W, 3) float32
        Textured colour, 0 to 255; 0 in the background.
    facet_id : (H, W) int32
        Facet index + 1; 0 is background.
    class_id : (H, W) int32
        Class of the facet; 0 is background.
    depth : (H, W) float32
        z in the camera frame, mm; 0 in the background.
    barycentrics : (H, W, 3) float32
        Perspective-correct weights of the facet's three vertices; 0 in the background.
    """

    rgb: NDArray[np.float32]
    facet_id: NDArray[np.int32]
    class_id: NDArray[np.int32]
    depth: NDArray[np.float32]
    barycentrics: NDArray[np.float32]

    @property
    def image(self) -> NDArray[np.uint8]:
        """The colour buffer as a picture, (H, W, 3) uint8 RGB."""
        return np.asarray(np.clip(np.rint(self.rgb), 0, 255), np.uint8)

    @property
    def covered(self) -> NDArray[np.bool_]:
        """Mask of the pixels on which a facet was drawn, (H, W) bool."""
        return np.asarray(self.facet_id > 0)


@dataclass(frozen=True, eq=False)
class Outlines:
    """Borders of a drawing, where its classes meet, row 0 at the top. H, W are drawn pixels.

    Parameters
    ----------
    facet_id, class_id : (H, W) int32
        As of `Buffers`.
    depth : (H, W) float32
    barycentrics : (H, W, 3) float32
        As of `Buffers`, wherever a neighbouring pixel is of another class; elsewhere anything.
    """

    facet_id: NDArray[np.int32]
    class_id: NDArray[np.int32]
    depth: NDArray[np.float32]
    barycentrics: NDArray[np.float32]

    @classmethod
    def of(cls, drawn: Buffers) -> Outlines:
        """Those of all buffers."""
        return cls(drawn.facet_id, drawn.class_id, drawn.depth, drawn.barycentrics)


@dataclass(frozen=True, eq=False)
class Sums:
    """Result of the fused comparison for a batch of B candidates: numbers and no image.

    `total` (B,) is the sum of the pixel term over the drawn pixels, `pixels` (B,) how many they
    are.
    """

    total: NDArray[np.float64]
    pixels: NDArray[np.int64]
