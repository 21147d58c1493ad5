"""Checks of a corpus: points that no face has, and lips that do not lie as lips do."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from abs_engine.capture.corpus import Corpus
from abs_engine.capture.exchanged import exchanged, most_often
from abs_engine.capture.settings import CAPTURE
from abs_engine.core.arrays import FloatArray
from abs_engine.core.errors import ParameterError


def check_unit(points: FloatArray) -> None:
    """Raise `ParameterError` where the points (T, K, 3) lie too far apart for a face."""
    there = np.asarray(np.isfinite(points).all(axis=2))
    whole = points[there.any(axis=1)]
    if not whole.size:
        return
    away = np.linalg.norm(whole - np.nanmedian(whole, axis=1, keepdims=True), axis=2)
    wide = float(np.median(np.nanmedian(away, axis=1)))
    if wide > CAPTURE.wide:
        raise ParameterError(
            f"half of the points of the face lie {wide:.0f} mm or more from their middle",
            "is --unit right? without it, points are in mm",
        )


def check_wild(points: FloatArray, names: Sequence[str], frames: Sequence[int]) -> None:
    """Raise `ParameterError` where a point of (T, K, 3) lies farther off than faces move.

    `frames` are the numbers of these frames.
    """
    for name, places in zip(names, points.swapaxes(0, 1), strict=True):
        there = np.flatnonzero(np.isfinite(places).all(axis=1))
        if not len(there):
            continue
        seen = places[there]
        away = np.linalg.norm(seen - np.median(seen, axis=0), axis=1)
        if away.max() > CAPTURE.wild:
            frame = frames[there[away.argmax()]]
            raise ParameterError(
                f"in frame {frame}, the point '{name}' lies {away.max():.0f} mm from its usual "
                "place",
                "correct it, or leave it empty there; if the head moves, name the upper teeth",
            )


def check_exchanged(points: FloatArray, names: Sequence[str], frames: Sequence[int]) -> None:
    """Raise `ParameterError` where two points have each other's place; as `check_wild`."""
    at = np.flatnonzero(np.isfinite(points).all(axis=2).any(axis=0))
    points = points[:, at]
    usual = np.broadcast_to(np.nanmedian(points, axis=0), points.shape)
    off = np.asarray(np.linalg.norm(points - usual, axis=2) > CAPTURE.moved, np.bool_)
    pairs = exchanged(points, usual, off)
    if pairs:
        a, b, said = most_often(pairs, frames)
        raise ParameterError(
            f"the points '{names[at[a]]}' and '{names[at[b]]}' have each other's places in {said}",
            "exchange their names there",
        )


def check_lips(corpus: Corpus) -> None:
    """Raise `ParameterError` where the lips do not lie as they do on the upper teeth."""
    upper, lower = (_place(corpus, group) for group in ("upper_lip", "lower_lip"))
    if upper[1] < lower[1]:
        raise ParameterError(
            f"the upper lip lies {lower[1] - upper[1]:.0f} mm below the lower one",
            "check that right and left teeth are the subject's, and that y is up",
        )
    ahead = 0.5 * (upper[2] + lower[2])
    if ahead < CAPTURE.lips_behind:
        raise ParameterError(
            f"the lips lie {-ahead:.0f} mm behind the edge of the front teeth",
            "check which points the teeth are, and that z is forward",
        )


def _place(corpus: Corpus, group: str) -> FloatArray:
    """The mean (3,) of a group's points; NaN where it has none."""
    at = [corpus.names.index(name) for name in corpus.groups.get(group, ())]
    own = corpus.points[:, at].reshape(-1, 3)
    there = own[np.isfinite(own).all(axis=1)]
    return np.asarray(there.mean(axis=0)) if len(there) else np.full(3, np.nan)
