"""The camera model: OpenCV pinhole with distortion, and the window of the image that is drawn.

Pixel centres are at integers, as in `cv2.projectPoints`. The camera frame is OpenCV's: x right,
y down, z forward.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from functools import cached_property, lru_cache

import cv2
import numpy as np
from numpy.typing import NDArray

from abs_engine.core.arrays import FloatArray
from abs_engine.core.errors import ParameterError
from abs_engine.core.kinds import WHOLE
from abs_engine.core.lens import radial_factor, unfolded
from abs_engine.core.settings import GENERAL

WIDEST_SIDE = 1 << 15
"""px: no picture is wider or higher."""
_FIXED = [0, 1, 2, 2, 2], [1, 0, 0, 1, 2]
"""Elements of a matrix that are the same for all cameras: no skew, as in OpenCV."""
_CONVERGED = cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, 50, 1e-12


@dataclass(frozen=True, eq=False)
class Camera:
    """A calibrated camera.

    Parameters
    ----------
    matrix : (3, 3) float64
        Intrinsics in pixels: [[fx, 0, cx], [0, fy, cy], [0, 0, 1]].
    size : tuple of int
        Width and height of the whole image in pixels.
    distortion : (8,) float64, optional
        k1, k2, p1, p2, k3, k4, k5, k6 as in OpenCV; shorter vectors are padded with zeros.
    near, far : float
        Depth range in mm. What is nearer than `near` is cut off.

    Raises
    ------
    ParameterError
        If a value is not finite or of another kind, the matrix is transposed, scaled or has skew, a
        focal length or the size is not positive, the picture is wider than any, the depths are no
        range, or the distortion has more than eight coefficients.
    """

    matrix: FloatArray
    size: tuple[int, int]
    distortion: FloatArray = field(default_factory=lambda: np.zeros(8))
    near: float = 10.0
    far: float = 10_000.0

    def __post_init__(self) -> None:
        try:
            matrix = np.array(self.matrix, np.float64).reshape(3, 3)
            lens = () if self.distortion is None else self.distortion
            given = np.asarray(lens, np.float64).ravel()
        except (TypeError, ValueError) as error:
            raise ParameterError(
                "a camera is a 3x3 matrix and at most eight numbers of distortion",
                "give both as OpenCV's calibration returns them",
            ) from error
        size = _checked_size(self.size)
        if given.size > 8 and np.any(given[8:]):
            raise ParameterError(
                "thin-prism and tilted distortion are not supported",
                "calibrate with at most eight coefficients (CALIB_RATIONAL_MODEL)",
            )
        distortion = np.zeros(8)
        distortion[: min(8, given.size)] = given[:8]
        if not np.isfinite(matrix).all() or not np.isfinite(distortion).all():
            raise ParameterError("the camera holds NaN or infinity", "calibrate it again")
        if not 0 < min(size) <= max(size) <= WIDEST_SIDE:
            raise ParameterError(
                f"the image size is {size[0]}x{size[1]}", "check the calibration file"
            )
        if not 0 < self.near < self.far < np.inf:
            raise ParameterError(
                "the near distance must be positive, and far beyond it", "give both in mm"
            )
        if matrix[0, 0] <= 0 or matrix[1, 1] <= 0:
            raise ParameterError("focal lengths must be positive", "check the calibration file")
        if not np.allclose(matrix[_FIXED], [0, 0, 0, 0, 1], rtol=0, atol=1e-6):
            raise ParameterError(
                f"the camera's matrix is {matrix.tolist()}",
                "give [[fx, 0, cx], [0, fy, cy], [0, 0, 1]], without skew and not transposed",
            )
        object.__setattr__(self, "matrix", matrix)
        object.__setattr__(self, "distortion", distortion)
        object.__setattr__(self, "size", size)

    @classmethod
    def ideal(cls, size: tuple[int, int], focal: float | None = None) -> Camera:
        """A distortion-free camera; without `focal` (px) its field of view is about 33 degrees.

        Parameters
        ----------
        size : tuple of int
            Width and height in pixels.
        focal : float, optional
            Focal length in pixels, by default `GENERAL.focal` times the larger side.
        """
        size = _checked_size(size)
        focal = GENERAL.focal * max(size) if focal is None else focal
        centre = (size[0] - 1) / 2, (size[1] - 1) / 2
        return cls(np.array([[focal, 0, centre[0]], [0, focal, centre[1]], [0, 0, 1.0]]), size)

    @property
    def whole(self) -> Window:
        """The window that covers the image, one drawn pixel for each image pixel."""
        return Window(0, 0, *self.size)

    def scaled(self, scale: float) -> Camera:
        """The camera of the whole picture as a window of that scale samples it.

        Parameters
        ----------
        scale : float
            Its pixels per pixel of this camera.
        """
        matrix = self.matrix.copy()
        matrix[:2] *= scale
        matrix[:2, 2] += 0.5 * scale - 0.5  # pixel centres are whole numbers in both
        size = Window(0, 0, *self.size, scale).drawn
        return Camera(matrix, size, self.distortion, self.near, self.far)

    @cached_property
    def distorted(self) -> bool:
        """Whether any distortion coefficient is not zero."""
        return bool(self.distortion.any())

    @cached_property
    def radius_limit(self) -> float:
        """Largest r^2 (normalised units) up to which the distortion is trusted.

        Beyond the image the polynomial may fold back; it is held constant outside of 1.5 times
        the largest normalised radius of the image, and from where it turns back.
        """
        width, height = self.size
        corners = np.array([[-1, -1], [width, -1], [-1, height], [width, height]], np.float64)
        flat = cv2.undistortPoints(corners[:, None], self.matrix, self.distortion)[:, 0]
        return unfolded(self.distortion, float(2.25 * (flat**2).sum(axis=1).max()))

    def distort(self, points: FloatArray) -> FloatArray:
        """Apply lens distortion, keeping z.

        Parameters
        ----------
        points : (..., 3) float64, camera frame

        Returns
        -------
        (..., 3) float64
            (x'' z, y'' z, z) with x'', y'' of the OpenCV model; `points` themselves where the lens
            does not distort.
        """
        if not self.distorted:
            return points
        p1, p2 = self.distortion[2:4]
        z = points[..., 2]
        safe = np.where(np.abs(z) < 1e-9, 1e-9, z)
        x, y = points[..., 0] / safe, points[..., 1] / safe
        r2 = np.minimum(x * x + y * y, self.radius_limit)
        radial = radial_factor(self.distortion, r2)
        inside = x * x + y * y <= self.radius_limit
        dx = np.where(inside, 2 * p1 * x * y + p2 * (r2 + 2 * x * x), 0.0)
        dy = np.where(inside, p1 * (r2 + 2 * y * y) + 2 * p2 * x * y, 0.0)
        return np.stack([(x * radial + dx) * z, (y * radial + dy) * z, z], axis=-1)

    def undistort(self, pixels: FloatArray) -> FloatArray:
        """Rays x/z and y/z (..., 2) through pixels (..., 2): what `project` undoes.

        A strong lens model does not reach far beyond the picture, where points of a face that is
        cut off may lie: there the lens is left out. NaN stays NaN.
        """
        if not pixels.size:
            return np.zeros(pixels.shape)
        flat = np.ascontiguousarray(pixels.reshape(-1, 1, 2), np.float64)
        plain = np.asarray(cv2.undistortPoints(flat, self.matrix, None), np.float64)
        if not self.distorted:
            return plain.reshape(pixels.shape)
        # by default OpenCV stops after five iterations: too early towards the edges of wide lenses
        rays = cv2.undistortPoints(flat, self.matrix, self.distortion, criteria=_CONVERGED)
        off = self.project(np.concatenate([rays, np.ones_like(rays[..., :1])], axis=-1)) - flat
        there = np.abs(off).max(axis=-1, keepdims=True) < 1.0
        return np.asarray(np.where(there, rays, plain), np.float64).reshape(pixels.shape)

    def project(self, points: FloatArray) -> FloatArray:
        """Project camera-frame points (..., 3) in mm to pixels (..., 2), as `cv2.projectPoints`."""
        image = self.distort(points) @ self.matrix.T
        return np.asarray(image[..., :2] / image[..., 2:])

    def clip_matrix(self, window: Window) -> FloatArray:
        """The ONE matrix from (distorted) OpenCV camera coordinates to GL clip coordinates.

        Row 0 of the framebuffer is the top row of the window, so what is read back needs no flip;
        front facets are therefore clockwise for OpenGL.

        Returns
        -------
        (4, 4) float64
        """
        return _clip_matrix(self, window)


def _checked_size(size: Sequence[int]) -> tuple[int, int]:
    """Width and height as Python's own numbers; else `ParameterError`."""
    sides = list(size) if isinstance(size, Iterable) else []
    if len(sides) != 2 or not all(map(WHOLE[0], sides)):
        raise ParameterError(
            f"the image size is {size!r}", "give width and height, two whole numbers of pixels"
        )
    return int(sides[0]), int(sides[1])


@lru_cache(maxsize=32)  # asked for in every drawing
def _clip_matrix(camera: Camera, window: Window) -> FloatArray:
    """See `Camera.clip_matrix`."""
    s, (width, height) = window.scale, window.drawn
    k, n, f = camera.matrix, camera.near, camera.far
    shift_x, shift_y = 0.5 - window.x, 0.5 - window.y
    rows = [
        [2 * s * k[0, 0] / width, 0, 2 * s * (k[0, 2] + shift_x) / width - 1, 0],
        [0, 2 * s * k[1, 1] / height, 2 * s * (k[1, 2] + shift_y) / height - 1, 0],
        [0, 0, (f + n) / (f - n), -2 * f * n / (f - n)],
        [0, 0, 1, 0],
    ]
    return np.array(rows, np.float64)


@dataclass(frozen=True)
class Window:
    """A rectangle of the image, and how finely it is drawn.

    Parameters
    ----------
    x, y : float
        Left and top edge in image pixels: the window's first pixel, at scale 1, is (x, y).
    width, height : float
        Size in image pixels.
    scale : float
        Drawn pixels per image pixel.
    """

    x: float
    y: float
    width: float
    height: float
    scale: float = 1.0

    def __post_init__(self) -> None:
        if not (self.width > 0 and self.height > 0 and self.scale > 0):
            raise ParameterError(f"the window {self} is empty", "give a positive size and scale")
        if not max(self.width, self.height) * self.scale <= WIDEST_SIDE:
            raise ParameterError(
                f"the window {self} has a side of more than {WIDEST_SIDE} drawn pixels",
                "give a smaller size or scale",
            )

    @property
    def drawn(self) -> tuple[int, int]:
        """Width and height in drawn pixels."""
        return max(1, round(self.width * self.scale)), max(1, round(self.height * self.scale))

    def to_drawn(self, pixels: FloatArray) -> FloatArray:
        """Image pixel coordinates (..., 2) to coordinates of the drawn window."""
        origin = np.array([self.x - 0.5, self.y - 0.5])
        return np.asarray((pixels - origin) * self.scale - 0.5)

    def to_image(self, drawn: FloatArray) -> FloatArray:
        """Coordinates of the drawn window (..., 2) to image pixel coordinates."""
        origin = np.array([self.x - 0.5, self.y - 0.5])
        return np.asarray((drawn + 0.5) / self.scale + origin)

    @property
    def places(self) -> tuple[FloatArray, FloatArray]:
        """Columns (W,) and rows (H,) of the image that the drawn pixels' centres lie at."""
        width, height = self.drawn
        along = np.repeat(np.arange(max(self.drawn), dtype=np.float64)[:, None], 2, axis=1)
        x, y = self.to_image(along).T
        return x[:width], y[:height]

    def sample(self, image: NDArray[np.generic]) -> NDArray[np.generic]:
        """Cut the window out of an image (H, W) or (H, W, C), at the drawn resolution.

        Bilinear; area-averaged when the window is drawn coarser than the image. Pixels outside of
        the image repeat its border.
        """
        s = self.scale
        offset = (0.5 / s - 0.5) + np.array([self.x, self.y])
        source = image
        if s < 1:  # average before sampling, or fine detail aliases
            source = cv2.GaussianBlur(np.asarray(image), (0, 0), GENERAL.window_blur / s)
        matrix = np.array([[1 / s, 0, offset[0]], [0, 1 / s, offset[1]]])
        flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
        return np.asarray(
            cv2.warpAffine(
                np.asarray(source), matrix, self.drawn, flags=flags, borderMode=cv2.BORDER_REPLICATE
            )
        )
