"""Arrays and files as text inside of an HTML page, deflated; ``web/arrays.js`` reads them."""

from __future__ import annotations

import base64
import json
import zlib
from typing import Any

import numpy as np
from numpy.typing import NDArray

from abs_engine.tracking.results.run_mesh import LinearSurface

FINE_MM = 0.004
"""Steps of a mode's vertices, as far as its weights move them; ten modes are wrong by 0.02 mm."""

LOST = -32768
"""What stands for NaN among numbers of 16 bits."""

_MOST = 32767
_KINDS = {"float32": "f4", "int16": "i2", "uint8": "u1", "uint16": "u2", "uint32": "u4"}


class Store:
    """Collects the arrays of a page, each once.

    The bytes of an array are those of its numbers, little-endian, first the lowest byte of every
    number, then the second of every number, and so on: so they deflate better.
    """

    def __init__(self) -> None:
        self._bytes = bytearray()
        self._places: dict[bytes, int] = {}

    def add(self, array: NDArray[Any], row: int = 0) -> dict[str, Any]:
        """Keep an array of whole numbers or of float32.

        Parameters
        ----------
        row : int
            Keep the difference to the number `row` places before, modulo the kind's range; whole
            numbers only, 0 for none.

        Returns
        -------
        dict
            Where and how it lies, as JSON: `kind`, `shape`, `at`, `row`, `step`.
        """
        kind = np.dtype(array.dtype)
        flat = np.ascontiguousarray(array, kind.newbyteorder("<")).ravel()
        if row:
            flat = flat.copy()
            flat[row:] -= flat[:-row].copy()
        planes = flat.view(np.uint8).reshape(-1, kind.itemsize).T.tobytes()
        at = self._places.setdefault(planes, len(self._bytes))
        if at == len(self._bytes):
            self._bytes += planes
        shape = list(array.shape)
        return {"kind": _KINDS[kind.name], "shape": shape, "at": at, "row": row, "step": None}

    def add_steps(self, values: NDArray[np.floating[Any]], row: int) -> dict[str, Any]:
        """Keep numbers as 65,535 even steps, by rows as in `add`; NaN for what is not finite."""
        known = np.isfinite(values)
        reach = float(np.abs(values[known]).max(initial=0))
        step = reach / _MOST if reach > 0 else 1.0
        steps = np.rint(np.where(known, values, 0) / step)
        told = self.add(np.where(known, steps, LOST).astype(np.int16), row)
        return told | {"step": step}

    def add_motion(self, motion: LinearSurface) -> dict[str, Any]:
        """Keep a motion; modes in steps of their own, whose sizes are in the weights."""
        lost = np.asarray(~np.isfinite(motion.weights).all(axis=1))
        weights = np.nan_to_num(motion.weights.astype(np.float64))
        reach = np.abs(motion.modes).max(axis=(1, 2), initial=0)
        used = np.maximum(np.abs(weights).max(axis=0, initial=0), 1e-9)
        step = np.maximum(reach / _MOST, FINE_MM / used)
        steps = np.rint(motion.modes / step[:, None, None]).astype(np.int16)
        return {
            "mean": self.add_steps(motion.mean, 3),
            "modes": self.add(steps, 3),
            "weights": self.add((weights * step).astype(np.float32)),
            "lost": self.add(lost.astype(np.uint8)),
        }

    @property
    def content(self) -> bytes:
        """All that was kept."""
        return bytes(self._bytes)


def deflated(content: bytes) -> str:
    """Bytes, deflated (zlib), in base64."""
    return text64(zlib.compress(content, 9))


def text64(content: bytes) -> str:
    """Bytes in base64."""
    return base64.b64encode(content).decode("ascii")


def json_bytes(value: Any) -> bytes:
    """JSON without spaces, and without NaN, which no browser reads."""
    return json.dumps(value, allow_nan=False, separators=(",", ":")).encode("utf-8")
