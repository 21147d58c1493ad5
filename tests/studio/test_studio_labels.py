"""Labels worked out from ids and geometry: by hand, and against the engine's own rasteriser."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy import ndimage

from abs_engine.core.camera import Camera
from abs_engine.core.geometry import Pose, compose
from abs_engine.core.scene import Candidates, Scene
from abs_engine.dataset.coco import OUTSIDE, VISIBLE, keypoints
from abs_engine.dataset.codec import OTHER
from abs_engine.io.assets import load_speaker
from abs_engine.render.cpu import CpuRenderer
from abs_engine.studio import labels, surface
from abs_engine.studio.cast import Cast
from abs_engine.studio.mirror import Mirror
from abs_engine.studio.resolve import plan_clip
from abs_engine.studio.scenefile import complete, parse_scene
from abs_engine.studio.take import Take

CAMERA = Camera(np.array([[200.0, 0, 31.5], [0, 200.0, 23.5], [0, 0, 1]]), (64, 48))
CORNERS = np.array([[-60.0, -50, 400], [70, -40, 500], [0, 80, 620]])
TRIANGLE = np.array([[0, 2, 1]], np.int32)
ALL = ("normals", "albedo", "flow")

SCENE = """
format = "abs_engine.scene"
version = 1
seed = 2
shirt = false
[[camera]]
name = "ideal"
[[camera]]
name = "bent"
position = [150, 20, 560]
focal = 420
distortion = [-0.25, 0.09, 0.003, -0.002]
[[camera]]
name = "glass"
position = [60, 30, 700]
target = [60, 0, 60]
focal = 420
distortion = [-0.2, 0.08]
mirror = { centre = [190, 0, 640], yaw_degrees = -50, size = [260, 300] }
[[clip]]
speaker = "amara"
sentence = "a"
frames = 2
"""


@pytest.fixture(scope="module")
def speaker():
    return load_speaker()


@pytest.fixture(scope="module")
def shots(speaker):
    """Plan, and by camera what was posed and shot in the first frame, and the next frame's head."""
    scene = complete(parse_scene(SCENE))
    plan = plan_clip(scene, 0, speaker, Cast(speaker, ()), Path(), "")
    out = {}
    for number, view in enumerate(plan.views):
        with Take(speaker, plan, number, ALL) as take:
            out[view.name] = *next(take.film(0, 2)), take.posed(1)
    return plan, out


def seen(corners=CORNERS, camera=CAMERA):
    points = np.asarray(corners, np.float64)
    head = labels.Geometry.of(camera, points, np.tile(np.float32([0, 0, -1]), (3, 1)))
    return labels.Surface(np.ones(camera.size[::-1], np.uint16), head, TRIANGLE, camera), head


def covered():
    """Pixels whose ray goes through the triangle: it is a sum of its corners, none negative."""
    y, x = np.mgrid[:48, :64]
    rays = np.stack([(x - 31.5) / 200, (y - 23.5) / 200, np.ones_like(x)]).reshape(3, -1)
    return (np.linalg.solve(CORNERS.T, rays) >= 0).all(axis=0).reshape(48, 64)


def test_depth_is_that_of_the_plane_under_the_pixel():
    surface_, _ = seen()
    plane = np.linalg.solve(CORNERS, np.ones(3))  # n . x = 1, so depth = 1 / (n . ray)
    y, x = np.mgrid[:48, :64]
    rays = np.stack([(x - 31.5) / 200, (y - 23.5) / 200, np.ones_like(x)], axis=-1)
    inside = covered()
    assert 200 < inside.sum() < inside.size
    np.testing.assert_allclose(surface_.depth[inside], (1 / (rays @ plane))[inside], rtol=1e-9)


def test_flow_is_where_the_point_goes():
    surface_, head = seen()
    inside = covered()
    assert np.abs(surface_.flow(head)[0][inside]).max() < 1e-4  # nothing moves
    # A shift across the axis moves a point of depth z by 200 dx / z pixels.
    moved = labels.Geometry.of(CAMERA, CORNERS + np.array([7.0, 0, 0]), head.normals)
    flow, valid = surface_.flow(moved)
    np.testing.assert_allclose(flow[inside, 0], 1400 / surface_.depth[inside], atol=1e-4)
    np.testing.assert_allclose(flow[inside, 1], 0, atol=1e-4)
    assert valid.all()
    behind = labels.Geometry.of(CAMERA, CORNERS - np.array([0, 0, 900.0]), head.normals)
    assert not surface_.flow(behind)[1].any()


def test_normals_are_blended_and_unit():
    surface_, head = seen()
    side = np.float32([[1, 0, 0], [0, 1, 0], [0, 0, -1]])
    given = labels.Geometry(head.points, head.drawn, head.pixels, side)
    out = labels.Surface(surface_.ids, given, TRIANGLE, CAMERA).normals()
    np.testing.assert_allclose(np.linalg.norm(out, axis=2), 1, atol=1e-5)
    x, y = np.rint(head.pixels.mean(axis=0)).astype(int)
    assert (np.abs(out[y, x]) > 0.3).all()


def test_a_point_is_hidden_by_what_stands_before_it():
    wall = CORNERS - np.array([0, 0, 100])
    pixels = labels.flat(CAMERA, wall)
    middle = pixels.mean(axis=0)
    points = np.array([[*middle, 600.0], [*middle, 300.0], [60.0, 45.0, 600.0]])
    weld, nobody = np.arange(3, dtype=np.int32), np.full(3, -1)
    front = surface.hidden(points, wall, pixels, TRIANGLE, weld, nobody, 0.1)
    assert front.tolist() == [True, False, False]
    turned = np.ascontiguousarray(TRIANGLE[:, ::-1])
    assert not surface.hidden(points, wall, pixels, turned, weld, nobody, 0.1).any()
    own = np.array([1, 1, 1])
    assert not surface.hidden(points, wall, pixels, TRIANGLE, weld, own, 0.1).any()


def engines(scene_of, camera, pose):
    with CpuRenderer() as renderer:
        return renderer.draw(scene_of, Candidates.one([], pose), camera, camera.whole)[0]


def drawn_by_the_engine(plan, speaker, name, now, mirrored=False):
    view = next(v for v in plan.views if v.name == name)
    head = now.mirrored if mirrored else now.direct
    faces = speaker.faces[:, ::-1] if mirrored else speaker.faces
    scene = Scene(
        head.points, np.zeros((0, len(head.points), 3)), faces, speaker.uv,
        speaker.facet_class.astype(np.int32), plan.texture,
    )  # fmt: skip
    return engines(scene, view.camera, Pose(np.eye(3), np.zeros(3)))


def agree(ours, others):
    """Every pixel's id is found within one pixel in the other picture; returns who differs."""
    for a, b in ((ours, others), (others, ours)):
        near = np.stack([np.roll(b, (i, j), (0, 1)) for i in (-1, 0, 1) for j in (-1, 0, 1)])
        lost = ~(near == a).any(axis=0)
        assert lost.sum() <= 0.0002 * max((a > 0).sum(), 1), lost.sum()
    return (ours != others).mean()


@pytest.mark.parametrize("name", ["ideal", "bent"])
def test_silhouette_and_ids_are_the_engines_to_within_a_pixel(speaker, shots, name):
    plan, out = shots
    now, shot, _ = out[name]
    engine = drawn_by_the_engine(plan, speaker, name, now)
    assert agree(shot.ids.astype(int), engine.facet_id) < 0.002
    edge = (shot.ids > 0) != (engine.facet_id > 0)
    inner = ndimage.binary_erosion(engine.facet_id > 0)
    outer = ndimage.binary_dilation(engine.facet_id > 0)
    assert not edge[inner | ~outer].any()
    same = (shot.ids == engine.facet_id) & (shot.ids > 0)
    off = np.abs(shot.depth - engine.depth)[same]
    assert np.quantile(off, 0.999) < 0.005
    assert off.max() < 1.5  # a centre that is on the edge of a facet seen nearly edge-on
    assert np.abs(shot.albedo.astype(float) - engine.rgb)[same].mean() < 6  # filtered otherwise


def test_in_a_mirror_as_well(speaker, shots):
    plan, out = shots
    now, shot, _ = out["glass"]
    view = plan.views[2]
    mirror = Mirror(view.mirror)
    mask, glass = mirror.mask(view.camera), mirror.depth(view.camera)
    direct = drawn_by_the_engine(plan, speaker, "glass", now)
    within = drawn_by_the_engine(plan, speaker, "glass", now, mirrored=True)
    before = (direct.depth > 0) & (direct.depth < glass)
    expected = np.where(mask & ~before, within.facet_id, direct.facet_id)
    assert agree(shot.ids.astype(int), expected) < 0.002
    inside = mask & (shot.ids > 0)
    assert inside.sum() > 1000
    assert (~mask & (shot.ids > 0)).sum() > 3000
    assert (shot.depth[inside] > glass[inside]).all()  # behind the glass
    same = inside & (shot.ids == expected)
    assert np.abs(shot.depth - within.depth)[same].max() < 0.02
    rays = (
        np.stack(np.meshgrid(np.arange(320), np.arange(240)), axis=-1) - view.camera.matrix[:2, 2]
    )
    facing = (shot.normals[..., :2] * rays / 420).sum(axis=-1) + shot.normals[..., 2]
    assert (facing[inside] < 0.1).mean() > 0.98  # what is seen faces the camera, mirrored or not


def filmed(speaker, text):
    """A scene's plan, and its first picture."""
    scene = complete(parse_scene(text))
    plan = plan_clip(scene, 0, speaker, Cast(speaker, ()), Path(), "")
    with Take(speaker, plan, 0, ()) as take:
        return plan, next(take.film(0, 2))[1]


HEAD = """
format = "abs_engine.scene"
version = 1
shirt = false
[[camera]]
name = "glass"
size = [192, 144]
field_of_view_degrees = 47
"""
TURNED = """
position = [0, 0, 700]
target = [0, 0, 60]
mirror = { corners = [[-60, -180, 980], [260, -180, 860], [260, 180, 860], [-60, 180, 980]] }
[[clip]]
frames = 2
motion = { amount = 0, keys = [{ time = 0, turn_degrees = [0, 150, 0] }] }
"""
"""A head that looks into a mirror behind it, of which it hides a part."""


def test_landmarks_in_a_mirror_are_hidden_by_the_head_before_it(speaker):
    plan, shot = filmed(speaker, HEAD + TURNED)
    column, row = np.rint(shot.mirror_pixels).astype(int).T
    on_it = Mirror(plan.views[0].mirror).mask(plan.views[0].camera)[row, column]
    assert shot.glass[row, column][shot.mirror_seen].all()
    assert 10 < shot.mirror_seen.sum() < on_it.sum() - 5


BESIDE = """
position = [60, 30, 700]
target = [60, 0, 60]
mirror = { corners = [[50, -180, 800], [250, -180, 450], [250, 180, 450], [50, 180, 800]] }
[[occluder]]
kind = "microphone"
start = -1.0
end = 5.0
offset = [300, 20, -20]
[[clip]]
frames = 2
motion = { amount = 0 }
"""
"""A microphone behind a mirror, where its image would come before the head's."""


def test_what_is_behind_a_mirror_is_not_seen_in_it(speaker):
    without = BESIDE.replace("frames = 2", "frames = 2\noccluders = []")
    behind, alone = (filmed(speaker, HEAD + text)[1] for text in (BESIDE, without))
    assert alone.mirror_seen.sum() > 10
    assert (behind.mirror_seen == alone.mirror_seen).all()
    assert (behind.ids == alone.ids).all()
    assert not behind.cover.any()


SHOULDER = """
format = "abs_engine.scene"
version = 1
[[camera]]
size = [320, 240]
position = [430, -380, -120]
target = [0, -60, 60]
focal = 450
[[clip]]
say = "m a"
frames = 2
motion = { amount = 0, keys = [{ time = 0, turn_degrees = [30, 25, 25], shift = [0, -10, 0] }] }
"""
"""A head seen from below and behind, whose jaw is behind the shirt."""


def test_landmarks_behind_the_shirt_are_hidden(speaker):
    _, shot = filmed(speaker, SHOULDER)
    behind = ndimage.minimum_filter((shot.cover == OTHER).astype(np.uint8), 3) > 0
    column, row = np.rint(shot.pixels).astype(int).T
    assert behind[row, column].sum() >= 3
    assert not shot.seen[behind[row, column]].any()
    assert shot.seen.any()


BELOW = """
position = [0, 10, 170]
target = [0, 510, 220]
[[clip]]
frames = 2
motion = { amount = 0 }
"""
"""A camera close before the face that looks up past it."""


def test_landmarks_behind_the_lens_are_not_in_the_picture(speaker):
    plan, shot = filmed(speaker, HEAD.replace("= 47", "= 145") + BELOW)
    head = plan.head(0).apply(plan.neutral[speaker.points["landmark_68"]].astype(np.float64))
    behind = plan.views[0].pose(0).apply(head)[:, 2] < 0
    flags = np.array(keypoints(shot.pixels, shot.seen, plan.views[0].camera.size)[2::3])
    assert behind.sum() > 20
    assert (flags[behind] == OUTSIDE).all()
    assert (flags[~behind] == VISIBLE).any()


def hits(facet, directions):
    """Depth (N,) at which rays (N, 3) of z = 1 meet a facet (3, 3), from either side; or inf."""
    weights = np.linalg.solve(facet.T, directions.T).T
    return np.where((weights >= 0).all(axis=1), 1 / weights.sum(axis=1), np.inf)


def test_what_reaches_behind_the_lens_hides_what_is_behind_the_rest_of_it(speaker, shots):
    """As a hand that is moved past a worn camera."""
    plan, out = shots
    now, camera = out["ideal"][0].direct, plan.views[0].camera
    vertex = speaker.points["landmark_68"]
    alone = labels.visible(vertex, now, speaker, camera)
    rays = now.drawn[vertex] / now.drawn[vertex, 2:]
    rng, hidden = np.random.default_rng(3), 0
    for _ in range(200):
        facet = rng.normal(size=(3, 3)) * [40, 40, 0] + [0, 0, 1] * rng.uniform(-30, 60, (3, 1))
        depth = hits(facet, rays)
        before = (depth > camera.near) & (depth < 400)
        cover = labels.Cover(facet, TRIANGLE)
        told = labels.visible(vertex, now, speaker, camera, (cover,))
        assert (told == (alone & ~before)).all(), facet
        hidden += before.any() and facet[:, 2].min() < camera.near
    assert hidden > 20


def test_flow_takes_points_where_they_are_in_the_next_frame(speaker, shots):
    plan, out = shots
    for name in ("ideal", "bent"):
        now, shot, following = out[name]
        camera = next(v.camera for v in plan.views if v.name == name)
        flow, valid = shot.flow
        assert (valid == (shot.ids > 0)).all()
        y, x = np.nonzero(shot.ids)
        y, x = y[::97], x[::97]
        facets = speaker.faces[shot.ids[y, x].astype(int) - 1]
        corners = camera.project(now.direct.points[facets])
        moved = camera.project(following.direct.points[facets])
        # An affine map from the facet's three corners to where they go moves the pixel there.
        one = np.ones((len(x), 3, 1))
        maps = np.linalg.solve(np.concatenate([corners, one], axis=2), moved)
        place = np.einsum("ni,nij->nj", np.column_stack([x, y, np.ones_like(x)]), maps)
        np.testing.assert_allclose(flow[y, x], place - np.column_stack([x, y]), atol=0.02)


def test_landmarks_in_the_picture_and_on_the_surface_are_seen(speaker, shots):
    _, out = shots
    for name in ("ideal", "bent"):
        now, shot, _ = out[name]
        vertex = speaker.points["landmark_68"]
        at = np.rint(shot.pixels).astype(int)
        depth = shot.depth[at[:, 1], at[:, 0]]
        z = now.direct.points[vertex, 2]
        # Hidden: all pixels around show something nearer.
        farthest = ndimage.maximum_filter(np.where(shot.depth > 0, shot.depth, 1e9), 3)
        hidden = farthest[at[:, 1], at[:, 0]] < z - 6
        clear = np.abs(depth - z) < 0.3
        assert clear.sum() > 15
        assert shot.seen[clear].mean() > 0.95
        assert not shot.seen[hidden].any()
    assert not out["bent"][1].seen.all()


def test_poses_compose():
    first, second = (
        Pose.from_vectors([0.1, 0.2, 0.3], [1, 2, 3]),
        Pose.from_vectors([1, 0, 0], [4, 5, 6]),
    )
    point = np.array([[7.0, 8, 9]])
    both = compose(second, first)
    np.testing.assert_allclose(both.apply(point), second.apply(first.apply(point)))
