"""NumPy's usual treatment of floating-point errors, whatever a caller has set by `numpy.seterr`.

Densities of colours far from a class are too small for a number, and count as 0. A caller may have
NumPy raise or warn there. The state is each thread's own, and threads begin with NumPy's usual one.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import TypeVar

import numpy as np

Item = TypeVar("Item")
_END = object()


def as_usual() -> np.errstate:
    """NumPy's usual state, as a context or a decorator."""
    return np.errstate(divide="warn", over="warn", under="ignore", invalid="warn")


def made_as_usual(items: Iterable[Item]) -> Iterator[Item]:
    """The same items, each made in NumPy's usual state, and used in the caller's."""
    source = iter(items)
    while True:
        with as_usual():
            item = next(source, _END)
        if item is _END:
            return
        yield item  # type: ignore[misc]  # never _END
