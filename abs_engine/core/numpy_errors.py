"""NumPy's usual treatment of floating-point errors, whatever a caller has set by `numpy.seterr`.

Densities of colours far from a class are too small for a number, and count as 0. A caller may have
NumPy raise or warn there. The state is each thread's own, and threads begin with NumPy's usual one.
"""

from __future__ import annotations

import numpy as np


def as_usual() -> np.errstate:
    """NumPy's usual state, as a context or a decorator."""
    return np.errstate(divide="warn", over="warn", under="ignore", invalid="warn")
