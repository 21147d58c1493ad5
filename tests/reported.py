"""A dataset with a film whose grey tells the frame, and runs with known errors."""

from __future__ import annotations

import base64
import json
import re
import zlib
from functools import cache
from pathlib import Path

import numpy as np
from results import clip, run_arrays, speaker, surface, true_landmarks, wide_rows, write_csv
from results import write_dataset as write_plain
from results import write_run as write_perfect

from abs_engine.dataset import Truth, write_sums
from abs_engine.io.video import VideoWriter
from abs_engine.tracking.results.run_mesh import RunMesh

FRAMES = 30
SHIFT_MM = 2.0
LOST = 7
PAUSED, PAUSE = 12, 0.5
GREY, GREY_STEP = 20, 7


@cache
def truth() -> Truth:
    return clip(FRAMES)


def write_film(path: Path, frames: int = FRAMES) -> Path:
    """Frame k is of one grey, GREY + GREY_STEP k."""
    width, height = truth().camera.size
    with VideoWriter(path, (width, height), truth().rate) as video:
        for k in range(frames):
            video.write(np.full((height, width, 3), GREY + GREY_STEP * k, np.uint8))
    return path


def write_dataset(folder: Path) -> Path:
    """The clip, with phonemes: /m/ for half a second, then /a/."""
    write_plain(folder, truth())
    write_film(folder / "clip/camera/video.mp4")
    file = folder / "clip/truth.npz"
    with np.load(file) as archive:
        arrays = dict(archive)
    said = np.array(["m"] * 12 + ["a"] * (FRAMES - 12))
    arrays |= {"phonemes": said, "phoneme_label": np.array(["m", "a"])}
    arrays |= {"phoneme_start": np.array([0, 0.48]), "phoneme_end": np.array([0.48, 1.2])}
    np.savez(file, **arrays)
    write_sums(folder)
    return folder


def write_shifted(folder: Path) -> Path:
    """A run that is SHIFT_MM too far to the left, everywhere, and has lost a frame."""
    arrays = run_arrays(truth())
    points = arrays["lip_points"] + [SHIFT_MM, 0, 0]
    points[LOST] = np.nan
    found = np.arange(FRAMES) != LOST
    changed = {"lip_points": points, "found": found}
    for key in ("rotation", "translation", "aperture", "width"):
        changed[key] = np.where(
            found.reshape(-1, *[1] * (arrays[key].ndim - 1)), arrays[key], np.nan
        )
    return _write(folder, changed, found)


def write_exact(folder: Path) -> Path:
    """A run that found the truth."""
    return _write(folder, {}, np.ones(FRAMES, bool), shift=0.0)


def write_uneven(folder: Path) -> Path:
    """A run of a video that begins at 2 s and stands still for half a second in its middle."""
    time = 2 + np.arange(FRAMES) / truth().rate + np.where(np.arange(FRAMES) < PAUSED, 0, PAUSE)
    return _write(folder, {"time": time}, np.ones(FRAMES, bool), shift=0.0)


def _write(folder: Path, changed: dict, found: np.ndarray, shift: float = SHIFT_MM) -> Path:
    camera = truth().camera
    write_perfect(
        folder, truth(), camera_matrix=camera.matrix, camera_distortion=camera.distortion,
        camera_size=np.array(camera.size), rate=truth().rate, **changed,
    )  # fmt: skip
    shape = surface(truth())
    used = np.flatnonzero(np.abs(shape.weights).max(axis=0) > 0)
    weights = np.where(found[:, None], shape.weights[:, used], np.nan)
    mean = (shape.mean + np.array([shift, 0, 0])).astype(np.float32)
    RunMesh(mean, shape.modes[used].astype(np.float32), weights, speaker().faces).save(folder)
    told = {"engine_version": "9.9.9", "renderer": "a renderer", "settings": {"video": "film.mp4"}}
    (folder / "run.json").write_text(json.dumps(told))
    return folder


def write_landmarks(path: Path) -> Path:
    """Another system's exact 68 landmarks, without a mesh."""
    heading, rows = wide_rows(truth(), *true_landmarks(truth()))
    return write_csv(path, heading, rows)


def part_of(page: str, name: str) -> bytes:
    """What an element of a page holds deflated."""
    found = re.search(f'<script type="text/plain" id="{name}">(.*?)</script>', page)
    return zlib.decompress(base64.b64decode(found[1]))


def told_by(page: str) -> dict:
    """What a page tells its scripts."""
    return json.loads(part_of(page, "data"))


def unpacked(told: dict, store: bytes) -> np.ndarray:
    """An array that a page holds, as ``web/arrays.js`` reads it."""
    kind = np.dtype({"f4": "<f4", "i2": "<i2", "u1": "u1", "u2": "<u2", "u4": "<u4"}[told["kind"]])
    count = int(np.prod(told["shape"]))
    planes = np.frombuffer(store, np.uint8, count * kind.itemsize, told["at"])
    flat = planes.reshape(kind.itemsize, count).T.copy().view(kind).ravel()
    if told["row"]:
        for column in range(told["row"]):
            flat[column :: told["row"]] = np.cumsum(flat[column :: told["row"]], dtype=kind)
    if told["step"] is None:
        return flat.reshape(told["shape"])
    return np.where(flat == -32768, np.nan, flat * told["step"]).reshape(told["shape"])
