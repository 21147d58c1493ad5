"""A candidate deformed, placed, drawn and compared in one call of a compiled function.

Whoever changes a loop of `kernels`, `pixel_kernels` or `vertex` must remove what numba has cached
of these: it does not see that what they call has changed in another file.
"""
# mypy: disable-error-code="no-untyped-def, no-untyped-call, untyped-decorator"

from __future__ import annotations

from typing import Any

import numba
import numpy as np

from abs_engine.core.compiled import LOOP
from abs_engine.render.kernels import rasterise
from abs_engine.render.pixel_kernels import outlines, sum_class_maps
from abs_engine.render.vertex import deform, to_clip

_compiled: Any = numba.njit(**LOOP, error_model="numpy")


@_compiled
def drawn(mean, modes, weights, motion, lens, limit, clip, faces, order, first, near, far, cull,
          keys, facet):  # fmt: skip
    """Clip coordinates (V, 4) of a candidate; `facet` (H, W) becomes what it shows.

    See `vertex.clip_positions` and `kernels.rasterise`.
    """
    positions = np.empty((len(mean), 4), np.float32)
    to_clip(deform(mean, modes, weights), motion, lens, limit, clip, positions)
    rasterise(positions, faces, order, first, near, far, cull, keys, facet)
    return positions


@_compiled
def measured(mean, modes, weights, motion, lens, limit, clip, faces, order, first, near, far, cull,
             keys, facet, facet_class, maps):  # fmt: skip
    """The sum of the maps (C, H, W) of what a candidate shows, and the drawn pixels."""
    drawn(mean, modes, weights, motion, lens, limit, clip, faces, order, first, near, far, cull,
          keys, facet)  # fmt: skip
    return sum_class_maps(facet, facet_class, maps)


@_compiled
def outlined(mean, modes, weights, motion, lens, limit, clip, faces, order, first, near, far, cull,
             keys, facet, facet_class, shown, depth, bary):  # fmt: skip
    """Borders of a candidate, where classes meet; see `pixel_kernels.outlines`."""
    positions = drawn(mean, modes, weights, motion, lens, limit, clip, faces, order, first, near,
                      far, cull, keys, facet)  # fmt: skip
    outlines(positions, faces, facet, facet_class, shown, depth, bary)
