"""Options of loops that are compiled for other compiled loops alone."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

INNER: Mapping[str, Any] = MappingProxyType(
    {"cache": True, "nogil": True, "no_cpython_wrapper": True, "no_cfunc_wrapper": True}
)
"""For `numba.njit`: without what Python and C would call them by, they compile a quarter faster."""
