"""The linear texture: comes back from frames it was drawn with; what is hidden is not learned."""

from __future__ import annotations

from dataclasses import replace

import appearances
import numpy as np
import pytest
import shapes

from abs_engine.core.camera import Camera
from abs_engine.core.errors import (
    NothingSeenError,
    ParameterError,
    PictureError,
)
from abs_engine.core.geometry import Pose
from abs_engine.core.scene import Candidates
from abs_engine.face.appearance.atlas import fitting_size, lay_atlas, warp
from abs_engine.face.appearance.regression import LinearFits
from abs_engine.face.appearance.texture import TextureModel, learn_texture
from abs_engine.face.appearance.visibility import Sighting, in_sight
from abs_engine.render.cpu import CpuRenderer

RENDERER = CpuRenderer()


@pytest.fixture(scope="module")
def scene():
    return appearances.varying_ball()


@pytest.fixture(scope="module")
def camera():
    return shapes.view(appearances.PIXELS)[0]


@pytest.fixture(scope="module")
def atlas(scene, camera):
    size = fitting_size(scene, camera, Pose.facing(shapes.DISTANCE))
    return lay_atlas(scene, size, RENDERER)


@pytest.fixture(scope="module")
def frames(scene, camera):
    return appearances.sightings(scene, camera, 25)


@pytest.fixture(scope="module")
def model(frames, scene, atlas, camera):
    return learn_texture(frames, scene, atlas, camera, RENDERER)


def square(z: float, x: float) -> np.ndarray:
    """Two triangles, 60 mm squared, in the camera frame, that face the camera."""
    corner = np.array([[-30, -30, z], [30, -30, z], [30, 30, z], [-30, 30, z]], float)
    corner[:, 0] += x
    return corner[[[2, 1, 0], [3, 2, 0]]]


def test_an_atlas_is_as_fine_as_the_picture(atlas, scene):
    assert atlas.facet_id.shape[0] == atlas.facet_id.shape[1]
    assert 64 <= atlas.facet_id.shape[0] <= 128  # the ball is about 90 px across, 0.9 of the atlas
    rows, columns = atlas.texels
    points, _ = atlas.surface(np.column_stack([scene.uv, np.zeros(len(scene.uv))]))
    place = (np.column_stack([columns, rows]) + 0.5) / atlas.facet_id.shape[0]
    assert np.abs(points[:, :2] - place).max() < 1e-3


def test_what_was_drawn_is_learned(model, scene, atlas):
    rows, columns = atlas.texels
    seen = model.frames > 20
    assert seen.sum() > 1000
    here = np.stack([(columns + 0.5), (rows + 0.5)], axis=1) / atlas.facet_id.shape[0]
    at = (here * [scene.texture.shape[1], scene.texture.shape[0]] - 0.5).round().astype(int)
    known = seen[rows, columns]
    for got, true in (
        (model.base, scene.texture.astype(float)),
        (model.modes[0], scene.texture_modes[0]),
        (model.modes[2], scene.texture_modes[2]),
    ):
        ours, theirs = got[rows, columns][known], true[at[:, 1], at[:, 0]][known]
        assert np.abs(ours - theirs).mean() < 1.5
        assert np.corrcoef(ours.ravel(), theirs.ravel())[0, 1] > 0.97
    assert 0.9 < model.explained <= 1


def test_synthesis_and_constant_twins(model):
    a = np.array([1.0, -0.5, 0.3])
    made = np.clip(model.base + np.tensordot(a, model.modes, 1), 0, 255)
    assert np.abs(model.at(a) - made).max() <= 0.5
    assert np.array_equal(model.constant().at(a), np.rint(np.clip(model.mean, 0, 255)))
    low, high = model.nomogram(1, [-2, 2])
    assert np.array_equal(high, model.at([0, 2, 0]))
    assert not np.array_equal(low, high)
    with pytest.raises(ParameterError, match="no parameter 3"):
        model.nomogram(3, [0])
    with pytest.raises(ParameterError, match="for a texture of 3"):
        model.at([1.0])


def test_a_dressed_scene_draws_the_synthesis(model, scene, camera, frames):
    plain = replace(scene, texture_modes=None)
    dressed = model.dress(plain)
    sighting = frames[3]
    many = Candidates.one(sighting.parameters, sighting.pose)
    drawn = RENDERER.draw(dressed, many, camera, camera.whole)[0]
    assert np.abs(drawn.rgb - sighting.image)[drawn.covered].mean() < 2.5
    assert model.constant().dress(plain).texture_modes is None
    fewer = replace(plain, modes=plain.modes[:2])
    with pytest.raises(ParameterError, match="scene has 2 modes"):
        model.dress(fewer)
    more = replace(plain, modes=np.concatenate([plain.modes] * 2))
    assert not model.dress(more).texture_modes[3:].any()


def test_what_is_hidden_is_not_learned():
    """A green square behind a red one: half of it is never seen."""
    camera = Camera.ideal((96, 96), focal=300)
    base = shapes.triangles(np.concatenate([square(500, 0), square(600, 30)]))
    quarter = np.array([[0.05, 0.05], [0.45, 0.05], [0.45, 0.45], [0.05, 0.45]])
    uv = np.concatenate([quarter, quarter + 0.5])[[2, 1, 0, 3, 2, 0, 6, 5, 4, 7, 6, 4]]
    scene = replace(base, uv=uv, facet_class=[1, 1, 2, 2])
    still = Pose(np.eye(3), np.zeros(3))
    drawn = shapes.draw_one(RENDERER, scene, camera)
    image = np.zeros((96, 96, 3), np.uint8)
    image[np.isin(drawn.class_id, 1)] = [200, 0, 0]
    image[np.isin(drawn.class_id, 2)] = [0, 200, 0]
    atlas = lay_atlas(scene, (64, 64), RENDERER)
    sighting = Sighting(image, scene.mean, still, np.zeros(0))
    colours, weights = warp(sighting, atlas, scene, camera, RENDERER)
    kind = scene.facet_class[atlas.facet_id[atlas.texels] - 1]
    shown = weights > 0
    assert (shown & (kind == 1)).sum() > 50
    assert 0 < (shown & (kind == 2)).sum() < 0.8 * (kind == 2).sum()
    assert np.array_equal(np.unique(colours[shown & (kind == 1)], axis=0), [[200, 0, 0]])
    assert np.array_equal(np.unique(colours[shown & (kind == 2)], axis=0), [[0, 200, 0]])
    model = learn_texture([sighting], scene, atlas, camera, RENDERER)
    rows, columns = atlas.texels
    assert np.array_equal(model.frames[rows, columns] > 0, shown)
    unseen = ~shown & (kind == 2)  # filled from the nearest of their own class
    assert np.array_equal(np.unique(model.mean[rows, columns][unseen], axis=0), [[0, 200, 0]])


def test_turned_away_and_outside_are_not_in_sight():
    camera = Camera.ideal((64, 64), focal=100)
    depth = np.full((64, 64), 500, np.float32)
    points = np.array([[0, 0, 500], [0, 0, 500], [0, 0, 520], [400, 0, 500], [0, 0, -500.0]])
    normals = np.array([[0, 0, -2], [0, 0, 1], [0, 0, -1], [0, 0, -1], [0, 0, 1.0]])
    found = in_sight(points, normals, depth, camera, camera.whole)
    np.testing.assert_allclose(found, [1, 0, 0, 0, 0])
    assert in_sight(points[:1], normals[:1], 0 * depth, camera, camera.whole)[0] == 1
    assert in_sight(points[:1], normals[:1], 0 * depth, camera, camera.whole, margin=True)[0] == 0


def test_a_texture_with_no_visible_texel(frames, scene, atlas, camera):
    away = replace(frames[0], pose=Pose(np.eye(3), np.array([0, 0, -900.0])))
    with pytest.raises(NothingSeenError, match="no training frame shows"):
        learn_texture([away], scene, atlas, camera, RENDERER)


def test_bad_frames_are_named(frames, scene, atlas, camera):
    image = frames[0].image.astype(float)
    image[3, 4] = np.nan
    with pytest.raises(PictureError, match="1 pixels"):
        replace(frames[0], image=image)
    with pytest.raises(ParameterError, match="no frames"):
        learn_texture([], scene, atlas, camera, RENDERER)
    other = replace(frames[1], parameters=np.zeros(2))
    with pytest.raises(ParameterError, match="give 3 for every frame"):
        learn_texture([frames[0], other], scene, atlas, camera, RENDERER)
    small = replace(frames[0], image=frames[0].image[:50])
    with pytest.raises(PictureError, match="96x50"):
        learn_texture([small], scene, atlas, camera, RENDERER)
    fewer = replace(frames[0], vertices=frames[0].vertices[:-1])
    with pytest.raises(ParameterError, match="the same mesh"):
        learn_texture([fewer], scene, atlas, camera, RENDERER)


def test_few_frames_hardly_depend_on_the_parameters():
    """Two frames cannot tell five slopes: the ridge spreads little over them, and all is finite."""
    rng = np.random.default_rng(0)
    fits = LinearFits(2, 1, 5)
    rows = rng.normal(0, 1, (40, 5))
    slope = np.array([1.0, 0, 2, 0, -1])
    for k, row in enumerate(rows):
        value = 10 + row @ slope
        fits.add(np.full((2, 1), value), np.array([1.0, float(k < 2)]), row)
    found = fits.solve(0.1)
    np.testing.assert_allclose(found.modes[:, 0, 0], slope, atol=0.05)
    assert np.abs(found.modes[:, 1]).max() < 2.5
    assert list(found.frames) == [40, 2]
    assert found.explained > 0.99


def test_its_arrays_make_it_again(model):
    back = TextureModel.from_arrays(model.arrays())
    for name in ("base", "modes", "mean", "frames"):
        assert np.array_equal(getattr(back, name), getattr(model, name))
    assert back.explained == model.explained
    for name in ("spread", "common"):
        assert np.array_equal(getattr(back.leftover, name), getattr(model.leftover, name))
