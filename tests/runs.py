"""A tracker's setting and its results without any video, and small videos that are wrong."""

from __future__ import annotations

import resource
import struct
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from fractions import Fraction
from functools import cache
from pathlib import Path
from types import SimpleNamespace
from unittest.mock import patch

import av
import numpy as np

from abs_engine.core.camera import Camera
from abs_engine.core.geometry import FACING, Pose
from abs_engine.face.head import MouthModel
from abs_engine.face.held_head import held_head
from abs_engine.io.assets import load_speaker, shipped
from abs_engine.io.video import VideoWriter
from abs_engine.render.cpu import CpuRenderer
from abs_engine.tracking.frame.clip_setting import ClipSetting, FrameResult
from abs_engine.tracking.runs.recorder import Recorder
from abs_engine.tracking.start.blob_start import mouth_model

SIZE = 320, 240


@cache
def toy_model() -> MouthModel:
    """The average head."""
    return mouth_model(load_speaker(), None)


@cache
def toy_setting() -> ClipSetting:
    """The average head before a calibrated camera; nothing follows it and nothing is compared."""
    face = held_head(toy_model(), np.zeros(toy_model().n_person))
    nothing = SimpleNamespace()
    return ClipSetting(face, Camera.ideal(SIZE), CpuRenderer(), 25.0, nothing, nothing)


def toy_result(index: int, prototype: int = 0) -> FrameResult:
    """A frame in which the head looks into the camera in one of the model's postures."""
    vector = np.r_[np.zeros(6), toy_model().prototypes[prototype]]
    lips, width, aperture = toy_setting().face.measures(vector[6:])
    pose = Pose(FACING, [0.0, 40.0, 700.0])
    return FrameResult(
        index, True, vector, pose, lips, width, aperture, 12.5, 0.9, 321, "converged"
    )


def lost_result(index: int) -> FrameResult:
    """A frame without a face."""
    vector, lips = (np.full(a.shape, np.nan) for a in (toy_result(0).vector, toy_result(0).lips))
    nan = float("nan")
    return FrameResult(index, False, vector, None, lips, nan, nan, nan, nan, 0, "face not found")


def written_run(folder: Path, postures: Sequence[int | None]) -> Path:
    """A run as `track` writes it, but for pictures; None stands for a lost frame."""
    folder.mkdir()
    recorder = Recorder(toy_setting())
    for index, posture in enumerate(postures):
        recorder.add(lost_result(index) if posture is None else toy_result(index, posture))
    recorder.record().write(folder, {})
    return folder


def noise(frames: int, size: tuple[int, int] = (96, 80), seed: int = 0) -> list[np.ndarray]:
    """Pictures without a face."""
    rng = np.random.default_rng(seed)
    return [rng.integers(0, 256, (size[1], size[0], 3), np.uint8) for _ in range(frames)]


def write_noise(path: Path, frames: int = 4) -> Path:
    """A video without a face."""
    with VideoWriter(path, (96, 80), 25.0) as writer:
        for picture in noise(frames):
            writer.write(picture)
    return path


def write_broken(path: Path, frames: int = 20) -> Path:
    """A video whose index says more than there is, as after a download that broke off."""
    whole = path.with_suffix(".whole.mp4")
    with av.open(str(whole), "w", options={"movflags": "faststart"}) as container:
        stream = container.add_stream("libx264", rate=Fraction(25))
        stream.width, stream.height, stream.pix_fmt = 96, 80, "yuv420p"
        for picture in noise(frames):
            container.mux(stream.encode(av.VideoFrame.from_ndarray(picture, format="rgb24")))
        container.mux(stream.encode())
    content = whole.read_bytes()
    whole.unlink()
    path.write_bytes(content[: len(content) * 6 // 10])
    return path


def drift(frames: int) -> list[np.ndarray]:
    """Smooth pictures (80, 96, 3) that move a little, with fresh grain."""
    rng = np.random.default_rng(0)
    y, x = np.mgrid[:80, :96]
    return [
        np.uint8(
            np.clip(
                128
                + 80 * np.sin((x + 2 * k) / 9 + np.arange(3)[:, None, None]) * np.cos(y / 7)
                + rng.normal(0, 8, (3, 80, 96)),
                0,
                255,
            )
        ).transpose(1, 2, 0)
        for k in range(frames)
    ]


def write_kind(
    path: Path,
    codec: str,
    pictures: list[np.ndarray],
    *,
    pixels: str = "yuv420p",
    gop: int | None = None,
    stamps: list[int] | None = None,
    rate: int = 25,
) -> Path:
    """A video in the container that the suffix names; `stamps` are in milliseconds."""
    faststart = {"movflags": "faststart"} if path.suffix in (".mp4", ".mov") else {}
    with av.open(str(path), "w", options=faststart) as container:
        stream = container.add_stream(codec, rate=Fraction(rate))
        stream.height, stream.width = pictures[0].shape[:2]
        stream.pix_fmt = "yuvj420p" if codec == "mjpeg" else pixels
        if codec == "libx264":  # with several threads it writes other bytes each time
            stream.options = {"x264-params": "threads=1:lookahead-threads=1:asm=sse4.2"}
        if gop is not None:
            stream.codec_context.gop_size = gop
        if stamps is not None:
            stream.codec_context.time_base = Fraction(1, 1000)
        for k, picture in enumerate(pictures):
            frame = av.VideoFrame.from_ndarray(np.ascontiguousarray(picture), format="rgb24")
            if stamps is not None:
                frame.pts, frame.time_base = stamps[k], Fraction(1, 1000)
            container.mux(stream.encode(frame))
        container.mux(stream.encode())
    return path


def write_speaker(path: Path, **changes: object) -> Path:
    """The bundled head with some arrays changed."""
    with np.load(shipped("speaker/head.npz")) as archive:
        arrays = {name: archive[name] for name in archive.files}
    np.savez(path, **(arrays | changes))
    return path


@contextmanager
def full(size: int) -> Iterator[None]:
    """No file can be longer than so many bytes, as on a disk with that much space left.

    Meanwhile Python keeps no bytecode: it would be cut short, and read like that later.
    """
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, before[1]))
    try:
        with patch.object(sys, "dont_write_bytecode", True):
            yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)


def turned(path: Path, matrix: tuple[float, float, float, float]) -> Path:
    """An MP4 with another a, b, c, d in its track header's matrix, see ISO/IEC 14496-12, 8.3.2."""
    content = bytearray(path.read_bytes())
    at = content.index(b"tkhd") + 4 + 40
    for place, value in zip((0, 1, 3, 4), matrix, strict=True):
        struct.pack_into(">i", content, at + 4 * place, round(value * 65536))
    path.write_bytes(content)
    return path


def rewrite(run: Path, without: str = "", **arrays: np.ndarray) -> None:
    """Write the results of a run again without one of its arrays, or with others."""
    with np.load(run / "results.npz") as data:
        kept = {name: data[name] for name in data.files if name != without}
    np.savez(run / "results.npz", **(kept | arrays))
