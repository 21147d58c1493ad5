"""Recordings of one person, or of several: their heads are compared."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from abs_engine.core.arrays import FloatArray
from abs_engine.core.errors import OtherPersonError
from abs_engine.io.assets import Speaker
from abs_engine.tracking.person.scale import USUAL_PUPILS
from abs_engine.tracking.runs.recordings import Recording
from abs_engine.tracking.settings.doubts import DOUBTS

_DIFFERS = "the shape of the face differs by"


def check_same(recordings: Sequence[Recording], speaker: Speaker) -> None:
    """Raise `OtherPersonError` if a recording's head is not the others'.

    Heads are compared at the size that the usual pupil distance gives them. Of three or more, the
    one farthest from the median of all is named; of two, both.
    """
    found = _beyond(recordings, speaker, DOUBTS.same_speaker)
    if found is None:
        return
    worst, apart = found
    who = f"{recordings[worst].path} does not show the same person as the others"
    if len(recordings) < 3:
        who = f"{recordings[0].path} and {recordings[1].path} do not show the same person"
    raise OtherPersonError(
        f"{who}: {_DIFFERS} {apart:.1f} mm", "leave it out, or learn a face of each"
    )


def doubt_same(recordings: Sequence[Recording], speaker: Speaker) -> tuple[int, str] | None:
    """A warning, with the recording it is of, if a head may be another person's; else none."""
    found = _beyond(recordings, speaker, DOUBTS.doubted_speaker)
    if found is None:
        return None
    worst, apart = found
    few = len(recordings) < 3
    others = recordings[0].path.name if few else "the others"
    return len(recordings) - 1 if few else worst, (
        f"warning: may not show the same person as {others}: {_DIFFERS} {apart:.1f} mm; look at "
        "it, and leave it out if it does not"
    )


def _beyond(
    recordings: Sequence[Recording], speaker: Speaker, limits: tuple[float, float]
) -> tuple[int, float] | None:
    """The recording whose head lies farthest beyond two limits, and how far off, mm; or none.

    The first limit is that of what the front shows, the second of the whole face.
    """
    faces = _sized(recordings, speaker)
    away = np.stack([_apart(_from_the_front(faces, speaker)), _apart(faces)])
    share = away / np.array(limits)[:, None]
    which, worst = np.unravel_index(int(np.argmax(share)), share.shape)
    return (int(worst), float(away[which, worst])) if share[which, worst] > 1 else None


def _from_the_front(faces: FloatArray, speaker: Speaker) -> FloatArray:
    """Faces (N, K, 3) without what their height and depth change alike.

    Recordings from the front leave that open.
    """
    usual = speaker.vertices[speaker.points["face"]].astype(np.float64)
    basis = np.linalg.qr((usual - usual.mean(axis=0))[:, 1:])[0]
    shown = faces.copy()
    shown[..., 1:] -= basis @ (basis.T @ faces[..., 1:])
    return shown


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
