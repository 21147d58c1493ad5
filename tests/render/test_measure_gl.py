"""Batches, the fused comparison, the two vertex paths and what is left behind."""

from __future__ import annotations

import gc

import numpy as np
import pytest
import shapes
from gl_objects import live_objects
from shapes import FISHY, STILL, draw_one, triangles
from snapping import allowed

from abs_engine.core.buffers import Buffers
from abs_engine.core.camera import Camera
from abs_engine.core.errors import OpenGLError, ParameterError
from abs_engine.core.scene import Candidates, ClassMaps, ColourError, Scene
from abs_engine.render import targets
from abs_engine.render.layout import class_layout, facet_layout
from abs_engine.render.raster import OpenGLRenderer

pytestmark = pytest.mark.gl


def terms_for(seen: Buffers, seed: int = 3):
    rng = np.random.default_rng(seed)
    noisy = np.clip(seen.rgb + rng.normal(0, 12, seen.rgb.shape), 0, 255)
    return ClassMaps(rng.uniform(0, 4, (5, *seen.depth.shape))), ColourError(noisy)


def class_value(seen: Buffers, term: ClassMaps) -> float:
    rows, columns = np.nonzero(seen.covered)
    classes = seen.class_id[rows, columns]
    return float(term.maps.astype(np.float64)[classes, rows, columns].sum())


def colour_value(seen: Buffers, term: ColourError) -> float:
    def normal(image):
        image = image.astype(np.float64)
        return (image + 1) / (image.sum(axis=2, keepdims=True) + 3)

    difference = normal(term.frame) - normal(seen.rgb)
    return float((difference**2).sum(axis=2)[seen.covered].sum())


@pytest.mark.parametrize("cull", [True, False])
@pytest.mark.parametrize("size", [1.0, 3.0, 60.0, 900.0])
def test_no_facet_is_left_out_that_would_be_seen(renderer, size, cull):
    """`measure` submits only what can matter, `draw` everything; they see the same pixels."""
    rng = np.random.default_rng(8)
    middle = rng.uniform([-250, -250, 5], [250, 250, 700], (8000, 1, 3))
    corners = middle + rng.normal(0, size, (8000, 3, 3))
    scene = triangles(corners, classes=1 + np.arange(8000) % 4, cull=cull)
    camera = Camera.ideal((61, 47), 60.0)
    seen = draw_one(renderer, scene, camera)
    term = ClassMaps(rng.uniform(0, 1, (5, 47, 61)))
    sums = renderer.measure(scene, STILL, camera, camera.whole, term)
    assert seen.covered.sum() > 20
    assert sums.pixels[0] == seen.covered.sum()
    assert sums.total[0] == pytest.approx(class_value(seen, term), rel=1e-5)


@pytest.mark.parametrize("pixels", [64, 96])
@pytest.mark.parametrize("distortion", [np.zeros(8), FISHY], ids=["ideal", "distorted"])
def test_the_fused_value_is_that_of_the_buffers(renderer, pixels, distortion):
    scene = shapes.ball(shapes.SMALL)
    ideal, window = shapes.view(pixels)
    camera = Camera(ideal.matrix, ideal.size, distortion)
    many = shapes.states(scene, 6)
    drawn = renderer.draw(scene, many, camera, window)
    class_maps, colour = terms_for(drawn[0])
    for term, value in ((class_maps, class_value), (colour, colour_value)):
        sums = renderer.measure(scene, many, camera, window, term)
        assert sums.total == pytest.approx([value(seen, term) for seen in drawn], rel=1e-5)
        assert sums.pixels.tolist() == [int(seen.covered.sum()) for seen in drawn]
        assert (sums.total.dtype, sums.pixels.dtype) == (np.float64, np.int64)
    assert sums.total.min() > 0.1  # there was something to compare


def test_a_batch_equals_single_calls_bit_for_bit(renderer):
    scene = shapes.ball(shapes.SMALL)
    camera, window = shapes.view(64)
    many = shapes.states(scene, 5)
    singles = [
        Candidates(*(part[i : i + 1] for part in vars(many).values())) for i in range(len(many))
    ]
    drawn = renderer.draw(scene, many, camera, window)
    for seen, one in zip(drawn, singles, strict=True):
        alone = renderer.draw(scene, one, camera, window)[0]
        for name, part in vars(seen).items():
            assert np.array_equal(part, getattr(alone, name)), name
    for term in terms_for(drawn[0]):
        sums = renderer.measure(scene, many, camera, window, term)
        alone = [renderer.measure(scene, one, camera, window, term) for one in singles]
        assert sums.total.tolist() == [s.total[0] for s in alone]
        assert sums.pixels.tolist() == [s.pixels[0] for s in alone]


def test_a_batch_is_cut_into_parts_where_it_must_be(gl, monkeypatch):
    monkeypatch.setattr("abs_engine.render.instanced.MAX_LAYERS", 3)
    scene = shapes.ball(1, 2)
    camera, window = shapes.view(32)
    many = shapes.states(scene, 8)
    with OpenGLRenderer(gl, "instanced") as parts, OpenGLRenderer(gl, "thin") as thin:
        drawn = parts.draw(scene, many, camera, window)
        term = ClassMaps(np.ones((5, 32, 32)))
        sums = parts.measure(scene, many, camera, window, term)
        assert len(drawn) == 8
        assert sums.pixels.tolist() == [int(seen.covered.sum()) for seen in drawn]
        near = thin.measure(scene, many, camera, window, term)
        assert np.abs(near.pixels - sums.pixels).max() <= 2


def test_an_empty_batch(renderer):
    scene = shapes.ball(1, 2)
    camera, window = shapes.view(32)
    none = shapes.states(scene, 0)
    assert renderer.draw(scene, none, camera, window) == []
    sums = renderer.measure(scene, none, camera, window, ClassMaps(np.ones((5, 32, 32))))
    assert len(sums.total) == 0


@pytest.mark.parametrize("distortion", [np.zeros(8), FISHY], ids=["ideal", "distorted"])
def test_the_two_paths_agree(gl, distortion):
    scene = shapes.ball(shapes.LARGE)
    ideal, window = shapes.view(128)
    camera = Camera(ideal.matrix, ideal.size, distortion)
    many = shapes.states(scene, 4)
    with OpenGLRenderer(gl, "thin") as thin, OpenGLRenderer(gl, "instanced") as instanced:
        pairs = list(
            zip(
                thin.draw(scene, many, camera, window),
                instanced.draw(scene, many, camera, window),
                strict=True,
            )
        )
        limits = allowed(gl, scene, many, camera, window)
        for (a, b), limit in zip(pairs, limits, strict=True):
            same = a.facet_id == b.facet_id
            assert (~same).sum() <= 4  # float32 against float64 projection
            same &= np.isfinite(limit.depth)  # a vertex may be rounded the other way, by a step
            assert (np.abs(a.depth - b.depth) - 2 * limit.depth)[same].max() < 0.05
            assert (np.abs(a.rgb - b.rgb) - 2 * limit.rgb)[same].max() < 0.1
        borders = (r.outlines(scene, many, camera, window) for r in (thin, instanced))
        for one, other in zip(*borders, strict=True):
            assert (one.facet_id != other.facet_id).sum() <= 4
        for term in terms_for(pairs[0][0]):
            one, other = (r.measure(scene, many, camera, window, term) for r in (thin, instanced))
            assert one.total == pytest.approx(other.total, rel=1e-3)


def test_a_thousand_renders_leave_nothing_behind(gl):
    camera, window = shapes.view(32)
    rng = np.random.default_rng(5)
    before = live_objects(gl)
    with OpenGLRenderer(gl, "thin") as thin, OpenGLRenderer(gl, "instanced") as instanced:
        kept = shapes.ball(1, 2)
        term = ClassMaps(np.ones((5, 32, 32)))
        counts = []
        for i in range(1000):
            renderer = (thin, instanced)[i % 2]
            scene = shapes.ball(0, 1, seed=i) if i % 10 < 2 else kept  # scenes come and go
            one = shapes.states(scene, 1 + i % 2, seed=i)
            if i % 4 < 2:
                renderer.draw(scene, one, camera, window)
            elif i % 8 < 4:
                renderer.measure(scene, one, camera, window, term)
            else:
                frame = ColourError(rng.uniform(0, 255, (32, 32, 3)))  # frames come and go
                renderer.measure(scene, one, camera, window, frame)
            if i % 250 == 249:
                del scene, one
                gc.collect()
                with gl.current():
                    for owner in (thin, instanced):
                        owner._scenes.sweep()
                        owner._terms.sweep()
                counts.append(live_objects(gl))
        assert counts[0] == counts[1] == counts[2] == counts[3]
        assert counts[0] != before
    assert live_objects(gl) == before


def test_sizes_come_and_go_in_the_pool(gl):
    scene = shapes.ball(0, 1)
    before = live_objects(gl)
    with OpenGLRenderer(gl, "thin") as renderer:
        for pixels in range(8, 40):
            camera, window = shapes.view(pixels)
            renderer.draw(scene, shapes.states(scene, 1), camera, window)
        held = live_objects(gl)["Framebuffer"] - before["Framebuffer"]
        assert 0 < held <= targets.POOL_SIZE
    assert live_objects(gl) == before


def test_pictures_are_smooth_where_buffers_are_not(renderer):
    camera = Camera.ideal((32, 32), 60.0)
    scene = triangles([[[-90, -90, 400], [90, -60, 400], [0, 110, 400]]])
    picture = renderer.picture(scene, STILL, camera, camera.whole, 4)[0]
    seen = draw_one(renderer, scene, camera)
    assert (picture.shape, picture.dtype) == ((32, 32, 3), np.uint8)
    assert set(np.unique(seen.image)) == {0, 200}
    between = np.unique(picture[(picture > 0) & (picture < 199)])
    assert len(between) >= 2  # partly covered pixels
    assert picture[16, 16].tolist() == [200, 200, 200]
    plain = renderer.picture(scene, STILL, camera, camera.whole, 0)[0]
    assert np.array_equal(plain, seen.image)


def test_arguments_that_do_not_fit_are_refused(renderer):
    scene = shapes.ball(0, 2)
    camera, window = shapes.view(32)
    one = shapes.states(scene, 1)
    with pytest.raises(ParameterError, match="weights"):
        renderer.draw(scene, shapes.states(shapes.ball(0, 3), 1), camera, window)
    with pytest.raises(ParameterError, match="the window 32x32"):
        renderer.measure(scene, one, camera, window, ClassMaps(np.ones((5, 16, 32))))
    with pytest.raises(ParameterError, match="one map for each class"):
        renderer.measure(scene, one, camera, window, ClassMaps(np.ones((2, 32, 32))))


def test_a_closed_renderer_is_refused(gl):
    renderer = OpenGLRenderer(gl, "thin")
    renderer.close()
    renderer.close()
    scene = shapes.ball(0, 2)
    with pytest.raises(OpenGLError, match="closed"):
        renderer.draw(scene, shapes.states(scene, 1), *shapes.view(16))


def test_the_path_suits_the_device(gl, monkeypatch):
    with OpenGLRenderer(gl) as renderer:
        assert renderer.vertex_path == ("instanced" if gl.hardware else "thin")
        assert gl.renderer in renderer.description
        assert renderer.vertex_path in renderer.description
    monkeypatch.setattr(gl, "hardware", not gl.hardware)
    with OpenGLRenderer(gl) as renderer:
        assert renderer.vertex_path == ("instanced" if gl.hardware else "thin")
    with pytest.raises(ParameterError, match="vertex path"):
        OpenGLRenderer(gl, "fast")


def test_a_driver_without_layers_is_named_or_drawn_on_thinly(gl, monkeypatch):
    monkeypatch.setattr("abs_engine.render.instanced.LAYER_EXTENSIONS", {"GL_FOO_bar"})
    with pytest.raises(OpenGLError, match="GL_FOO_bar"):
        OpenGLRenderer(gl, "instanced")
    monkeypatch.setattr(gl, "hardware", True)
    with OpenGLRenderer(gl) as renderer:
        assert renderer.vertex_path == "thin"


def are_turned(layout, scene):
    """Whether its facets are the scene's, from whatever corner they begin."""
    original = layout.source[layout.faces]
    turned = [np.roll(original, k, axis=1) == scene.faces for k in range(3)]
    return np.any([t.all(axis=1) for t in turned], axis=0).all()


def test_the_layout_numbers_every_facet():
    scene = shapes.ball(shapes.SMALL)
    layout = facet_layout(scene)
    assert np.array_equal(layout.label[layout.faces[:, 2]], 1 + np.arange(len(scene.faces)))
    assert are_turned(layout, scene)
    assert len(layout.source) <= len(scene.mean) + len(scene.faces)


def test_the_layout_gives_every_facet_its_class():
    scene = shapes.ball(shapes.SMALL)
    rng = np.random.default_rng(0)
    wild = Scene(
        **{**vars(scene), "facet_class": rng.integers(1, 7, len(scene.faces))}  # classes everywhere
    )
    for one in (scene, wild):
        layout = class_layout(one)
        assert np.array_equal(layout.label[layout.faces[:, 2]], one.facet_class)
        assert are_turned(layout, one)
    assert len(class_layout(scene).source) < 1.02 * len(scene.mean)
