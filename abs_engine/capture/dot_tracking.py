"""Dots followed through the frames of one view, under a person's supervision."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from scipy.optimize import linear_sum_assignment

from abs_engine.capture.dots import DotModel, Map, Peaks, correlate, cut, find_peaks
from abs_engine.capture.dots import learn_dots as learn
from abs_engine.capture.settings import CAPTURE
from abs_engine.core.arrays import BoolArray, FloatArray, Image, IntArray

Corrections = Mapping[int, tuple[float, float] | None]
"""Places in one frame by the number of the dot; None: it cannot be seen."""
Box = tuple[slice, slice]


@dataclass(frozen=True, eq=False)
class Sighting:
    """The dots of one view in one frame.

    Parameters
    ----------
    places : (N, 2) float64, px; NaN where a dot is lost
    scores : (N,) float64
        The lower of two normalised correlations: with a disc, and with how the dot and what is
        around it looked before. 0 where it is lost.
    corrected : (N,) bool
        Placed by a person.
    """

    places: FloatArray
    scores: FloatArray
    corrected: BoolArray

    @property
    def found(self) -> BoolArray:
        """Mask (N,) of the dots that have a place."""
        return np.asarray(np.isfinite(self.places).all(axis=1))


class DotFollower:
    """Follows the dots of one view; feed it every frame in order.

    In each frame all places that look like a dot compete for all dots at once (Hungarian method),
    by how far they are from where a dot is expected, and by two normalised correlations (see
    `Sighting`). The centre of the disc that correlates best, to a fraction of a pixel, is the
    place; so a dot that is pointed at carelessly at first is not off for ever, and nothing drifts.

    Parameters
    ----------
    image : (H, W, 3) uint8 RGB
        The first frame.
    places : (N, 2) float64, px
        Where a person sees each dot in it.
    """

    def __init__(self, image: Image, places: FloatArray) -> None:
        self.model: DotModel = learn(image, places)
        self._first: list[Map | None] = [None] * len(places)
        self._latest: list[Map | None] = [None] * len(places)
        self._place = np.array(places, np.float64)
        self._speed = np.zeros_like(self._place)
        self._layout = np.tile(self._place, (len(places), 1, 1))
        given: Corrections = {i: (float(x), float(y)) for i, (x, y) in enumerate(places)}
        picture, _ = self._picture(image, self._place)
        self.start = self._accept(picture, *self._nothing(), given)

    def step(self, image: Image, corrections: Corrections | None = None) -> Sighting:
        """Find the dots in the next frame.

        Parameters
        ----------
        corrections : mapping of int to place or None, optional
            What a person says of this frame; it is gone on from there.
        """
        given = corrections or {}
        pointed = [place for place in given.values() if place is not None]
        expected = self._place + self._speed
        picture, box = self._picture(
            image, np.concatenate([expected, np.reshape(pointed, (-1, 2))])
        )
        return self._accept(picture, *self._assign(picture, box, expected), given)

    def _picture(self, image: Image, places: FloatArray) -> tuple[Map, Box]:
        """The dots' contrast (H, W), worked out only in a box around where they may be."""
        far = (2 * CAPTURE.reach + 2 * CAPTURE.dot_patch) * self.model.radius + 2
        size = np.array([image.shape[1], image.shape[0]])
        low = np.clip(np.floor(places.min(axis=0) - far), 0, size - 1).astype(int)
        high = np.clip(np.ceil(places.max(axis=0) + far), low + 1, size).astype(int)
        box = slice(low[1], high[1]), slice(low[0], high[0])
        picture = np.zeros(image.shape[:2], np.float32)
        picture[box] = self.model.picture(image[box])
        return picture, box

    def _nothing(self) -> tuple[FloatArray, FloatArray]:
        return np.full_like(self._place, np.nan), np.zeros(len(self._place))

    def _assign(
        self, picture: Map, box: Box, expected: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Places (N, 2) and scores (N,) by competition."""
        inside = find_peaks(self.model.match(picture[box]), CAPTURE.least)
        corner = np.array([box[1].start, box[0].start])
        peaks = Peaks(inside.places + corner, inside.scores)
        alike = self._likeness(picture, expected, peaks)
        places, scores = self._nothing()
        for _ in range(2):  # again, from where the neighbours went
            chosen = self._choose(expected, peaks, alike)
            taken = chosen >= 0
            expected = _with_neighbours(self._place, expected, peaks, chosen)
        places[taken] = peaks.places[chosen[taken]]
        both = np.minimum(alike[taken, chosen[taken]], peaks.scores[chosen[taken]])
        scores[taken] = both
        return places, scores

    def _choose(self, expected: FloatArray, peaks: Peaks, alike: FloatArray) -> IntArray:
        """The peak (N,) of each dot, -1 for none."""
        count = len(expected)
        costs = self._costs(expected, peaks, alike)
        spare = np.full((count, count), np.inf)
        np.fill_diagonal(spare, CAPTURE.miss)
        table = np.concatenate([costs, spare], axis=1)
        row, column = linear_sum_assignment(np.where(np.isfinite(table), table, 1e6))
        chosen = np.full(count, -1)
        chosen[row] = np.where(column < len(peaks.places), column, -1)
        return chosen

    def _costs(self, expected: FloatArray, peaks: Peaks, alike: FloatArray) -> FloatArray:
        """Cost (N, M) of each pair; infinite beyond reach."""
        reach = CAPTURE.reach * self.model.radius
        away = np.linalg.norm(expected[:, None] - peaks.places[None], axis=2) / reach
        cost = away**2 + CAPTURE.unlike * (1 - alike) + CAPTURE.unlike * (1 - peaks.scores)
        return np.asarray(np.where(away < 1, cost, np.inf))

    def _likeness(self, picture: Map, expected: FloatArray, peaks: Peaks) -> FloatArray:
        """Correlation (N, M) of each peak with how the dot looked, first or of late; 0 if far."""
        alike = np.zeros((len(expected), len(peaks.places)))
        half = int(np.ceil((2 * CAPTURE.reach + CAPTURE.dot_patch) * self.model.radius)) + 1
        for i, place in enumerate(expected):
            part, origin = cut(picture, place, half)
            at = np.rint(peaks.places - origin).astype(int)
            near = ((at >= 0) & (at < part.shape[::-1])).all(axis=1)
            for patch in (self._first[i], self._latest[i]):
                if patch is None or not near.any():
                    continue
                found = cv2.dilate(
                    correlate(np.asarray(part, np.float32), patch), np.ones((3, 3), np.uint8)
                )
                alike[i, near] = np.maximum(alike[i, near], found[at[near, 1], at[near, 0]])
        return alike

    def _accept(
        self, picture: Map, places: FloatArray, scores: FloatArray, given: Corrections
    ) -> Sighting:
        """Take over what was found and what a person said, and remember it."""
        corrected = np.zeros(len(places), bool)
        corrected[list(given)] = True
        for i, place in given.items():
            places[i], scores[i] = (np.nan, 0.0) if place is None else self._snap(picture, place)
        self._keep_apart(picture, places, scores, given)
        sure = np.isfinite(places[:, 0]) & (corrected | (scores >= CAPTURE.sure))
        self._lose_strays(places, scores, sure)
        found = np.asarray(np.isfinite(places).all(axis=1))
        self._speed = np.where(found[:, None] & ~corrected[:, None], places - self._place, 0.0)
        self._place = np.where(found[:, None], places, self._guess(places, found))
        self._layout[sure] = self._place
        self._remember(picture, sure, corrected)
        return Sighting(places.copy(), scores, corrected)

    def _lose_strays(self, places: FloatArray, scores: FloatArray, sure: BoolArray) -> None:
        """Lose, in place, uncertain dots that went where their neighbours did not."""
        if not sure.any():
            return
        away = np.linalg.norm(places - self._guess(places, sure), axis=1)
        stray = ~sure & (away > CAPTURE.stray * self.model.radius)
        places[stray], scores[stray] = np.nan, 0.0

    def _guess(self, places: FloatArray, found: BoolArray) -> FloatArray:
        """Places of lost dots (N, 2), judged by how their neighbours went since they were seen."""
        guess = self._place.copy()
        for i in np.flatnonzero(~found) if found.any() else ():
            before = self._layout[i]
            away = np.linalg.norm(before[found] - before[i], axis=1)
            near = away.argsort()[: CAPTURE.neighbours]
            moved = (places[found] - before[found])[near]
            guess[i] = before[i] + np.average(moved, axis=0, weights=1 / (away[near] ** 2 + 1.0))
        return guess

    def _remember(self, picture: Map, sure: BoolArray, corrected: BoolArray) -> None:
        half = int(np.ceil(CAPTURE.dot_patch * self.model.radius))
        for i in np.flatnonzero(sure):
            place = tuple(float(c) for c in self._place[i])
            patch = cv2.getRectSubPix(picture, (2 * half + 1, 2 * half + 1), place)
            self._latest[i] = np.asarray(patch, np.float32)
            if corrected[i]:
                self._first[i] = self._latest[i]

    def _keep_apart(
        self, picture: Map, places: FloatArray, scores: FloatArray, given: Corrections
    ) -> None:
        """Leave, in place, where a person says it is a dot that was moved onto another given one.

        Of two the one that was moved less keeps the peak; dots that overlap may have only one.
        """
        said = {i: np.asarray(place, np.float64) for i, place in given.items() if place is not None}
        by_move = sorted(said, key=lambda i: float(np.linalg.norm(places[i] - said[i])))
        for k, i in enumerate(by_move):
            before = places[by_move[:k]]
            if (np.linalg.norm(before - places[i], axis=1) < CAPTURE.same).any():
                places[i], scores[i] = said[i], self._score(picture, said[i])

    def _snap(self, picture: Map, place: Sequence[float]) -> tuple[FloatArray, float]:
        """The best dot near a place that a person gives; the place itself where there is none."""
        at = np.asarray(place, np.float64)
        origin, match = self._around(picture, at)
        peaks = find_peaks(match, CAPTURE.least)
        away = np.linalg.norm(peaks.places + origin - at, axis=1)
        near = np.flatnonzero(away <= CAPTURE.snap * self.model.radius)
        if len(near):
            best = near[peaks.scores[near].argmax()]
            return peaks.places[best] + origin, float(peaks.scores[best])
        return at, self._score(picture, at)

    def _score(self, picture: Map, at: FloatArray) -> float:
        """The correlation of a place with a disc, 0 at least."""
        origin, match = self._around(picture, at)
        x, y = np.rint(at - origin).astype(int)
        inside = 0 <= y < match.shape[0] and 0 <= x < match.shape[1]
        return max(float(match[y, x]), 0.0) if inside else 0.0

    def _around(self, picture: Map, at: FloatArray) -> tuple[FloatArray, Map]:
        """The correlation with a disc around a place, and where (x, y) its map begins."""
        half = int(np.ceil(CAPTURE.snap * self.model.radius)) + self.model.template.shape[0]
        part, origin = cut(picture, at, half)
        return origin, self.model.match(np.asarray(part, np.float32))


def _with_neighbours(
    before: FloatArray, expected: FloatArray, peaks: Peaks, chosen: IntArray
) -> FloatArray:
    """Expected places of dots, if each moved as the median of itself and its nearest neighbours."""
    taken = np.flatnonzero(chosen >= 0)
    if len(taken) < 3:
        return expected
    surprise = peaks.places[chosen[taken]] - expected[taken]
    away = np.linalg.norm(before[:, None] - before[None, taken], axis=2)
    nearest = away.argsort(axis=1)[:, : CAPTURE.neighbours]
    return np.asarray(expected + np.median(surprise[nearest], axis=1))
