"""Options of compiled loops; those that are damaged, or cannot be kept, are compiled again."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress
from pickle import UnpicklingError
from types import MappingProxyType
from typing import Any

from numba.core.caching import FunctionCache

LOOP: Mapping[str, Any] = MappingProxyType({"cache": True, "nogil": True})
"""For `numba.njit`: kept once compiled, and without the GIL."""
INNER: Mapping[str, Any] = MappingProxyType(
    {**LOOP, "no_cpython_wrapper": True, "no_cfunc_wrapper": True}
)
"""The same for loops that are compiled for other compiled loops alone.

Without what Python and C would call them by, they compile a quarter faster.
"""
_load: Any = FunctionCache.load_overload
_save: Any = FunctionCache.save_overload


def _loaded(kept: Any, *given: Any) -> Any:
    """A loop that numba has kept; None if there is none, or a crash left it in pieces."""
    try:
        return _load(kept, *given)
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
