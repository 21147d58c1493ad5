"""Scores of tracked sentences: mm in head coordinates, lips, closures of p, b and m."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from abs_engine.core.arrays import BoolArray, FloatArray, IntArray
from abs_engine.evaluate.metrics.closure import closed_intervals
from abs_engine.face.articulated import FaceShape
from abs_engine.io.assets import Speaker
from abs_engine.papers.odisio2004.sentences_filmed import RATE, Filmed
from abs_engine.papers.odisio2004.sequence import Tracked
from abs_engine.studio.people.lip_contact import widest_gap
from abs_engine.studio.speech import Segment

_NEAR = 1
"""Frames by which a closure may be early or late."""
BILABIALS = ("p", "b", "m")


@dataclass(frozen=True, eq=False)
class Curves:
    """Curves of figure 8 for a sentence, T frames.

    Parameters
    ----------
    evaluations : (T,) int64
    rms, lips, rest : (T,) float64, mm
        Of all points, of those on the lips and around them, and of all others, in head
        coordinates.
    depth : (T,) float64, mm
        Of all points, the part along z, out of the face: a camera in front hardly sees it.
    width, aperture : (T,) float64, mm
        Of the lips, by their landmarks among the points.
    gap : (T,) float64, mm
        Widest gap between the lips of the tracked mesh.
    """

    evaluations: IntArray
    rms: FloatArray
    lips: FloatArray
    rest: FloatArray
    depth: FloatArray
    width: FloatArray
    aperture: FloatArray
    gap: FloatArray

    def told(self) -> dict[str, float]:
        """Means over the frames, for ``results.json``."""
        return {
            "rms_mm": float(self.rms.mean()),
            "lips_mm": float(self.lips.mean()),
            "evaluations_per_frame": float(self.evaluations.mean()),
        }


@dataclass(frozen=True)
class Closures:
    """Closures of a sentence, or of several.

    Parameters
    ----------
    spoken, closed : int
        In how many p, b and m the filmed lips close, and in how many of these the tracked ones do.
    found, true : int
        Runs of frames with closed tracked lips while somebody speaks, and how many of these meet
        a frame in which the filmed lips are closed, `_NEAR` frames earlier or later allowed.
    """

    spoken: int
    closed: int
    found: int
    true: int

    @property
    def recall(self) -> float:
        """Share of these p, b and m in which the tracked lips close; NaN where there is none."""
        return self.closed / self.spoken if self.spoken else float("nan")

    @property
    def precision(self) -> float:
        """Share of the closures found that are true; NaN where none was found."""
        return self.true / self.found if self.found else float("nan")

    def __add__(self, other: Closures) -> Closures:
        """Those of both."""
        return Closures(**{name: own + getattr(other, name) for name, own in vars(self).items()})


def lip_size(shape: FaceShape, points: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Width and aperture (T,), mm, of the lips of points (T, N, 3).

    Width is from corner to corner of the outer border; aperture is the height between the middles
    of the inner borders.
    """
    names = shape.model.names
    at = {name: k for k, name in enumerate(names)}
    across = points[:, at["lip_corner_000"]] - points[:, at["lip_corner_001"]]
    up = points[:, at["lip_upper_006"], 1] - points[:, at["lip_lower_006"], 1]
    return np.linalg.norm(across, axis=1), np.asarray(up)


def curves(speaker: Speaker, shape: FaceShape, filmed: Filmed, tracked: Tracked) -> Curves:
    """A tracked sentence, or its first frames, against the truth."""
    points = np.array([shape.points(row) for row in tracked.alpha])
    squared = (points - filmed.points[: len(tracked)]) ** 2
    away = squared.sum(axis=2)
    width, aperture = lip_size(shape, points)
    return Curves(
        tracked.evaluations, np.sqrt(away.mean(axis=1)),
        np.sqrt(away[:, shape.lips].mean(axis=1)),
        np.sqrt(np.delete(away, shape.lips, axis=1).mean(axis=1)),
        np.sqrt(squared[..., 2].mean(axis=1)), width, aperture,
        mesh_gaps(speaker, shape, tracked.alpha),
    )  # fmt: skip


def mesh_gaps(speaker: Speaker, shape: FaceShape, alpha: FloatArray) -> FloatArray:
    """Widest gap (T,), mm, between the lips of the model's mesh at parameters (T, P)."""
    heads = (shape.scene.vertices(row).astype(np.float32) for row in alpha)
    return np.array([widest_gap(speaker, head) for head in heads])


def closing_gap(
    speaker: Speaker, shape: FaceShape, visemes: Sequence[str], alpha: FloatArray
) -> float:
    """Widest gap, mm, below which the model's lips count as closed.

    The seven parameters make no exact seal. The gap is learned from the visemes that the model
    was built from: halfway between the widest of p, b and m and the narrowest of all others but
    the silent ones, or the middle of both medians where these overlap.

    Parameters
    ----------
    visemes : sequence of str, V
    alpha : (V, P) float64
    """
    gaps = mesh_gaps(speaker, shape, alpha)
    sealed = np.array([len(v) > 1 and v[1] in BILABIALS and v[0] == v[-1] for v in visemes])
    silent = np.isin(list(visemes), ["rest", "preph"])
    shut, apart = gaps[sealed], gaps[~sealed & ~silent]
    if shut.max() < apart.min():
        return float((shut.max() + apart.min()) / 2)
    return float((np.median(shut) + np.median(apart)) / 2)


def closures(filmed: Filmed, gap: FloatArray, below: float) -> Closures:
    """Closures of a tracked sentence.

    Parameters
    ----------
    gap : (T,) float64, mm
        Of the tracked mesh.
    below : float, mm
        See `closing_gap`.
    """
    shut, frames = gap < below, np.arange(len(gap))
    near = np.convolve(filmed.closed, np.ones(2 * _NEAR + 1), "same") > 0
    spoken = closed = 0
    for segment in filmed.utterance.segments:
        own = _frames(segment, frames)
        if segment.phoneme.closes_lips and (filmed.closed & own).any():
            spoken += 1
            closed += bool((shut & own).any())
    silent = np.zeros(len(gap), np.bool_)
    for segment in filmed.utterance.segments:
        if segment.phoneme.manner == "pause":
            silent |= _frames(segment, frames)
    runs = [run for run in closed_intervals(shut) if not silent[run[0] : run[1]].any()]
    true = sum(bool(near[first:last].any()) for first, last in runs)
    return Closures(spoken, closed, len(runs), true)


def _frames(segment: Segment, frames: IntArray) -> BoolArray:
    """Frames that belong to a segment, one more on either side."""
    times = frames / RATE
    return np.asarray(
        (times >= segment.start - _NEAR / RATE) & (times <= segment.end + _NEAR / RATE)
    )
