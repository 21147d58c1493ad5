"""A tracker's setting and its results without any video, and small videos that are wrong."""

from __future__ import annotations

from fractions import Fraction
from functools import cache
from pathlib import Path
from types import SimpleNamespace

import av
import numpy as np

from abs_engine.assets import load_speaker, shipped
from abs_engine.camera import Camera
from abs_engine.geometry import FACING, Pose
from abs_engine.render.cpu import CpuRenderer
from abs_engine.systems.lips import lip_model
from abs_engine.track.tracker import FrameResult, TrackerSetting, lip_measures
from abs_engine.video import VideoWriter

SIZE = 320, 240


@cache
def toy_setting() -> TrackerSetting:
    """The average head before a calibrated camera."""
    model = lip_model(load_speaker(), None)
    person = np.zeros(model.n_person)
    calibration = SimpleNamespace(person=person)
    camera = Camera.ideal(SIZE)
    return TrackerSetting(model, model.held(person), calibration, camera, CpuRenderer(), 25.0)


def toy_result(index: int, prototype: int = 0) -> FrameResult:
    """A frame in which the head looks into the camera in one of the model's postures."""
    setting = toy_setting()
    vector = np.r_[np.zeros(6), setting.model.prototypes[prototype]]
    lips, width, aperture = lip_measures(setting.model, setting.scene, vector[6:])
    pose = Pose(FACING, [0.0, 40.0, 700.0])
    return FrameResult(
        index, True, vector, pose, lips, width, aperture, 12.5, 0.9, 321, "converged"
    )


def lost_result(index: int) -> FrameResult:
    """A frame without a face."""
    vector, lips = (np.full(a.shape, np.nan) for a in (toy_result(0).vector, toy_result(0).lips))
    nan = float("nan")
    return FrameResult(index, False, vector, None, lips, nan, nan, nan, nan, 0, "face not found")


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


def write_speaker(path: Path, **changes: object) -> Path:
    """The bundled head with some arrays changed."""
    with np.load(shipped("speaker/head.npz")) as archive:
        arrays = {name: archive[name] for name in archive.files}
    np.savez(path, **(arrays | changes))
    return path
