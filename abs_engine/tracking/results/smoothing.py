"""Smoothing of a run's curves, where it is asked for: two standard filters of SciPy, by name."""

from __future__ import annotations

import csv
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.arrays import BoolArray, FloatArray
from abs_engine.core.errors import ParameterError
from abs_engine.core.kinds import TEXT, check_kind
from abs_engine.core.registry import nearest
from abs_engine.io.inputs import to_number
from abs_engine.tracking.frame.frame_times import evenly_spaced
from abs_engine.tracking.results.measures import ANGLES, LIPS, cuts, velocities
from abs_engine.tracking.results.run_table import written

SMOOTHED = "smoothed.csv"
BUTTERWORTH, SAVITZKY_GOLAY = "butterworth", "savitzky-golay"
_ORDER, _DEGREE = 2, 2
_SIZES = ("width", "aperture", "protrusion", *LIPS, "jaw_opening")
_NEVER_BELOW_0 = ("width", "aperture", "opening_area", "lip_area")


@dataclass(frozen=True)
class Smoothing:
    """A filter without delay for curves of evenly spaced frames.

    Parameters
    ----------
    name : str
        "butterworth": a low pass of second order that runs forwards and backwards
        (`scipy.signal.sosfiltfilt`), so that half of the amplitude is left at the cutoff.
        "savitzky-golay": a parabola fitted to a window around each frame
        (`scipy.signal.savgol_filter`).
    amount : float
        The cutoff, Hz; the window, frames.
    """

    name: str
    amount: float

    @classmethod
    def named(cls, text: str) -> Smoothing:
        """A filter as it is typed, such as "butterworth:8" or "savitzky-golay:7".

        Raises
        ------
        ParameterError
            If there is no such filter.
        """
        check_kind("smooth", text, TEXT)
        name, _, given = text.partition(":")
        if name not in (BUTTERWORTH, SAVITZKY_GOLAY):
            raise ParameterError(
                f"there is no filter '{name}'",
                f"{nearest(name, (BUTTERWORTH, SAVITZKY_GOLAY))}; write, for example, "
                f"{BUTTERWORTH}:8",
            )
        try:
            amount = to_number(given)
        except ValueError:
            amount = 0.0
        window = name == SAVITZKY_GOLAY
        if amount <= 0 or (window and (amount % 2 != 1 or amount <= _DEGREE + 1)):
            what = "an odd number of frames, 5 or more" if window else "a frequency in Hz"
            raise ParameterError(
                f"'{text}' must give {what}", f"write, for example, {name}:{_DEGREE + 5}"
            )
        return cls(name, amount)

    def __str__(self) -> str:
        return f"{self.name}:{self.amount:g}"

    def told(self) -> dict[str, Any]:
        """Its settings, as JSON values."""
        if self.name == BUTTERWORTH:
            return {"filter": self.name, "cutoff_hz": self.amount, "order": _ORDER,
                    "passes": "forwards and backwards"}  # fmt: skip
        return {"filter": self.name, "window_frames": int(self.amount), "degree": _DEGREE}

    @classmethod
    def of_told(cls, told: Mapping[str, Any]) -> Smoothing:
        """The filter whose settings these are."""
        amount = told["cutoff_hz" if told["filter"] == BUTTERWORTH else "window_frames"]
        return cls.named(f"{told['filter']}:{amount}")

    def check(self, rate: float, times: FloatArray) -> None:
        """Raise `ParameterError` where it cannot be used, for frames (T,) shown at `times`, s."""
        if not evenly_spaced(times, rate):
            raise ParameterError(
                "the frames are not evenly spaced in time, as the filters need",
                "leave out --smooth, or convert the video to a constant rate",
            )
        if self.name == BUTTERWORTH and self.amount >= rate / 2:
            raise ParameterError(
                f"frames at {rate:g} Hz hold nothing above {rate / 2:g} Hz",
                "give a lower cutoff, or leave out --smooth",
            )
        least = self._filter(rate)[1]
        if 0 < len(times) < least:
            narrower = self.name == SAVITZKY_GOLAY and len(times) > _DEGREE + 2
            fits = "a shorter window" if narrower else "a longer run"
            raise ParameterError(
                f"{self} needs {least} frames in a row, and there are {len(times)}",
                f"give {fits}, or leave out --smooth",
            )
        if self.name == BUTTERWORTH and 0 < self.amount * len(times) < rate:
            raise ParameterError(
                f"{self} keeps only waves longer than the clip's {len(times) / rate:.1f} s",
                "give a higher cutoff, or leave out --smooth",
            )

    def __call__(
        self, curve: FloatArray, rate: float, cut: BoolArray, turn: float | None = None
    ) -> FloatArray:
        """A curve (T,) or curves (T, K) at `rate` frames a second, smoothed.

        Each stretch of frames with numbers, of one shot (`cut`, (T,), begins another), by itself;
        one too short to be filtered stays. Angles jump by a whole `turn`.
        """
        out = np.array(curve, np.float64)
        run, least = self._filter(rate)
        known = np.atleast_1d(np.isfinite(out).all(axis=tuple(range(1, out.ndim))))
        edges = np.flatnonzero((cut | (known != np.roll(known, 1)))[1:]) + 1
        ends = np.r_[0, edges, len(out)]
        for first, end in pairwise(ends.tolist()):
            if known[first:end].all() and end - first >= least:
                part = out[first:end]
                out[first:end] = run(part if turn is None else np.unwrap(part, period=turn, axis=0))
        return out if turn is None else out - turn * np.round(out / turn)

    def _filter(self, rate: float) -> tuple[Callable[[FloatArray], FloatArray], int]:
        """The filter of (N, ...), and the least N."""
        # Takes a while to import, and few runs are smoothed
        from scipy.signal import butter, savgol_filter, sosfiltfilt

        if self.name == SAVITZKY_GOLAY:
            window = int(self.amount)
            return (lambda x: savgol_filter(x, window, _DEGREE, axis=0)), window
        sections = butter(_ORDER, self.amount, fs=rate, output="sos")
        least = 3 * (2 * len(sections) + 1) + 1  # more than SciPy extends each end by
        return (lambda x: sosfiltfilt(sections, x, axis=0)), least

    def measures(self, arrays: Mapping[str, NDArray[Any]]) -> dict[str, FloatArray]:
        """The measures of a run, (T,) each, smoothed; velocities are those of smoothed curves."""
        rate, time = float(arrays["rate"]), np.asarray(arrays["time"], np.float64)
        cut, turns = cuts(arrays), dict.fromkeys(_SIZES) | dict.fromkeys(ANGLES, 360.0)
        out = {k: self(arrays[k], rate, cut, turn) for k, turn in turns.items() if k in arrays}
        for name in _NEVER_BELOW_0:
            if name in out:
                out[name] = out[name].clip(min=0.0)
        return out | velocities(out, time, cut)


def write_smoothed(
    folder: Path, arrays: Mapping[str, NDArray[Any]], found: Mapping[str, FloatArray]
) -> None:
    """Write ``smoothed.csv`` into a run's folder: measures as `Smoothing.measures` gives them."""
    rows = zip(arrays["index"].tolist(), arrays["time"].tolist(),
               *(curve.tolist() for curve in found.values()), strict=True)  # fmt: skip
    with (folder / SMOOTHED).open("w", encoding="utf-8", newline="") as file:
        csv.writer(file).writerows(written([["index", "time", *found], *rows]))
