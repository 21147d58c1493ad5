"""A film that loses its colour: colours are learned, and asked, in frames that have it."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from drawn import drawn, network_sees, speaker, vertices_of
from runs import write_kind

import abs_engine
from abs_engine.core.errors import ParameterError
from abs_engine.face.base import lip_aperture
from abs_engine.face.rings import lip_rings
from abs_engine.tracking.detection.landmarks import OUTER_RING
from abs_engine.tracking.detection.light import SkinLight
from abs_engine.tracking.frame import landmark_motion
from abs_engine.tracking.frame.clip_setting import GREY
from abs_engine.tracking.frame.landmark_motion import LandmarkMotion

NOTHING = SimpleNamespace(pose=None)
AMOUNTS = (0.0, 0.15, 0.3, 0.05, 0.0, 0.25)
"""Closed more than once, as in speech: a bias of the network is learned from three frames."""
HALF = len(AMOUNTS)


def grey_of(image: np.ndarray) -> np.ndarray:
    """The picture (H, W, 3) in black and white."""
    return np.repeat(image.mean(axis=2, keepdims=True).astype(np.uint8), 3, axis=2)


def truth() -> list[float]:
    """The drawn apertures, mm; those that colours find err themselves."""
    points = lip_rings(speaker())["points"]
    return [lip_aperture(vertices_of("clara", jawOpen=amount)[points]) for amount in AMOUNTS]


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    """Runs of the same frames twice: once all in colour, once grey from the middle on."""
    folder = tmp_path_factory.mktemp("films")
    coloured = [drawn("clara", jawOpen=amount) for amount in AMOUNTS]
    films = {"colour": coloured * 2, "half": coloured + [grey_of(image) for image in coloured]}
    return {
        name: abs_engine.track(write_kind(folder / f"{name}.mp4", "libx264", film), renderer="cpu")
        for name, film in films.items()
    }


def test_frames_without_colour_go_by_landmarks_and_say_so(runs):
    whole, half = runs["colour"], runs["half"]
    assert half["found"].all()
    assert (half["status"][HALF:] == GREY).all()
    assert (half["status"][:HALF] != GREY).all()
    assert (whole["status"] != GREY).all()
    np.testing.assert_allclose(half["aperture"][HALF:], truth(), atol=1.5)


def test_a_start_by_colour_without_colour_names_the_box_that_was_given(tmp_path):
    image = grey_of(drawn("clara"))
    video = write_kind(tmp_path / "grey.mp4", "libx264", [image] * 4)
    box = network_sees(image).pixels[OUTER_RING]
    mouth = (*box.min(axis=0), *np.ptp(box, axis=0))
    with pytest.raises(ParameterError) as caught:
        abs_engine.track(video, start="blobs", renderer="cpu")
    assert "no colour, and a start by colour finds no lips" in caught.value.problem
    with pytest.raises(ParameterError) as caught:
        abs_engine.track(video, start="blobs", mouth=mouth, renderer="cpu")
    assert "no colour where --mouth puts the face" in caught.value.problem
    assert caught.value.remedy.startswith("check that --mouth holds the whole mouth")


def test_the_colours_of_the_other_frames_are_hardly_spoilt(runs):
    """The mouth is fitted to frames with colour: in the others landmarks are alone, which err."""
    whole, half = runs["colour"], runs["half"]
    np.testing.assert_allclose(half["aperture"][:HALF], whole["aperture"][:HALF], atol=0.8)
    lips, sound = (run.summary["separability"] for run in (half, whole))
    assert lips == pytest.approx(sound, abs=0.015)  # 0.026 where grey frames are learned from
    assert half.summary["mean_score"] == pytest.approx(whole.summary["mean_score"], abs=0.01)


def test_the_run_warns_of_them(runs):
    said = [line for line in runs["half"].warnings if "have no colour" in line]
    assert len(said) == 1
    assert said[0].startswith("6 of 12 frames")
    assert not [line for line in runs["colour"].warnings if "have no colour" in line]


def test_a_face_that_hides_its_red_lips_still_has_its_colour(monkeypatch):
    """A pale face's chroma is its lips': of a hidden mouth too little is left, of the skin all."""
    monkeypatch.setattr(landmark_motion, "placed_fit", lambda *_: NOTHING)
    image = drawn("clara")
    light = SkinLight.of([(image, network_sees(image))])
    little = LandmarkMotion(None, None, light=light, grey_below=1e9)
    pictures = {
        "colour": image, "grey": grey_of(image), "dim": np.uint8(0.15 * image),
        "black": np.uint8(0.05 * image),
    }  # fmt: skip
    frames = {name: little.follower().step(one) for name, one in pictures.items()}
    assert {name: (frame.grey, frame.dark) for name, frame in frames.items()} == {
        "colour": (False, False),
        "grey": (True, False),
        "dim": (True, False),
        "black": (True, True),
    }
    unknown = LandmarkMotion(None, None, grey_below=1e9).follower().step(image)
    assert (unknown.grey, unknown.dark) == (True, False)
