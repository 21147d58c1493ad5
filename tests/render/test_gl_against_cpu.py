"""OpenGL against the CPU rasteriser: the same ids, buffers and values."""

from __future__ import annotations

import numpy as np
import pytest
import shapes
from snapping import allowed

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


def ball(cull):
    return Scene(**{**vars(shapes.ball(shapes.SMALL)), "cull": cull})


def with_allowed(gl, drawn, camera, window, cull):
    """Each drawing with how far it may lie off, and at few pixels it may show another facet."""
    scene = ball(cull)
    limits = allowed(gl, scene, shapes.states(scene, 4), camera, window)
    for (ours, oracle, same), limit in zip(drawn, limits, strict=True):
        assert np.isfinite(limit.depth).mean() > 0.98
        yield ours, oracle, same & np.isfinite(limit.depth), limit


def beyond(name, ours, oracle, limit, where, summary=np.max):
    """By how much values differ beyond what is allowed, over some pixels."""
    one, other, allowed_there = (getattr(part, name)[where] for part in (ours, oracle, limit))
    return summary(np.maximum(np.abs(one - other) - allowed_there, 0))


def beside(what, renderer, camera, window, cull):
    """Drawings of both renderers, and where they show the same facet: all but a few borders."""
    scene = ball(cull)
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
def test_buffers(gl, renderer, camera, window_of, cull):
    drawn = beside("draw", renderer, camera, window_of(camera), cull)
    for ours, oracle, same, more in with_allowed(gl, drawn, camera, window_of(camera), cull):
        # llvmpipe interpolates from a facet's corner; at grazing facets that costs a few digits.
        assert (
            beyond("depth", ours, oracle, more, same)
            < 1e-4 * oracle.depth[same & oracle.covered].min()
        )
        assert beyond("barycentrics", ours, oracle, more, same) < 0.02
        assert beyond("barycentrics", ours, oracle, more, same, np.mean) < 1e-4
        assert beyond("rgb", ours, oracle, more, same) < 0.25


@pytest.mark.parametrize("window_of", [whole, crop])
@pytest.mark.parametrize("cull", [True, False])
def test_outlines(gl, renderer, camera, window_of, cull):
    drawn = beside("outlines", renderer, camera, window_of(camera), cull)
    for ours, oracle, same, more in with_allowed(gl, drawn, camera, window_of(camera), cull):
        seen = boundary(oracle.class_id) & same & (oracle.facet_id > 0)
        assert seen.any()
        assert beyond("depth", ours, oracle, more, seen) < 1e-4 * oracle.depth[seen].min()
        assert beyond("barycentrics", ours, oracle, more, seen) < 0.02


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
def test_a_texture_that_depends_on_the_weights(gl, renderer, camera, window_of):
    scene, window = varying(), window_of(camera)
    many = shapes.states(scene, 5)
    limits = allowed(gl, scene, many, camera, window)
    width, height = window.drawn
    term = ColourError(np.random.default_rng(2).uniform(0, 255, (height, width, 3)))
    oracle = CpuRenderer()
    ours = renderer.measure(scene, many, camera, window, term)
    theirs = oracle.measure(scene, many, camera, window, term)
    assert ours.total == pytest.approx(theirs.total, rel=1e-3)
    assert np.abs(ours.pixels - theirs.pixels).max() <= 2
    for drawn, known, limit in zip(
        renderer.draw(scene, many, camera, window),
        oracle.draw(scene, many, camera, window),
        limits,
        strict=True,
    ):
        same = (drawn.facet_id == known.facet_id) & np.isfinite(limit.depth)
        assert (np.abs(drawn.rgb - known.rgb) - limit.rgb)[same].max() < 0.5
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
