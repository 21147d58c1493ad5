"""What a texture model leaves out of its frames whitens differences; outlines are left out of S."""

from __future__ import annotations

import numpy as np
import pytest
import shapes

from abs_engine.compare.descriptor import off_outlines
from abs_engine.compare.whiten import TextureNoise
from abs_engine.core.buffers import Buffers
from abs_engine.core.camera import Camera
from abs_engine.core.geometry import Pose
from abs_engine.core.scene import Candidates
from abs_engine.face.appearance.atlas import lay_atlas
from abs_engine.face.appearance.regression import Frames
from abs_engine.face.appearance.residual_covariance import Leftover, leftover, normalised
from abs_engine.face.settings.appearance import APPEARANCE
from abs_engine.render.cpu import CpuRenderer

RENDERER = CpuRenderer()
SIZE = 32


@pytest.fixture(scope="module")
def seen():
    scene, (camera, _) = shapes.ball(), shapes.view(64)
    still = Candidates.one(np.zeros(scene.n_modes), Pose.facing(shapes.DISTANCE))
    return scene, camera, RENDERER.draw(scene, still, camera, camera.whole)[0]


def test_normalised_does_not_depend_on_brightness():
    rgb = np.array([[30.0, 20.0, 10.0]])
    np.testing.assert_allclose(normalised(10 * rgb), normalised(rgb), atol=0.02)
    assert normalised(rgb).sum() == pytest.approx(1.0)


@pytest.mark.parametrize("kind", [np.uint8, np.int64, np.float32, np.float64])
def test_normalised_takes_any_numbers(kind):
    """Of 8-bit pictures too: 255 + 1 is not 0, and shares of whole numbers are not whole."""
    rgb = np.array([[255, 20, 10], [255, 255, 255]])
    found = normalised(rgb.astype(kind))
    assert np.issubdtype(found.dtype, np.floating)
    np.testing.assert_allclose(found, (rgb + 1.0) / (rgb.sum(axis=1, keepdims=True) + 3), rtol=1e-6)


def test_spread_and_common_noise_are_found(seen):
    """Half of the texels twice as noisy as the others, and a pattern that all have in common."""
    scene, *_ = seen
    atlas = lay_atlas(scene, (SIZE, SIZE), RENDERER)
    k, rng = len(atlas.texels[0]), np.random.default_rng(1)
    parameters = rng.normal(size=(60, 2))
    own = np.where(np.arange(k) < k // 2, 0.01, 0.02)[:, None]
    pattern = rng.normal(size=(k, 3)) * own
    values = 0.3 + own * rng.normal(size=(60, k, 3)) + rng.normal(size=(60, 1, 1)) * pattern
    frames = Frames(values.astype(np.float32), np.ones((60, k), np.bool_), parameters)
    found = leftover(frames, 1.0, atlas)
    spread = found.spread[atlas.texels]
    assert np.median(spread[k // 2 :]) == pytest.approx(2 * np.median(spread[: k // 2]), rel=0.1)
    first = found.common[0][atlas.texels].ravel()
    assert abs(np.corrcoef(first, (pattern / own).ravel())[0, 1]) > 0.95
    strength = (found.common**2).sum(axis=(1, 2, 3))
    assert strength[0] > 5 * strength[1]


@pytest.mark.parametrize("strength", [1.0, 2.0, 4.0])
def test_what_is_measured_whitens_other_frames(seen, strength):
    """Noise of some frames is measured, that of others whitened: it has variance 1 all over.

    Half as strong as the rest or less, so few frames do not tell where it points.
    """
    scene, *_ = seen
    atlas = lay_atlas(scene, (SIZE, SIZE), RENDERER)
    k, rng = len(atlas.texels[0]), np.random.default_rng(3)
    pattern = strength * rng.normal(size=(k, 3))

    def drawn(count: int) -> np.ndarray:
        return 0.01 * (rng.normal(size=(count, 1, 1)) * pattern + rng.normal(size=(count, k, 3)))

    values = (0.3 + drawn(60)).astype(np.float32)
    seen_all = np.ones((60, k), np.bool_)
    found = leftover(Frames(values, seen_all, rng.normal(size=(60, 1))), 1.0, atlas)
    v = found.common[:, *atlas.texels].reshape(len(found.common), -1).astype(np.float64)
    fresh = drawn(300).reshape(300, -1) / np.repeat(found.spread[atlas.texels], 3)
    squared, axes = np.linalg.eigh(v @ v.T)
    unit = axes.T @ v / np.sqrt(squared)[:, None]
    white = fresh - (fresh @ unit.T * (1 - 1 / np.sqrt(1 + squared))) @ unit
    assert white.var() == pytest.approx(1.0, abs=0.2)
    along = pattern.ravel() / np.linalg.norm(pattern)
    assert np.var(white @ along) < 3.0  # its direction is known from 60 frames only
    assert np.var(fresh @ along) > 20.0


def test_too_few_frames_say_nothing(seen):
    scene, *_ = seen
    atlas = lay_atlas(scene, (SIZE, SIZE), RENDERER)
    k = len(atlas.texels[0])
    one = Frames(np.zeros((1, k, 3), np.float32), np.ones((1, k), np.bool_), np.zeros((1, 2)))
    found = leftover(one, 1.0, atlas)
    assert (found.spread == 1).all()
    assert len(found.common) == 0


def test_common_noise_becomes_white(seen):
    """Noise drawn as the model has it, whitened: each pixel and all together have variance 1."""
    scene, _, drawn = seen
    rng = np.random.default_rng(2)
    common = rng.normal(size=(2, SIZE, SIZE, 3)).astype(np.float32)
    noise = TextureNoise(Leftover(np.full((SIZE, SIZE), 0.1, np.float32), common).layers)
    plain = TextureNoise(Leftover(np.full((SIZE, SIZE), 0.1, np.float32), common[:0]).layers)
    where = drawn.covered
    read = noise._at(scene, drawn, where)[:, 1:]
    v = read.reshape(len(read), 2, 3).transpose(1, 0, 2).reshape(2, -1)
    off = 0.1 * (rng.normal(size=(400, 2)) @ v + rng.normal(size=(400, v.shape[1])))
    white = [
        noise.whitened(o.reshape(-1, 3).astype(np.float32), scene, drawn, where).ravel()
        for o in off
    ]
    assert np.var(white) == pytest.approx(1.0, rel=0.05)
    along = v[0] / np.linalg.norm(v[0])
    assert np.var(off @ along) / 0.01 > 50
    assert np.var(np.array(white) @ along) == pytest.approx(1.0, rel=0.25)
    same = plain.whitened(off[0].reshape(-1, 3).astype(np.float32), scene, drawn, where)
    np.testing.assert_allclose(same.ravel(), 10 * off[0], rtol=1e-4, atol=1e-5)


def test_pixels_beside_an_outline_are_left_out(seen):
    _, camera, drawn = seen
    inner = off_outlines(drawn, camera, camera.whole)
    assert inner.any()
    assert (inner <= drawn.covered).all()
    rows, columns = np.nonzero(inner)
    for row in (-1, 0, 1):
        for column in (-1, 0, 1):
            assert drawn.covered[rows + row, columns + column].all()
    left = drawn.covered & ~inner
    assert 0 < left.sum() < 0.35 * drawn.covered.sum()


def walls(*depths: float) -> tuple[Camera, Buffers]:
    """Walls that face the camera, side by side and equally wide, mm from it; all else is empty."""
    camera, window = shapes.view(64)
    focal, corners = float(camera.matrix[0, 0]), []
    edges = np.linspace(-24, 24, len(depths) + 1) * [1.0 / focal]
    for depth, left, right in zip(depths, edges[:-1], edges[1:], strict=True):
        x, y = np.array([left, right, right, left]), 24 / focal * np.array([-1, -1, 1, 1])
        square = depth * np.column_stack([x, y, np.ones(4)])
        corners += [square[[0, 1, 2]], square[[0, 2, 3]]]
    return camera, shapes.draw_one(RENDERER, shapes.triangles(corners), camera, window)


def test_both_sides_of_a_step_between_drawn_surfaces_are_left_out():
    """The near surface ends there, and the far one has its outline before it."""
    camera, drawn = walls(500.0, 500.0)
    same = off_outlines(drawn, camera, camera.whole)
    camera, drawn = walls(500.0, 560.0)
    found = off_outlines(drawn, camera, camera.whole)
    row = 32
    near, far = (np.flatnonzero(np.isclose(drawn.depth[row], z, atol=1)) for z in (500, 560))
    assert len(near) > 20
    assert len(far) > 20
    assert far[0] == near[-1] + 1
    assert not found[:, [near[-1], far[0]]].any()
    beside = [near[-2], far[1]]
    np.testing.assert_array_equal(found[:, beside], same[:, beside])
    assert found[row, beside].all()
    assert same[row, [near[-1], far[0]]].all()


@pytest.mark.parametrize("share", [0.9, 1.1])
def test_a_step_counts_from_the_flattest_surface_that_is_learned(share):
    camera, _ = shapes.view(64)
    step = np.tan(np.arccos(APPEARANCE.facing)) * 500 / float(camera.matrix[0, 0])
    camera, drawn = walls(500.0, 500.0 + share * step)
    found = off_outlines(drawn, camera, camera.whole)[32]
    left = np.flatnonzero(drawn.depth[32] == drawn.depth[32, 20])[-1]
    assert found[left] == (share < 1)
