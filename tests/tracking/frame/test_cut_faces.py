"""Faces that the picture's border cuts off: what the landmark network sees beyond it."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from drawn import AHEAD, CAMERA, anybody, average_shape, lit, projected
from runs import write_kind

import abs_engine
from abs_engine.core.camera import Camera
from abs_engine.core.geometry import Pose
from abs_engine.tracking.detection.landmarks import EYES, OUTER_RING, Landmarks
from abs_engine.tracking.frame.blob_visibility import OUTSIDE
from abs_engine.tracking.frame.cut_faces import MouthInPicture, shows_eyes, trust_at_border
from abs_engine.tracking.frame.frame_state import HeadFrame, SeenFace
from abs_engine.tracking.frame.mouth_visibility import ByLook
from abs_engine.tracking.landmark.landmark_fit import fit_frame

MODES = len(average_shape().modes)
WIDTH, HEIGHT = CAMERA.size


@cache
def shape():
    """The landmarks of the average head."""
    return replace(anybody(), identity=anybody().identity[:0])


@cache
def whole() -> Landmarks:
    """The face as it lies in the middle of the picture."""
    return projected(shape().mean, AHEAD)


def below(row: float) -> Landmarks:
    """The face in a picture that begins at a row; what is cut off is seen half as far outside."""
    pixels = whole().points - np.array([0.0, row, 0.0])
    pixels[:, 1] = np.where(pixels[:, 1] < 0, 0.5 * pixels[:, 1], pixels[:, 1])
    return Landmarks(pixels, 1.0)


def above(row: float, mouth: float) -> Landmarks:
    """The face in a picture that ends at a row; the lower lip is seen to end at `mouth` at most.

    What lies close to the border, or beyond it, is seen too high by a share of how far it does.
    """
    pixels, first = whole().points.copy(), row - 0.15 * whole().size
    share = min(1.0, (mouth - first) / (float(edge().max()) - first))
    low = pixels[:, 1] > first
    pixels[low, 1] = first + share * (pixels[low, 1] - first)
    return Landmarks(pixels, 1.0)


def upper_part(row: float) -> Camera:
    """The camera of a picture that ends at a row: its centre stays that of the whole one."""
    return replace(CAMERA, size=(WIDTH, round(row)))


def edge() -> np.ndarray:
    """Rows of the outer edge of the lips."""
    return whole().pixels[OUTER_RING, 1]


def test_a_whole_face_is_trusted_as_it_is():
    assert trust_at_border(whole(), CAMERA.size) is None
    assert shows_eyes(whole(), CAMERA.size)


def test_what_is_cut_off_is_not_trusted_and_little_what_is_near_the_border():
    eyes = whole().pixels[np.concatenate(EYES), 1]
    seen = below(float(eyes.mean()))
    trust = trust_at_border(seen, CAMERA.size)
    assert trust is not None
    rows = seen.pixels[:, 1] + 0.5
    assert (trust[rows < 0] == 0).all()
    near = (rows > 0) & (rows < 0.1 * seen.size)
    assert near.any()
    assert (trust[near] < 0.9).all()
    assert (trust[rows > 0.25 * seen.size] == 1).all()


def test_a_face_that_lies_outside_of_the_picture_has_no_mouth_in_it():
    away = Landmarks(whole().points + np.array([10.0 * WIDTH, 0.0, 0.0]), 1.0)
    trust = trust_at_border(away, CAMERA.size)
    assert trust is not None
    assert not trust.any()
    assert not MouthInPicture(shape(), MODES, CAMERA).whole(away)


@pytest.mark.parametrize(("share", "seen"), [(-0.2, True), (-0.02, False), (0.05, False)])
def test_eyes_close_to_a_border_that_cuts_the_face_are_not_sure_to_be_there(share, seen):
    """`share` of the face's size by which the border lies below the eyes."""
    highest = float(whole().pixels[np.concatenate(EYES), 1].min())
    assert shows_eyes(below(highest + share * whole().size), CAMERA.size) == seen


def test_eyes_close_to_a_border_of_a_whole_face_are_there():
    highest = float(whole().pixels[:, 1].min())
    assert shows_eyes(below(highest - 1.0), CAMERA.size)


def test_a_mouth_that_is_cut_through_is_found_where_its_landmarks_are_within_the_picture():
    row = float(edge().mean())
    seen = above(row, mouth=row - 1.0)
    camera = upper_part(row)
    ring = seen.pixels[OUTER_RING, 1]
    assert ring.max() < row  # as the network has it, all lies in the picture
    assert not MouthInPicture(shape(), MODES, camera).whole(seen)


def test_a_whole_mouth_above_a_chin_that_is_cut_off_is_whole():
    size = whole().size
    row = float(edge().max()) + 0.06 * size
    assert whole().pixels[:, 1].max() > row + 0.05 * size  # the chin
    seen = above(row, mouth=float(edge().max()) - 0.01 * size)
    assert MouthInPicture(shape(), MODES, upper_part(row)).whole(seen)
    assert MouthInPicture(shape(), MODES, CAMERA).whole(whole())


def test_a_frame_whose_mouth_is_cut_through_is_lost_for_that():
    row = float(edge().mean())
    camera = upper_part(row)
    place = MouthInPicture(shape(), MODES, camera)
    image = np.full((camera.size[1], WIDTH, 3), 128, np.uint8)

    def reason(seen: Landmarks, place: MouthInPicture) -> str:
        face = SeenFace(seen, fit_frame(shape(), seen, camera))
        return ByLook(None, None, place).hidden(HeadFrame(image, AHEAD, face), AHEAD)

    cut = above(row, mouth=row - 1.0)
    assert reason(cut, place) == OUTSIDE
    assert reason(whole(), MouthInPicture(shape(), MODES, CAMERA)) == ""


def test_a_given_pose_beside_the_picture_has_no_mouth_in_it():
    place = MouthInPicture(shape(), MODES, CAMERA)
    image = np.full((HEIGHT, WIDTH, 3), 128, np.uint8)
    beside = Pose(AHEAD.rotation, AHEAD.translation + np.array([400.0, 0.0, 0.0]))
    seen = [ByLook(None, None, place).hidden(HeadFrame(image, p), p) for p in (AHEAD, beside)]
    assert seen == ["", OUTSIDE]


@pytest.mark.usefixtures("soon_ready")
def test_a_run_that_never_sees_the_eyes_is_less_sure_of_its_scale(tmp_path):
    frames = [lit("walter", jawOpen=amount)[100:] for amount in (0.0, 0.2, 0.3)]
    run = abs_engine.track(write_kind(tmp_path / "cut.mp4", "libx264", frames), renderer="cpu")
    warned = [line for line in run.warnings if line.startswith("the eyes are outside")]
    assert len(warned) == 1
    assert run.settings["scale"]["uncertainty"] == pytest.approx(0.1, abs=0.01)
