"""Densities of Gaussian mixtures, compiled: see `face.appearance.mixture`."""
# mypy: disable-error-code="no-untyped-def, no-untyped-call, untyped-decorator"

from __future__ import annotations

import numba


@numba.njit(cache=True, nogil=True, error_model="numpy", fastmath=True)
def exponents(samples, means, roots, part, out):
    """Fill -0.5 times the squared deviations of samples (D, N) from each component, (K, N).

    `roots` (K, D, D) are upper triangles whose product root' root is the inverse covariance;
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
                out[k, n] -= 0.5 * part[n] * part[n]
