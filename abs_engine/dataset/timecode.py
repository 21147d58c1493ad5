"""Timecodes as cameras and phones write them: hours:minutes:seconds:frames."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.errors import InputFileError

BASES = (24, 25, 30, 48, 50, 60, 120)
"""Frames that timecodes usually count in a second."""

_BARELY = 1.002
"""Times a rate that its base may be: 29.97 frames a second are counted as 30."""
_DAY = 86400.0
_APART = 2.5
"""Usual steps between two rows, beyond which some are missing for certain. Chosen."""
_FEWEST, _EVEN = 2, 0.01
"""Numbers left out that make a rate, and how far from a whole frame steps may be. Chosen."""
_CODE = re.compile(r"\s*" + r"(\d{1,9}):" * 3 + r"(\d{1,9}(?:\.\d+)?)\s*", re.ASCII)


def seconds(
    codes: Sequence[str], path: Path, rate: float | None = None, lines: Sequence[int] | None = None
) -> NDArray[np.float64]:
    """Seconds (N,) of N timecodes ``hh:mm:ss:ff.fff`` since timecode 0; they may pass midnight.

    Parameters
    ----------
    codes : sequence of str
        Of the lines of a table, below its heading.
    path : Path
        The table, for what is said of a bad one.
    rate : float, optional
        Frames counted in a second. By default the smallest of `BASES` above the largest frame
        number; takes under a second may not show it.
    lines : sequence of int, optional
        The lines of the table that they are in; by default those from 2 on.

    Raises
    ------
    InputFileError
        If one is no timecode; its line is named.
    """
    parts = [_CODE.fullmatch(code) for code in codes]
    numbers = range(2, len(codes) + 2) if lines is None else lines
    for line, code, part in zip(numbers, codes, parts, strict=True):
        if part is None:
            raise InputFileError(
                f"line {line} of {path}: '{code}' is not a timecode",
                "write hours, minutes, seconds and frames as hh:mm:ss:ff.fff in every row",
            )
    if not parts:
        return np.zeros(0)
    fields = np.array([part.groups() for part in parts if part is not None], np.float64)
    largest = float(fields[:, 3].max())
    base = rate or next((base for base in BASES if base > largest), np.floor(largest) + 1)
    times = fields[:, :3] @ [3600.0, 60.0, 1.0] + fields[:, 3] / base
    days = np.cumsum(np.diff(times) < -_DAY / 2)
    return np.asarray(times + _DAY * np.concatenate([[0], days]))


def seconds_since_first(
    codes: Sequence[str], path: Path, rate: float | None = None
) -> NDArray[np.float64]:
    """The same since the first of them; parameters and errors as `seconds`."""
    times = seconds(codes, path, rate)
    return times - times[:1]


def steadied(times: NDArray[np.float64]) -> NDArray[np.float64]:
    """Growing times (N,) of timecodes, s, without what is rounded to whole frames of their base.

    Whoever takes 50 frames a second and counts whole ones at 60 leaves out every sixth number.
    Where numbers are left out as steadily as at one of `BASES`, that is the rate of the rows; at
    any other rate, and where one alone is left out, rows are missing.
    """
    steps = np.diff(times)
    near = steps <= _APART * np.median(steps)
    least, most = steps[near].min(initial=np.inf), steps[near].max(initial=0.0)
    if (steps[near] > 0.5 * (least + most)).sum() < _FEWEST:
        return times
    runs = np.split(times, 1 + np.flatnonzero(~near))
    even = [[run[0] + np.arange(len(run)) / rate for run in runs] for rate in BASES]
    off = [max(np.ptp(a - b) for a, b in zip(runs, e, strict=True)) for e in even]
    best = int(np.argmin(off))
    return np.concatenate(even[best]) if off[best] < (1 - _EVEN) * (most - least) else times


def timecodes(times: NDArray[np.float64], rate: float) -> list[str]:
    """Timecodes of times (N,), s, with thousandths of a frame, as Live Link Face writes them.

    They count frames at the nearest usual rate that is not above `rate`, at least 24, so that
    `seconds_since_first` recognises it; times between those frames are fractions of one.
    """
    base = base_below(rate)
    return [_timecode(round(1000 * base * float(time)), base) for time in times]


def base_below(rate: float) -> int:
    """The nearest usual number of frames in a second that is not above a rate; at least 24."""
    return max((base for base in BASES if base <= _BARELY * rate), default=BASES[0])


def _timecode(thousandths: int, base: int) -> str:
    """A timecode of thousandths of a frame."""
    frames, part = divmod(thousandths, 1000)
    seconds, frame = divmod(frames, base)
    minutes, hours = seconds // 60 % 60, seconds // 3600
    return f"{hours:02d}:{minutes:02d}:{seconds % 60:02d}:{frame:02d}.{part:03d}"
