"""Frames of recordings: of the face that was tracked, and all in colour or none."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from drawn import drawn, lit
from heads import SIZE, seen_at
from runs import noise, write_kind

from abs_engine.core.errors import ParameterError
from abs_engine.tracking.detection.face_choice import LARGEST, FaceChoice
from abs_engine.tracking.runs.recordings import Recording
from abs_engine.tracking.speaker.recorded_frames import check_colours, pictures

FRAMES = 3
PEOPLE = ("kofi", 1100), ("clara", 700)


def recording(video, choice):
    """A recording of which frames are read and nothing else."""
    none = np.zeros((0, 0))
    return Recording(video, video, {}, none, none, 63.4, choice)


@pytest.fixture(scope="module")
def two(tmp_path_factory):
    """A film of two people, the nearer one on the right."""
    far, near = (drawn(who, seen_at([0, 0, 0], [0, 0, z])) for who, z in PEOPLE)
    path = tmp_path_factory.mktemp("two") / "two.avi"
    return write_kind(path, "ffv1", [np.hstack([far, near])] * FRAMES)


@pytest.mark.parametrize(("choice", "right"), [(LARGEST, True), (FaceChoice(2), False)])
def test_frames_are_those_of_the_face_that_was_tracked(two, choice, right):
    seen = pictures(recording(two, choice), [0, 2])
    assert len(seen) == 2
    for _, marks in seen:
        assert (marks.pixels[:, 0].mean() > SIZE[0]) == right


@pytest.fixture(scope="module")
def films(tmp_path_factory):
    """A face in colour, in another colour, and in none; and no face."""
    folder, face = tmp_path_factory.mktemp("films"), lit("amara", seen_at([0, 0, 0], [0, 0, 700]))
    grey = np.repeat(cv2.cvtColor(face, cv2.COLOR_RGB2GRAY)[..., None], 3, axis=2)
    made = {"one": [face], "other": [face[:, ::-1]], "grey": [grey], "nobody": noise(1, SIZE)}
    return {
        name: (
            folder / f"{name}.mp4",
            write_kind(folder / f"{name}.mp4", "libx264", shown),
            LARGEST,
        )
        for name, shown in made.items()
    }


def test_a_recording_without_colour_among_others_is_named(films):
    with pytest.raises(ParameterError, match=r"grey\.mp4 has no colour, .*; leave it out"):
        check_colours([films[name] for name in ("one", "grey", "other")])


@pytest.mark.parametrize("names", [("one", "other"), ("grey",), ("one", "nobody"), ("nobody",)])
def test_recordings_that_go_together(films, names):
    check_colours([films[name] for name in names])
