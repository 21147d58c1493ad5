"""One person's face, learned from several recordings of them that were tracked."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.camera import Camera
from abs_engine.core.errors import FaceNotFoundError
from abs_engine.core.scene import Renderer
from abs_engine.io.video import read_frames
from abs_engine.tracking.face_choice import FaceChoice, FaceFollower
from abs_engine.tracking.head_fit import AverageHead
from abs_engine.tracking.landmarks import Landmarks
from abs_engine.tracking.person_fit import fit_person
from abs_engine.tracking.speaker_face import SpeakerFace

FloatArray = NDArray[np.float64]
Image = NDArray[np.uint8]
Arrays = dict[str, NDArray[Any]]

LEAST_EACH, MOST = 2, 32
"""Frames that the head is fitted to: so many of each recording at least, and of all at most unless
that makes them more."""


@dataclass(frozen=True, eq=False)
class Recording:
    """A video and what was tracked in it.

    Parameters
    ----------
    video : Path
    run : dict of str to array
        As ``results.npz`` has them.
    """

    video: Path
    run: Arrays


def sure_frames(run: Arrays) -> NDArray[np.bool_]:
    """Frames (T,) whose mouth was found, seen, and not doubted by the landmarks."""
    fine = run["found"] & ~run["covered"] & ~run["contradicted"]
    return np.asarray(fine & (run["status"] == "converged"))


def spread_frames(run: Arrays, usable: NDArray[np.bool_], count: int) -> NDArray[np.intp]:
    """So many of the usable frames (T,), spread over how open and how wide the mouth is.

    Every other one is taken by the rank of its aperture, the others by that of its width.
    """
    at = np.flatnonzero(usable)
    chosen: list[int] = []
    for k, name in enumerate(("aperture", "width")):
        share = (count + 1 - k) // 2
        left = np.setdiff1d(at, chosen)
        order = left[np.argsort(run[name][left], kind="stable")]
        ranks = np.linspace(0, len(order) - 1, share).round().astype(int)
        chosen += [int(f) for f in order[np.unique(ranks)]] if len(order) else []
    return np.unique(chosen).astype(np.intp)


def pictures(video: Path, frames: Sequence[int]) -> list[tuple[Image, Landmarks]]:
    """Frames of a video with the landmarks of its face, where they are seen."""
    follower, wanted = FaceFollower(FaceChoice()), set(map(int, frames))
    found = []
    for index, image in enumerate(read_frames(video)):
        seen = follower.step(image)
        if index in wanted and seen is not None:
            found.append((image, seen))
        if index >= max(wanted, default=-1):
            break
    return found


def learn_head(
    recordings: Sequence[Recording],
    usable: Sequence[NDArray[np.bool_]],
    average: AverageHead,
    head: str,
    camera: Camera,
    renderer: Renderer,
    tell: Callable[[str], None],
) -> SpeakerFace:
    """One head and one set of colours, fitted to frames of all recordings together.

    Parameters
    ----------
    recordings : sequence of Recording
        Of one person and one camera.
    usable : sequence of (T,) bool
        The frames of each that may be learned from.
    average : AverageHead
    head : str
        Checksum of the head that it is; see `learn.training.checksum`.
    camera : Camera
    renderer : Renderer
    tell : callable
        Called with what is begun, in a few words.
    """
    each = max(LEAST_EACH, MOST // len(recordings))
    tell("choosing frames")
    chosen = [
        found
        for one, own in zip(recordings, usable, strict=True)
        for found in pictures(one.video, list(spread_frames(one.run, own, each)))
    ]
    if not chosen:
        raise FaceNotFoundError("no frame shows the mouth well", "give recordings of a face")
    tell(f"fitting one head to {len(chosen)} frames of {len(recordings)} recordings")
    fitted = fit_person(average, chosen, camera, renderer, None, tell)
    return SpeakerFace.of(fitted, average.scale, head)
