"""Frames of a clip in which it is judged whether the face in it is the speaker's."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from abs_engine.core.errors import FaceNotFoundError
from abs_engine.tracking.detection.face_choice import LARGEST
from abs_engine.tracking.settings.preparation import PREPARATION
from abs_engine.tracking.speaker.speakers import SpeakerClip


def looked_at(shows, looked, first=0):
    """Frames chosen of a clip whose frames hold their numbers; some of them show a face."""
    frames = [np.full((1, 1, 3), k) for k in range(400)]
    clip = SimpleNamespace(frames=lambda: iter(frames), video=Path("a.mp4"))
    follower = SimpleNamespace(step=lambda i: i.max() if shows(i.max()) else None, found=[])
    seen = SpeakerClip(clip, LARGEST, None, None, first, looked)._seen(follower)
    return [image.max() for image, _ in seen]


@pytest.mark.parametrize(
    ("shows", "looked", "first", "chosen"),
    [
        (lambda _: True, 25, 0, range(0, 25, 3)),
        (lambda k: k >= 10 and k != 13, 25, 0, [10, *range(16, 35, 3)]),
        (lambda _: True, 1, 40, [40]),
        (lambda k: k >= PREPARATION.look_at - 1, 1, 0, [PREPARATION.look_at - 1]),
    ],
)
def test_frames_are_spread_from_the_first_with_a_face(shows, looked, first, chosen):
    assert looked_at(shows, looked, first) == list(chosen)


def test_a_face_that_comes_too_late_is_none():
    with pytest.raises(FaceNotFoundError, match=r"no face was found .* of a\.mp4"):
        looked_at(lambda k: k >= PREPARATION.look_at, 25)
