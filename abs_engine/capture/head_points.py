"""Points of the head: of dots that were followed, or of the markers of a file."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from abs_engine.capture.dot_annotations import needed_among
from abs_engine.capture.head import HeadChoice, head_motion
from abs_engine.capture.markers import Markers
from abs_engine.capture.observations import Observations
from abs_engine.capture.recorded import check_size
from abs_engine.capture.session import Tracks
from abs_engine.capture.settings import CAPTURE
from abs_engine.capture.triangulate import triangulate
from abs_engine.capture.view import View
from abs_engine.core.errors import TooFewPointsError
from abs_engine.core.words import listed

ORDER = "the order of videos, views and calibrations, and of x and y"
"""What is usually wrong where views do not agree on most points."""


def points_of_head(
    tracks: Tracks,
    views: Sequence[View],
    head: HeadChoice,
    largest_error: float = CAPTURE.largest_error,
    source: str = "",
) -> Observations:
    """Triangulate dots and take them into the head frame.

    A point with a lower correlation than `CAPTURE.sure` in one of the views counts as uncertain,
    unless a person corrected it there.

    Parameters
    ----------
    largest_error : float, px
        A point whose reprojection error is larger counts as not found.

    Raises
    ------
    DegenerateViewsError
        If the views leave depth open, or the rigid points a rotation.
    TooFewPointsError
        If the rigid points are too few, or points that the head frame needs have larger errors.
    ParameterError
        If the points lie closer together than a face's do in mm, or far from the head as given.
    """
    made = triangulate(views, tracks.pixels)
    agreed = made.known & (made.error <= largest_error)
    world = np.where(agreed[..., None], made.points, np.nan)
    if 2 * agreed.sum() > agreed.size:  # what else is wrong is more likely the order
        check_size(world, "calibrate again with the side of the board's squares in mm (--square)")
    try:
        motion = head_motion(world, tracks.names, head)
    except TooFewPointsError as error:
        never = np.asarray(made.known.any(axis=0) & ~agreed.any(axis=0))
        dropped = [n for n, so in zip(tracks.names, never, strict=True) if so and n in head.needed]
        if not dropped:
            raise
        raise TooFewPointsError(
            f"the views agree within {largest_error:g} px in no frame on {listed(dropped)}",
            f"check {ORDER}",
        ) from error
    points = motion.to_head(world)
    found = np.asarray(agreed & motion.found[:, None])
    score = tracks.scores.min(axis=0)
    doubtful = ((tracks.scores < CAPTURE.sure) & ~tracks.corrected).any(axis=0)
    return Observations(
        points, tracks.names, found, found & doubtful, made.error, score, tracks.rate,
        motion.rotations, motion.translations, motion.error, tracks.pixels, source,
    )  # fmt: skip


def points_of_markers(markers: Markers, head: HeadChoice, source: str = "") -> Observations:
    """Take the markers of a file into the head frame; those needed are of `needed_among`.

    Raises
    ------
    TooFewPointsError
        If a needed marker is not there, or the rigid points are too few.
    DegenerateViewsError
        If the rigid points leave a rotation open.
    ParameterError
        If the markers lie closer together than a face's do in mm.
    """
    needed = needed_among(markers.names)
    lacking = [name for name in needed if name not in markers.names]
    if lacking:
        raise TooFewPointsError(
            f"{len(lacking)} of the {len(needed)} points are missing: {lacking[0]}, ...",
            f"rename the markers (there are {', '.join(markers.names[:8])}, ...)",
        )
    check_size(markers.points)
    names = (*needed, *(n for n in markers.names if n not in needed))
    order = [markers.names.index(n) for n in names]
    world = markers.points[:, order]
    motion = head_motion(world, names, head)
    points = motion.to_head(world)
    found = np.asarray(np.isfinite(points).all(axis=2))
    return Observations(
        points, names, found, np.zeros_like(found), markers.residual[:, order],
        found.astype(float), markers.rate, motion.rotations, motion.translations, motion.error,
        source=source, first=markers.first,
    )  # fmt: skip
