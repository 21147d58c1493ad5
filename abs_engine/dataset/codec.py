"""The encoding of a dataset's labels: names, units, pure functions on arrays.

Depth, normals and flow are kept as 16-bit pictures. Each `encode_` function has a `decode_`
function that gives back what was encoded, up to half a step of the encoding.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.errors import ParameterError

FORMAT = "abs_engine.dataset"
"""Of ``dataset.json`` and of ``truth.npz``."""
CAMERA_FORMAT, POINTS_FORMAT = "abs_engine.camera", "abs_engine.landmarks"
OFFSETS_FORMAT = "abs_engine.offsets"
VERSION = 2

DATASET, SCENE, README = "dataset.json", "scene.toml", "README.md"
TRUTH, POINTS = "truth.npz", "points.npz"
CAMERA, VIDEO, COCO = "camera.json", "video.mp4", "coco.json"
VERTICES, FRAMES, COVER = "vertices", "frames", "cover"

LABELS = ("ids", "depth", "normals", "albedo", "flow")
"""Label pictures of a camera; the first two are always there."""

CHUNK = 100
"""Frames in one file of vertex offsets."""

DEPTH_STEP = 0.05
"""mm along the optical axis."""

CLOSED_BELOW = 0.25
"""Lips whose widest gap is smaller than this (mm) count as closed."""

NORMAL_SCALE = 65_534.0
FLOW_SCALE, FLOW_ZERO = 64.0, 32_768
FLOW_REACH = (FLOW_ZERO - 1) / FLOW_SCALE
"""Largest displacement of a flow picture, px; what moves farther is marked as not valid."""

HAND, MICROPHONE, OTHER, BOARD, UNUSED = 1, 2, 3, 4, 255
COVER_NAMES = {
    0: "nothing",
    HAND: "hand",
    MICROPHONE: "microphone",
    OTHER: "torso or other",
    BOARD: "calibration board",
}

PICTURES: dict[str, tuple[type[np.generic], int]] = {
    "ids": (np.uint16, 1),
    "depth": (np.uint16, 1),
    "normals": (np.uint16, 3),
    "albedo": (np.uint8, 3),
    "flow": (np.uint16, 3),
    COVER: (np.uint8, 1),
    FRAMES: (np.uint8, 3),
}
"""dtype and channels of each kind of PNG."""

Words = NDArray[np.uint16]


def frame_name(frame: int) -> str:
    """File name of the PNG of a frame."""
    return f"{frame:06d}.png"


def chunk_name(frame: int) -> str:
    """File name of the offsets of a frame: that of the first frame in the same chunk."""
    return f"{frame // CHUNK * CHUNK:06d}.npz"


def encode_depth(depth: NDArray[np.floating]) -> Words:
    """Depth (H, W) in mm, 0 where nothing is seen, as steps of `DEPTH_STEP`.

    Raises
    ------
    ParameterError
        If something is farther away than 16 bits can say.
    """
    steps = np.rint(np.asarray(depth, np.float64) / DEPTH_STEP)
    if steps.size and steps.max() > 65_535:
        raise ParameterError(
            f"a depth of {depth.max():.0f} mm does not fit 16 bits",
            f"place the head within {65_535 * DEPTH_STEP:.0f} mm of the camera",
        )
    return steps.astype(np.uint16)


def decode_depth(steps: Words) -> NDArray[np.float32]:
    """Depth (H, W), mm, of what `encode_depth` made."""
    return np.asarray(steps * np.float32(DEPTH_STEP), np.float32)


def encode_normals(normals: NDArray[np.floating], seen: NDArray[np.bool_]) -> Words:
    """Unit normals (H, W, 3), camera frame, as (n + 1) / 2 * 65534 + 1; 0 where not `seen`."""
    values = np.rint((np.clip(normals, -1, 1) + 1) / 2 * NORMAL_SCALE + 1)
    return np.where(seen[..., None], values, 0).astype(np.uint16)


def decode_normals(words: Words) -> NDArray[np.float32]:
    """Normals (H, W, 3), camera frame, of what `encode_normals` made; zero where nothing is."""
    values = (words.astype(np.float32) - 1) * np.float32(2 / NORMAL_SCALE) - 1
    return np.where(words.any(axis=2, keepdims=True), values, 0).astype(np.float32)


def encode_flow(flow: NDArray[np.floating], valid: NDArray[np.bool_]) -> Words:
    """Displacements (H, W, 2) in px as KITTI 2015 stores them: u * 64 + 2^15, v * 64 + 2^15, valid.

    All three are 0 where it is not `valid` or farther than `FLOW_REACH`. Source: the development
    kit of the KITTI flow benchmark (Menze & Geiger, CVPR 2015).
    """
    within = valid & (np.abs(flow) <= FLOW_REACH).all(axis=2)
    out = np.zeros((*flow.shape[:2], 3), np.uint16)
    out[within, :2] = np.rint(flow[within] * FLOW_SCALE + FLOW_ZERO).astype(np.uint16)
    out[..., 2] = within
    return out


def decode_flow(words: Words) -> tuple[NDArray[np.float32], NDArray[np.bool_]]:
    """Displacements (H, W, 2), px, 0 where not valid, and where they are valid (H, W)."""
    valid = words[..., 2] > 0
    flow = (words[..., :2].astype(np.float32) - FLOW_ZERO) / np.float32(FLOW_SCALE)
    return np.where(valid[..., None], flow, 0).astype(np.float32), valid
