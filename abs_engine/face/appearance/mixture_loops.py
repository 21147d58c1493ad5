"""Densities of Gaussian mixtures, compiled: see `face.appearance.mixture`."""
# mypy: disable-error-code="no-untyped-def, no-untyped-call, untyped-decorator"

from __future__ import annotations

import numba
import numpy as np

from abs_engine.core.compiled import LOOP


@numba.njit(**LOOP, error_model="numpy", fastmath=True)
def exponents(samples, means, roots, part, out):
    """Fill -0.5 times the squared deviations of samples (D, N) from each component, (K, N).

    `roots` (K, D, D) are upper triangles whose product root' root is half the inverse covariance;
    `part` (N,) is scratch.
    """
    size, count = samples.shape
    for k in range(len(means)):
        out[k] = 0.0
        for row in range(size):
            part[:] = 0.0
            for column in range(row, size):
                slope, middle = roots[k, row, column], means[k, column]
                for n in range(count):  # innermost, for it is what processors do several of at once
                    part[n] += slope * (samples[column, n] - middle)
            for n in range(count):
                out[k, n] -= part[n] * part[n]


@numba.njit(**LOOP, error_model="numpy", fastmath=True)
def scatters(samples, share, means):
    """Sum of each component's share (K, N) of samples (D, N) by their offsets, (K, D, D)."""
    size, count = samples.shape
    out = np.empty((len(means), size, size))
    for k in range(len(means)):
        for row in range(size):
            for column in range(row + 1):
                one, other, total = means[k, row], means[k, column], 0.0
                for n in range(count):
                    total += share[k, n] * (samples[row, n] - one) * (samples[column, n] - other)
                out[k, row, column] = out[k, column, row] = total
    return out
