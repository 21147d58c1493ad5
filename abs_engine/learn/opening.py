"""Learning of mouths' local appearance from frames with points on their inner lips."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.arrays import FloatArray
from abs_engine.core.words import counted
from abs_engine.face.appearance.opening import (
    ACROSS,
    CENTRE,
    SIDES,
    SIZE,
    MouthSpot,
    OpeningLooks,
    surroundings,
)
from abs_engine.face.settings.appearance import APPEARANCE
from abs_engine.learn.settings import LEARNING

Generator = np.random.Generator
POINTS = (
    "left", "right", "upper_left", "lower_left", "upper", "lower", "upper_right", "lower_right",
)  # fmt: skip
"""Corners of the mouth on the left and right of the picture, and points on the inner lips."""
_SWAPPED = [1, 0, 6, 7, 4, 5, 2, 3]  # which each point is in a mirror image
_UPPER, _LOWER = [0, 2, 4, 6, 1], [0, 3, 5, 7, 1]
_OFF = np.array(LEARNING.opening_off)
"""Deviations by which a spot is put off for learning: shares of the width across and down, its
logarithm, and radians. Mouths are found in a clip about so well."""


@dataclass(frozen=True, eq=False)
class LabelledMouth:
    """A frame with points on the inner lips.

    Parameters
    ----------
    image : (H, W, 3) uint8 RGB
    points : (8, 2) float64, px
        In the order of `POINTS`.
    spot : MouthSpot
        Of the clip.
    """

    image: NDArray[np.uint8]
    points: FloatArray
    spot: MouthSpot

    @property
    def parted(self) -> bool:
        """Whether the lips are labelled as open."""
        gaps = np.linalg.norm(self.points[_UPPER] - self.points[_LOWER], axis=1)
        width = float(np.linalg.norm(self.points[1] - self.points[0]))
        return float(gaps.max()) > LEARNING.opening_parted * width

    @property
    def mirrored(self) -> LabelledMouth:
        """The same in a mirror."""
        last = self.image.shape[1] - 1
        points = self.points[_SWAPPED] * [-1, 1] + [last, 0]
        spot = replace(self.spot, x=last - self.spot.x, roll=-self.spot.roll)
        return LabelledMouth(self.image[:, ::-1], points, spot)


def spot_of(points: Sequence[FloatArray]) -> MouthSpot:
    """Place of a clip's mouth, by points (8, 2) of some of its frames."""
    left, right = np.median(np.stack(points)[:, :2], axis=0)
    return MouthSpot.between(left, right)


def doubt(mouths: Sequence[LabelledMouth]) -> list[str]:
    """Warnings of few labelled frames or videos to learn from, and of none with closed lips."""
    said, videos = [], len({mouth.spot for mouth in mouths})
    if len(mouths) < LEARNING.opening_frames or videos < LEARNING.opening_videos:
        said.append(
            f"warning: {counted(len(mouths), 'frame')} of {counted(videos, 'video')} may show too "
            f"little to learn from; label {LEARNING.opening_frames} or more, of at least "
            f"{LEARNING.opening_videos} people"
        )
    if all(mouth.parted for mouth in mouths):
        said.append(
            "warning: no closed mouth is labelled, so closed lips may come out open; label some"
        )
    return said


def learn_opening(mouths: Sequence[LabelledMouth], seed: int = 0) -> OpeningLooks:
    """Learn on which side of the inner lips a pixel lies, by its surroundings.

    The seed is of what pixels are taken, and of the first weights.
    """
    random = np.random.default_rng(seed)
    both = [side for mouth in mouths for side in (mouth, mouth.mirrored)]
    taken = [_pixels(mouth, random) for mouth in both for _ in range(LEARNING.opening_copies)]
    seen, sides = (np.concatenate(part) for part in zip(*taken, strict=True))
    mean, spread = seen.mean(axis=0), seen.std(axis=0) + 1e-6
    return OpeningLooks(mean, spread, _trained((seen - mean) / spread, sides, random))


def _pixels(
    mouth: LabelledMouth, random: Generator
) -> tuple[NDArray[np.float32], NDArray[np.int_]]:
    """Surroundings (K, F) and sides (K,) of pixels about a mouth whose spot is put off."""
    dx, dy, larger, turn = random.normal(0, _OFF)
    spot = mouth.spot
    spot = MouthSpot(
        spot.x + dx * spot.width, spot.y + dy * spot.width, spot.width * np.exp(larger),
        spot.roll + turn,
    )  # fmt: skip
    sides, away = sides_of(spot.to_normalised(mouth.points))
    rows = np.abs(np.arange(SIZE[1]) - CENTRE[1]) < LEARNING.opening_reach
    likely = (
        rows[:, None] * (LEARNING.opening_anywhere + np.exp(-away / LEARNING.opening_near))
    ).ravel()
    chosen = random.choice(
        likely.size, LEARNING.opening_pixels, replace=False, p=likely / likely.sum()
    )
    seen = surroundings(spot.normalised(mouth.image))
    return seen.reshape(likely.size, -1)[chosen], sides.ravel()[chosen]


def disagreement(looks: OpeningLooks, mouths: Sequence[LabelledMouth]) -> float:
    """Disagreement of what was learned with the points of a clip's frames.

    Near the inner lips, the mean -log probability of the sides that pixels lie on, less the
    correlation over frames of how much lies inside; NaN where no frame has points, or by them the
    mouth hardly moves.
    """
    unlike, shares = [], []
    for mouth in [mouth for mouth in mouths if np.isfinite(mouth.points).all()]:
        sides, away = sides_of(mouth.spot.to_normalised(mouth.points))
        weight = np.exp(-away / LEARNING.opening_near)
        maps = looks.probabilities(mouth.image, mouth.spot)
        given = np.take_along_axis(maps, sides[None], axis=0)[0]
        unlike.append(np.average(-np.log(given), weights=weight))
        inside = sides == SIDES.index("inside"), maps[SIDES.index("inside")]
        shares.append([np.average(part, weights=weight) for part in inside])
    if not unlike or np.std([share for share, _ in shares]) < LEARNING.opening_varied:
        return float("nan")
    labelled, seen = (np.array(shares) - np.mean(shares, axis=0)).T
    together = labelled @ seen / max(np.linalg.norm(labelled) * np.linalg.norm(seen), 1e-9)
    return float(np.mean(unlike) - together)


def sides_of(points: FloatArray) -> tuple[NDArray[np.int_], FloatArray]:
    """Sides (`SIDES`) of pixels, and their distance from the inner lips, both (88, 96).

    By `POINTS` (8, 2) in the normalised picture.
    """
    from scipy.interpolate import PchipInterpolator  # takes a while to import

    x, y = np.arange(SIZE[0]), np.arange(SIZE[1])[:, None]
    lines = []
    for ring in (_UPPER, _LOWER):
        at = points[ring][np.argsort(points[ring, 0])]
        along = np.maximum.accumulate(at[:, 0] + 1e-6 * np.arange(len(at)))
        within = np.clip(x, along[0], along[-1])
        lines.append(PchipInterpolator(along, at[:, 1])(within))
    upper, lower = lines[0], np.maximum(*lines)
    sides = np.where(y < upper, 0, np.where(y <= lower, 1, 2))
    left, right = points[:2, 0]
    off = np.abs(y - 0.5 * (upper + lower)) < APPEARANCE.beside * ACROSS
    sides[off & ((x < left) | (x > right))] = SIDES.index("beside")
    beyond = np.maximum(np.maximum(left - x, x - right), 0)
    away = np.minimum(np.abs(y - upper), np.abs(y - lower)) + beyond * 0.5
    return sides, away


def _trained(
    seen: NDArray[np.float32], sides: NDArray[np.int_], random: Generator
) -> tuple[tuple[NDArray[np.float32], NDArray[np.float32]], ...]:
    """Layers by the Adam method (Kingma and Ba 2015), with noise on what is seen."""
    sizes = (seen.shape[1], LEARNING.network_hidden, LEARNING.network_hidden, len(SIDES))
    first = [random.normal(0, m**-0.5, (m, n)) for m, n in pairwise(sizes)]
    state = [np.asarray(w, np.float32) for w in first]
    state += [np.zeros(n, np.float32) for n in sizes[1:]]
    slow, wide = [np.zeros_like(p) for p in state], [np.zeros_like(p) for p in state]
    batch, decay = LEARNING.network_batch, LEARNING.network_decay
    last = LEARNING.network_last
    steps = LEARNING.network_epochs * (len(seen) // batch)
    for step in range(steps):
        if step % (len(seen) // batch) == 0:
            order = random.permutation(len(seen))
        start = step % (len(seen) // batch) * batch
        some = order[start : start + batch]
        noise = random.standard_normal((batch, sizes[0]), np.float32)
        slopes = _slopes(state, seen[some] + LEARNING.network_noise * noise, sides[some])
        fall = (1 - last) / 2 * (1 + np.cos(np.pi * step / steps))
        rate = LEARNING.network_rate * (last + fall)
        for k, slope in enumerate(slopes):
            slow[k] += 0.1 * (slope - slow[k])
            wide[k] += 0.001 * (slope**2 - wide[k])
            size = np.sqrt(wide[k] / (1 - 0.999 ** (step + 1))) + 1e-8
            move = slow[k] / (1 - 0.9 ** (step + 1)) / size
            state[k] -= np.float32(rate) * (move + (decay * state[k] if k < 3 else 0))
    return tuple(zip(state[:3], state[3:], strict=True))


def _slopes(
    state: Sequence[NDArray[np.float32]], seen: NDArray[np.float32], sides: NDArray[np.int_]
) -> list[NDArray[np.float32]]:
    """Of the mean -log probability of the sides, by weights (3), then offsets (3)."""
    weights, offsets = state[:3], state[3:]
    at = [seen]
    for w, b in zip(weights[:2], offsets[:2], strict=True):
        at.append(np.maximum(at[-1] @ w + b, 0))
    out = at[-1] @ weights[2] + offsets[2]
    grown = np.exp(out - out.max(axis=1, keepdims=True))
    back = grown / grown.sum(axis=1, keepdims=True)
    back[np.arange(len(seen)), sides] -= 1
    back /= len(seen)
    of_weights, of_offsets = [], []
    for k in (2, 1, 0):
        of_weights.append(at[k].T @ back)
        of_offsets.append(back.sum(axis=0))
        back = (back @ weights[k].T) * (at[k] > 0)
    return [*of_weights[::-1], *of_offsets[::-1]]
