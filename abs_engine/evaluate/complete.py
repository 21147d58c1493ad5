"""Adds to an estimate what follows from it, so that every system has the same rows in the table.

From a mesh or a file of points alike: the 68 landmarks, the 20 of the lips, their pixels, and the
frames in which the lips are closed.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from abs_engine.assets import LIPS_OF_68
from abs_engine.evaluate.estimate import Estimate, PointTrack, Surface
from abs_engine.evaluate.measures import both_spaces
from abs_engine.truth import Truth
from abs_engine.truth.codec import CLOSED_BELOW
from abs_engine.truth.lip_gap import lip_edges, widest_gap

FloatArray = NDArray[np.float64]
LIPS = ("upper_lip", "lower_lip")
"""Facet classes between which the mouth opens."""


def complete(estimate: Estimate, truth: Truth, landmark_68: NDArray[Any] | None) -> Estimate:
    """The estimate with everything that follows from what it says.

    Parameters
    ----------
    estimate : Estimate
    truth : Truth
        Whose camera projects landmarks of systems that say where the head is.
    landmark_68 : (68,) int, optional
        The landmarks on the truth's mesh; without them no points are added.

    Returns
    -------
    Estimate
        With the tracks `landmarks` and `lip_landmarks`, with `pixels`, and with `closed` measured
        on the mesh, each where it can be had. What the system says itself is kept, but for
        `closed`, where it gives a mesh.
    """
    if landmark_68 is not None:
        estimate = replace(estimate, tracks=_tracks(estimate, landmark_68))
        estimate = replace(estimate, pixels=_pixels(estimate, truth, landmark_68))
    if estimate.surface is not None and set(LIPS) <= set(truth.class_names):
        closed = closed_on_mesh(estimate.surface, truth, np.flatnonzero(estimate.found).tolist())
        estimate = replace(estimate, closed=closed, closed_by="mesh")
    return estimate


def closed_on_mesh(surface: Surface, truth: Truth, frames: Iterable[int]) -> NDArray[np.bool_]:
    """Frames (T,) in which the lips of a mesh are closed, as `Clip.closed` defines it.

    Parameters
    ----------
    surface : Surface
    truth : Truth
        Whose facets tell the lips.
    frames : iterable of int
        Those that are measured; the others are open.
    """
    edges = [lip_edges(truth, label) for label in LIPS]
    corners = truth.landmarks["mouth_corners"]
    vertex = np.unique(np.concatenate([corners, *(e.ravel() for e in edges)]))
    places = [np.searchsorted(vertex, given) for given in (corners, *edges)]
    paths = surface.points(vertex).astype(np.float32)
    closed = np.zeros(len(truth), bool)
    for frame in frames:
        closed[frame] = widest_gap(paths[frame], *places) < CLOSED_BELOW
    return closed


def _tracks(estimate: Estimate, landmark_68: NDArray[Any]) -> dict[str, PointTrack]:
    tracks = dict(estimate.tracks)
    if "landmarks" not in tracks and estimate.surface is not None:
        paths = np.array(estimate.surface.points(landmark_68))
        paths[~estimate.found] = np.nan
        tracks["landmarks"] = PointTrack(landmark_68, paths)
    lips = landmark_68[LIPS_OF_68]
    for track in (tracks[name] for name in ("landmarks", "lip_points") if name in tracks):
        if "lip_landmarks" not in tracks and np.isin(lips, track.vertex).all():
            place = {int(vertex): k for k, vertex in enumerate(track.vertex)}
            chosen = track.points[:, [place[int(vertex)] for vertex in lips]]
            tracks["lip_landmarks"] = PointTrack(lips, chosen, track.space)
    return tracks


def _pixels(estimate: Estimate, truth: Truth, landmark_68: NDArray[Any]) -> FloatArray | None:
    """The pixels that a system gives, or else its landmarks by the truth's camera, (T, 68, 2)."""
    track = estimate.tracks.get("landmarks")
    if estimate.pixels is not None or track is None or estimate.turned == "camera":
        return estimate.pixels
    if not np.isin(track.vertex, landmark_68).all():
        return None
    _, points = both_spaces(track, estimate)
    if points is None:
        return None
    points = np.where(points[..., 2:] > 0, points, np.nan)  # nothing behind the camera is seen
    place = {int(vertex): k for k, vertex in enumerate(landmark_68)}
    pixels = np.full((len(estimate), len(landmark_68), 2), np.nan)
    pixels[:, [place[int(vertex)] for vertex in track.vertex]] = truth.camera.project(points)
    return pixels
