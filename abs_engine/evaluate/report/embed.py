"""Arrays and files as text inside of an HTML page."""

from __future__ import annotations

import base64
import json
from typing import Any

import numpy as np
from numpy.typing import NDArray

from abs_engine.evaluate.report.motion import LinearMotion

_KINDS = {"float32": "f4", "int16": "i2", "uint8": "u1", "uint16": "u2", "uint32": "u4"}


def packed(array: NDArray[Any]) -> dict[str, Any]:
    """An array as JSON: its kind, its shape, and its little-endian bytes in base64."""
    kind = np.dtype(array.dtype).name
    plain = np.ascontiguousarray(array, np.dtype(array.dtype).newbyteorder("<"))
    return {"kind": _KINDS[kind], "shape": list(array.shape), "data": text64(plain.tobytes())}


def text64(content: bytes) -> str:
    """Bytes in base64."""
    return base64.b64encode(content).decode("ascii")


def data_url(content: bytes, kind: str) -> str:
    """A file as an address that holds it."""
    return f"data:{kind};base64,{text64(content)}"


def script_json(value: Any) -> str:
    """JSON that may stand inside of a script element."""
    text = json.dumps(value, allow_nan=False, separators=(",", ":"))
    return text.replace("<", "\\u003c").replace("\u2028", "\\u2028").replace("\u2029", "\\u2029")


def packed_motion(motion: LinearMotion) -> dict[str, Any]:
    """A motion as JSON; modes in 16 bits, each with a scale of its own in the weights."""
    reach = np.abs(motion.modes).max(axis=(1, 2), initial=0)
    scale = np.where(reach > 0, reach / 32767, 1.0)
    steps = np.rint(motion.modes / scale[:, None, None]).astype(np.int16)
    weights = motion.weights * scale
    lost = np.asarray(~np.isfinite(motion.weights).all(axis=1))
    return {
        "mean": packed(motion.mean.astype(np.float32)),
        "modes": packed(steps),
        "weights": packed(np.nan_to_num(weights).astype(np.float32)),
        "lost": packed(lost.astype(np.uint8)),
    }
