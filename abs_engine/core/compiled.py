"""Options of compiled loops; those that are damaged, or cannot be kept, are compiled again.

Loops that are kept are loaded without the half of numba that only compiling needs.
"""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress
from pickle import UnpicklingError
from types import MappingProxyType
from typing import Any

from numba.core.caching import FunctionCache
from numba.core.runtime.nrt import rtsys

LOOP: Mapping[str, Any] = MappingProxyType({"cache": True, "nogil": True})
"""For `numba.njit`: kept once compiled, and without the GIL."""
INNER: Mapping[str, Any] = MappingProxyType(
    {**LOOP, "no_cpython_wrapper": True, "no_cfunc_wrapper": True}
)
"""The same for loops that are compiled for other compiled loops alone.

Without what Python and C would call them by, they compile a quarter faster.
"""
_save: Any = FunctionCache.save_overload


def _loaded(kept: Any, signature: Any, target: Any) -> Any:
    """A loop that numba has kept; None if there is none, or a crash left it in pieces.

    numba would first import what it compiles with (`target.refresh`), as it does when it compiles.
    """
    rtsys.initialize(target)  # memory of arrays
    try:
        with kept._guard_against_spurious_io_errors():
            return kept._load_overload(signature, target)
    except (EOFError, UnpicklingError, ValueError):
        with suppress(OSError):
            kept.flush()  # forgotten, so that it is compiled and kept again
    return None


def _saved(kept: Any, *given: Any) -> None:
    """Keep a loop, if the disk takes it; without that it can be used as well."""
    with suppress(OSError):
        _save(kept, *given)


FunctionCache.save_overload = _saved  # type: ignore[method-assign]
FunctionCache.load_overload = _loaded  # type: ignore[method-assign]
