"""OpenGL against the CPU rasteriser: the same ids, buffers and values."""

from __future__ import annotations

import numpy as np
import pytest
import shapes

from abs_engine.core.camera import Camera, Window
from abs_engine.core.scene import ClassMaps, ColourError, Scene
from abs_engine.render.cpu import CpuRenderer

pytestmark = pytest.mark.gl

BARREL = np.array([-0.2, 0.05, 0.003, -0.002, 0.01, 0, 0, 0])


def whole(camera: Camera) -> Window:
    return camera.whole


def crop(camera: Camera) -> Window:
    width, height = camera.size
    return Window(width * 0.2, height * 0.3, width * 0.6, height * 0.5, 1.5)


@pytest.fixture(params=[False, True], ids=["ideal", "distorted"])
def camera(request) -> Camera:
    ideal, _ = shapes.view(96)
    return Camera(ideal.matrix, ideal.size, BARREL) if request.param else ideal


def boundary(ids):
    """Pixels with another id above, below, left or right."""
    padded = np.pad(ids, 1, mode="edge")
    around = [padded[:-2, 1:-1], padded[2:, 1:-1], padded[1:-1, :-2], padded[1:-1, 2:]]
    return np.any([part != ids for part in around], axis=0)


def beside(what, renderer, camera, window, cull):
    """Drawings of both renderers, and where they show the same facet: all but a few borders."""
    scene = Scene(**{**vars(shapes.ball(shapes.SMALL)), "cull": cull})
    given = scene, shapes.states(scene, 4), camera, window
    both = (getattr(one, what)(*given) for one in (renderer, CpuRenderer()))
    for ours, oracle in zip(*both, strict=True):
        same = ours.facet_id == oracle.facet_id
        assert (~same).sum() <= 4
        assert (same | boundary(oracle.facet_id)).all()
        assert np.array_equal(ours.class_id[same], oracle.class_id[same])
        yield ours, oracle, same


@pytest.mark.parametrize("window_of", [whole, crop])
@pytest.mark.parametrize("cull", [True, False])
def test_buffers(renderer, camera, window_of, cull):
    for ours, oracle, same in beside("draw", renderer, camera, window_of(camera), cull):
        # llvmpipe interpolates from a facet's corner; at grazing facets that costs a few digits.
        steep = 1 / np.maximum(oracle.depth, 1) * np.abs(ours.depth - oracle.depth)
        assert steep[same].max() < 1e-4
        assert np.abs(ours.barycentrics - oracle.barycentrics)[same].max() < 0.02
        assert np.abs(ours.barycentrics - oracle.barycentrics)[same].mean() < 1e-4
        assert np.abs(ours.rgb - oracle.rgb)[same].max() < 0.25


@pytest.mark.parametrize("window_of", [whole, crop])
@pytest.mark.parametrize("cull", [True, False])
def test_outlines(renderer, camera, window_of, cull):
    for ours, oracle, same in beside("outlines", renderer, camera, window_of(camera), cull):
        seen = boundary(oracle.class_id) & same & (oracle.facet_id > 0)
        assert seen.any()
        np.testing.assert_allclose(ours.depth[seen], oracle.depth[seen], rtol=1e-4)
        assert np.abs(ours.barycentrics - oracle.barycentrics)[seen].max() < 0.02


def test_what_is_out_of_the_picture_has_no_outline(renderer, camera):
    scene, window = shapes.ball(shapes.SMALL), Window(1e4, 1e4, 40.0, 40.0, 1.0)
    (one,) = renderer.outlines(scene, shapes.states(scene, 1), camera, window)
    assert not one.facet_id.any()
    assert one.facet_id.shape == (40, 40)


@pytest.mark.parametrize("window_of", [whole, crop])
def test_objectives(renderer, camera, window_of):
    scene = shapes.ball(shapes.SMALL)
    window = window_of(camera)
    width, height = window.drawn
    rng = np.random.default_rng(2)
    many = shapes.states(scene, 8)
    oracle = CpuRenderer()
    for term in (
        ClassMaps(rng.uniform(0, 5, (5, height, width))),
        ColourError(rng.uniform(0, 255, (height, width, 3))),
    ):
        ours = renderer.measure(scene, many, camera, window, term)
        theirs = oracle.measure(scene, many, camera, window, term)
        assert ours.total == pytest.approx(theirs.total, rel=1e-3)
        assert np.abs(ours.pixels - theirs.pixels).max() <= 2


def test_they_agree_on_which_candidate_is_best(renderer):
    """The value's differences are what a solver sees: they must agree far below those."""
    scene = shapes.ball(shapes.SMALL)
    camera, window = shapes.view(64)
    many = shapes.states(scene, 30)
    oracle = CpuRenderer()
    frame = ColourError(oracle.draw(scene, shapes.states(scene, 1, seed=9), camera, window)[0].rgb)
    ours = renderer.measure(scene, many, camera, window, frame).total
    theirs = oracle.measure(scene, many, camera, window, frame).total
    assert np.abs(ours - theirs).max() < 1e-3 * np.ptp(theirs)
    assert np.array_equal(np.argsort(ours), np.argsort(theirs))


def varying(n_modes: int = 8) -> Scene:
    """A ball whose texture depends on its weights, so strongly that some of it is clipped."""
    ball = shapes.ball(shapes.SMALL, n_modes)
    height, width, _ = ball.texture.shape
    blobs = [shapes.noise_texture(width, height, 10 + k).astype(float) for k in range(n_modes)]
    layers = 0.8 * (np.stack(blobs) - 127)
    return Scene(**{**vars(ball), "texture_modes": layers})


@pytest.mark.parametrize("window_of", [whole, crop])
def test_a_texture_that_depends_on_the_weights(renderer, camera, window_of):
    scene, window = varying(), window_of(camera)
    many = shapes.states(scene, 5)
    width, height = window.drawn
    term = ColourError(np.random.default_rng(2).uniform(0, 255, (height, width, 3)))
    oracle = CpuRenderer()
    ours = renderer.measure(scene, many, camera, window, term)
    theirs = oracle.measure(scene, many, camera, window, term)
    assert ours.total == pytest.approx(theirs.total, rel=1e-3)
    assert np.abs(ours.pixels - theirs.pixels).max() <= 2
    for drawn, known in zip(
        renderer.draw(scene, many, camera, window),
        oracle.draw(scene, many, camera, window),
        strict=True,
    ):
        same = drawn.facet_id == known.facet_id
        assert np.abs(drawn.rgb - known.rgb)[same].max() < 0.5
        assert known.rgb[known.covered].max() == 255


def test_a_picture_shows_the_texture_of_its_weights(renderer, camera):
    scene = varying()
    many = shapes.states(scene, 2)
    pictures = renderer.picture(scene, many, camera, camera.whole, 1)
    for picture, known in zip(
        pictures, CpuRenderer().draw(scene, many, camera, camera.whole), strict=True
    ):
        inside = known.covered & ~boundary(known.facet_id)
        assert np.abs(picture.astype(int) - known.image)[inside].max() <= 1
