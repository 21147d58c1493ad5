"""Motion of measured points: face units that make it, and places that move as the points do."""

from __future__ import annotations

import numpy as np
from scipy.optimize import lsq_linear

from abs_engine.core.arrays import FloatArray
from abs_engine.face.settings.shape import SHAPE
from abs_engine.face.shape.dots import ShellPoints
from abs_engine.learn.measured.settings import MEASURED_FACE


def unit_weights(moved: FloatArray, units: FloatArray, noise: float) -> FloatArray:
    """Weights (T, U), 0 to 1, of face units (U, N, 3), mm, that move points most nearly so.

    `moved` (T, N, 3), mm, are displacements from rest; a coordinate is off by `noise`, mm.
    """
    matrix = units.reshape(len(units), -1).T / noise
    whole = np.vstack([matrix, np.eye(len(units)) / SHAPE.usual_weight])
    basis, triangle = np.linalg.qr(whole)  # least squares of so many unknowns alone
    wanted = moved.reshape(len(moved), -1) / noise @ basis[: len(matrix)]
    solved = [lsq_linear(triangle, row, bounds=(0, 1), method="bvls").x for row in wanted]
    return np.asarray(solved, np.float64).reshape(len(moved), len(units))


def slid(
    vertices: FloatArray,
    moves: FloatArray,
    places: ShellPoints,
    points: FloatArray,
    at_rest: int,
    noise: float,
    along: float,
) -> FloatArray:
    """Points (N, 3), mm, along the head's surface from where they were placed, that fit better.

    A place fits that moves as its point does, and lies where it does at rest.

    Parameters
    ----------
    vertices : (V, 3) float64, mm, head frame
        At rest.
    moves : (T, V, 3) float64, mm
        Displacements in each posture.
    points : (T, N, 3) float64, mm, head frame
    at_rest : int
        The posture in which places are compared.
    noise : float, mm
        Standard deviation of a point's coordinate.
    along : float, mm
        Standard deviation of a place along the surface.
    """
    edges = _edges(vertices[places.corners])
    tangents = _tangents(edges)
    inverse = np.linalg.inv(np.einsum("nij,nkj->nik", edges, tangents))
    slope = np.einsum("nij,tnjk->tnik", inverse, _edges(moves[:, places.corners]))
    still = points - places.at(moves)
    slope, left = slope - slope.mean(axis=0), still - still.mean(axis=0)
    off = np.einsum("nik,nk->ni", tangents, still[at_rest] - places.at(vertices))
    own = np.einsum("tnik,tnjk->nij", slope, slope) / noise**2 + np.eye(2) / along**2
    pull = np.einsum("tnik,tnk->ni", slope, left) / noise**2 + off / along**2
    step = np.linalg.solve(own, pull[..., None])[..., 0]
    length = np.linalg.norm(step, axis=1, keepdims=True)
    step *= np.minimum(1.0, MEASURED_FACE.most_moved / np.maximum(length, 1e-12))
    return np.asarray(places.at(vertices) + np.einsum("ni,nik->nk", step, tangents))


def _edges(corners: FloatArray) -> FloatArray:
    """Two edges (..., 2, 3) of triangles (..., 3, 3)."""
    return corners[..., 1:, :] - corners[..., :1, :]


def _tangents(edges: FloatArray) -> FloatArray:
    """Orthonormal directions (N, 2, 3) in the planes of edges (N, 2, 3)."""
    first = edges[:, 0] / np.linalg.norm(edges[:, 0], axis=1, keepdims=True)
    second = edges[:, 1] - (edges[:, 1] * first).sum(axis=1, keepdims=True) * first
    return np.stack([first, second / np.linalg.norm(second, axis=1, keepdims=True)], axis=1)
