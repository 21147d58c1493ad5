"""Local appearance: the filters by hand, the model from drawn frames, the choice of points."""

from __future__ import annotations

from dataclasses import replace

import appearances
import numpy as np
import pytest
import shapes

from abs_engine.core.errors import (
    NothingSeenError,
    ParameterError,
    PictureError,
)
from abs_engine.core.geometry import Pose, rotations, vertex_normals
from abs_engine.core.scene import Candidates
from abs_engine.face.appearance.descriptors import (
    COMPONENTS,
    YCBCR,
    DescriptorMaps,
    kernels,
    to_ycbcr,
)
from abs_engine.face.appearance.local import LocalModel
from abs_engine.face.appearance.local_learning import learn_local
from abs_engine.face.appearance.patches import Patches
from abs_engine.face.appearance.point_selection import choose_points, reconstructed
from abs_engine.face.appearance.windows import Windows
from abs_engine.render.cpu import CpuRenderer

RENDERER = CpuRenderer()


def around(image, pixels, sigma):
    """Descriptors by the definition: the whole filter at each exact place, by brute force."""
    ycbcr = to_ycbcr(image)
    height, width = ycbcr.shape[:2]
    reach = int(np.ceil(3 * sigma))
    offset = np.arange(-reach, reach + 1)
    smooth = np.exp(-0.5 * (offset / sigma) ** 2)
    smooth /= smooth.sum()
    slope = offset * smooth / (offset**2 @ smooth)
    out = []
    for x, y in pixels:
        rows, columns = y + offset[:, None], x + offset[None]
        fy, fx = rows % 1, columns % 1
        at = [np.clip(np.floor(rows).astype(int) + d, 0, height - 1) for d in (0, 1)]
        left = [np.clip(np.floor(columns).astype(int) + d, 0, width - 1) for d in (0, 1)]
        weights = [(1 - fy) * (1 - fx), (1 - fy) * fx, fy * (1 - fx), fy * fx]
        spots = [(at[0], left[0]), (at[0], left[1]), (at[1], left[0]), (at[1], left[1])]
        patch = sum(w[..., None] * ycbcr[spot] for w, spot in zip(weights, spots, strict=True))
        plain = np.einsum("i,j,ijc->c", smooth, smooth, patch)
        right = np.einsum("i,j,ijc->c", smooth, slope, patch)
        down = np.einsum("i,j,ijc->c", slope, smooth, patch)
        out.append(np.concatenate([plain[1:], right, down]))
    return np.array(out)


@pytest.fixture(scope="module")
def scene():
    return appearances.varying_ball()


@pytest.fixture(scope="module")
def camera():
    return shapes.view(appearances.PIXELS)[0]


@pytest.fixture(scope="module")
def frames(scene, camera):
    return appearances.sightings(scene, camera, 25)


@pytest.fixture(scope="module")
def front(scene):
    """Points of the ball that look towards the camera."""
    return np.flatnonzero(scene.mean[:, 2] > 0.6 * shapes.RADIUS)[::5]


@pytest.fixture(scope="module")
def model(frames, scene, front, camera):
    return learn_local(frames, scene, front, camera, RENDERER)


def test_the_matrix_is_the_papers():
    image = np.array([[[255, 255, 255], [0, 0, 0], [255, 0, 0]]], np.uint8)
    white, black, red = to_ycbcr(image)[0]
    np.testing.assert_allclose(white, [255, 127.5, 127.5], atol=0.01)
    np.testing.assert_allclose(black, [0, 127.5, 127.5])
    np.testing.assert_allclose(red, [56.61, 97.0275, 255], atol=1e-3)
    assert YCBCR.shape == (3, 4)
    assert YCBCR[0, :3].sum() == pytest.approx(1)


def test_the_filters_on_a_ramp_and_an_offset():
    y, x = np.mgrid[:40, :50].astype(float)
    grey = np.repeat((20 + 2 * x + 3 * y)[..., None], 3, axis=2)
    maps = DescriptorMaps.of(grey, np.array([1.5, 2.5]))
    for which in (0, 1):
        (found,) = maps.at(np.array([[20.3, 17.6]]), np.array([which]))
        values = dict(zip(COMPONENTS, found, strict=True))
        assert values["Y_x"] == pytest.approx(2, abs=1e-3)
        assert values["Y_y"] == pytest.approx(3, abs=1e-3)
        assert [values[c] for c in ("Cb", "Cr")] == pytest.approx([127.5, 127.5], abs=1e-3)
        assert [values[c] for c in ("Cb_x", "Cr_x", "Cb_y", "Cr_y")] == pytest.approx(
            [0] * 4, abs=1e-5
        )
    brighter = DescriptorMaps.of(grey + 30, np.array([1.5, 2.5]))
    np.testing.assert_allclose(brighter.maps, maps.maps, atol=1e-3)


def test_the_maps_are_the_definition():
    rng = np.random.default_rng(0)
    image = rng.integers(0, 255, (60, 70, 3)).astype(np.uint8)
    pixels = rng.uniform([12, 12], [57, 47], (15, 2))
    for sigma in (1.0, 2.3):
        maps = DescriptorMaps.of(image, np.array([sigma]))
        np.testing.assert_allclose(maps.at(pixels), around(image, pixels, sigma), atol=2e-3)
    batch = maps.at(np.stack([pixels, pixels + 1]))
    np.testing.assert_array_equal(batch[0], maps.at(pixels))
    assert np.isfinite(maps.at(np.array([[-1e9, 1e9], [np.nan, 3]]))).all()


def test_the_model_foretells_other_frames(model, scene, camera):
    """Descriptors of unseen frames are nearer to the linear model than to the constant one."""
    others = appearances.sightings(scene, camera, 6, seed=9)
    errors = {"lin": [], "cst": []}
    patches = Patches.around(scene, model.vertices)
    for other in others:
        points, _ = patches.surface(patches.placed(Candidates.one(other.parameters, other.pose), 0))
        found = DescriptorMaps.of(other.image, model.sigma[:1]).at(camera.project(points))
        for name, which in (("lin", model), ("cst", model.constant())):
            errors[name].append(((found - which.at(other.parameters)) ** 2).mean())
    assert np.mean(errors["lin"]) < 0.2 * np.mean(errors["cst"])
    assert 0.8 < model.explained <= 1


def test_hidden_points_are_left_out(frames, scene, front, camera):
    back = np.flatnonzero(scene.mean[:, 2] < -0.5 * shapes.RADIUS)[:4]
    mixed = learn_local(frames, scene, np.r_[front[:10], back], camera, RENDERER)
    assert np.all(mixed.seen[:10] == 1)
    assert np.all(mixed.seen[10:] == 0)
    chosen = choose_points(mixed, 14)
    assert sorted(chosen) == list(range(10))
    with pytest.raises(NothingSeenError):
        learn_local(frames, scene, back, camera, RENDERER)


def test_points_are_chosen_by_turns():
    modes = np.zeros((2, 5, 8))
    modes[0, :, 0] = [5, 4, 1, 0, 3]
    modes[1, :, 3] = [9, 1, 2, 3, 0]
    ones = np.ones((5, 8))
    reach = np.array([1.0, 0.5])
    model = LocalModel(
        np.arange(5), ones, modes, ones, np.ones(5), ones, np.zeros((1, 5, 8)), np.ones(5),
            np.ones(5), reach, 0.5,
    )  # fmt: skip
    np.testing.assert_allclose(reconstructed(model)[1], np.array([9, 1, 2, 3, 0]) ** 2 / 4)
    assert list(choose_points(model, 3)) == [0, 3, 1]  # 0 is the best of both: a duplicate
    assert sorted(choose_points(model)) == list(range(5))
    places = np.array([[0, 0, 0], [1, 0, 0], [9, 0, 0], [0.5, 0, 0], [20, 0, 0.0]])
    assert list(choose_points(model, 5, places, 2.0)) == [0, 2, 4]
    with pytest.raises(ParameterError, match="ranks no points"):
        choose_points(model.constant())
    with pytest.raises(ParameterError, match="no point is seen"):
        choose_points(replace(model, seen=np.zeros(5)))
    flat = replace(model, facing=np.array([0.2, 1, 1, 1, 1]))
    assert 0 not in choose_points(flat)


def test_patches_give_points_and_normals(scene, front):
    patches = Patches.around(scene, front)
    many = shapes.states(scene, 2)
    points, normals = patches.surface(patches.placed(many, 1))
    moved = scene.vertices(many.weights[1]) @ many.rotations[1].T + many.translations[1]
    np.testing.assert_allclose(points, moved[front], atol=1e-3)
    whole = vertex_normals(moved, scene.faces)[front]
    unit = normals / np.linalg.norm(normals, axis=1, keepdims=True)
    np.testing.assert_allclose(unit, whole, atol=1e-4)
    with pytest.raises(ParameterError, match="none of the"):
        Patches.around(scene, np.array([10**6]))
    with pytest.raises(ParameterError, match="not a list"):
        Patches.around(scene, np.array([-1]))


def test_windows_on_the_surface_turn_and_grow_with_it(scene, front):
    """A picture that turns and grows with the surface gives the same descriptors on it."""
    camera = shapes.view(192)[0]
    middle = front[np.linalg.norm(scene.mean[front, :2], axis=1) < 30]
    patches = Patches.around(scene, middle)
    unit = float(camera.matrix[0, 0] / (shapes.DISTANCE - shapes.RADIUS))
    dressed = replace(scene, texture_modes=None)
    found = {"rigid": [], "lying": []}
    for angle, distance in ((0.0, shapes.DISTANCE), (0.5, 0.8 * shapes.DISTANCE)):
        turn = rotations(np.array([[0, 0, angle]]))[0] @ Pose.facing(1.0).rotation
        pose = Pose(turn, np.array([0, 0, distance]))
        one = Candidates.one(np.zeros(scene.n_modes), pose)
        image = RENDERER.draw(dressed, one, camera, camera.whole)[0].rgb
        flat = camera.project(patches.placed(one, 0))
        for name, size in (("rigid", 0.0), ("lying", unit)):
            windows = Windows(patches, np.full(len(middle), 3.0), size)
            found[name].append(windows.read(DescriptorMaps.of(image, windows.scales), flat))
    change = {k: np.abs(a - b)[:, 2:].mean() for k, (a, b) in found.items()}
    assert change["lying"] < 0.25 * change["rigid"]
    rigid, lying = found["rigid"][0], found["lying"][0]  # head-on, both see the same
    assert np.corrcoef(rigid[:, 2:].ravel(), lying[:, 2:].ravel())[0, 1] > 0.97


def test_a_model_with_windows_on_the_surface(frames, scene, front, camera):
    model = learn_local(frames, scene, front, camera, RENDERER, unit=0.5)
    assert model.explained > 0.8
    assert LocalModel.from_arrays(model.arrays()).unit == 0.5


def test_bad_pictures_are_named(frames, scene, front, camera):
    image = frames[0].image.astype(float)
    image[0, 0, 1] = np.inf
    with pytest.raises(PictureError, match="1 pixels"):
        DescriptorMaps.of(image, np.ones(1))
    with pytest.raises(PictureError, match="shape"):
        to_ycbcr(image[..., 0])
    with pytest.raises(ParameterError, match="scale is 0"):
        kernels(0)
    with pytest.raises(ParameterError, match="no frames"):
        learn_local([], scene, front, camera, RENDERER)


def test_its_arrays_make_it_again(model):
    back = LocalModel.from_arrays(model.arrays())
    a = np.array([0.3, -1, 2])
    assert np.array_equal(back.at(a), model.at(a))
    assert np.array_equal(back.only(np.array([2, 0])).vertices, model.vertices[[2, 0]])
    constant = model.constant()
    assert np.array_equal(constant.at(np.zeros(3)), model.mean)
    assert len(constant.modes) == 0
    with pytest.raises(ParameterError, match="parameters for a model of 3"):
        model.at([1.0])
