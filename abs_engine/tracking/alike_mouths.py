"""Frames whose mouth looks as in most frames, before it is known how lips and skin look.

A mask, a microphone or a hand before the mouth in some of the frames that are learned from would
otherwise be learned as lips. What the mouth does changes its colours beside those of the
forehead little by little; what hides it changes them at once, and by more.
"""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np

from abs_engine.core.arrays import FloatArray, Image
from abs_engine.face.appearance.colourless import grey_below
from abs_engine.tracking.frame_choice import Sighted
from abs_engine.tracking.landmarks import INNER_RING, OUTER_RING, Landmarks
from abs_engine.tracking.settings.frames import FRAME_LOOP
from abs_engine.tracking.settings.preparation import PREPARATION

FOREHEAD = (151, 9, 108, 337, 69, 299, 104, 333)
_MIX = np.array([[0.2, 0.2, 0.2], [2.0, -2.0, 0.0], [0.0, -1.5, 1.5]])
"""Logarithms of RGB to brightness, which shade changes most, red and blue beside green."""


def mouth_colours(image: Image, seen: Landmarks) -> FloatArray | None:
    """Colours of the lips and of what is around them beside those of the forehead, (6,).

    None where one of these lies outside of the picture.
    """
    outer, inner = seen.pixels[OUTER_RING], seen.pixels[INNER_RING]
    around = outer.mean(axis=0) + FRAME_LOOP.look_near * (outer - outer.mean(axis=0))
    parts = 0.5 * (outer + inner), around, seen.pixels[list(FOREHEAD)]
    means = [_mean(image, part, seen.size) for part in parts]
    if any(mean is None for mean in means):
        return None
    lips, skin, forehead = (_MIX @ mean for mean in means if mean is not None)
    return np.concatenate([lips - forehead, skin - forehead])


def _mean(image: Image, points: FloatArray, size: float) -> FloatArray | None:
    """Mean logarithm of RGB (3,) about points (N, 2), px, of a face of a size; None outside."""
    limit = np.array(image.shape[1::-1]) - 1
    at = np.rint(points).astype(int)
    at = at[((at >= 0) & (at <= limit)).all(axis=1)]
    if 2 * len(at) < len(points):
        return None
    reach = max(1, round(FRAME_LOOP.light_patch * size))
    low, high = np.maximum(at.min(axis=0) - reach, 0), at.max(axis=0) + reach + 1
    part = cv2.blur(image[low[1] : high[1], low[0] : high[0]], (2 * reach + 1,) * 2)
    shown = part[at[:, 1] - low[1], at[:, 0] - low[0]].astype(np.float64)
    return np.asarray(np.log(shown + FRAME_LOOP.light_black).mean(axis=0))


def alike(seen: Sequence[Sighted]) -> list[Sighted]:
    """Those of some frames whose mouth looks as in most, by steps from one to the next.

    All of them where these are too few to learn from. A frame in which the mouth's colours are not
    known is kept.
    """
    colours = [mouth_colours(*one) for one in seen]
    known = [k for k, one in enumerate(colours) if one is not None]
    if not known:
        return list(seen)
    rows = np.array([one for one in colours if one is not None])
    apart = np.linalg.norm(rows[:, None] - rows[None], axis=2)
    near = apart < PREPARATION.mouth_apart
    for _ in range(len(rows).bit_length()):  # twice as many steps each time
        near = near @ near
    group = near.argmax(axis=1)
    most = int(np.argmax(np.bincount(group)))
    left = {k for k, of in zip(known, group, strict=True) if of != most}
    if len(seen) - len(left) < PREPARATION.least_shown:
        return list(seen)
    return [one for k, one in enumerate(seen) if k not in left]


def to_learn_from(seen: list[Sighted]) -> tuple[list[Sighted], float]:
    """Frames whose mouth looks as in most, and the chroma below which one of them has none.

    All of them, where only others have colour.
    """
    most = alike(seen)
    for kept in (most, seen):
        grey = grey_below([(image, marks.pixels) for image, marks in kept])
        if grey:
            return kept, grey
    return most, 0.0
