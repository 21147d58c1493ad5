"""A first look at a video: its face is followed in a thread until somebody asks for what it saw."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from abs_engine.core.threads import begin, one_thread
from abs_engine.io.video import read_frames
from abs_engine.tracking.detection.face_choice import FaceChoice, FaceFollower
from abs_engine.tracking.settings.preparation import PREPARATION


class FirstLook:
    """Follows a face through a video's first frames in its own thread, until it is asked for."""

    def __init__(self, video: Path, choice: FaceChoice) -> None:
        self.video, self.choice = video, choice
        self._follower = FaceFollower(choice)
        self._busy, self._asked = threading.Lock(), threading.Event()
        begin(self._look)

    def follower(self) -> FaceFollower:
        """A follower for the same frames from the first one on, which need not look again."""
        self._asked.set()
        with self._busy:  # the frame that is looked at is worth waiting for
            return FaceFollower(self.choice, tuple(self._follower.found), self._follower.faces)

    def _look(self) -> None:
        """Follow the face; what is wrong with the video is left to whoever reads it next."""
        with self._busy, one_thread():
            for image, _ in zip(read_frames(self.video), range(PREPARATION.look_at), strict=False):
                if self._asked.is_set():
                    return
                self._follower.step(image)


_begun: list[FirstLook] = []


@contextmanager
def first_look(video: Path, choice: FaceChoice) -> Iterator[None]:
    """Follow a video's face from now on, for the `follower_of` it; at the end it is left alone."""
    look = FirstLook(video, choice)
    _begun.append(look)
    try:
        yield
    finally:
        _begun.remove(look)
        look.follower()


def follower_of(video: Path, choice: FaceChoice) -> FaceFollower:
    """A follower of a video's face from its first frame on; what a `first_look` found is used."""
    for look in _begun:
        if (look.video, look.choice) == (video, choice):
            return look.follower()
    return FaceFollower(choice)
