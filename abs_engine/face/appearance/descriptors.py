"""Local descriptors: Gaussian derivatives of luminance and chrominance (Odisio & Bailly, 3.2).

A descriptor's eight components are, in this order: G0 of Cb and Cr; G1x of Y, Cb, Cr; G1y of Y, Cb,
Cr. G0 of Y is left out, so that an offset of luminance changes nothing. x is to the right, y down,
in drawn pixels; filters reach to `REACH` times their scale.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from abs_engine.core.arrays import FloatArray
from abs_engine.core.errors import ParameterError
from abs_engine.face.appearance.visibility import check_picture

COMPONENTS = ("Cb", "Cr", "Y_x", "Cb_x", "Cr_x", "Y_y", "Cb_y", "Cr_y")
REACH = 3.0

YCBCR: FloatArray = np.array(
    [
        [0.2220, 0.7067, 0.0713, 0.0],
        [-0.1195, -0.3805, 0.5000, 127.5],
        [0.5000, -0.4542, -0.0458, 127.5],
    ]
)
"""Y, Cb, Cr of (R, G, B, 1), as the paper prints it (section 3.2)."""


def to_ycbcr(image: NDArray[np.generic]) -> NDArray[np.float32]:
    """Luminance and chrominance (H, W, 3) float32 of an image (H, W, 3), RGB 0 to 255.

    Raises `PictureError` if the picture has another shape or pixels that are not finite.
    """
    check_picture(image)
    return np.asarray(cv2.transform(np.asarray(image, np.float32), YCBCR), np.float32)


@dataclass(frozen=True, eq=False)
class DescriptorMaps:
    """The descriptors (S, H, W, 8) of every pixel of an image, at scales (S,), drawn pixels.

    Filters run once for a frame. For the hundreds of evaluations that a fit takes, reading these
    maps is far cheaper than filtering around each point anew.
    """

    maps: NDArray[np.float32]
    scales: FloatArray

    @classmethod
    def of(cls, image: NDArray[np.generic], scales: NDArray[np.floating]) -> DescriptorMaps:
        """Filter an image (H, W, 3), RGB 0 to 255, at each of some scales (S,), drawn pixels.

        Raises as `to_ycbcr` and `kernels`.
        """
        ycbcr = to_ycbcr(image)
        given = np.asarray(scales, np.float64)
        return cls(np.stack([_filtered(ycbcr, float(s)) for s in given]), given)

    def at(self, pixels: FloatArray, scale: NDArray[np.integer] | None = None) -> FloatArray:
        """Descriptors (..., N, 8) at drawn pixels (..., N, 2), bilinear; the border is repeated.

        `scale` (N,) is the index into `scales` for each point; by default the first.
        """
        height, width = self.maps.shape[1:3]
        last = np.array([width - 1, height - 1])
        place = np.clip(np.nan_to_num(pixels, nan=0.0), 0, last)
        low = np.minimum(place.astype(np.intp), np.maximum(last - 1, 0))
        fx, fy = np.moveaxis(place - low, -1, 0)[..., None]
        x, y = np.moveaxis(low, -1, 0)
        x2, y2 = np.minimum(x + 1, width - 1), np.minimum(y + 1, height - 1)
        k = np.zeros(x.shape[-1], np.intp) if scale is None else scale
        upper = (1 - fx) * self.maps[k, y, x] + fx * self.maps[k, y, x2]
        lower = (1 - fx) * self.maps[k, y2, x] + fx * self.maps[k, y2, x2]
        return np.asarray((1 - fy) * upper + fy * lower, np.float64)


def kernels(sigma: float) -> tuple[FloatArray, FloatArray]:
    """The sampled Gaussian, of sum 1, and its derivative, of slope 1 on a ramp (1 / px).

    Both are in the order that correlates: the derivative is positive where the image rises. Raises
    `ParameterError` if the scale is not positive.
    """
    if not sigma > 0:
        raise ParameterError(f"the filters' scale is {sigma}", "give a positive number of pixels")
    x = np.arange(-np.ceil(REACH * sigma), np.ceil(REACH * sigma) + 1)
    smooth = np.exp(-0.5 * (x / sigma) ** 2)
    slope = x * smooth
    return smooth / smooth.sum(), slope / (x @ slope)


def _filtered(ycbcr: NDArray[np.float32], sigma: float) -> NDArray[np.float32]:
    smooth, slope = kernels(sigma)
    border = cv2.BORDER_REPLICATE
    plain = cv2.sepFilter2D(ycbcr[..., 1:], -1, smooth, smooth, borderType=border)
    right = cv2.sepFilter2D(ycbcr, -1, slope, smooth, borderType=border)
    down = cv2.sepFilter2D(ycbcr, -1, smooth, slope, borderType=border)
    return np.concatenate([plain, right, down], axis=2)
