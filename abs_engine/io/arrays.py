"""The one check of arrays that are read: their kind, shape, range, and that all is finite."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import DTypeLike, NDArray

from abs_engine.core.errors import ModelFormatError
from abs_engine.io.inputs import MOST

_LONGEST_TEXT = 1 << 22
"""Characters of a list of text, each as long as the longest."""
_WORDS = {"fiu": "real numbers", "iu": "whole numbers", "b": "truth values", "U": "text"}


@dataclass(frozen=True)
class Array:
    """Requirements of an array. Use `real`, `whole`, `index`, `truth`, `text`.

    Parameters
    ----------
    kinds : str
        The kinds of number that are accepted, as NumPy's `dtype.kind` has them.
    shape : tuple of int or str
        Lengths; those of one name are the same in all arrays of a file, and not 0. A name that
        ends in ``?`` is that length or 0, one that ends in ``*`` may be 0.
    dtype : dtype
        What it is turned into.
    low, high : float or str
        The range, both ends included; a name of a length is one less than that.
    gaps : bool
        Whether NaN stands for what is not known.
    """

    kinds: str
    shape: tuple[int | str, ...]
    dtype: DTypeLike
    low: float = -MOST
    high: float | str = MOST
    gaps: bool = False
    optional: bool = False


Layout = Mapping[str, Array]
"""What a file must hold, by name; others among its arrays are left out."""


def real(*shape: int | str, dtype: DTypeLike = np.float64, **more: Any) -> Array:
    """Finite real numbers; `more` as in `Array`."""
    return Array("fiu", shape, dtype, **more)


def whole(*shape: int | str, dtype: DTypeLike = np.int64, **more: Any) -> Array:
    """Whole numbers; `more` as in `Array`."""
    return Array("iu", shape, dtype, **more)


def index(high: str | int, *shape: int | str, dtype: DTypeLike = np.int32, **more: Any) -> Array:
    """Whole numbers from 0 to `high`, or below the length of that name."""
    return Array("iu", shape, dtype, low=0, high=high, **more)


def truth(*shape: int | str, **more: Any) -> Array:
    """True or false; `more` as in `Array`."""
    return Array("b", shape, np.bool_, **more)


def text(*shape: int | str, **more: Any) -> Array:
    """Text that can be written in UTF-8; `more` as in `Array`."""
    return Array("U", shape, np.str_, **more)


def check_arrays(
    path: Path, data: Mapping[str, Any], layout: Layout, remedy: str, **lengths: int
) -> dict[str, NDArray[Any]]:
    """The arrays of a layout, each checked and of its dtype; optional ones may be missing.

    Parameters
    ----------
    path : Path
        Where they are from, for errors.
    remedy : str
        What to do if they are not as they must be.
    **lengths : int
        Those that are known already.

    Raises
    ------
    ModelFormatError
        If one is missing, or is not what it must be.
    """
    missing = [name for name, kind in layout.items() if name not in data and not kind.optional]
    if missing:
        raise ModelFormatError(f"{path} lacks {', '.join(missing)}", remedy)
    check = _Check(dict(lengths))
    there = {name: np.asarray(data[name]) for name in layout if name in data}
    for name, values in there.items():
        problem = check.shape_problem(layout[name], values)
        if problem:
            raise ModelFormatError(f"'{name}' of {path} {problem}", remedy)
    for name, values in there.items():  # only now, as ranges depend on lengths
        problem, there[name] = check.turned(layout[name], values)
        if problem:
            raise ModelFormatError(f"'{name}' of {path} {problem}", remedy)
    return there


def of_json(value: Any) -> NDArray[Any]:
    """Lists, numbers and text of a JSON file as an array; of objects where they make none."""
    loose = np.array(value, object)
    kinds = {type(one) for one in loose.ravel()}
    if kinds <= {int, float} or kinds == {bool}:
        return np.array(value)
    if kinds == {str} and loose.size * max(map(len, loose.ravel())) < _LONGEST_TEXT:
        return loose.astype(np.str_)
    return loose


def flat(parts: Mapping[str, Mapping[str, Any]]) -> dict[str, Any]:
    """The arrays of parts by one name each, that of the part and a dot before their own."""
    return {f"{part}.{name}": v for part, values in parts.items() for name, v in values.items()}


def part_of(arrays: Mapping[str, Any], name: str) -> dict[str, Any]:
    """Those of one part of what `flat` made, by their own names."""
    start = f"{name}."
    return {key.removeprefix(start): v for key, v in arrays.items() if key.startswith(start)}


def places_of(
    path: Path, names: NDArray[Any], wanted: Sequence[str], remedy: str
) -> NDArray[np.intp]:
    """Places of some names among those of a file; `ModelFormatError` if it lacks one."""
    known = {str(name): k for k, name in enumerate(names)}
    missing = [name for name in wanted if name not in known]
    if missing:
        raise ModelFormatError(f"{path} says nothing of {missing[0]}", remedy)
    return np.array([known[name] for name in wanted], np.intp)


def plain(arrays: Mapping[str, NDArray[Any]]) -> dict[str, Any]:
    """The same with single values as numbers and text, and lists of text as tuples."""
    return {
        name: v.item() if v.ndim == 0 else tuple(v.tolist()) if v.dtype.kind == "U" else v
        for name, v in arrays.items()
    }


@dataclass
class _Check:
    """Compares arrays with what they must be; `lengths` grows with each array."""

    lengths: dict[str, int]

    def shape_problem(self, wanted: Array, values: NDArray[Any]) -> str:
        """Reason why kind and shape are wrong; empty where they are not."""
        if values.size and values.dtype.kind not in wanted.kinds:
            return f"holds {values.dtype}, not {_WORDS[wanted.kinds]}"
        if values.ndim == len(wanted.shape) and all(map(self._fits, wanted.shape, values.shape)):
            return ""
        known = [self.lengths.get(str(w).rstrip("?*"), w) for w in wanted.shape]
        return f"has shape {values.shape}, not ({', '.join(map(str, known))})"

    def _fits(self, wanted: int | str, length: int) -> bool:
        if isinstance(wanted, int):
            return wanted == length
        if length == 0 and wanted.endswith("?"):
            return True
        if length == 0 and not wanted.endswith("*"):
            return False
        return self.lengths.setdefault(wanted.rstrip("?*"), length) == length

    def turned(self, wanted: Array, values: NDArray[Any]) -> tuple[str, NDArray[Any]]:
        """Reason why the values are wrong, empty where they are not; and they, of their dtype."""
        turned = _turned(values, wanted.dtype)
        if wanted.kinds == "U":
            return _text_problem(values), turned
        # whole numbers may not fit into what they are turned into
        return self._range_problem(wanted, turned if wanted.kinds == "fiu" else values), turned

    def _range_problem(self, wanted: Array, numbers: NDArray[Any]) -> str:
        if not numbers.size:
            return ""
        least, most = numbers.min().item(), numbers.max().item()
        if not np.isfinite([least, most]).all():
            if not wanted.gaps or np.isinf(numbers).any():
                return "holds infinity" if wanted.gaps else "holds NaN or infinity"
            return self._range_problem(wanted, numbers[~np.isnan(numbers)])
        low, high = self._range(wanted)
        within = low <= least <= most <= high
        return "" if within else f"goes from {least:g} to {most:g}, not {low:g} to {high:g}"

    def _range(self, wanted: Array) -> tuple[float, float]:
        high = wanted.high
        limit = self.lengths[high] - 1 if isinstance(high, str) else high
        if not np.issubdtype(wanted.dtype, np.integer):
            return wanted.low, limit
        ends = np.iinfo(wanted.dtype)
        return max(wanted.low, ends.min), min(limit, ends.max)


def _text_problem(values: NDArray[Any]) -> str:
    try:
        "".join(map(str, values.ravel())).encode()
    except ValueError:  # no such characters
        return "holds what is not text"
    return ""


def _turned(values: NDArray[Any], dtype: DTypeLike) -> NDArray[Any]:
    if dtype is np.str_:  # without cutting any
        return values if values.size else values.astype(np.str_)
    with np.errstate(over="ignore", invalid="ignore"):  # becomes infinite, which is refused
        return np.array(values, dtype, order="C")
