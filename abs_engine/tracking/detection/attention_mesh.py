"""Face mesh with attention to the lips (Grishchenko et al. 2020), run by OpenCV in two parts.

"Attention Mesh: High-fidelity Face Mesh Prediction in Real-time", arXiv:2006.10962. One part sees
all landmarks, the other only the lips, in features of the first that are cut out around them. What
joins them in MediaPipe's file are operations that OpenCV does not have, and a few lines here.
`assets/take_detector.py` takes the parts out of that file.
"""

from __future__ import annotations

import json
from dataclasses import dataclass
from functools import cache

import cv2
import numpy as np
from numpy.typing import NDArray

from abs_engine.core.arrays import FloatArray
from abs_engine.io.assets import shipped
from abs_engine.tracking.detection.network import Network

SIDE = 192  # pixels, of the picture that the network looks at
_FACE = Network("face_mesh.tflite", "output_mesh", "conv_faceflag", "p_re_lu_3")
_LIPS = Network("face_lips.tflite", "conv_lips")
_COARSE = 4  # pixels of the picture for one of the features
_CELLS = 16  # of the features, about the lips, to a side


@dataclass(frozen=True, eq=False)
class _Region:
    """Lips as the second part sees them: its landmarks, and how it is laid about them."""

    landmarks: NDArray[np.int_]
    ends: tuple[int, int]
    around: float

    def placed(self, mesh: FloatArray) -> FloatArray:
        """Affine map (2, 3) from the region's cells to those of all features.

        The region is upright between its ends, and `around` times as large as its landmarks.
        """
        points = mesh[:, :2] / _COARSE
        along = np.subtract(*points[list(self.ends[::-1])])
        along = along / max(float(np.linalg.norm(along)), 1e-9)
        axes = np.stack([along, [-along[1], along[0]]])
        within = points[self.landmarks] @ axes.T
        low, high = within.min(axis=0), within.max(axis=0)
        linear = axes.T * (self.around * (high - low) / _CELLS)
        start = 0.5 * (low + high) @ axes - linear @ np.full(2, 0.5 * _CELLS)
        return np.column_stack([linear, start])


@cache
def _region() -> _Region:
    known = json.loads(shipped("detector/face_lips.json").read_text())
    right, left = known["ends"]
    return _Region(np.array(known["landmarks"], np.int_), (right, left), float(known["around"]))


def seen_mesh(patch: NDArray[np.uint8]) -> tuple[FloatArray, float]:
    """The landmarks of an upright face, and how probably there is one.

    Parameters
    ----------
    patch : (192, 192, 3) uint8, RGB
        A square of 1.5 times the face's size.

    Returns
    -------
    points : (468, 3) float64, px
        Column, row and depth in the square; columns and rows of the lips are those of the second
        part.
    presence : float
        0 to 1.
    """
    found, flag, features = _FACE.seen(patch.astype(np.float32) / 255.0)
    mesh = found.reshape(-1, 3).astype(np.float64)
    region = _region()
    placed = region.placed(mesh)
    quarters = _LIPS.seen(_cut(features[0].transpose(1, 2, 0), placed))[0].reshape(-1, 2)
    # the network counts quarters of a cell, and a feature has as many pixels
    mesh[region.landmarks, :2] = quarters @ placed[:, :2].T + _COARSE * placed[:, 2]
    logit = float(np.clip(flag.ravel()[0], -50.0, 50.0))
    return mesh, float(1 / (1 + np.exp(-logit)))


def _cut(features: NDArray[np.float32], placed: FloatArray) -> NDArray[np.float32]:
    """Features (H, W, C) at the middles of a region's cells, (16, 16, C), between neighbours."""
    moved = placed.copy()
    moved[:, 2] += placed[:, :2] @ np.full(2, 0.5) - 0.5
    flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
    few = [np.ascontiguousarray(part) for part in np.split(features, features.shape[2] // 4, 2)]
    return np.dstack([cv2.warpAffine(f, moved, (_CELLS, _CELLS), flags=flags) for f in few])
