"""Recordings of one person, or of several: their heads are compared."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from abs_engine.core.arrays import FloatArray
from abs_engine.core.errors import OtherPersonError
from abs_engine.io.assets import Speaker
from abs_engine.tracking.person.scale import USUAL_PUPILS
from abs_engine.tracking.runs.recordings import Recording
from abs_engine.tracking.settings.frames import FRAME_LOOP

_DIFFERS = "the shape of the face differs by"


def check_same(recordings: Sequence[Recording], speaker: Speaker) -> None:
    """Raise `OtherPersonError` if a recording's head is not the others'.

    Heads are compared at the size that the usual pupil distance gives them. Of three or more, the
    one farthest from the median of all is named; of two, both.
    """
    away = _apart(_shown(recordings, speaker))
    worst = int(np.argmax(away))
    if away[worst] <= FRAME_LOOP.same_speaker:
        return
    who = f"{recordings[worst].path} does not show the same person as the others"
    if len(recordings) < 3:
        who = f"{recordings[0].path} and {recordings[1].path} do not show the same person"
    raise OtherPersonError(
        f"{who}: {_DIFFERS} {away[worst]:.1f} mm", "leave it out, or learn a face of each"
    )


def doubt_same(recordings: Sequence[Recording], speaker: Speaker) -> tuple[int, str] | None:
    """A warning, with the recording it is of, if a head may be another person's; else none."""
    away = _apart(_shown(recordings, speaker))
    worst = len(away) - 1 if len(away) < 3 else int(np.argmax(away))
    if away[worst] <= FRAME_LOOP.doubted_speaker:
        return None
    others = recordings[0].path.name if len(away) < 3 else "the others"
    return worst, (
        f"warning: may not show the same person as {others}: {_DIFFERS} {away[worst]:.1f} mm; look "
        "at it, and leave it out if it does not"
    )


def _shown(recordings: Sequence[Recording], speaker: Speaker) -> FloatArray:
    """Faces (N, K, 3) without what their height and depth change alike.

    Recordings from the front leave that open.
    """
    heads = _sized(recordings, speaker)
    usual = speaker.vertices[speaker.points["face"]].astype(np.float64)
    basis = np.linalg.qr((usual - usual.mean(axis=0))[:, 1:])[0]
    heads[..., 1:] -= basis @ (basis.T @ heads[..., 1:])
    return heads


def _sized(recordings: Sequence[Recording], speaker: Speaker) -> FloatArray:
    """Centred faces (N, K, 3), mm, at the size that the usual pupil distance gives them.

    Without expression if all say how they are then, as models differ in their mean posture.
    """
    at = speaker.points["face"]
    rests = [one.rest for one in recordings if one.rest is not None]
    heads = rests if len(rests) == len(recordings) else [one.head for one in recordings]
    sizes = [USUAL_PUPILS / one.pupils for one in recordings]
    faces = np.stack(
        [h[at].astype(np.float64) * size for h, size in zip(heads, sizes, strict=True)]
    )
    return np.asarray(faces - faces.mean(axis=1, keepdims=True))


def _apart(faces: FloatArray) -> FloatArray:
    """RMS distance (N,) of faces (N, K, 3) from the median of all; of two, from each other."""
    away = np.sqrt(((faces - np.median(faces, axis=0)) ** 2).sum(axis=2).mean(axis=1))
    times = 2.0 if len(faces) < 3 else 1.0  # two lie half-way from the median
    return np.asarray(times * away)
