"""Frames of a clip that are learned from."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TypeVar

import cv2
import numpy as np
from numpy.typing import NDArray

from abs_engine.core.arrays import FloatArray, Image, evenly
from abs_engine.core.errors import FaceNotFoundError
from abs_engine.core.geometry import Pose
from abs_engine.face.appearance.colourless import grey_below
from abs_engine.tracking.detection.landmarks import INNER_RING, OUTER_RING, Landmarks
from abs_engine.tracking.detection.mouth_search import CalibrationFrame
from abs_engine.tracking.settings.frames import FRAME_LOOP
from abs_engine.tracking.settings.preparation import PREPARATION

Seen = TypeVar("Seen")
Sighted = tuple[Image, Landmarks]
FOREHEAD = (151, 9, 108, 337, 69, 299, 104, 333)
_MIX = np.array([[0.2, 0.2, 0.2], [2.0, -2.0, 0.0], [0.0, -1.5, 1.5]])
"""Logarithms of RGB to brightness, which shade changes most, red and blue beside green."""


def choose_frames(
    posed: Iterable[tuple[Image, Pose | None]], name: str, least: float = PREPARATION.least_found
) -> list[CalibrationFrame]:
    """Frames to fit the person on, spread evenly over the time; see `candidate_frames`.

    Raises
    ------
    FaceNotFoundError
        If hardly a frame shows a face.
    """
    kept = candidate_frames(posed, name, least)
    return [CalibrationFrame(*kept[k]) for k in spread_over(np.arange(len(kept)))]


def spread_over(values: NDArray[np.floating] | NDArray[np.integer]) -> list[int]:
    """Indices of a few values (N,), from the least to the largest by rank."""
    picked = evenly(len(values), PREPARATION.learn_from)
    return [int(k) for k in np.sort(np.argsort(values, kind="stable")[picked])]


def turned_apart(seen: Sequence[Landmarks], count: int) -> list[int]:
    """Indices of `count` faces, in order, each of which faces farthest from those before it.

    The first is the one that faces most nearly as all do in the median. Texture says how deep a
    head is by how it moves when the head turns, and shape and nodding trade against each other
    where it hardly does. How a head leans in the picture says nothing of its shape and is left out.
    """
    facing = np.array([seen[0].turn_to(one)[:2] for one in seen])
    first = int(np.argmin(np.linalg.norm(facing - np.median(facing, axis=0), axis=1)))
    picked, away = [first], np.full(len(seen), np.inf)
    for _ in range(min(count, len(seen)) - 1):
        away = np.minimum(away, np.linalg.norm(facing - facing[picked[-1]], axis=1))
        away[picked] = -1.0
        picked.append(int(np.argmax(away)))
    return sorted(picked)


def frames_to_learn(seen: Sequence[Sighted]) -> tuple[list[Sighted], list[Sighted]]:
    """Of the frames that show a face, those to learn its mouth from, and those for its head.

    The first are spread over how open the mouth is, the others over how the head is turned.
    """
    chosen = [seen[k] for k in spread_over(np.array([marks.openness for _, marks in seen]))]
    return chosen, [seen[k] for k in turned_apart([marks for _, marks in seen], len(chosen))]


def candidate_frames(
    found: Iterable[tuple[Image, Seen | None]], name: str, least: float = PREPARATION.least_found
) -> list[tuple[Image, Seen]]:
    """Frames with what was seen in them, of the first ones from the first face on.

    Memory does not grow with the clip: they are thinned out as they come. More than a share
    `least` of the frames must show a face, those before the first one, up to
    `PREPARATION.look_at`, among them: a few faces in a clip of something else are none.

    Raises
    ------
    FaceNotFoundError
        If hardly a frame shows a face.
    """
    kept: list[tuple[Image, Seen]] = []
    stride, seen, looked, empty = 1, 0, 0, 0
    light = Brightness()
    for image, there in found:
        if there is None:
            light.add(image)
        if seen == 0 and there is None:
            empty += 1
            continue
        looked += 1
        if there is not None:
            if seen % stride == 0:
                kept.append((image, there))
            seen += 1
        if len(kept) >= 4 * PREPARATION.learn_from:
            kept, stride = kept[::2], 2 * stride
        if looked == PREPARATION.look_at:
            break
    if seen <= least * (looked + min(empty, PREPARATION.look_at)):
        raise FaceNotFoundError(
            f"no face was found in {looked + empty - seen} of {looked + empty} frames of "
            f"{name}{light.fault()}",
            "give a video with a whole frontal face; one that is there but not found needs --mouth "
            "X Y WIDTH HEIGHT, the whole mouth in the first frame",
        )
    return kept


class Brightness:
    """Mean brightness of some frames, as far as it says why no face is seen in them."""

    def __init__(self) -> None:
        self._sum, self._count = 0.0, 0

    def add(self, image: Image) -> None:
        """Take in a frame (H, W, 3) RGB."""
        self._sum, self._count = self._sum + float(image.mean()), self._count + 1

    def fault(self) -> str:
        """A clause that says that they are too dark or too bright; empty where they are not."""
        mean = self._sum / max(self._count, 1)
        if not self._count or PREPARATION.darkest <= mean <= PREPARATION.brightest:
            return ""
        kind = "dark" if mean < PREPARATION.darkest else "bright"
        return f", which are too {kind}: {mean:.0f} of 255 on average"


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

    Before it is known how lips and skin look, a mask, a microphone or a hand before the mouth in
    some of the frames would be learned as lips. What the mouth does changes its colours beside
    those of the forehead little by little; what hides it changes them at once, and by more.

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
