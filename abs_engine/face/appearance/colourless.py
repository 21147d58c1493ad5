"""The test for film without colour: black and white, near infrared, or one tint as sepia.

What counts is not how colourful a picture is but whether its chroma says more than its luminance
does: the tint of a sepia picture is a function of luminance, compression adds a little noise.
Strong tints are known by `one_tint`.
"""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

from abs_engine.core.arrays import FloatArray
from abs_engine.face.appearance.one_tint import TO_CHROMA, in_one_tint, off_tint
from abs_engine.face.settings.colour import COLOURS
from abs_engine.face.settings.tint import TINT

_FEWEST = 4 * COLOURS.luminance_levels  # cells of a face


def chroma_spread(image: NDArray[np.uint8], outline: FloatArray) -> float | None:
    """RMS of a face's chroma about what its luminance tells of it, levels of 255.

    None where too little of the face, which fills the hull of `outline` (N, 2), px, lies in the
    picture (H, W, 3). A dark face's is divided by how dark it is, since the same skin shows less
    chroma in less light. What coding adds does not shrink with it, so the divisor has a lower
    limit. A picture in one strong tint has none: there chroma that is coarser than luminance is far
    off at edges.
    """
    height, width = image.shape[:2]
    low = np.clip(np.floor(outline.min(axis=0)), 0, [width, height]).astype(int)
    high = np.clip(np.ceil(outline.max(axis=0)) + 1, 0, [width, height]).astype(int)
    if (high - low).min() < 2:
        return None
    scale = COLOURS.cells_across / float(np.ptp(outline[:, 0]))
    size = np.maximum(np.rint((high - low) * scale).astype(int), 1)
    part = np.asarray(image[low[1] : high[1], low[0] : high[0]], np.float32)
    cells = cv2.resize(part, (int(size[0]), int(size[1])), interpolation=cv2.INTER_AREA)
    inside = np.zeros(cells.shape[:2], np.uint8)
    hull = cv2.convexHull(np.rint((outline - low) * scale).astype(np.int32))
    cv2.fillConvexPoly(inside, hull, 1)
    kept = cv2.erode(inside, np.ones((3, 3), np.uint8)) > 0
    if np.count_nonzero(kept) < _FEWEST:
        return None
    if off_tint(cells[kept]) < TINT.most_off_face:
        margin = np.rint(TINT.around * (high - low)).astype(int)
        first, last = np.maximum(low - margin, 0), high + margin
        if in_one_tint(image[first[1] : last[1], first[0] : last[0]]):
            return 0.0
    seen = TO_CHROMA @ cells[kept].astype(np.float64).T
    blue, red, luminance = seen
    of_blue, of_red, at = _medians(seen[:, np.argsort(luminance, kind="stable")])
    away = [blue - np.interp(luminance, at, of_blue), red - np.interp(luminance, at, of_red)]
    dim = np.clip(float(np.median(luminance)) / COLOURS.light_face, COLOURS.most_dim, 1.0)
    return float(np.sqrt(np.square(away).sum(axis=0).mean()) / dim)


def _medians(values: FloatArray) -> FloatArray:
    """Medians of values (3, N) in groups of one after another, (3, G), as even as can be.

    Those of one size are made at once, as NumPy takes long to begin a median.
    """
    least, more = divmod(values.shape[1], COLOURS.luminance_levels)
    larger = values[:, : more * (least + 1)].reshape(3, more, least + 1)
    others = values[:, more * (least + 1) :].reshape(3, -1, least)
    return np.concatenate([np.median(part, axis=2) for part in (larger, others)], axis=1)


def grey_below(faces: Sequence[tuple[NDArray[np.uint8], FloatArray]]) -> float:
    """Spread of chroma below which a frame of a clip in colour has none, levels of 255.

    By some of its frames with the face's outline; 0, so that no frame is, of a clip that has no
    colour, or in too few of them.
    """
    spreads = [chroma_spread(image, outline) for image, outline in faces]
    told = np.array([spread for spread in spreads if spread is not None])
    coloured = told[told > COLOURS.least_spread]
    if len(coloured) < max(1.0, COLOURS.least_coloured * len(told)):
        return 0.0
    return COLOURS.grey_share * float(np.median(coloured))


def is_grey(image: NDArray[np.uint8], outline: FloatArray, below: float) -> bool:
    """Whether a frame (H, W, 3) RGB has no colour in a clip that has, by `grey_below`."""
    spread = chroma_spread(image, outline) if below > 0 else None
    return spread is not None and spread < below


def in_colour(faces: Sequence[tuple[NDArray[np.uint8], FloatArray]]) -> bool:
    """Whether a clip shows a face in colour, by some of its frames with the face's outline.

    True where none of them shows enough of it.
    """
    spreads = [chroma_spread(image, outline) for image, outline in faces]
    told = [spread for spread in spreads if spread is not None]
    return not told or float(np.median(told)) > COLOURS.least_spread
