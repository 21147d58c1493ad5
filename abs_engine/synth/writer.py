"""Writes a clip and its ground truth; the folder appears when it is complete."""

from __future__ import annotations

import hashlib
from pathlib import Path
from types import TracebackType
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from abs_engine.camera import Camera
from abs_engine.files import NewFolder, unwritable
from abs_engine.truth import DEPTH_STEP, FORMAT, SUMS, VERSION, camera_json
from abs_engine.video import VideoWriter

_CRF = 16


class TakeWriter:
    """A folder in the making: frames are added, then `finish` names it.

    Leaving the context without `finish` removes what was written.

    Parameters
    ----------
    folder : Path
        Must not exist.
    camera : Camera
    rate : float
        Frames per second.
    lossless : bool
        Also write ``lossless.mp4`` (H.264 RGB without loss).

    Raises
    ------
    OutputError
        If the folder exists or its parent cannot be written.
    """

    def __init__(self, folder: Path, camera: Camera, rate: float, *, lossless: bool) -> None:
        self._folder, self._made = Path(folder), NewFolder(folder)
        self._work = self._made.work
        for kind in ("ids", "depth"):
            (self._work / kind).mkdir()
        (self._work / "camera.json").write_text(camera_json(camera), encoding="utf-8")
        names = {"video.mp4": _CRF, **({"lossless.mp4": 0} if lossless else {})}
        self._videos = [
            VideoWriter(self._work / name, camera.size, rate, crf) for name, crf in names.items()
        ]
        self._frames = 0

    def add(
        self,
        picture: NDArray[np.uint8],
        ids: NDArray[np.uint32],
        depth: NDArray[np.float32],
    ) -> None:
        """Append a frame: picture (H, W, 3), facet ids + 1 (H, W), depth (H, W) in mm."""
        steps = np.rint(depth / DEPTH_STEP)
        for kind, values in (("ids", ids), ("depth", np.minimum(steps, 65535))):
            path = self._work / kind / f"{self._frames:06d}.png"
            fast = [cv2.IMWRITE_PNG_COMPRESSION, 1]
            if not cv2.imwrite(str(path), values.astype(np.uint16), fast):
                raise unwritable(self._folder, OSError())
        try:
            for video in self._videos:
                video.write(picture)
        except OSError as error:  # PyAV's errors are among them
            raise unwritable(self._folder, error) from error
        self._frames += 1

    def finish(self, **arrays: object) -> None:
        """Write ``truth.npz`` and the checksums, and give the folder its name.

        Raises
        ------
        OutputError
            If that fails, or somebody made the folder in the meantime.
        """
        try:
            for video in self._videos:
                video.close()
            values: dict[str, Any] = {"format": FORMAT, "version": VERSION, **arrays}
            np.savez_compressed(self._work / "truth.npz", **values)
            self._sign()
        except OSError as error:
            raise unwritable(self._folder, error) from error
        self._made.finish()

    def _sign(self) -> None:
        paths = sorted(p for p in self._work.rglob("*") if p.is_file())
        lines = [
            f"{hashlib.sha256(p.read_bytes()).hexdigest()}  {p.relative_to(self._work)}\n"
            for p in paths
        ]
        (self._work / SUMS).write_text("".join(lines), encoding="utf-8")

    def __enter__(self) -> TakeWriter:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._made.discard()
