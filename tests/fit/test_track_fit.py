"""A toy frame, drawn from known parameters: the fit comes back, with either renderer the same."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from runs import toy_model, toy_setting

from abs_engine.compare.prior import GaussianPrior
from abs_engine.core.geometry import FACING, Pose
from abs_engine.core.params import ParamSpec
from abs_engine.core.pose import PoseFrame, pose_and
from abs_engine.core.scene import ClassMaps
from abs_engine.face.appearance.colour_features import CLASSES
from abs_engine.face.appearance.hamming import hamming
from abs_engine.face.contact import lip_gaps
from abs_engine.face.held_head import held_head
from abs_engine.fit.head_frame import (
    best_start,
    class_maps,
    contact_prior,
    head_problem,
    likelihood_of,
    mouth_window,
    zone,
)
from abs_engine.fit.problem import Problem
from abs_engine.fit.settings import HEAD_FIT
from abs_engine.optimise.by_nlopt import Simplex
from abs_engine.render.cpu import CpuRenderer
from abs_engine.render.raster import OpenGLRenderer
from abs_engine.tracking.person.identity_fit import POSE_DEVIATION

SETTING = toy_setting()
MODEL, SCENE, CAMERA = toy_model(), SETTING.face.scene, SETTING.camera
N = 6 + MODEL.n_expression
POSE = Pose(FACING, [0.0, 20.0, 400.0])
BASE = PoseFrame(POSE, MODEL.pivot)
CPU = CpuRenderer()
LEADING = np.arange(6, 10)
"""The four shape modes with most of the variance: those that a picture of the mouth determines."""


@cache
def maps_of(case: int) -> ClassMaps:
    """Class maps, smoothed as the tracker's own, of the frame with `truth(case)`."""
    return maps_at(truth(case))


def maps_at(vector: np.ndarray) -> ClassMaps:
    """The same of the frame with parameters (N,)."""
    window = mouth_window(MODEL, POSE, CAMERA)
    drawn = CPU.draw(SCENE, BASE.candidates(vector[None]), CAMERA, window)[0].class_id
    groups = (1,), (2, 3), (4, 5, 6, 7)
    planes = np.stack([np.isin(drawn, g).astype(float) for g in groups])
    skin, lips, inside = hamming(planes, HEAD_FIT.smoothing * HEAD_FIT.drawn_mouth) * zone(window)
    lips += HEAD_FIT.in_shade * inside
    zero = np.zeros_like(skin)
    return ClassMaps(np.stack([zero, skin, lips, lips, inside, inside, inside, inside, zero]))


def truth(case: int) -> np.ndarray:
    rng = np.random.default_rng(case)
    posture = MODEL.prototypes[case % len(MODEL.prototypes)]
    return np.r_[rng.normal(0, 0.5, 6) * POSE_DEVIATION, posture + rng.normal(0, 0.2, N - 6)]


def start(case: int, free: np.ndarray) -> np.ndarray:
    """The truth, with the free parameters off by half a deviation or so."""
    step = (
        np.random.default_rng(100 + case).normal(0, 0.6, N) * np.r_[POSE_DEVIATION, np.ones(N - 6)]
    )
    moved = truth(case)
    moved[free] += step[free]
    return moved


def posterior(renderer, case: int, priors=None) -> Problem:
    window = mouth_window(MODEL, POSE, CAMERA)
    likelihood = likelihood_of(renderer, SCENE, CAMERA, window, maps_of(case))
    if priors is None:
        likely = GaussianPrior(np.zeros(N), np.r_[POSE_DEVIATION, np.ones(N - 6)])
        priors = likely, contact_prior(MODEL, np.zeros(MODEL.n_person))
    return head_problem(likelihood, BASE, priors, MODEL.posture)


def fit(renderer, case: int, free: np.ndarray, solver: Simplex, rounds: int = 1, priors=None):
    """Lip points (mm), vector and value after fitting the free parameters from `start`.

    Each further round starts a fresh simplex from where the one before it ended.
    """
    objective, vector, whole = (
        posterior(renderer, case, priors),
        start(case, free),
        pose_and(MODEL.posture).spec,
    )
    names, units = (tuple(v[k] for k in free) for v in (whole.names, whole.units))
    spec = ParamSpec(names, units, whole.scale[free], whole.lower[free], whole.upper[free])

    def at(x):
        moved = vector.copy()
        moved[free] = x
        return moved

    x = vector[free]
    for _ in range(rounds):
        solution = solver.minimise(lambda y: objective(at(y)), x, spec)
        x = solution.x
    return lips(at(x)), at(x), solution.value


@cache
def fitted(case: int):
    """All parameters on the CPU, at the tracker's own tolerance."""
    return fit(CPU, case, ALL, SETTING.driver)


@cache
def fitted_leading(case: int) -> np.ndarray:
    """Lip points (mm) of the leading modes on the CPU, to the end."""
    return fit(CPU, case, LEADING, FINE, rounds=4)[0]


def lips(vector: np.ndarray) -> np.ndarray:
    return SETTING.face.measures(vector[6:])[0]


def rms(one: np.ndarray, two: np.ndarray) -> float:
    """Root mean square distance of points, mm."""
    return float(np.sqrt(((one - two) ** 2).sum(axis=1).mean()))


FINE = Simplex(tolerance=1e-3, limit=3000)
CASES = {"thin": range(4), "instanced": range(3)}  # the second draws far more slowly on a CPU
ALL = np.arange(N)


@pytest.mark.parametrize("case", range(8))
def test_a_perturbed_posture_comes_back(case):
    """Without a prior, which would pull; across the line of sight, as one picture shows it."""
    contact = (contact_prior(MODEL, np.zeros(MODEL.n_person)),)
    found, _, _ = fit(CPU, case, LEADING, FINE, rounds=4, priors=contact)
    before, wanted = lips(start(case, LEADING)), lips(truth(case))
    assert rms(before[:, :2], wanted[:, :2]) > 0.4
    assert rms(found[:, :2], wanted[:, :2]) < 0.3


def test_a_mouth_that_opens_wider_than_most_is_followed_all_the_way():
    opens = np.sign(aperture(np.eye(N)[6]) - aperture(np.zeros(N)))
    wide = 5.5 * opens * np.eye(N)[6]
    likelihood = likelihood_of(CPU, SCENE, CAMERA, mouth_window(MODEL, POSE, CAMERA), maps_at(wide))
    likely = GaussianPrior(np.zeros(N), np.r_[POSE_DEVIATION, np.ones(N - 6)])
    problem = head_problem(likelihood, BASE, (likely,), MODEL.posture)

    found = SETTING.driver.minimise(problem, 0.6 * wide, problem.spec).x

    assert opens * found[6] > 4.0
    assert aperture(found) == pytest.approx(aperture(wide), rel=0.1)


def aperture(vector: np.ndarray) -> float:
    """Height of the opening, mm."""
    return SETTING.face.measures(vector[6:])[2]


def test_all_parameters_together_improve_on_the_start():
    """Sixteen at the tracker's own tolerance: some hardly show, so the lips are only nearer."""
    before, after = [], []
    for case in range(8):
        found, vector, value = fitted(case)
        objective = posterior(CPU, case)
        assert value < objective(start(case, ALL)).value
        assert objective(vector).value == pytest.approx(value)
        before.append(rms(lips(start(case, ALL)), lips(truth(case))))
        after.append(rms(found, lips(truth(case))))
    assert np.mean(after) < 0.75 * np.mean(before)


@pytest.mark.gl
class TestBothRenderers:
    def test_objectives_are_the_same(self, renderer):
        for case in range(4):
            rng = np.random.default_rng(case)
            vectors = (
                truth(case) + rng.normal(0, 0.5, (16, N)) * np.r_[POSE_DEVIATION, np.ones(N - 6)]
            )
            ours, theirs = (posterior(r, case).values(vectors) for r in (renderer, CPU))
            data = [posterior(r, case, priors=()).values(vectors) for r in (renderer, CPU)]
            for one, other in ((ours, theirs), data):
                assert np.median(np.abs(one / other - 1)) < 1e-5
                np.testing.assert_allclose(one, other, atol=0.1)  # nats: a pixel on a border

    def test_fits_are_the_same(self, renderer):
        """All sixteen parameters, at the tracker's own tolerance.

        The instanced path deforms in single precision: one boundary pixel may turn a step of the
        simplex, which then ends elsewhere, once in a while by nats. It is held by what a picture
        determines, below.
        """
        apart, off = [], []
        for case in CASES[renderer.vertex_path]:
            ours, theirs = fit(renderer, case, ALL, SETTING.driver), fitted(case)
            apart.append(rms(ours[0], theirs[0]))
            off.append(abs(ours[2] / theirs[2] - 1))
        assert np.median(apart) <= 0.02
        assert np.median(off) <= 0.01
        assert max(off) <= 0.5
        if renderer.vertex_path == "thin":
            assert max(apart) <= 0.02
            assert max(off) <= 0.01

    def test_fits_of_the_leading_modes_are_the_same(self, renderer):
        """The sum over pixels is constant in small steps. A simplex that ends on one of them is
        started afresh until it no longer matters which.
        """
        apart = []
        for case in CASES[renderer.vertex_path][::3]:
            ours = fit(renderer, case, LEADING, FINE, rounds=4)[0]
            apart.append(rms(ours, fitted_leading(case)))
        assert max(apart) <= 0.02


@pytest.mark.gl
def test_the_thin_path_and_the_cpu_agree_to_the_last_digit(gl):
    """One pixel that only one of them draws would turn a simplex: there is none."""
    with OpenGLRenderer(gl, "thin") as thin:
        for case in range(4):
            spread = np.random.default_rng(case).normal(0, 0.3, (100, N))
            vectors = truth(case) + spread * np.r_[POSE_DEVIATION, np.ones(N - 6)]
            ours, theirs = (posterior(r, case).values(vectors) for r in (thin, CPU))
            np.testing.assert_array_equal(ours, theirs)


def test_the_best_start_is_the_one_with_the_lowest_value():
    objective = posterior(CPU, 2)
    starts = np.vstack([start(2, ALL), truth(2) + 1, truth(2), truth(2) - 1])
    np.testing.assert_array_equal(best_start(objective, starts), truth(2))
    np.testing.assert_allclose(objective.values(starts), [objective(x).value for x in starts])


def test_the_value_is_the_sum_of_its_terms():
    result = posterior(CPU, 1)(start(1, ALL))
    assert result.value == pytest.approx(sum(result.terms.values()))
    assert result.terms["prior"] > 0


def test_the_window_holds_the_mouth_at_a_set_resolution():
    for distance in (300.0, 400.0, 900.0):
        pose = Pose(FACING, [30.0, 0.0, distance])
        window = mouth_window(MODEL, pose, CAMERA)
        ring = MODEL.head.mean[SPEAKER.lip_ring].astype(float)
        drawn = window.to_drawn(CAMERA.project(pose.apply(ring)))
        assert (drawn > 0).all()
        assert (drawn < window.drawn).all()
        if window.scale < 2:
            assert np.ptp(drawn[:, 0]) == pytest.approx(HEAD_FIT.drawn_mouth, rel=0.01)


def test_the_window_follows_a_person_whose_mouth_is_lower_and_wider():
    """Else the lower lip of such a mouth lies outside of what is compared."""
    person = MODEL.person({"mouth height": -3.0, "mouth width": 2.0})
    ring = MODEL.held(person).mean - MODEL.held(np.zeros_like(person)).mean
    moved = np.isin(MODEL.kept, SPEAKER.lip_ring)
    middle, whole = MODEL.border(person).mean(axis=0), MODEL.border().mean(axis=0)
    np.testing.assert_allclose(middle - whole, ring[moved].mean(axis=0), atol=1e-3)
    one, other = (mouth_window(MODEL, POSE, CAMERA, p) for p in (np.zeros_like(person), person))
    centre = [w.y + w.height / 2 for w in (one, other)]
    assert centre[1] - centre[0] > 0.15 * one.width
    assert other.width > 1.1 * one.width
    lips = other.to_drawn(CAMERA.project(POSE.apply(MODEL.border(person)))).astype(int)
    assert zone(other)[lips[:, 1], lips[:, 0]].all()


SPEAKER = MODEL.speaker


def test_the_zone_is_an_ellipse_within_the_window():
    window = mouth_window(MODEL, POSE, CAMERA)
    inside = zone(window)
    width, height = window.drawn
    assert inside.shape == (height, width)
    assert inside.mean() == pytest.approx(np.pi / 4, abs=0.01)
    np.testing.assert_array_equal(inside, inside[::-1, ::-1])


def test_class_maps_follow_the_facet_classes():
    window = mouth_window(MODEL, POSE, CAMERA)
    width, height = window.drawn

    class Even:
        def compared(self, image):
            assert image.shape == (height, width, 3)
            return self

        def probabilities(self, smoothing, _place):
            assert smoothing == pytest.approx(HEAD_FIT.smoothing * HEAD_FIT.drawn_mouth)
            return np.stack([np.full((height, width), p) for p in (0.2, 0.3, 0.1, 0.3)])

        def teeth_in_shade(self):
            return np.ones((height, width))

    maps = class_maps(
        Even(), MODEL.colour_classes, window, np.zeros((*CAMERA.size[::-1], 3), np.uint8)
    ).maps
    lips, inside = 0.3 + HEAD_FIT.in_shade * 0.4, 0.4  # what is inside is thick in the middle
    middle = maps[:, height // 2, width // 2]
    red = inside + HEAD_FIT.red_inside * 0.3
    of_region = {"skin": 0.2, "lips": lips, "teeth": inside, "dark": red, None: 0.0}
    for k, name in enumerate(SPEAKER.class_names[1:], start=1):
        assert middle[k] == pytest.approx(of_region[MODEL.colour_classes[k]]), name
    assert middle[0] == 0
    assert not maps[:, ~zone(window)].any()


def test_gaps_are_the_distance_between_the_lips():
    gap, slope = lip_gaps(MODEL.held(np.zeros(MODEL.n_person)), MODEL.rings)
    assert slope.shape == (len(gap), N - 6)
    closed, parted, wide = (gap + slope @ MODEL.prototypes[k] for k in (0, 3, 4))
    assert np.abs(closed).max() < 2
    middle = len(gap) // 2
    assert wide[middle] > parted[middle] + 2 > 4
    assert wide[middle] > wide[0]
    assert wide[middle] > wide[-1]
    for k in (3, 4):
        aperture = SETTING.face.measures(MODEL.prototypes[k])[2]
        assert (gap + slope @ MODEL.prototypes[k])[middle] == pytest.approx(aperture, abs=0.6)


def test_contact_leaves_pose_and_parted_lips_alone():
    contact = contact_prior(MODEL, np.zeros(MODEL.n_person))
    assert not contact.slope_of_gaps[:, :6].any()
    wide = np.r_[np.ones(6), MODEL.prototypes[4]]
    assert contact.negative_log(wide) < 0.1
    gap, slope = contact.gap, contact.slope_of_gaps[:, 6:]
    through = np.linalg.lstsq(slope, -2.0 - gap, rcond=None)[0]
    assert contact.negative_log(np.r_[np.zeros(6), through]) > 10


def test_a_held_person_is_the_person_modes_added():
    person = np.linspace(-0.5, 0.5, MODEL.n_person)
    weights = np.linspace(-1, 1, N - 6)
    np.testing.assert_allclose(
        MODEL.held(person).vertices(weights),
        MODEL.scene.vertices(np.r_[weights, person]),
        atol=1e-3,
    )
    wide = held_head(MODEL, np.eye(MODEL.n_person)[0])
    resting = [face.measures(np.zeros(N - 6))[1] for face in (SETTING.face, wide)]
    assert resting[1] > resting[0] + 1


def test_the_pose_turns_about_the_mouth():
    moved = BASE.pose(np.r_[0.1, -0.2, 0.05, 1.0, 2.0, 3.0])
    np.testing.assert_allclose(
        moved.apply(MODEL.pivot), POSE.apply(MODEL.pivot) + np.array([1, 2, 3]), atol=1e-9
    )
    np.testing.assert_allclose(BASE.pose(np.zeros(6)).rotation, POSE.rotation)


def test_a_thin_dim_line_may_be_closed_lips_but_a_thick_one_or_lit_teeth_less_so():
    window = mouth_window(MODEL, POSE, CAMERA)
    width, height = window.drawn
    middle = height // 2

    class Line:
        def __init__(self, thick, name, shade):
            self.thick, self.plane, self.shade = thick, CLASSES.index(name), shade

        def compared(self, _image):
            return self

        def probabilities(self, _smoothing, _place):
            maps = np.zeros((4, height, width))
            maps[self.plane, middle - self.thick : middle + self.thick + 1] = 1.0
            return maps

        def teeth_in_shade(self):
            return np.full((height, width), self.shade)

    names = SPEAKER.class_names[1:]
    lip, inside = 1 + names.index("upper_lip"), 1 + names.index("inner_mouth")
    frame = np.zeros((*CAMERA.size[::-1], 3), np.uint8)
    for thick, name, shade, share in (
        (0, "dark", 0.0, HEAD_FIT.in_line), (6, "dark", 0.0, HEAD_FIT.in_shade),
        (0, "teeth", 0.0, HEAD_FIT.in_shade), (6, "teeth", 0.0, HEAD_FIT.in_shade),
        (0, "teeth", 1.0, HEAD_FIT.in_line), (6, "teeth", 1.0, HEAD_FIT.in_shade),
    ):  # fmt: skip
        maps = class_maps(Line(thick, name, shade), MODEL.colour_classes, window, frame).maps
        assert maps[lip, middle, width // 2] == pytest.approx(share)
        assert maps[inside, middle, width // 2] == pytest.approx(1.0)
