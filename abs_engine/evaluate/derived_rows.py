"""Adds to an estimate what follows from it, so that every system has the same rows in the table.

From a mesh or a file of points alike: the 68 landmarks, the 20 of the lips, their pixels, and the
frames in which the lips are closed.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.arrays import FloatArray
from abs_engine.dataset import Truth
from abs_engine.evaluate.closing import narrow
from abs_engine.evaluate.estimate import Estimate, PointTrack, places
from abs_engine.evaluate.measures import both_spaces
from abs_engine.io.assets import LIPS_OF_68


def complete(estimate: Estimate, truth: Truth, landmark_68: NDArray[Any] | None) -> Estimate:
    """The estimate with everything that follows from what it says.

    Parameters
    ----------
    truth : Truth
        Whose camera projects landmarks of systems that say where the head is.
    landmark_68 : (68,) int, optional
        The landmarks on the truth's mesh; without them no points are added.

    Returns
    -------
    Estimate
        With the tracks `landmarks` and `lip_landmarks`, with `pixels`, and with `closed` measured
        on the aperture, each where it can be had. What the system says itself is kept, but for
        `closed`, where it gives a mesh: all systems' lips are closed by one measure.
    """
    if landmark_68 is not None:
        estimate = replace(estimate, tracks=_tracks(estimate, landmark_68))
        estimate = replace(estimate, pixels=_pixels(estimate, truth, landmark_68))
    if estimate.surface is not None and "aperture" in estimate.curves:
        closed = narrow(estimate.curves["aperture"])
        estimate = replace(estimate, closed=closed, closed_by="aperture")
    return estimate


def _tracks(estimate: Estimate, landmark_68: NDArray[Any]) -> dict[str, PointTrack]:
    tracks = dict(estimate.tracks)
    if "landmarks" not in tracks and estimate.surface is not None:
        paths = np.array(estimate.surface.points(landmark_68))
        paths[~estimate.found] = np.nan
        tracks["landmarks"] = PointTrack(landmark_68, paths)
    lips = landmark_68[LIPS_OF_68]
    for track in (tracks[name] for name in ("landmarks", "lip_points") if name in tracks):
        at = places(lips, track.vertex)
        if "lip_landmarks" not in tracks and at is not None:
            tracks["lip_landmarks"] = PointTrack(lips, track.points[:, at], track.space)
    return tracks


def _pixels(estimate: Estimate, truth: Truth, landmark_68: NDArray[Any]) -> FloatArray | None:
    """The pixels that a system gives, or else its landmarks by the truth's camera, (T, 68, 2)."""
    track = estimate.tracks.get("landmarks")
    if estimate.pixels is not None or track is None or estimate.turned == "camera":
        return estimate.pixels
    at, (_, points) = places(track.vertex, landmark_68), both_spaces(track, estimate)
    if at is None or points is None:
        return None
    points = np.where(points[..., 2:] > 0, points, np.nan)  # nothing behind the camera is seen
    pixels = np.full((len(estimate), len(landmark_68), 2), np.nan)
    pixels[:, at] = truth.camera.project(points)
    return pixels
