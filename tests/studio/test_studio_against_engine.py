"""The studio against the engine's own rasteriser: the same head, the same pixels, other colours.

Both draw the bundled head from the same vertices. Where a facet is must be the same; what it looks
like must not: the studio lights it, the engine draws its texture flat.
"""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np
import pytest
from said import say

from abs_engine.core.camera import Camera
from abs_engine.core.scene import Candidates, Scene
from abs_engine.io.assets import load_speaker
from abs_engine.render.cpu import CpuRenderer
from abs_engine.studio import filming
from abs_engine.studio.appearance.look import Look
from abs_engine.studio.appearance.optics import Sensor
from abs_engine.studio.take import Take

CAMERA = Camera(np.array([[410.0, 0, 121.3], [0, 415.0, 84.6], [0, 0, 1]]), (240, 180))
PERSON = "amara"
DISC = np.ones((3, 3), np.uint8)


@pytest.fixture(scope="module")
def speaker():
    return load_speaker()


@pytest.fixture(scope="module")
def both(speaker):
    """A frame of an open mouth: by the studio, without what a lens adds, and by the engine."""
    said = say("a a a", speaker, PERSON, CAMERA, frames=9, seed=3)
    middle = slice(4, 5)
    still = replace(
        said,
        **{n: getattr(said, n)[middle] for n in ("weights", "rotations", "translations")},
        visemes=said.visemes[middle],
    )
    clean = Sensor(blur=0.0, shot=0.0, read=0.0)
    plan = filming.plan_of(speaker, still, CAMERA, Look(shirt=None, sensor=clean))
    with Take(speaker, plan, 0, ("albedo", "normals")) as take:
        now, shot = next(take.film(0, 1))
    vertices = speaker.named(PERSON) + now.offsets.astype(np.float32)
    scene = Scene(
        mean=vertices, modes=np.zeros((0, len(vertices), 3), np.float32), faces=speaker.faces,
        uv=speaker.uv, facet_class=speaker.facet_class, texture=speaker.texture(PERSON),
    )  # fmt: skip
    one = Candidates.one(np.zeros(0), still.pose(0))
    with CpuRenderer() as renderer:
        (drawn,) = renderer.draw(scene, one, CAMERA, CAMERA.whole)
    return shot, drawn


@pytest.fixture(scope="module")
def skin(speaker, both):
    """Pixels that both show as skin, three pixels and more from anything else."""
    shot, drawn = both
    kinds = np.concatenate([[0], speaker.facet_class])
    own = (kinds[shot.ids] == speaker.class_id("skin")) & (shot.ids == drawn.facet_id)
    solid = cv2.morphologyEx(own.astype(np.uint8), cv2.MORPH_CLOSE, DISC)
    return own & (cv2.erode(solid, DISC, iterations=3) > 0)


def beside_an_edge(ids):
    """Pixels whose 3x3 neighbourhood holds more than one id."""
    ids = ids.astype(np.float32)
    return cv2.dilate(ids, DISC) != cv2.erode(ids, DISC)


def test_ids_agree_but_at_edges_of_facets(both):
    shot, drawn = both
    assert (shot.ids > 0).sum() > 5000
    wrong = shot.ids != drawn.facet_id
    assert not (wrong & ~beside_an_edge(shot.ids)).any()
    assert wrong.sum() < 0.01 * (shot.ids > 0).sum()


def test_silhouettes_agree_to_a_pixel(both):
    shot, drawn = both
    ours, theirs = (drawn.facet_id > 0).astype(np.uint8), (shot.ids > 0).astype(np.uint8)
    for one, other in ((ours, theirs), (theirs, ours)):
        assert (cv2.dilate(one, DISC) >= other).all()
        assert (cv2.erode(one, DISC) <= other).all()
    assert (ours != theirs).sum() < 0.01 * ours.sum()


def test_the_studio_shades_what_the_engine_draws_flat(both, skin):
    shot, drawn = both
    assert skin.sum() > 1000
    albedo = shot.albedo[skin].astype(np.float64)
    flat = drawn.image[skin].astype(np.float64) / albedo
    lit = linear(shot.picture[skin]) / linear(albedo)
    assert np.abs(flat - 1).mean() < 0.1  # the engine's colour is the texture's
    lightness, steady = lit.mean(axis=1), flat.mean(axis=1)
    assert lightness.std() / lightness.mean() > 0.15
    assert lightness.std() / lightness.mean() > 4 * steady.std() / steady.mean()
    # What the shading follows is the way that the skin faces, which flat colours do not know.
    assert explained(shot.normals[skin], lightness) > 0.6
    assert explained(shot.normals[skin], steady) < 0.2


def test_the_pictures_are_not_the_same_but_for_brightness(both, skin):
    shot, drawn = both
    ours, theirs = (image[skin].astype(np.float64) for image in (drawn.image, shot.picture))
    gain = (ours * theirs).sum() / (ours * ours).sum()
    assert np.abs(theirs - gain * ours).mean() > 8  # grey levels


def linear(levels):
    """Light (N, 3) of sRGB levels, 0 to 1."""
    share = np.asarray(levels, np.float64) / 255
    return np.where(share <= 0.04045, share / 12.92, ((share + 0.055) / 1.055) ** 2.4)


def explained(normals, values):
    """Share of the variance that a linear function of normals (N, 3) explains."""
    model = np.column_stack([np.ones(len(values)), normals])
    rest = values - model @ np.linalg.lstsq(model, values, rcond=None)[0]
    return 1 - rest.var() / values.var()
