"""Pictures for the person who supervises: the dots where they were found, and how surely."""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

from abs_engine.capture.dot_tracking import Sighting
from abs_engine.capture.settings import CAPTURE
from abs_engine.core.arrays import Image

SURE, UNSURE, GIVEN = (60, 230, 90), (255, 60, 40), (80, 170, 255)
"""RGB of a dot that was surely found, that is uncertain, that a person placed."""

_CROSS, _BITS = 5, 4


def draw_dots(image: Image, sighting: Sighting, names: Sequence[str]) -> Image:
    """A copy of a picture with a cross and the number, from 1, at each dot that was found.

    A line at the bottom names the dots that are lost.
    """
    out = np.ascontiguousarray(image).copy()
    for i in np.flatnonzero(sighting.found):
        colour = SURE if sighting.scores[i] >= CAPTURE.sure else UNSURE
        if sighting.corrected[i]:
            colour = GIVEN
        _cross(out, sighting.places[i], colour)
        x, y = np.rint(sighting.places[i] + np.array([_CROSS, -_CROSS])).astype(int).tolist()
        cv2.putText(out, str(i + 1), (x, y), cv2.FONT_HERSHEY_SIMPLEX, 0.35, colour, 1, cv2.LINE_AA)
    lost = ", ".join(f"{i + 1} {names[i]}" for i in np.flatnonzero(~sighting.found).tolist())
    if lost:
        cv2.putText(
            out, f"lost: {lost}", (5, out.shape[0] - 6), cv2.FONT_HERSHEY_SIMPLEX, 0.4, UNSURE, 1,
            cv2.LINE_AA,
        )  # fmt: skip
    return out


def draw_views(
    images: Sequence[Image], sightings: Sequence[Sighting], names: Sequence[str]
) -> Image:
    """The views side by side; one picture where both are in it.

    Parameters
    ----------
    images : sequence of (H, W, 3) uint8 RGB
        The same object twice for a picture with a mirror.
    """
    if images[0] is images[-1]:
        out = images[0]
        for sighting in sightings:
            out = draw_dots(out, sighting, names)
        return out
    drawn = [draw_dots(i, s, names) for i, s in zip(images, sightings, strict=True)]
    height = max(d.shape[0] for d in drawn)
    return np.concatenate(
        [np.pad(d, ((0, height - d.shape[0]), (0, 0), (0, 0))) for d in drawn], axis=1
    )


def _cross(image: NDArray[np.uint8], place: NDArray[np.float64], colour: Sequence[int]) -> None:
    """Two strokes that leave the dot's centre free, drawn at fractions of a pixel."""
    for way in np.array([[1, 0], [-1, 0], [0, 1], [0, -1]]):
        ends = np.rint((place + np.outer([2.5, _CROSS], way)) * 2**_BITS).astype(int)
        cv2.line(image, ends[0].tolist(), ends[1].tolist(), colour, 1, cv2.LINE_AA, _BITS)
