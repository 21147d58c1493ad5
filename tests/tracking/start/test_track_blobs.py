"""The face and the lips found as blobs of colour, and followed through a gap."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest

from abs_engine.core.camera import Camera
from abs_engine.core.errors import FaceNotFoundError
from abs_engine.core.geometry import FACING, Pose
from abs_engine.face.appearance.colour import ColourClasses
from abs_engine.face.appearance.colour_features import CLASSES, features
from abs_engine.face.appearance.mixture import Mixture
from abs_engine.io.video import VideoInfo
from abs_engine.render.cpu import CpuRenderer
from abs_engine.tracking.frame.blob_motion import BlobMotion, LipFollower
from abs_engine.tracking.frame.blobs import LipPrior, find_face_blob, find_lips
from abs_engine.tracking.frame.external_poses import GivenMotion
from abs_engine.tracking.frame.frame_state import Memory
from abs_engine.tracking.options import Clip, TrackOptions
from abs_engine.tracking.run import prepare_clip
from abs_engine.tracking.settings.blobs import BLOB_START

SIZE = 320, 240
COLOURS = {"skin": (200, 152, 126), "lips": (170, 86, 88), "teeth": (180, 165, 150)}
DARK = (40, 18, 18)
WALL = (90, 110, 130)
RATE = 25.0
REFERENCE = 160.0
NOTHING = np.full((SIZE[1], SIZE[0], 3), WALL, np.uint8)


def classes() -> ColourClasses:
    """The painted colours with a little spread."""
    spread = np.diag([0.008**2, 0.008**2, 0.03**2])[None]
    colours = {**COLOURS, "dark": DARK}
    mixtures = {
        c: Mixture(np.ones(1), features(np.array([colours[c]]), REFERENCE), spread) for c in CLASSES
    }
    return ColourClasses(mixtures, np.ones(len(CLASSES)), REFERENCE)


CLASSES_OF_ALL = classes()


def face_at(
    x: float, y: float, lips: bool = True, parted: int = 0, size: tuple[int, int] = SIZE
) -> np.ndarray:
    """A face 120 px wide whose mouth, 50 by 20 px, lies at (x, y)."""
    picture = np.full((size[1], size[0], 3), WALL, np.uint8)
    mouth = round(x), round(y)
    cv2.ellipse(picture, (mouth[0], mouth[1] - 40), (60, 78), 0, 0, 360, COLOURS["skin"], -1)
    for side in (-25, 25):
        cv2.circle(picture, (mouth[0] + side, mouth[1] - 62), 6, DARK, -1)
    if lips:
        cv2.ellipse(picture, mouth, (25, 10 + parted), 0, 0, 360, COLOURS["lips"], -1)
        if parted:
            cv2.ellipse(picture, mouth, (19, parted), 0, 0, 360, DARK, -1)
            cv2.ellipse(picture, mouth, (17, parted), 0, 200, 340, COLOURS["teeth"], -1)
    noise = np.random.default_rng(5).normal(0, 2, picture.shape)
    return np.uint8(np.clip(np.rint(picture + noise), 0, 255))


def between(share: float) -> tuple[int, ...]:
    """A colour that is so much lips and otherwise skin."""
    skin, lips = (np.array(COLOURS[c], float) for c in ("skin", "lips"))
    return tuple(round(c) for c in skin + share * (lips - skin))


@pytest.mark.parametrize("side", [-1, 1])
def test_the_mouth_of_a_turned_head_is_found_beside_the_middle(side: int):
    picture = face_at(160, 160, lips=False)
    mouth = 160 + side * 42, 150  # 0.35 widths
    cv2.ellipse(picture, mouth, (14, 10), 0, 0, 360, COLOURS["lips"], -1)
    cv2.circle(picture, (160, 160), 5, COLOURS["lips"], -1)  # a sore on the chin
    blob = find_lips(CLASSES_OF_ALL, picture)
    assert blob is not None
    assert blob.centre == pytest.approx(mouth, abs=2)


def test_shade_that_is_lips_by_a_little_is_no_mouth_however_large():
    picture = face_at(160, 160, lips=False)
    shade = next(c for c in map(between, np.arange(0.3, 0.8, 0.01)) if 0.6 < as_lips(c) < 0.8)
    cv2.ellipse(picture, (160, 165), (32, 7), 0, 0, 360, shade, -1)
    cv2.ellipse(picture, (202, 150), (14, 10), 0, 0, 360, COLOURS["lips"], -1)
    blob = find_lips(CLASSES_OF_ALL, picture)
    assert blob is not None
    assert blob.centre == pytest.approx([202, 150], abs=2)


def test_pale_lips_are_no_less_sure_than_others_where_nothing_else_is_like_them():
    pale = next(c for c in map(between, np.arange(0.3, 0.8, 0.01)) if 0.5 < as_lips(c) < 0.65)
    picture = face_at(160, 160, lips=False)
    cv2.ellipse(picture, (160, 160), (25, 10), 0, 0, 360, pale, -1)
    blob = find_lips(CLASSES_OF_ALL, picture)
    assert blob is not None
    assert blob.posterior > BLOB_START.sure


def test_lips_far_from_where_they_may_be_are_not_sure():
    prior = LipPrior(np.array([200.0, 160.0]), np.array([0.3, 0.3]), 785.0)
    blob = find_lips(CLASSES_OF_ALL, face_at(160, 160), prior)
    assert blob is not None
    assert blob.posterior == 0


def as_lips(colour: tuple[int, ...]) -> float:
    """P(lips) of a colour."""
    patch = np.full((9, 9, 3), colour, np.uint8)
    return float(CLASSES_OF_ALL.probabilities(patch, 3.0)[CLASSES.index("lips")][4, 4])


def test_the_face_is_the_largest_skin():
    face = find_face_blob(CLASSES_OF_ALL, face_at(150, 160))
    assert face is not None
    assert face.centre == pytest.approx([150, 120], abs=6)
    assert face.top == pytest.approx(43, abs=4)
    assert face.width == pytest.approx(120, rel=0.08)
    assert face.inside.sum() == pytest.approx(np.pi * 60 * 78, rel=0.1)
    assert face.inside[160, 150]
    assert not face.inside[20, 20]


def test_without_skin_there_is_no_face():
    assert find_face_blob(CLASSES_OF_ALL, NOTHING) is None
    assert find_lips(CLASSES_OF_ALL, NOTHING) is None
    dot = NOTHING.copy()
    cv2.circle(dot, (100, 100), 8, COLOURS["skin"], -1)
    assert find_face_blob(CLASSES_OF_ALL, dot) is None  # too small


@pytest.mark.parametrize("parted", [0, 8])
@pytest.mark.parametrize("factor", [1, 3])
def test_the_lips_are_where_they_were_painted(parted, factor):
    picture = face_at(170.0, 150.0, parted=parted)
    picture = np.repeat(np.repeat(picture, factor, axis=0), factor, axis=1)
    lips = find_lips(CLASSES_OF_ALL, picture)
    assert lips is not None
    assert lips.posterior > BLOB_START.sure
    middle = factor * (np.array([170.0, 150.0]) + 0.5) - 0.5
    assert lips.centre == pytest.approx(middle, abs=1.5 * factor)
    assert lips.size[0] == pytest.approx(50 * factor, rel=0.25)
    if not parted:
        assert lips.size[1] == pytest.approx(20 * factor, rel=0.25)
        assert lips.area == pytest.approx(np.pi * 25 * 10 * factor**2, rel=0.25)


@pytest.mark.parametrize(
    ("between", "half", "one"),
    [
        ("teeth", 10, True),
        ("dark", 10, True),
        ("skin", 10, False),
        ("dark", 20, False),
    ],
)
def test_two_patches_are_one_mouth_over_teeth_and_dark_if_not_too_far(between, half, one):
    picture = face_at(160.0, 150.0, lips=False)
    colour = {**COLOURS, "dark": DARK}[between]
    cv2.rectangle(picture, (140, 144 - half), (180, 156 + half), colour, -1)
    for y in (144 - half, 150 + half):
        cv2.rectangle(picture, (140, y), (180, y + 6), COLOURS["lips"], -1)
    prior = LipPrior(np.array([160.0, 150.0]), np.array([12.5, 12.5]), 625.0)
    lips = find_lips(CLASSES_OF_ALL, picture, prior)
    assert lips is not None
    assert (abs(lips.centre[1] - 150) < 3) == one


def test_lips_far_apart_are_one_mouth():
    """Of a mouth wide open the corners may be too dark for lips: two patches remain."""
    picture = face_at(160.0, 150.0, parted=14)
    cv2.ellipse(picture, (160, 150), (27, 14), 0, 0, 360, DARK, -1)
    painted = (picture.astype(int) - DARK).max(axis=2) > 15
    painted &= np.abs(picture.astype(int) - COLOURS["lips"]).max(axis=2) < 20
    prior = LipPrior(np.array([160.0, 150.0]), np.array([12.5, 12.5]), 625.0)
    lips = find_lips(CLASSES_OF_ALL, picture, prior)
    assert lips is not None
    assert lips.centre == pytest.approx([160, 150], abs=2)
    assert lips.area > 0.65 * painted.sum()  # half of it is one lip
    assert lips.posterior > BLOB_START.sure


def test_lips_without_a_mouth_are_not_sure():
    lips = find_lips(CLASSES_OF_ALL, face_at(160, 160, lips=False))
    assert lips is None or lips.posterior < 0.2


def test_lip_colour_elsewhere_is_not_the_mouth():
    picture = face_at(160, 160)
    cv2.circle(picture, (160, 62), 12, COLOURS["lips"], -1)  # on the forehead
    cv2.circle(picture, (30, 160), 20, COLOURS["lips"], -1)  # not on the face
    lips = find_lips(CLASSES_OF_ALL, picture)
    assert lips is not None
    assert lips.centre == pytest.approx([160, 160], abs=2)
    prior = LipPrior(np.array([32.0, 158.0]), np.array([10.0, 10.0]), 1000.0)
    told = find_lips(CLASSES_OF_ALL, picture, prior)
    assert told is not None
    assert told.centre == pytest.approx([30, 160], abs=2)


def test_a_prior_outside_of_the_picture_finds_nothing():
    prior = LipPrior(np.array([900.0, 100.0]), np.array([10.0, 10.0]), 500.0)
    assert find_lips(CLASSES_OF_ALL, face_at(160, 160), prior) is None


def test_lips_are_followed_through_a_gap():
    """A mouth that moves evenly is expected where it would be, and is found again."""
    follower = LipFollower(CLASSES_OF_ALL, RATE)
    assert follower.expected is None
    for k in range(40):
        hidden = 20 <= k < 27
        x = 90 + 3 * k
        blob = follower.step(face_at(x, 150, lips=not hidden))
        assert (blob is None) == hidden
        assert follower.expected is not None
        if k > 10:
            assert follower.expected.centre == pytest.approx([x, 150], abs=6)
        if blob is not None:
            assert blob.centre == pytest.approx([x, 150], abs=2)


def test_lips_that_come_back_elsewhere_are_found_again():
    follower = LipFollower(CLASSES_OF_ALL, RATE)
    assert follower.step(face_at(90, 120)) is not None
    for _ in range(round(BLOB_START.patience * RATE) + 1):
        assert follower.step(NOTHING) is None
    assert follower.expected is None
    blob = follower.step(face_at(240, 190))
    assert blob is not None
    assert blob.centre == pytest.approx([240, 190], abs=2)


def test_a_mouth_is_put_at_its_blob_through_a_lens():
    ideal, pivot = Camera.ideal(SIZE), np.array([1.0, -40.0, 90.0])
    lens = Camera(ideal.matrix, SIZE, np.array([-0.5, 0.2]))
    held = GivenMotion((Pose(FACING, np.array([0.0, 0.0, 600.0])),))
    follower = BlobMotion(CLASSES_OF_ALL, RATE, lens, pivot, held).follower()
    found = follower.step(face_at(255, 190), Memory())
    assert found.pose is not None
    assert found.blob is not None
    middle = found.pose.apply(pivot)
    assert lens.project(middle) == pytest.approx(found.blob.centre, abs=1e-3)
    assert middle[2] == pytest.approx(held.given[0].apply(pivot)[2])


def test_a_camera_is_learned_from_as_it_films():
    """Its frames, as there is no file that could be read."""
    clip = Clip(
        Path("camera 0"), VideoInfo(SIZE, RATE, 0), Camera.ideal(SIZE), None, (NOTHING,) * 3
    )
    with pytest.raises(FaceNotFoundError, match="no face was found in 3 of 3 frames of camera 0"):
        prepare_clip(clip, CpuRenderer(), TrackOptions(start="blobs"), print)
