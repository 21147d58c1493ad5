"""A thin shell: linear elastic triangles with three displacements a node.

Basu, Oliver and Pentland (1998), section 2: a two-dimensional plane-stress isotropic material with
a strain relation for the out-of-plane components added. K U = F (eq. 1).

In the frame of a triangle, with displacements (u, v) in its plane and w across it, all linear over
the triangle, the strains are constant:

    e_x = du/dx,  e_y = dv/dy,  g_xy = du/dy + dv/dx     plane stress
    g_xz = dw/dx, g_yz = dw/dy                           out of the plane

so an element's stiffness is t A B' D B with B (5, 9), and the whole is assembled over the nodes.

Rigid motion. The three translations strain nothing. A rotation within the plane of a flat shell
strains nothing either; one that tilts it does, as the slope of w counts as shear (there is no
rotation at the nodes that could take it up). A shell of lips therefore does not turn freely
against the head, as lips do not. The translations are held by springs at chosen nodes, to the
head frame: at the border, where the skin goes on. Without any, K is singular.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse.linalg import SuperLU, splu

from abs_engine.core.arrays import FloatArray
from abs_engine.core.errors import ParameterError
from abs_engine.core.geometry import facet_areas

_SINGULAR = 1e-12  # smallest pivot of a shell that is held, as a share of its own stiffness


@dataclass(frozen=True)
class Material:
    """An isotropic linear elastic sheet.

    Parameters
    ----------
    young : float
        Young's modulus, N / mm^2.
    poisson : float
        Poisson's ratio, -1 to 0.5.
    thickness : float, mm
    shear : float
        Share of the shear modulus that resists slopes out of the plane; 5/6 is usual for plates.
    """

    young: float = 0.1
    poisson: float = 0.4
    thickness: float = 2.0
    shear: float = 5 / 6

    def __post_init__(self) -> None:
        if not (self.young > 0 and self.thickness > 0 and self.shear > 0):
            raise ParameterError(
                "young, thickness and shear of a material must be positive", "give other values"
            )
        if not -1 < self.poisson < 0.5:
            raise ParameterError(
                f"Poisson's ratio {self.poisson} is not between -1 and 0.5", "give another"
            )

    @property
    def elasticity(self) -> FloatArray:
        """D (5, 5), N / mm^2: stress from the strains e_x, e_y, g_xy, g_xz, g_yz."""
        e, v = self.young, self.poisson
        plane = e / (1 - v * v) * np.array([[1, v, 0], [v, 1, 0], [0, 0, (1 - v) / 2]])
        across = self.shear * e / (2 * (1 + v)) * np.eye(2)
        return np.asarray(np.block([[plane, np.zeros((3, 2))], [np.zeros((2, 3)), across]]))


@dataclass(frozen=True, eq=False)
class ThinShell:
    """An elastic shell, held to the head by springs.

    Parameters
    ----------
    vertices : (N, 3) float64, mm
        At rest.
    faces : (M, 3) int
    springs : (N,) float64, N / mm
        Stiffness, in each direction, by which a node is held where it is; 0 for a free node.
    material : Material

    Raises
    ------
    ParameterError
        If a triangle has no area or no such node, a spring is negative, the arrays do not fit
        together, or one holds what is not finite.
    """

    vertices: FloatArray
    faces: NDArray[np.integer]
    springs: FloatArray
    material: Material = field(default_factory=Material)

    def __post_init__(self) -> None:
        n = len(self.vertices)
        if np.shape(self.vertices) != (n, 3) or np.shape(self.springs) != (n,):
            raise ParameterError(
                f"{np.shape(self.springs)} springs do not fit {np.shape(self.vertices)} vertices",
                "give one for each node",
            )
        if not (np.isfinite(self.vertices).all() and np.isfinite(self.springs).all()):
            raise ParameterError("a node or a spring of the shell is not finite", "leave it out")
        if (np.asarray(self.springs) < 0).any():
            raise ParameterError("a spring of the shell is negative", "give 0 or more")
        faces = np.asarray(self.faces)
        if faces.ndim != 2 or faces.shape[1] != 3 or len(faces) == 0:
            raise ParameterError(f"faces of shape {faces.shape} make no shell", "give (M, 3)")
        wrong = np.flatnonzero(((faces < 0) | (faces >= n)).any(axis=1))
        if len(wrong):
            raise ParameterError(
                f"triangle {wrong[0]} has corners {faces[wrong[0]].tolist()}, the shell {n} nodes",
                f"give 0 to {n - 1}",
            )
        flat = np.flatnonzero(self.areas <= 1e-12 * max(1.0, float(self.areas.max())))
        if len(flat):
            raise ParameterError(f"triangle {flat[0]} has no area", "leave it out of the shell")

    @cached_property
    def areas(self) -> FloatArray:
        """Areas (M,), mm^2."""
        return facet_areas(self.vertices, self.faces)

    @cached_property
    def frames(self) -> FloatArray:
        """Axes (M, 3, 3) of each triangle as rows: two in its plane, then its normal."""
        a, b, c = np.moveaxis(self.vertices[self.faces], 1, 0)
        x = (b - a) / np.linalg.norm(b - a, axis=1, keepdims=True)
        z = np.cross(b - a, c - a)
        z /= np.linalg.norm(z, axis=1, keepdims=True)
        return np.stack([x, np.cross(z, x), z], axis=1)

    @cached_property
    def strain_matrices(self) -> FloatArray:
        """B (M, 5, 9): strains in the triangle's frame from its nodes' displacements, 1 / mm."""
        local = np.einsum("mij,mkj->mki", self.frames[:, :2], self.vertices[self.faces])
        x, y = local[..., 0], local[..., 1]
        twice = 2 * self.areas[:, None]
        b = (np.roll(y, -1, axis=1) - np.roll(y, -2, axis=1)) / twice  # d N_i / dx
        c = (np.roll(x, -2, axis=1) - np.roll(x, -1, axis=1)) / twice  # d N_i / dy
        x_axis, y_axis, z_axis = (self.frames[:, None, k] for k in range(3))
        rows = [
            b[..., None] * x_axis,
            c[..., None] * y_axis,
            c[..., None] * x_axis + b[..., None] * y_axis,
            b[..., None] * z_axis,
            c[..., None] * z_axis,
        ]
        return np.stack([row.reshape(len(self.faces), 9) for row in rows], axis=1)

    @cached_property
    def stiffness(self) -> sparse.csc_matrix:
        """K (3N, 3N), N / mm, springs included; degrees of freedom as x, y, z of each node."""
        b, d = self.strain_matrices, self.material.elasticity
        volume = self.material.thickness * self.areas
        elements = np.einsum("m,mpi,pq,mqj->mij", volume, b, d, b)
        of = (3 * self.faces[:, :, None] + np.arange(3)).reshape(len(self.faces), 9)
        rows, columns = np.repeat(of, 9, axis=1).ravel(), np.tile(of, (1, 9)).ravel()
        size = 3 * len(self.vertices)
        k = sparse.csc_matrix((elements.ravel(), (rows, columns)), shape=(size, size))
        return sparse.csc_matrix(k + sparse.diags(np.repeat(self.springs, 3)))

    @cached_property
    def _factors(self) -> tuple[SuperLU, FloatArray]:
        """Factors of K scaled to a diagonal of ones, and the scale of each degree of freedom."""
        loose = ParameterError(
            "the shell can move without strain: its stiffness is singular",
            "hold at least one node with a spring, and leave out nodes of no triangle",
        )
        diagonal = self.stiffness.diagonal()
        if diagonal.min() <= 0:
            raise loose
        scale = 1 / np.sqrt(diagonal)
        scaled = sparse.csc_matrix(sparse.diags(scale) @ self.stiffness @ sparse.diags(scale))
        try:
            factors = splu(scaled, diag_pivot_thresh=0.0, options={"SymmetricMode": True})
        except RuntimeError as error:
            raise loose from error
        if np.abs(factors.U.diagonal()).min() < _SINGULAR:
            raise loose
        return factors, scale

    def solve(self, right: FloatArray) -> FloatArray:
        """K^-1 times a matrix (3N, n)."""
        factors, scale = self._factors
        return np.asarray(scale[:, None] * factors.solve(scale[:, None] * right), np.float64)

    def compliance_rows(self, dofs: NDArray[np.integer] | sparse.spmatrix) -> FloatArray:
        """P (n, 3N), mm / N: rows of K^-1, or sums of them, P = W K^-1; see `selection`.

        Raises `ParameterError` if the shell is not held: K is singular.
        """
        return self.solve(self.selection(dofs).toarray().T).T  # K is symmetric

    def selection(self, dofs: NDArray[np.integer] | sparse.spmatrix) -> sparse.csr_matrix:
        """W (n, 3N) that picks degrees of freedom (n,); a W that is given is passed on.

        Raises `ParameterError` if it is of another shell.
        """
        size = 3 * len(self.vertices)
        if sparse.issparse(dofs):
            rows = sparse.csr_matrix(dofs)
        else:
            at = np.asarray(dofs, np.int64)
            wrong = at[(at < 0) | (at >= size)]
            if wrong.size:
                raise ParameterError(
                    f"the shell has no degree of freedom {wrong[0]}", f"give 0 to {size - 1}"
                )
            rows = sparse.csr_matrix(
                (np.ones(len(at)), (np.arange(len(at)), at)), shape=(len(at), size)
            )
        if rows.shape[1] != size:
            raise ParameterError(
                f"weights for {rows.shape[1]} degrees of freedom do not fit {size}",
                "make them for this shell",
            )
        return rows
