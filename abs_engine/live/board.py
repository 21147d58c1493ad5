"""The newest event of the live page, for any number of browsers, each at its own speed."""

from __future__ import annotations

import json
import threading
from base64 import b64encode
from collections.abc import Callable
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from abs_engine.core.pose import parted
from abs_engine.live.release import Released
from abs_engine.report.drawing.colours import clay_colours
from abs_engine.report.page import welded
from abs_engine.tracking.frame.clip_setting import ClipSetting
from abs_engine.tracking.results.contours import LipDrawing

_MOST_WIDE = 640  # px; a larger picture is made smaller
_QUALITY = 80  # of JPEG
_DIGITS = 2
Event = tuple[int, bytes]
"""Its number, and a server-sent event."""


class Board:
    """Holds the newest event; what nobody looks at is never encoded."""

    def __init__(self) -> None:
        self._changed = threading.Condition()
        self._number = 0
        self._make: Callable[[], bytes] = lambda: b""
        self._shown: dict[str, Any] = {}
        self._drawing: LipDrawing | None = None

    def stage(self, text: str) -> None:
        """Say what is being done before the first result."""
        self._post(lambda: _event("stage", {"text": text}))

    def begin(self, setting: ClipSetting) -> None:
        """Say what head it is, before the first result."""
        self._drawing, self._shown = LipDrawing.of(setting), _head(setting)

    def show(self, released: Released) -> None:
        """Show a result."""
        self._post(lambda: _event("frame", self._frame(released)))

    def end(self, text: str) -> None:
        """Say that there are no more results, and why."""
        self._post(lambda: _event("end", {"text": text}))

    def head(self) -> bytes:
        """The head as JSON: `mean` + weights x `modes`; empty as long as none is known."""
        return json.dumps(self._shown).encode()

    def after(self, number: int, seconds: float) -> Event | None:
        """The newest event if it is not the one of that number; waits for so long."""
        with self._changed:
            if not self._changed.wait_for(lambda: self._number > number, seconds):
                return None
            number, make = self._number, self._make
        return number, make()

    def _post(self, make: Callable[[], bytes]) -> None:
        with self._changed:
            self._number, self._make = self._number + 1, make
            self._changed.notify_all()

    def _frame(self, released: Released) -> dict[str, Any]:
        """A line of JSON, and what is to be drawn."""
        result, image = released.result, released.shot.image
        scale = min(1.0, _MOST_WIDE / image.shape[1])
        if scale < 1:
            image = np.asarray(cv2.resize(image, None, fx=scale, fy=scale), np.uint8)
        coded = cv2.imencode(".jpg", image[..., ::-1], [cv2.IMWRITE_JPEG_QUALITY, _QUALITY])[1]
        found = [] if self._drawing is None else self._drawing.contours(result)
        contours = [
            {
                "points": np.round((points + 0.5) * scale, _DIGITS).tolist(),
                "closed": closed,
                "colour": "rgb({},{},{})".format(*colour),
            }
            for points, closed, colour in found
        ]
        weights = parted(result.vector)[1].round(4).tolist() if result.found else None
        picture = b64encode(coded.tobytes()).decode()
        return {**released.line(), "picture": picture, "contours": contours, "weights": weights}


def _head(setting: ClipSetting) -> dict[str, Any]:
    body = setting.face.body
    names = tuple(name or "" for name in body.regions)
    mean = np.asarray(body.mean, np.float32)
    arrays: dict[str, NDArray[Any]] = {
        "mean": mean,
        "modes": np.asarray(body.modes, np.float32),
        "faces": np.asarray(body.faces, np.uint32),
        "weld": welded(mean),
        "colours": clay_colours(body.faces, body.facet_class, names, len(mean)),
    }
    return {
        name: b64encode(np.ascontiguousarray(array).tobytes()).decode()
        for name, array in arrays.items()
    }


def _event(name: str, values: dict[str, Any]) -> bytes:
    return f"event: {name}\ndata: {json.dumps(values)}\n\n".encode()
