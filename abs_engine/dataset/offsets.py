"""Vertex offsets of a clip, in files of `CHUNK` frames that are read when they are wanted."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.kinds import checked_frame
from abs_engine.dataset.codec import CHUNK, OFFSETS_FORMAT, VERSION, VERTICES, chunk_name
from abs_engine.dataset.picture import AGAIN
from abs_engine.io.arrays import real
from abs_engine.io.npz import read_npz

Offset = NDArray[np.float16]
_KEPT = 3


class StoredOffsets:
    """Offsets in a folder; only the last few files that were read are kept in memory.

    Parameters
    ----------
    folder : Path
        That of the clip.
    frames, vertices : int
        How many there must be.
    """

    def __init__(self, folder: Path, frames: int, vertices: int) -> None:
        self._folder, self._frames, self._vertices = folder / VERTICES, frames, vertices
        self._kept: Mapping[str, Offset] = {}

    def __len__(self) -> int:
        """Return the number of frames."""
        return self._frames

    def __getitem__(self, frame: int) -> Offset:
        """Offsets (V, 3) float16, mm, of a frame.

        Raises
        ------
        ParameterError
            If there is no such frame.
        InputFileError
            If its file is missing or broken.
        ModelFormatError
            If its file is of other frames or of another mesh.
        """
        frame = checked_frame(frame, self._frames)
        name = chunk_name(frame)
        kept = self._kept  # is replaced, never changed, as threads may share it
        chunk = kept[name] if name in kept else self._read(name, frame // CHUNK * CHUNK)
        others = [item for item in kept.items() if item[0] != name]
        self._kept = dict([*others[1 - _KEPT :], (name, chunk)])
        return np.asarray(chunk[frame % CHUNK])

    def _read(self, name: str, first: int) -> Offset:
        path = self._folder / name
        frames = min(CHUNK, self._frames - first)
        layout = {"offsets": real(frames, self._vertices, 3, dtype=np.float16)}
        return read_npz(path, OFFSETS_FORMAT, VERSION, layout, AGAIN)["offsets"]
