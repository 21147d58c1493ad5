"""Shaded skin is learned from pictures, and says where skin lies along itself."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from types import SimpleNamespace

import numpy as np
import pytest
from runs import write_noise

import abs_engine
from abs_engine.cli import main
from abs_engine.core.blocks import POSTURE
from abs_engine.core.camera import Camera, Window
from abs_engine.core.geometry import FACING, Pose, rotations, vertex_normals
from abs_engine.core.params import ParamSpec
from abs_engine.core.pose import PoseFrame, pose_and
from abs_engine.face.appearance.harmonics import harmonics
from abs_engine.face.base import Body
from abs_engine.face.settings.appearance import SHADING
from abs_engine.face.shading import LinearPicture, SkinPatch, learn_shading
from abs_engine.face.shading_loops import deviations
from abs_engine.fit.problem import Problem
from abs_engine.fit.shading import NAME, shading_term, with_shading
from abs_engine.fit.view import View

CAMERA = Camera.ideal((160, 160), 480.0)
POSE = Pose(FACING, np.array([0.0, 0.0, 300.0]))
SIDE = 41
LIGHT = np.zeros((9, 3))
LIGHT[0], LIGHT[1], LIGHT[2], LIGHT[3] = 0.30, 0.10, -0.06, -0.15
SPEC = ParamSpec(("a", "b"), ("sd", "sd"), np.full(2, 0.5), np.full(2, -9.0), np.full(2, 9.0))


def sheet():
    """A bulging sheet of skin, 60 mm wide; its postures slide it sideways and raise a bump."""
    x, y = (a.ravel() for a in np.meshgrid(*[np.linspace(-30, 30, SIDE)] * 2))
    mean = np.stack([x, y, -(x**2 + y**2) / 60], axis=1)
    soft = np.exp(-(x**2 + y**2) / (2 * 15.0**2))
    slide, bump = np.zeros((2, len(x), 3))
    slide[:, 0], bump[:, 2] = 2 * soft, 3 * np.exp(-(x**2 + y**2) / (2 * 8.0**2))
    k = np.arange(SIDE * SIDE).reshape(SIDE, SIDE)
    a, b, c, d = k[:-1, :-1].ravel(), k[:-1, 1:].ravel(), k[1:, :-1].ravel(), k[1:, 1:].ravel()
    faces = np.concatenate([np.stack([a, b, c], 1), np.stack([b, d, c], 1)]).astype(np.int32)
    return Body(
        mean.astype(np.float32), np.stack([slide, bump]).astype(np.float32), faces,
        np.zeros(len(faces), np.int32), ("skin",), np.zeros(0, np.int32),
    )  # fmt: skip


BODY = sheet()


def paint(x, y):
    """Blotches (..., 3) about 1, by the place on the sheet at rest."""
    waves = np.sin(0.5 * x + 1) * np.cos(0.4 * y) + 0.6 * np.sin(0.3 * x - 0.45 * y)
    return 1 + 0.12 * waves[..., None] * [1.0, 0.9, 0.8]


def picture(posture, pose=POSE, brightness=1.0):
    """The sheet as dots that lie so close that they fill the picture: no mesh is drawn."""
    fine = np.linspace(-30, 30, 641)
    x, y = np.meshgrid(fine, fine)
    soft = np.exp(-(x**2 + y**2) / (2 * 15.0**2))
    at = np.stack([x + posture[0] * 2 * soft, y, -(x**2 + y**2) / 60], axis=-1)
    at[..., 2] += posture[1] * 3 * np.exp(-(x**2 + y**2) / (2 * 8.0**2))
    along, across = np.gradient(at, fine, axis=1), np.gradient(at, fine, axis=0)
    normals = np.cross(along, across)
    normals /= np.linalg.norm(normals, axis=-1, keepdims=True)
    light = brightness * paint(x, y) * (harmonics(normals @ pose.rotation.T) @ LIGHT)
    pixels = np.rint(CAMERA.project(pose.apply(at.reshape(-1, 3)))).astype(int)
    total, count = np.zeros((160, 160, 3)), np.zeros((160, 160, 1))
    np.add.at(total, (pixels[:, 1], pixels[:, 0]), light.reshape(-1, 3))
    np.add.at(count, (pixels[:, 1], pixels[:, 0]), 1)
    linear = total / np.maximum(count, 1)
    coded = np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)
    return np.rint(255 * np.clip(coded, 0, 1)).astype(np.uint8)


def face_of(body):
    """Just what is asked of a face."""
    looks = {}

    def looking(**learned):
        looks.update(learned)
        return face

    face = SimpleNamespace(
        body=body, pivot=np.zeros(3), identity=(), looking=looking, learned=looks.get
    )
    return face


@cache
def learned_face():
    """The sheet with its shading, learned from some postures."""
    seen = [np.array([a, b]) for a, b in ((0, 0), (1.5, 0), (-1.5, 0.5), (0, 1.5), (1, -1))]
    frames = [(picture(p), POSE, np.r_[np.zeros(6), p]) for p in seen]
    return with_shading(face_of(BODY), CAMERA, frames)


def problem_of(posture, identity=(), **changed):
    """The problem of a frame in which the sheet has some posture, and its term.

    With an identity its person is one who was fitted.
    """
    view = View(
        picture(posture, **changed), CAMERA, None, PoseFrame(POSE, np.zeros(3)),
        Window(0, 0, 160, 160), np.zeros(8),
    )  # fmt: skip
    face = SimpleNamespace(learned=learned_face().learned, identity=identity)
    term = shading_term(face, view)
    return Problem(view.frame, pose_and(SPEC), {NAME: term}), term


def stepped(problem, x, free):
    """Parameters after ten Newton steps of the free ones alone."""
    for _ in range(10):
        _, slope, curve = problem.newton(x, 2)
        x = x.copy()
        x[free] -= np.linalg.solve(curve[np.ix_(free, free)], slope[free])
    return x


def test_colours_and_light_explain_the_pictures_they_were_learned_from():
    frames = [
        (picture(p), PoseFrame(POSE, np.zeros(3)).candidates(np.r_[np.zeros(6), p][None]))
        for p in ((0.0, 0.0), (1.5, 0.0), (-1.5, 1.0))
    ]
    learned = learn_shading(SkinPatch.of(BODY, 1.0), CAMERA, frames)
    assert (learned.noise < 0.05 * 0.3).all()
    x, y = learned.patch.mean[learned.patch.compared, :2].T
    for k in range(3):
        assert np.corrcoef(learned.colour[:, k], paint(x, y)[:, k])[0, 1] > 0.9


@pytest.mark.parametrize("brightness", [1.0, 0.8])
def test_newton_steps_find_the_posture_whatever_the_brightness(brightness):
    true = np.array([1.0, 0.8])
    problem, _ = problem_of(true, brightness=brightness)
    found = stepped(problem, np.zeros(8), np.array([6, 7]))[6:]
    np.testing.assert_allclose(found, true, atol=0.12)


def test_its_rows_are_what_its_value_says_and_the_truth_is_best():
    true = np.array([1.0, 0.8])
    problem, term = problem_of(true)
    several = np.zeros((5, 8))
    several[:, 6:] = true + np.array([[0, 0], [0.5, 0], [-0.5, 0], [0, 0.7], [0, -0.7]])
    values = problem.values(several)
    rows = term.rows(problem.candidates(several))
    np.testing.assert_allclose((rows.rows**2).sum(axis=1), values)
    assert values.argmin() == 0


@pytest.mark.parametrize(
    "pose",
    [
        Pose(POSE.rotation, np.array([55.0, 0.0, 300.0])),
        Pose(POSE.rotation @ rotations(np.array([[0.0, 1.2, 0.0]]))[0], POSE.translation),
    ],
    ids=["beyond the picture", "turned away"],
)
def test_points_that_are_not_seen_are_not_compared(pose):
    _, term = problem_of(np.zeros(2))
    view = View(
        picture(np.zeros(2)), CAMERA, None, PoseFrame(pose, np.zeros(3)),
        Window(0, 0, 160, 160), np.zeros(8),
    )  # fmt: skip
    face = face_of(BODY).looking(**{NAME: term.looks})
    assert 0 < shading_term(face, view).seen.sum() < term.seen.sum()


def test_a_channel_that_is_black_says_nothing():
    frames = [
        (picture(np.array(p)) * np.uint8([1, 1, 0]), POSE, np.r_[np.zeros(6), p])
        for p in ((0.0, 0.0), (1.5, 0.0), (-1.5, 0.5))
    ]
    looks = with_shading(face_of(BODY), CAMERA, frames).learned(NAME)
    assert np.isfinite(looks.colour).all()
    assert (looks.noise > 0).all()


def test_of_a_face_without_skin_there_is_none():
    bare = SimpleNamespace(**{**vars(BODY), "regions": (None,)})
    for body, frames in ((bare, [(picture(np.zeros(2)), POSE, np.zeros(8))]), (BODY, [])):
        assert with_shading(face_of(body), CAMERA, frames) is None


def test_some_of_the_skin_stands_for_all():
    """Points that are left out cost nothing, and the others count as much as all did."""
    spot = 100.0
    patch, whole = SkinPatch.of(BODY, spot), SkinPatch.of(BODY, 0.1)
    wanted = SHADING.together * patch.area / spot
    assert 0.7 * wanted < len(patch.compared) < 1.5 * wanted < len(whole.compared) / 2
    assert patch.area == whole.area
    assert patch.area == pytest.approx(np.pi * 2 * 15.0**2 * np.log(2), rel=0.25)
    still = PoseFrame(POSE, np.zeros(3)).candidates(np.zeros((1, 8)))
    at, normals = patch.about(np.zeros(2)).placed(still)
    assert np.linalg.norm(normals, axis=-1) == pytest.approx(1.0)
    assert (normals[..., 2] < 0).all()  # towards the camera
    assert np.ptp(at[0, :, 0]) > 30


@pytest.mark.parametrize(
    ("options", "line"),
    [
        (["--model", "shell", "--terms", "colour+shading"], "has no shading to compare"),
        (["--terms", "shading", "--driver", "simplex"], "use --terms colour+shading"),
    ],
)
def test_where_it_cannot_be_compared_it_is_refused(options, line, tmp_path, capsys):
    video = write_noise(tmp_path / "noise.mp4", 3)
    assert main(["track", str(video), "-o", str(tmp_path / "run"), *options]) == 2
    assert line in capsys.readouterr().err
    assert not (tmp_path / "run").exists()


def test_a_known_head_is_tracked_nearer_by_its_shading(filmed):
    run = abs_engine.track(
        filmed.video, renderer="cpu", camera=filmed.folder / "camera.json", person="clara",
        terms="colour+shading",
    )  # fmt: skip
    assert run.found.all()
    assert run.summary["score_of"] == "colour"
    away = run["lip_points"] - filmed.points(run["lip_vertex"])
    assert np.sqrt((away**2).sum(axis=-1).mean()) < 1.25  # 0.99 measured; 1.56 by colour alone


def test_normals_turn_as_the_posture_changes():
    """About a posture they are exact, and their slopes are those by differences."""
    patch, posture = SkinPatch.of(BODY, 100.0), np.array([0.7, -0.4])
    about = patch.about(posture)
    for k, step in enumerate(1e-3 * np.eye(2)):
        more, less = (patch.about(posture + way * step).across for way in (1, -1))
        np.testing.assert_allclose(about.turning[k], (more - less) / 2e-3, atol=1e-8)
    assert abs(about.turning).max() > 0.1
    moved = patch.mean + np.tensordot(posture, patch.modes, 1)
    exact = vertex_normals(moved, patch.facets)[patch.compared] @ POSE.rotation.T
    here = PoseFrame(POSE, np.zeros(3)).candidates(np.r_[np.zeros(6), posture][None])
    at, normals = about.placed(here)
    np.testing.assert_allclose(normals[0], exact, atol=1e-9)
    np.testing.assert_allclose(at[0], POSE.apply(moved[patch.compared]), atol=1e-9)
    some = np.arange(len(exact)) % 3 == 0
    for part, whole in zip(about.of(some).placed(here), (at, normals), strict=True):
        np.testing.assert_allclose(part, whole[:, some], atol=1e-12)


def test_slopes_are_those_by_differences():
    """By any base pose, pivot and camera; some points err far."""
    problem, term = problem_of(np.array([1.0, 0.3]))
    turned = rotations(np.array([[0.2, -0.3, 0.4]]))[0] @ POSE.rotation
    base = PoseFrame(Pose(turned, POSE.translation), np.array([6.0, -4.0, 3.0]))
    problem = replace(problem, frame=base)
    wide = CAMERA.matrix * np.array([[1.1], [0.9], [1.0]])
    term = replace(term, camera=Camera(wide, CAMERA.size))
    x = np.r_[np.zeros(3), 0.3, -0.2, 1.0, 0.8, 0.1]
    rows, along = term.slopes(problem.candidates(x[None]), problem.frame.pivot)

    def at(vector):
        return term.rows(problem.candidates(vector[None])).rows[0]

    np.testing.assert_allclose(rows, at(x))
    for slope, step in zip(along, 1e-5 * np.eye(len(x)), strict=True):
        found = (at(x + step) - at(x - step)) / 2e-5
        np.testing.assert_allclose(slope, found, rtol=1e-4, atol=1e-4 * abs(found).max())
    far = abs(rows) > SHADING.tail * np.sqrt(0.5 * term.nats)
    assert far.any()
    assert not far.all()


def test_a_frame_that_shows_none_of_the_skin_has_no_slopes():
    problem, term = problem_of(np.zeros(2))
    none = np.zeros(int(term.seen.sum()), bool)
    blind = replace(
        term, near=term.near.of(none), seen=np.zeros_like(term.seen), forgiven=term.forgiven[:, :0]
    )
    value, slope, curve = replace(problem, terms={NAME: blind}).newton(np.zeros(8), 2)
    assert (value, abs(slope).max(), abs(curve).max()) == (0, 0, 0)


def test_where_the_pose_is_held_slopes_are_those_of_the_posture():
    problem, _ = problem_of(np.array([1.0, 0.3]))
    x = np.r_[np.zeros(6), 0.8, 0.1]
    held = replace(problem, free=(POSTURE,), held=x)
    value, slope, curve = problem.newton(x, 2)
    for part, whole in zip(held.newton(x[6:], 2), (value, slope[6:], curve[6:, 6:]), strict=True):
        np.testing.assert_allclose(part, whole)


def test_the_picture_does_not_rise_beyond_its_border():
    picture = LinearPicture(np.random.default_rng(2).random((6, 8, 3), np.float32), 10, 20)
    pixels = np.array([[12.3, 22.6], [9.0, 22.6], [12.3, 30.0], [np.nan, 22.6]])
    found = picture.uphill(pixels)
    for k, step in enumerate(1e-4 * np.eye(2)):
        more, less = (picture.at((pixels + way * step)[None])[0] for way in (1, -1))
        np.testing.assert_allclose(found[:3, :, k], (more - less)[:3] / 2e-4, atol=1e-6)
    assert not found[1, :, 0].any()
    assert not found[2, :, 1].any()
    assert not found[3].any()


def test_the_skin_of_a_person_who_was_fitted_counts_less():
    """Errors of the fitted shape reach farther, so that fewer observations are independent."""
    problem, known = problem_of(np.zeros(2))
    _, fitted = problem_of(np.zeros(2), identity=np.zeros(3))
    slid = problem.candidates(np.r_[np.zeros(6), 1.0, 0.0][None])
    one, other = (term.negative_log(slid)[0] for term in (known, fitted))
    assert one / other == pytest.approx(SHADING.fitted_spot / SHADING.spot)
    assert one > other


def test_the_compiled_light_is_that_of_the_harmonics():
    rng = np.random.default_rng(3)
    normals = rng.normal(size=(2, 5, 3))
    normals /= np.linalg.norm(normals, axis=-1, keepdims=True)
    light, colour, noise = rng.normal(size=(9, 3)), rng.normal(size=(5, 3)), np.array([1.0, 2, 3])
    shown = rng.normal(size=(2, 5, 3))
    found = deviations(shown, normals, light, colour, noise)
    expected = (shown - colour * (harmonics(normals) @ light)) / noise
    np.testing.assert_allclose(found, np.moveaxis(expected, -1, 0), atol=1e-12)
