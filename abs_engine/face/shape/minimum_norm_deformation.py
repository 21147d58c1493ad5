"""The least displacement of a shell that takes some of its points to their goals (Basu, eq. 2)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from abs_engine.core.arrays import FloatArray
from abs_engine.core.errors import ParameterError
from abs_engine.face.shape.fem import ThinShell


def reach(
    shell: ThinShell, dofs: NDArray[np.integer] | sparse.spmatrix, goals: FloatArray
) -> FloatArray:
    """Displacements (..., N, 3), mm, of a whole shell that take points of it to their goals.

    Parameters
    ----------
    dofs : (n,) int, or (n, 3N) sparse
        Degrees of freedom with a goal: 3 times the node, plus 0, 1, 2 for x, y, z. Or, for points
        between the nodes, the weights W of all degrees of freedom in each goal, as
        `dots.ShellPoints.rows` gives them.
    goals : (..., n) float64, mm
        Displacement goals U_g, for one frame or more.

    Raises
    ------
    ParameterError
        If goals depend on one another (such as one degree of freedom named twice), do not fit
        or are not finite, or the shell is not held.

    Notes
    -----
    The forces' norm is least: F = P' (P P')^-1 U_g with P = W K^-1; where a goal is a node's own,
    its row of W picks one row of K^-1, as in the paper. The paper names least strain and prints
    the least force. Both are smooth; forces spread over all nodes follow the goals' surroundings
    more evenly, forces at the goals alone leave peaks.
    """
    picked, goals = shell.selection(dofs), np.asarray(goals, np.float64)
    different = np.linalg.matrix_rank((picked @ picked.T).toarray())
    if goals.shape[-1] != picked.shape[0] or different != picked.shape[0]:
        raise ParameterError(
            f"{goals.shape[-1]} goals for {different} different degrees of freedom",
            "give one goal for each",
        )
    if not np.isfinite(goals).all():
        raise ParameterError("a goal is not finite", "leave out frames in which a point was lost")
    p = shell.compliance_rows(picked)
    whole = shell.solve(p.T @ np.linalg.inv(p @ p.T))  # Eq. 2, then U = K^-1 F
    moved = goals @ whole.T
    return np.asarray(moved.reshape(*goals.shape[:-1], -1, 3), np.float64)
