"""The frames of a clip that are tracked, kept one by one, so that a killed run loses none.

A line for each frame: a checksum, then what was found and what is carried on to the next frame,
as JSON, its numbers bit by bit. The first line says what all of them follow from.
A line that was cut off, and what comes after it, does not count.
"""

from __future__ import annotations

import fcntl
import hashlib
import json
import os
import time
import zlib
from base64 import b64decode, b64encode
from collections.abc import Iterator, Mapping
from dataclasses import fields, is_dataclass, replace
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np

from abs_engine.core.errors import AbsEngineError
from abs_engine.core.geometry import Pose
from abs_engine.fit.belief import Belief
from abs_engine.optimise.base import Solution
from abs_engine.tracking.frame.clip_setting import FrameResult
from abs_engine.tracking.frame.frame_state import Memory

FRAMES = "frames.journal"
FORMAT, VERSION = "abs_engine.frames", 1
_INTERVAL = 1.0  # seconds after which lines are forced to the disk: a kill spares them anyway
Found = tuple[FrameResult, Memory]


class FrameJournal:
    """The frames that were done before, then those that are done now; a context manager.

    It waits for another process that still writes to it.

    Parameters
    ----------
    path : Path
        Its folder is made if need be.
    basis : str
        What the frames follow from: those that follow from something else are forgotten.
    ends : bool
        Whether the end of each frame's search (`FrameResult.highest`) is kept, too, without its
        trace.

    Attributes
    ----------
    resumed : int
        Number of frames that were done before.
    """

    def __init__(self, path: Path, basis: str, ends: bool = False) -> None:
        heading = {"format": FORMAT, "version": VERSION, "basis": basis}
        path.parent.mkdir(parents=True, exist_ok=True)
        self._file, self._ends = path.open("ab", buffering=0), ends
        self._synced = time.monotonic()
        try:
            fcntl.flock(self._file, fcntl.LOCK_EX)
            self.resumed, end = _known(path, heading)
            self._file.truncate(end)
            if end == 0:
                self._write(heading)
        except BaseException:
            self._file.close()  # else the next one would wait for it
            raise
        self._earlier = islice(_lines(path), 1, 1 + self.resumed)

    def earlier(self) -> Found | None:
        """The next frame of those that were done before; None after the last of them."""
        line = next(self._earlier, None)
        return None if line is None else _found(line[0])

    def add(self, result: FrameResult, memory: Memory) -> None:
        """Keep the next frame.

        Raises
        ------
        OSError
            If it cannot be written.
        """
        end = result.highest if self._ends else None
        if end is not None:
            end = replace(end, trace=np.zeros(0), information=None)
        self._write({"result": replace(result, highest=end), "memory": memory})

    def _write(self, told: dict[str, Any]) -> None:
        text = json.dumps(told, default=_plain).encode()
        line = memoryview(b"%08x %s\n" % (zlib.crc32(text), text))
        while line:
            line = line[self._file.write(line) :]
        if time.monotonic() - self._synced > _INTERVAL:
            os.fdatasync(self._file.fileno())
            self._synced = time.monotonic()

    def __enter__(self) -> FrameJournal:
        return self

    def __exit__(self, *_: object) -> None:
        self._file.close()


def _known(path: Path, heading: Mapping[str, Any]) -> tuple[int, int]:
    """Number of frames that a file holds, and of the bytes that they take with their heading.

    None, where it has another heading, or a frame makes no sense: it is begun anew.
    """
    lines, count = _lines(path), 0
    first, end = next(lines, (None, 0))
    if first != heading:
        return 0, 0
    try:
        for told, size in lines:
            _found(told)
            count, end = count + 1, end + size
    except (LookupError, TypeError, ValueError, AttributeError, AbsEngineError):
        return 0, 0
    return count, end


def _lines(path: Path) -> Iterator[tuple[dict[str, Any], int]]:
    """Content of each of a file's whole lines, and the number of bytes that it takes."""
    with path.open("rb") as file:
        for line in file:
            checksum, _, text = line.rstrip(b"\n").partition(b" ")
            if not line.endswith(b"\n") or checksum != b"%08x" % zlib.crc32(text):
                return
            try:
                yield json.loads(text, object_hook=_whole), len(line)
            except (ValueError, TypeError, RecursionError):
                return


def _plain(value: Any) -> Any:
    """Conversion of arrays, NumPy's numbers and values of several fields for JSON."""
    if isinstance(value, np.ndarray):
        text = b64encode(np.ascontiguousarray(value).tobytes()).decode()
        return {"dtype": value.dtype.str, "shape": value.shape, "base64": text}
    if isinstance(value, np.generic):
        return value.item()
    if isinstance(value, Mapping):
        return dict(value)
    return {field.name: getattr(value, field.name) for field in fields(value)}


def _whole(told: dict[str, Any]) -> Any:
    """An array, where that is what is told."""
    if told.keys() == {"dtype", "shape", "base64"}:
        flat = np.frombuffer(b64decode(told["base64"]), told["dtype"])
        return flat.reshape(told["shape"]).copy()
    return told


def _found(line: Mapping[str, Any]) -> Found:
    result, memory = dict(line["result"]), dict(line["memory"])
    belief, end = result["belief"], result["highest"]
    result |= {"pose": _pose(result["pose"]), "belief": belief and Belief(**belief)}
    result |= {"highest": end and Solution(**end)}
    memory |= {"pose": _pose(memory["pose"]), "values": tuple(memory["values"])}
    return FrameResult(**result), Memory(**memory)


def _pose(told: Mapping[str, Any] | None) -> Pose | None:
    return None if told is None else Pose(**told)


def fingerprint(value: object) -> str:
    """SHA-256 of all numbers and texts in a value and in what it is made of.

    Of what is no dataclass, array, mapping, list or tuple, only the kind counts.
    """
    seen = hashlib.sha256()
    for piece in _pieces(value, {}):
        seen.update(piece)
    return seen.hexdigest()


def _pieces(value: Any, known: dict[int, int]) -> Iterator[bytes]:
    """A value as bytes; what comes again as its number."""
    if value is None or isinstance(value, (str, bytes, int, float, np.generic, Path)):
        yield f"{value!r};".encode()
        return
    if id(value) in known:
        yield f"@{known[id(value)]};".encode()
        return
    known[id(value)] = len(known)
    yield f"{type(value).__qualname__}(".encode()
    if isinstance(value, np.ndarray):
        yield f"{value.dtype.str}{value.shape}".encode()
        yield np.ascontiguousarray(value).tobytes()
    else:
        inside: list[Any] = []
        if is_dataclass(value):
            inside = [getattr(value, field.name) for field in fields(value)]
        elif isinstance(value, Mapping):
            inside = [part for item in value.items() for part in item]
        elif isinstance(value, (list, tuple)):
            inside = list(value)
        for part in inside:
            yield from _pieces(part, known)
    yield b")"
