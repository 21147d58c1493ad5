"""Filter windows of points: rigid in the picture, or lying on the surface.

The paper's windows are rigid (3.2); that they should follow the surface, as an affine map of its
neighbourhood has it (Wiles et al.'s hyperpatches), is its outlook (6).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from abs_engine.core.arrays import FloatArray, IntArray
from abs_engine.face.appearance.descriptors import DescriptorMaps
from abs_engine.face.appearance.patches import Patches
from abs_engine.face.settings.appearance import APPEARANCE


@dataclass(frozen=True, eq=False)
class Windows:
    """Windows by which the descriptors of N points are read from maps.

    Parameters
    ----------
    patches : Patches
    sigma : (N,) float64, drawn pixels
        Scale of each point's filters.
    unit : float, drawn pixels per mm
        Where windows lie on the surface, the size at which their scale is `sigma`; 0 for windows
        that are rigid in the picture.

    Notes
    -----
    On the surface, the gradient is taken along the surface's own axes (those that point to the
    right and down in the picture of an upright head that faces the camera), by the affine map
    that carries its neighbourhood at rest to the picture: exact, for the gradient of the smoothed
    picture. The window becomes larger and smaller with the map's determinant, but stays round.
    """

    patches: Patches
    sigma: FloatArray
    unit: float = 0.0

    @cached_property
    def scales(self) -> FloatArray:
        """Scales that maps must have, ascending, drawn pixels."""
        if self.unit == 0:
            return np.unique(self.sigma)
        low, high = (
            self.sigma.min() / APPEARANCE.window_reach,
            self.sigma.max() * APPEARANCE.window_reach,
        )
        count = 1 + int(np.ceil(np.log(high / low) / np.log(APPEARANCE.window_step)))
        return np.geomspace(low, high, count)

    @cached_property
    def at_rest(self) -> IntArray:
        """Index of the one of `scales` that is nearest to each point's, (N,)."""
        distance = np.abs(np.log(self.scales / self.sigma[:, None]))
        return np.asarray(distance.argmin(axis=1), np.int64)

    def read(self, maps: DescriptorMaps, flat: FloatArray) -> FloatArray:
        """Descriptors (N, 8), where the patches' vertices lie at drawn pixels `flat` (K, 2)."""
        pixels = flat[self.patches.points]
        if self.unit == 0:
            return maps.at(pixels, self.at_rest)
        stretch = self._stretch(flat)
        grown = np.sqrt(np.maximum(np.abs(np.linalg.det(stretch)), 1e-9))
        wanted = np.clip(self.sigma * grown, self.scales[0], self.scales[-1])
        place = np.log(wanted / self.scales[0]) / np.log(self.scales[1] / self.scales[0])
        lower = np.clip(place.astype(np.int64), 0, len(self.scales) - 2)
        share = np.clip(place - lower, 0, 1)[:, None]
        found = (1 - share) * maps.at(pixels, lower) + share * maps.at(pixels, lower + 1)
        slopes = found[:, 2:].reshape(-1, 2, 3)  # right and down, by Y, Cb and Cr
        turned = np.einsum("nji,njc->nic", stretch, slopes)
        return np.concatenate([found[:, :2], turned.reshape(-1, 6)], axis=1)

    def _stretch(self, flat: FloatArray) -> FloatArray:
        """Affine maps (N, 2, 2) from the surface at rest, in drawn pixels, to the picture."""
        p = self.patches
        now = flat[p.facets] - np.repeat(flat[p.points], p.counts, axis=0)[:, None]
        mixed = np.einsum("mki,mkj->mij", now, self._rest)
        return np.asarray(np.add.reduceat(mixed, p.starts, axis=0) @ self._inverse)

    @cached_property
    def _rest(self) -> FloatArray:
        """Facets' corners (M, 3, 2) from their point, on the surface at rest, drawn pixels."""
        p = self.patches
        points, normals = p.surface(p.mean)
        normals = normals / np.linalg.norm(normals, axis=1, keepdims=True)
        right = np.array([1.0, 0, 0]) - normals * normals[:, :1]
        right /= np.maximum(np.linalg.norm(right, axis=1, keepdims=True), 1e-9)
        axes = np.stack([right, np.cross(right, normals)], axis=1)
        around = p.mean[p.facets] - np.repeat(points, p.counts, axis=0)[:, None]
        flat = np.einsum("mkx,mix->mki", around, np.repeat(axes, p.counts, axis=0))
        return np.asarray(self.unit * flat)

    @cached_property
    def _inverse(self) -> FloatArray:
        """Inverse (N, 2, 2) of the corners' second moments at rest."""
        squared = np.einsum("mki,mkj->mij", self._rest, self._rest)
        moments = np.add.reduceat(squared, self.patches.starts, axis=0)
        floor = 1e-9 * np.trace(moments, axis1=1, axis2=2)[:, None, None] * np.eye(2)
        return np.asarray(np.linalg.inv(moments + floor))
