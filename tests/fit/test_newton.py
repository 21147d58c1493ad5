"""Newton steps on drawn borders: their slopes, what they come to, and what a renderer must give."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from test_track_fit import (
    ALL,
    BASE,
    CAMERA,
    CPU,
    MODEL,
    POSE,
    SCENE,
    SETTING,
    N,
    posterior,
    start,
    truth,
)

from abs_engine.compare.borders import Borders, Groups
from abs_engine.compare.prior import ContactPrior, GaussianPrior, InformationPrior
from abs_engine.compare.residual_rows import Rows
from abs_engine.core.errors import ParameterError
from abs_engine.fit.forces import Forces
from abs_engine.fit.head_frame import COLOUR, contact_prior, mouth_window
from abs_engine.fit.problem import Problem
from abs_engine.fit.search import search
from abs_engine.fit.settings import HEAD_FIT
from abs_engine.fit.surface_jacobian import summed_along
from abs_engine.optimise.by_nlopt import Simplex
from abs_engine.optimise.newton import Newton

LIPS, DARK = (2, 3), 6
NONE = np.zeros(MODEL.n_person)


def problem(case: int, priors=None, renderer=CPU):
    """A drawn frame, whose lips may part."""
    made = posterior(renderer, case, priors)
    return replace(made, terms={COLOUR: replace(made.terms[COLOUR], seam=(LIPS, DARK))})


def slope_by_differences(made, x: np.ndarray) -> np.ndarray:
    """Of the value, for a first step of each parameter; over steps of several lengths."""
    scale, several = made.spec.scale, []
    for share in (0.3, 0.5, 0.8):
        moves = share * np.diag(scale)
        ahead, back = made.values(x + moves), made.values(x - moves)
        several.append((ahead - back) / (2 * share))
    return np.mean(several, axis=0)


def aperture(x: np.ndarray) -> float:
    return MODEL.aperture(NONE, x[6:])


PARTED = [k for k in range(12) if aperture(start(k, ALL)) > 0.5][:6]
"""Drawn frames whose lips are parted: where they overlap the value jumps."""


@pytest.mark.parametrize("case", PARTED)
def test_the_slope_is_that_of_the_value(case):
    made, x = problem(case, priors=()), start(case, ALL)
    value, slope, curve = made.newton(x, 2, local=True)
    assert value == pytest.approx(made.values(x[None])[0])
    ours, by_differences = slope * made.spec.scale, slope_by_differences(made, x)
    cosine = ours @ by_differences / np.linalg.norm(ours) / np.linalg.norm(by_differences)
    assert cosine > 0.9  # pixels are few
    np.testing.assert_allclose(curve, curve.T, atol=1e-9)
    assert np.linalg.eigvalsh(curve).min() > -1e-6


def test_borders_move_with_each_parameter_as_the_surface_does():
    """Some borders anywhere on the head: along their normals, against differences."""
    rng, x = np.random.default_rng(0), 0.3 * start(2, ALL)
    window = mouth_window(MODEL, POSE, CAMERA)
    facet, weights = rng.integers(len(SCENE.faces), size=12).astype(np.int32), rng.random((12, 3))
    weights /= weights.sum(axis=1, keepdims=True)
    angle = rng.uniform(0, 2 * np.pi, 12)
    normal = np.column_stack([np.cos(angle), np.sin(angle)])
    borders = Borders(facet, weights, normal, rng.normal(size=12), rng.random(12))

    def along(y):
        vertices = BASE.pose(y).apply(SCENE.vertices(y[6:]).astype(np.float64))
        points = (vertices[SCENE.faces[facet]] * weights[..., None]).sum(axis=1)
        return (window.to_drawn(CAMERA.project(points)) * normal).sum(axis=1)

    x[:3] = 0.0  # turns are about the pose as it is
    steps = 1e-3 * np.eye(N)
    moved = np.array([(along(x + s) - along(x - s)) / 2e-3 for s in steps])
    candidate = BASE.candidates(x[None])
    fall, bend = summed_along(SCENE, CAMERA, window, candidate, BASE, borders, 50.0)
    np.testing.assert_allclose(fall, moved @ borders.gain, rtol=1e-3, atol=2e-3)
    expected = (moved * borders.curve) @ moved.T + np.outer(fall, fall) / 50
    np.testing.assert_allclose(bend, expected, rtol=2e-3, atol=2e-3 * np.abs(expected).max())


class Pushed:
    """Known forces on the vertices of the head."""

    scene = SCENE
    pushes = np.random.default_rng(5).normal(size=(len(SCENE.mean), 3))

    def negative_log(self, candidates):
        return np.zeros(len(candidates))

    def forces(self, _candidate):
        return self.pushes


def test_forces_work_on_each_parameter_as_it_moves_the_surface():
    x = np.r_[0.0, 0, 0, 3, -2, 5, 0.3 * start(2, ALL)[6:]]
    forces = Forces(BASE, SETTING.face.blocks, {"pushed": Pushed()})

    def vertices(y):
        return BASE.pose(y).apply(SCENE.vertices(y[6:]).astype(np.float64))

    moved = np.array([vertices(x + s) - vertices(x - s) for s in 1e-3 * np.eye(N)]) / 2e-3
    worked = forces.generalised(BASE.candidates(x[None]))
    expected = (moved * Pushed.pushes).sum(axis=(1, 2))
    np.testing.assert_allclose(worked, expected, rtol=1e-3, atol=1e-3 * np.abs(expected).max())


@pytest.mark.parametrize(("size", "shortened"), [(0.01, False), (100.0, True)])
def test_a_first_stride_of_the_pose_is_shortened_and_never_lengthened(size, shortened):
    forces = Forces(BASE, SETTING.face.blocks, {"pushed": Pushed()})
    step = np.r_[0.0, 0, 0, size, 0, 0, np.ones(N - 6)]
    made = forces.strides(step, BASE.candidates(np.zeros((1, N))))
    assert made[3] == pytest.approx(HEAD_FIT.first_stride if shortened else size)
    nodes = np.linalg.norm(np.tensordot(made[6:], SCENE.modes.astype(np.float64), 1), axis=1)
    assert nodes.max() == pytest.approx(HEAD_FIT.first_stride, rel=1e-5)


@pytest.mark.parametrize("case", range(8))
def test_a_few_drawings_come_to_what_a_simplex_needs_hundreds_for(case):
    made, x = problem(case), start(case, ALL)
    long, few = (
        search(made, x[None], driver).best for driver in (Simplex(0.03, 400), Newton(starts=1))
    )
    assert few.n_evaluations < 0.2 * long.n_evaluations
    assert few.value < long.value + 1.0  # nats
    assert few.value == pytest.approx(made(few.x).value)
    assert few.information.shape == (N, N)


def test_closed_lips_part_where_the_picture_shows_what_is_behind():
    """Drawn closed there is no border of lips and opening that could move: only the seam."""
    opened = next(k for k in range(8) if aperture(truth(k)) > 4)
    closed = np.r_[np.zeros(6), MODEL.prototypes[0]]
    assert aperture(closed) < 0.5
    made = problem(opened)
    found = Newton().minimise(made, closed, made.spec)
    assert aperture(found.x) == pytest.approx(aperture(truth(opened)), abs=1.5)
    likelihood = made.terms[COLOUR]
    candidate = BASE.candidates(closed[None])
    seen = len(likelihood.borders(candidate, 8, False)[1].facet)
    unparted = len(replace(likelihood, seam=()).borders(candidate, 8, False)[1].facet)
    assert seen > unparted + 10


def test_a_simplex_has_the_last_word_where_it_is_asked():
    made, x = problem(3), start(3, ALL)
    plain, polished = (search(made, x[None], Newton(starts=1, polished=p)).best for p in (0, 60))
    assert polished.n_evaluations > plain.n_evaluations
    assert polished.value <= plain.value


def test_a_step_that_promises_nothing_is_not_tried():
    made, x = problem(3), start(3, ALL)
    end = Newton(polished=0).minimise(made, x, made.spec).x
    again = Newton(polished=0).descend(made, end, made.spec, 100)
    never = Newton(polished=0, gain=1e9).descend(made, end, made.spec, 100)
    assert never.n_evaluations <= again.n_evaluations
    assert never.n_evaluations == len(Newton.reaches)  # a drawing for each reach, and no step
    assert (never.x == made.spec.clip(end)).all()


def test_of_several_starts_the_better_end_counts():
    made = problem(1)
    starts = np.stack([start(1, ALL), np.r_[np.zeros(6), MODEL.prototypes[2]]])
    one, two = (search(made, starts, Newton(starts=k)).best for k in (1, 2))
    assert two.value <= one.value
    assert two.n_evaluations > one.n_evaluations


@pytest.mark.parametrize("limit", [1, 5, 100])
def test_no_more_is_drawn_than_allowed(limit):
    made, x = problem(3), start(3, ALL)
    found = Newton(limit=limit).minimise(made, x, made.spec)
    assert found.n_evaluations <= limit
    assert found.status == ("evaluation limit" if limit < 100 else "converged")
    assert found.value <= made(x).value


class Plain:
    """A renderer that can only draw."""

    def draw(self, *given):
        return CPU.draw(*given)


def test_outlines_are_those_of_the_buffers():
    window = mouth_window(MODEL, POSE, CAMERA)
    given = SCENE, BASE.candidates(truth(2)[None]), CAMERA, window
    drawn, outlined = CPU.draw(*given)[0], CPU.outlines(*given)[0]
    np.testing.assert_array_equal(outlined.facet_id, drawn.facet_id)
    np.testing.assert_array_equal(outlined.class_id, drawn.class_id)
    groups = Groups.by(problem(2).terms[COLOUR].maps.maps, LIPS, DARK)
    one, two = (Borders.of(b, groups, 4, False) for b in (outlined, drawn))
    for name in ("facet", "weights", "normal", "gain", "curve"):
        np.testing.assert_array_equal(getattr(one, name), getattr(two, name))
    x = start(2, ALL)
    for ours, theirs in zip(
        problem(2).newton(x, 4), problem(2, renderer=Plain()).newton(x, 4), strict=True
    ):
        np.testing.assert_allclose(ours, theirs, rtol=1e-9)


@pytest.mark.parametrize(
    "prior",
    [
        GaussianPrior(np.zeros(3), np.array([1.0, 2.0, 4.0])),
        InformationPrior(np.ones(3), np.diag([1.0, 2.0, 3.0]) + 0.2),
        ContactPrior(np.array([-1.0, 2.0]), np.array([[1.0, 0.5, 0], [0, 1.0, 0]])),
    ],
)
def test_the_curvature_of_a_prior_is_that_of_its_slope(prior):
    x = np.array([0.2, -0.3, 0.1])
    steps = 1e-4 * np.eye(3)
    by_differences = [(prior.slope(x + s) - prior.slope(x - s)) / 2e-4 for s in steps]
    np.testing.assert_allclose(prior.curvature(x), by_differences, atol=1e-6)


class Appears:
    """Two residuals: a weight, and one that is compared only where that weight is above 0."""

    def negative_log(self, candidates):
        return self.rows(candidates).value

    def rows(self, candidates):
        first = candidates.weights[:, 0]
        there = np.column_stack([np.ones(len(first), bool), first > 0])
        rows = np.column_stack([first, 5.0 * (first > 0)])
        return Rows(rows, there, (rows**2).sum(axis=1))


class Squares(Appears):
    """The squares of a posture's distances from 0.5, which are compared everywhere."""

    def rows(self, candidates):
        rows = candidates.weights - 0.5
        return Rows(rows, np.ones(rows.shape, bool), (rows**2).sum(axis=1))


def test_a_sum_of_squares_has_its_own_slope_and_curvature():
    made = Problem(BASE, SETTING.face.blocks, {"squares": Squares()}, ())
    x = np.random.default_rng(0).normal(size=N)
    value, slope, curve = made.newton(x, 2)
    assert value == pytest.approx(((x[6:] - 0.5) ** 2).sum())
    np.testing.assert_allclose(slope, np.r_[np.zeros(6), 2 * (x[6:] - 0.5)], atol=1e-9)
    np.testing.assert_allclose(curve, np.diag(np.r_[np.zeros(6), np.full(N - 6, 2.0)]), atol=1e-9)


def test_residuals_that_appear_with_a_step_are_no_slope():
    made = Problem(BASE, SETTING.face.blocks, {"appears": Appears()}, ())
    _, matrix, gradient = made.gauss_newton(np.zeros(N), np.ones(N), 0.5)
    expected = np.zeros((N, N))
    expected[6, 6] = 1.0
    np.testing.assert_allclose(matrix, expected, atol=1e-12)
    np.testing.assert_array_equal(gradient, 0)


def test_contact_ahead_is_felt_before_lips_touch():
    contact = contact_prior(MODEL, NONE)
    closed = np.r_[np.zeros(6), MODEL.prototypes[0]]
    assert contact.curvature(closed).any()


def test_evidence_without_borders_is_named():
    class Flat:
        def negative_log(self, candidates):
            return np.zeros(len(candidates))

    made = replace(problem(0), terms={"flat": Flat()})
    with pytest.raises(ParameterError, match="'flat' has no borders"):
        made.newton(start(0, ALL), 4)
    with pytest.raises(ParameterError, match="knows no borders"):
        Newton().minimise(lambda x: 0.0, np.zeros(len(made.spec)), made.spec)
