"""Feature matching: details of a drawn head in a picture, and the pose that puts them there.

Patches of the drawing are looked for by normalised correlation, which feels neither brightness nor
contrast. Each match counts by how sharply it is placed, as brows and nostrils are and smooth skin
is not.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from abs_engine.core.arrays import BoolArray, FloatArray, IntArray
from abs_engine.core.camera import Camera
from abs_engine.core.geometry import Pose
from abs_engine.core.settings import GENERAL
from abs_engine.tracking.settings.registration import REGISTRATION
from abs_engine.tracking.texture.rigid_motion import corners_of

Gray = NDArray[np.float32]
_PULL = 1 / np.array(REGISTRATION.patch_drift)  # rad^-1, mm^-1


@dataclass(frozen=True, eq=False)
class Matches:
    """Patches of a drawing that were found in a picture.

    Parameters
    ----------
    at : (N, 2) int
        Column and row of each in the drawing.
    found : (N, 2) float64
        Where it is in the picture, in drawn pixels.
    root : (N, 2, 2) float64, px^-1
        R with R'R the inverse covariance of `found`.
    agreement : float
        Mean correlation of all patches where they were drawn, -1 to 1.
    """

    at: IntArray
    found: FloatArray
    root: FloatArray
    agreement: float


@dataclass(frozen=True, eq=False)
class Drawn:
    """A drawing to be looked for in a picture, of H by W drawn pixels.

    Parameters
    ----------
    gray : (H, W) float32
    covered : (H, W) bool
        Where anything is drawn.
    wanted : (H, W) bool
        What is looked for.
    width : float
        Of the face, drawn pixels.
    """

    gray: Gray
    covered: BoolArray
    wanted: BoolArray
    width: float

    @property
    def half(self) -> int:
        """Half the side of a patch, drawn pixels."""
        return max(3, round(REGISTRATION.patch * self.width))

    @property
    def near(self) -> BoolArray:
        """Mask of the patches about the wanted points, (H, W)."""
        side = 2 * self.half + 3
        return cv2.dilate(self.wanted.astype(np.uint8), np.ones((side, side), np.uint8)) > 0

    def corners(self, edge: int) -> IntArray:
        """Middles (N, 2), column and row, of patches with structure, `edge` pixels inside."""
        side = 2 * self.half + 1
        whole = cv2.blur(self.covered.astype(np.float32), (side, side)) >= REGISTRATION.share_drawn
        wanted = cv2.erode(self.wanted.astype(np.uint8), np.ones((3, 3), np.uint8))
        usable = np.zeros(wanted.shape, np.uint8)
        inside = slice(edge, -edge), slice(edge, -edge)
        usable[inside] = wanted[inside] * whole[inside]
        most, quality = REGISTRATION.most_patches, REGISTRATION.patch_quality
        apart = max(REGISTRATION.least_apart, REGISTRATION.patches_apart * self.width)
        return corners_of(self.gray, most, quality, apart, usable, self.half).astype(np.int64)


def match(drawn: Drawn, seen: Gray, reach: float) -> Matches:
    """Look for a drawing's details in a picture (H, W) at the drawn pixels.

    Each is looked for within `reach` face widths of where it was drawn.
    """
    half, far = drawn.half, max(2, round(reach * drawn.width))
    at, found, roots, here = [], [], [], []
    for x, y in drawn.corners(half + far + 1):
        patch = drawn.gray[y - half : y + half + 1, x - half : x + half + 1]
        around = seen[y - half - far : y + half + far + 1, x - half - far : x + half + far + 1]
        like = np.asarray(cv2.matchTemplate(around, patch, cv2.TM_CCOEFF_NORMED), np.float64)
        here.append(like[far, far])
        peak = _peak(like)
        if peak is not None:
            at.append((x, y))
            found.append(peak[0] - far + [x, y])
            roots.append(peak[1])
    return Matches(
        np.array(at, np.int64).reshape(-1, 2), np.array(found).reshape(-1, 2),
        np.array(roots).reshape(-1, 2, 2), float(np.mean(here)) if here else -1.0,
    )  # fmt: skip


def _peak(like: FloatArray) -> tuple[FloatArray, FloatArray] | None:
    """Place (column, row) of a correlation's peak, and the root of its information.

    None where it is low, at the border, or no peak. By the paraboloid through its neighbours.
    """
    y, x = np.unravel_index(int(like.argmax()), like.shape)
    highest = float(like[y, x])
    inside = 0 < y < like.shape[0] - 1 and 0 < x < like.shape[1] - 1
    if highest < REGISTRATION.least_like or not inside:
        return None
    near = like[y - 1 : y + 2, x - 1 : x + 2]
    slope = 0.5 * np.array([near[1, 2] - near[1, 0], near[2, 1] - near[0, 1]])
    across = 0.25 * (near[2, 2] - near[2, 0] - near[0, 2] + near[0, 0])
    bend = np.array([
        [near[1, 2] - 2 * highest + near[1, 0], across],
        [across, near[2, 1] - 2 * highest + near[0, 1]],
    ])  # fmt: skip
    if bend[0, 0] >= 0 or np.linalg.det(bend) <= 1e-12:
        return None
    shift = -np.linalg.solve(bend, slope)
    if np.abs(shift).max() > 1:
        return None
    information = -bend * REGISTRATION.trust / max(1 - highest, REGISTRATION.best_noise)
    root = np.asarray(np.linalg.cholesky(information).T, np.float64)
    return np.array([x, y]) + shift, root


def pose_of_matches(
    points: FloatArray,
    motions: FloatArray,
    pixels: FloatArray,
    root: FloatArray,
    camera: Camera,
    start: tuple[Pose, FloatArray],
) -> tuple[Pose, FloatArray]:
    """The pose of a head, and its expression (K,), that put points where they were found.

    Robust to points that were found in the wrong place. Points (N, 3), mm, head frame, move by
    `motions` (N, K, 3), mm per standard deviation, with the expression. They were found at `pixels`
    (N, 2), with `root` (N, 2, 2), px^-1, of the inverse covariance. It begins at `start`, to which
    the pose is weakly held.
    """
    from scipy.optimize import least_squares  # not for every clip: it takes a while to import

    pose, weights = start
    centre = points.mean(axis=0)
    at = pose.apply(centre)

    def pose_at(x: FloatArray) -> Pose:
        turned = Pose.from_vectors(x[:3], np.zeros(3)).rotation @ pose.rotation
        return Pose(turned, at + x[3:6] - turned @ centre)

    def residuals(x: FloatArray) -> FloatArray:
        moved = points + np.einsum("k,nkd->nd", x[6:], motions)
        away = np.einsum("nij,nj->ni", root, camera.project(pose_at(x).apply(moved)) - pixels)
        return np.concatenate([away.ravel(), x[:6] * _PULL, x[6:]])

    scale = np.r_[REGISTRATION.patch_step, np.full(len(weights), GENERAL.mode_step)]
    first = np.r_[np.zeros(6), weights]
    fit = least_squares(
        residuals,
        first,
        loss="soft_l1",
        f_scale=REGISTRATION.small_residual,
        x_scale=scale,
        max_nfev=REGISTRATION.pose_limit,
    )
    return pose_at(fit.x), np.asarray(fit.x[6:], np.float64)
