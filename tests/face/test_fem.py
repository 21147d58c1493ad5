"""The thin shell against answers known from mechanics."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import sparse

from abs_engine.core.errors import ParameterError
from abs_engine.core.geometry import rotations
from abs_engine.face.shape.dots import ShellPoints
from abs_engine.face.shape.fem import Material, ThinShell
from abs_engine.face.shape.minimum_norm_deformation import reach

STEEL = Material(young=210.0, poisson=0.3, thickness=0.5)


def strip(length: float, height: float, columns: int, rows: int, springs=None, wobble=0.0):
    """A flat rectangle in the plane z = 0, meshed with crossed diagonals."""
    x, y = np.meshgrid(np.linspace(0, length, columns + 1), np.linspace(0, height, rows + 1))
    vertices = np.stack([x.ravel(), y.ravel(), np.zeros(x.size)], axis=1)
    inner = (x > 0) & (x < length) & (y > 0) & (y < height)
    vertices[inner.ravel(), :2] += np.random.default_rng(0).normal(0, wobble, (inner.sum(), 2))
    faces = []
    for i in range(rows):
        for j in range(columns):
            a = i * (columns + 1) + j
            b, c, d = a + 1, a + columns + 1, a + columns + 2
            faces += [[a, b, d], [a, d, c]] if (i + j) % 2 else [[a, b, c], [b, d, c]]
    held = np.zeros(len(vertices)) if springs is None else springs(vertices)
    return ThinShell(vertices, np.array(faces), held, STEEL)


def curved(n: int = 9):
    """A quarter of a tube."""
    angle, along = np.meshgrid(np.linspace(0, np.pi / 2, n), np.linspace(0, 20, n))
    vertices = np.stack([10 * np.cos(angle), 10 * np.sin(angle), along], axis=-1).reshape(-1, 3)
    quads = [
        (i * n + j, i * n + j + 1, (i + 1) * n + j) for i in range(n - 1) for j in range(n - 1)
    ]
    faces = [t for a, b, c in quads for t in ([a, b, c], [b, c + 1, c])]
    return ThinShell(vertices, np.array(faces), np.zeros(len(vertices)), STEEL)


def displaced(shell, forces):
    """Displacements (N, 3), mm, under forces (N, 3), N."""
    return shell.solve(forces.reshape(-1, 1)).reshape(-1, 3)


def energy(shell, displacement):
    u = np.ravel(displacement)
    return 0.5 * u @ (shell.stiffness @ u)


def edge(x: float, stiffness: float = 1e9):
    return lambda v: np.where(np.isclose(v[:, 0], x), stiffness, 0.0)


def test_patch_linear_displacements_strain_evenly_and_leave_inner_nodes_in_balance():
    shell = strip(8, 5, 6, 5, wobble=0.2)
    gradient = np.array([[2e-3, -1e-3, 0], [3e-3, 4e-3, 0], [5e-3, -2e-3, 0]])  # d u_i / d x_j
    moved = shell.vertices @ gradient.T
    (xx, xy, _), (yx, yy, _), (zx, zy, _) = gradient
    corners = moved[shell.faces].reshape(len(shell.faces), 9)
    strains = np.einsum("mpi,mi->mp", shell.strain_matrices, corners)
    # In each triangle's own frame; what does not depend on it is compared.
    np.testing.assert_allclose(strains[:, 0] + strains[:, 1], xx + yy, atol=1e-12)
    shear = (strains[:, 0] - strains[:, 1]) ** 2 + strains[:, 2] ** 2
    np.testing.assert_allclose(shear, (xx - yy) ** 2 + (xy + yx) ** 2, atol=1e-12)
    np.testing.assert_allclose((strains[:, 3:] ** 2).sum(axis=1), zx**2 + zy**2, atol=1e-12)
    forces = (shell.stiffness @ moved.ravel()).reshape(-1, 3)
    inner = (
        (shell.vertices[:, 0] > 0)
        & (shell.vertices[:, 0] < 8)
        & (shell.vertices[:, 1] > 0)
        & (shell.vertices[:, 1] < 5)
    )
    assert inner.sum() == 20
    assert np.abs(forces[inner]).max() < 1e-12 * np.abs(forces).max() + 1e-13


def test_a_pulled_strip_stretches_and_narrows_as_hooke_says():
    shell = strip(10, 4, 8, 4, wobble=0.1)
    stress = 1.5
    forces = np.zeros_like(shell.vertices)
    y = shell.vertices[:, 1]
    share = np.where(np.isclose(y, 0) | np.isclose(y, 4), 0.5, 1.0)  # end nodes carry half
    for x, sign in ((0.0, -1.0), (10.0, 1.0)):
        at = np.isclose(shell.vertices[:, 0], x)
        forces[at, 0] = sign * stress * STEEL.thickness * 4 / 4 * share[at]
    soft = ThinShell(shell.vertices, shell.faces, np.full(len(y), 1e-9), STEEL)
    moved = displaced(soft, forces)
    stretch = moved - moved[0]
    far = np.flatnonzero(np.isclose(shell.vertices[:, 0], 10) & np.isclose(y, 0))[0]
    assert stretch[far, 0] == pytest.approx(10 * stress / STEEL.young, rel=1e-6)
    top = np.flatnonzero(np.isclose(shell.vertices[:, 0], 0) & np.isclose(y, 4))[0]
    assert stretch[top, 1] == pytest.approx(-4 * STEEL.poisson * stress / STEEL.young, rel=1e-6)


def test_a_cantilever_in_its_plane_bends_as_timoshenko_says():
    """w = P L^3 / 3 E I + 6 P L / 5 G A for a beam of rectangular section."""
    length, height, load = 20.0, 2.0, 0.01
    e, v, t = STEEL.young, STEEL.poisson, STEEL.thickness
    inertia, area, g = t * height**3 / 12, t * height, e / (2 * (1 + v))
    known = load * length**3 / (3 * e * inertia) + 6 * load * length / (5 * g * area)
    error = []
    for rows in (4, 8, 16):
        shell = strip(length, height, 10 * rows, rows, edge(0))
        forces = np.zeros_like(shell.vertices)
        end = np.isclose(shell.vertices[:, 0], length)
        forces[end, 1] = load / end.sum()
        tip = displaced(shell, forces)[end, 1].mean()
        error.append(abs(tip / known - 1))
    assert error[-1] < 0.015
    assert error[0] > 2.5 * error[1] > 6 * error[2]  # constant strain: second order


def test_a_cantilever_across_its_plane_shears_as_a_string():
    """Slope counts as strain out of the plane: w = P L / (k G A), straight."""
    length, height, load = 12.0, 3.0, 0.02
    shell = strip(length, height, 24, 6, edge(0, 1e12))
    y = shell.vertices[:, 1]
    end = np.isclose(shell.vertices[:, 0], length)
    forces = np.zeros_like(shell.vertices)
    share = np.where(np.isclose(y, 0) | np.isclose(y, height), 0.5, 1.0)
    forces[end, 2] = load * share[end] / share[end].sum()
    g = STEEL.young / (2 * (1 + STEEL.poisson))
    slope = load / (STEEL.shear * g * STEEL.thickness * height)
    moved = displaced(shell, forces)
    np.testing.assert_allclose(moved[:, 2], slope * shell.vertices[:, 0], rtol=1e-6, atol=1e-9)
    assert np.abs(moved[:, :2]).max() < 1e-12


def test_stiffness_is_symmetric_and_not_negative():
    k = curved().stiffness.toarray()
    np.testing.assert_allclose(k, k.T, atol=1e-10 * np.abs(k).max())
    values = np.linalg.eigvalsh(k)
    assert values.min() > -1e-10 * values.max()
    assert (values < 1e-9 * values.max()).sum() == 3  # a curved shell: the translations alone


def test_rigid_motions_strain_as_the_module_says():
    flat, tube = strip(8, 5, 6, 5, wobble=0.1), curved()
    for shell in (flat, tube):
        assert energy(shell, np.tile([0.3, -0.2, 0.7], (len(shell.vertices), 1))) < 1e-12
    within, tilt = (1e-3 * np.cross(axis, flat.vertices) for axis in ([0, 0, 1.0], [1.0, 0, 0]))
    assert energy(flat, within) < 1e-12
    assert energy(flat, tilt) > 1e-4
    assert (np.linalg.eigvalsh(flat.stiffness.toarray()) < 1e-9).sum() == 4


def test_turning_the_shell_turns_the_answer():
    shell = strip(8, 5, 6, 5, edge(0, 3.0), wobble=0.1)
    turn = rotations(np.array([[0.4, -0.8, 0.3]]))[0]
    turned = ThinShell(shell.vertices @ turn.T, shell.faces, shell.springs, STEEL)
    forces = np.random.default_rng(1).normal(size=shell.vertices.shape)
    np.testing.assert_allclose(
        displaced(turned, forces @ turn.T), displaced(shell, forces) @ turn.T, atol=1e-9
    )


class TestReach:
    SHELL = strip(8, 5, 6, 5, edge(0, 2.0), wobble=0.1)
    DOFS = np.array([3 * 20, 3 * 20 + 2, 3 * 33 + 1])
    GOALS = np.array([[0.2, -0.1, 0.4], [0.0, 0.3, 0.1]])

    def test_goals_are_reached(self):
        moved = reach(self.SHELL, self.DOFS, self.GOALS)
        np.testing.assert_allclose(moved.reshape(2, -1)[:, self.DOFS], self.GOALS, atol=1e-10)

    def test_the_forces_are_least(self):
        k = self.SHELL.stiffness
        rng = np.random.default_rng(0)
        found = reach(self.SHELL, self.DOFS, self.GOALS[0]).ravel()
        for _ in range(20):
            other = rng.normal(0, 0.05, found.size)
            other[self.DOFS] = 0
            assert np.linalg.norm(k @ (found + other)) > np.linalg.norm(k @ found)

    def test_rows_that_pick_are_degrees_of_freedom(self):
        rows = self.SHELL.selection(self.DOFS)
        np.testing.assert_allclose(
            reach(self.SHELL, rows, self.GOALS),
            reach(self.SHELL, self.DOFS, self.GOALS),
            atol=1e-12,
        )

    def test_a_point_between_nodes_is_reached_with_the_least_force(self):
        rows = ShellPoints(np.array([[8, 9, 16], [20, 21, 28]]), np.array([[0.5, 0.3, 0.2]] * 2))
        w = rows.rows(len(self.SHELL.vertices), "xz")
        goals = np.array([0.2, -0.1, 0.3, 0.1])
        moved = reach(self.SHELL, w, goals)
        np.testing.assert_allclose(rows.at(moved)[:, [0, 2]].ravel(), goals, atol=1e-10)
        forces = self.SHELL.stiffness @ moved.ravel()
        rng = np.random.default_rng(0)
        for _ in range(20):
            other = rng.normal(0, 0.05, moved.size)
            other -= w.T @ np.linalg.solve((w @ w.T).toarray(), w @ other)  # moves no goal
            assert np.linalg.norm(forces) < np.linalg.norm(forces + self.SHELL.stiffness @ other)

    def test_bad_goals_are_named(self):
        with pytest.raises(ParameterError, match="3 goals for 2 different"):
            reach(self.SHELL, np.array([1, 1, 2]), self.GOALS)
        with pytest.raises(ParameterError, match="no degree of freedom 999"):
            reach(self.SHELL, np.array([1, 2, 999]), self.GOALS)
        with pytest.raises(ParameterError, match="no degree of freedom -1"):
            reach(self.SHELL, np.array([1, 2, -1]), self.GOALS)
        with pytest.raises(ParameterError, match="for this shell"):
            reach(self.SHELL, sparse.eye(3), self.GOALS)


def test_a_shell_that_nothing_holds_is_singular():
    with pytest.raises(ParameterError, match="singular"):
        displaced(strip(4, 2, 4, 2), np.zeros((15, 3)))


def test_a_node_of_no_triangle_is_singular():
    good = strip(4, 2, 4, 2, edge(0))
    loose = ThinShell(
        np.vstack([good.vertices, [9, 9, 9]]), good.faces, np.r_[good.springs, 0.0], STEEL
    )
    with pytest.raises(ParameterError, match="singular"):
        displaced(loose, np.zeros((16, 3)))


def test_what_is_no_shell_is_refused():
    vertices = np.array([[0, 0, 0], [1, 0, 0], [2, 0, 0.0]])
    with pytest.raises(ParameterError, match="triangle 0 has no area"):
        ThinShell(vertices, np.array([[0, 1, 2]]), np.zeros(3))
    with pytest.raises(ParameterError, match="springs"):
        ThinShell(vertices, np.array([[0, 1, 2]]), np.zeros(2))


@pytest.mark.parametrize("faces", [[[0, 1, 3]], [[0, 1, -1]], [[0, 1]], np.zeros((0, 3), int)])
def test_faces_that_make_no_shell_are_refused(faces):
    with pytest.raises(ParameterError, match=r"corners \[|faces of shape"):
        ThinShell(np.eye(3), np.array(faces), np.ones(3))


def test_what_is_not_finite_is_refused():
    shell = strip(4, 2, 4, 2, edge(0))
    with pytest.raises(ParameterError, match="goal is not finite"):
        reach(shell, np.array([6, 7]), np.array([[0.1, np.nan]]))
    with pytest.raises(ParameterError, match="node or a spring"):
        ThinShell(np.eye(3) * np.nan, np.array([[0, 1, 2]]), np.ones(3))


@pytest.mark.parametrize("wrong", [{"young": 0.0}, {"poisson": 0.5}, {"thickness": -1.0}])
def test_impossible_materials_are_refused(wrong):
    with pytest.raises(ParameterError):
        Material(**wrong)


def test_a_negative_spring_is_refused():
    with pytest.raises(ParameterError, match="spring of the shell is negative"):
        ThinShell(np.eye(3), np.array([[0, 1, 2]]), np.array([1.0, -0.02, 0.0]))
