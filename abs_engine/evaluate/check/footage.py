"""The video against the labels: all frames there, and each label at the frame that it is of.

A head under steady light is, pixel by pixel, close to a linear function of its albedo and of its
albedo times its normals (light of the first order of spherical harmonics: Basri & Jacobs 2003).
That function is fitted to the frame that a label is of, and to its neighbours. The frame that fits
best must be the label's own. A frame fits as well as the share of its own variance that is
explained, so that a change of exposure or light from frame to frame does not count. It must fit
better in half of the frames that are looked at: a highlight that comes or goes is in few of them.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from abs_engine.core.arrays import BoolArray, FloatArray, evenly
from abs_engine.core.errors import AbsEngineError
from abs_engine.core.geometry import seamless_normals
from abs_engine.dataset import Truth
from abs_engine.dataset.codec import FRAMES
from abs_engine.dataset.picture import read_picture
from abs_engine.evaluate.check.finding import Finding
from abs_engine.evaluate.check.visibility import Head, Sight, look
from abs_engine.io.video import probe, read_frames

LAGS = (-1, 0, 1)
WATCHED = 6
"""How many label frames are held against the video, at most."""

BETTER = 0.98
"""Another frame fits better if what it leaves unexplained is less than this share."""

EXPLAINED = 0.2
"""Share of the variance of a picture that its labels must explain."""

LOSS = 14.0
"""Mean grey levels by which compression may change a picture."""

UNIFORM = 2.0
"""Standard deviation, grey levels, of a head that shows nothing, as in the dark."""

PIXELS = 300
"""A head of fewer pixels says nothing about a picture."""


def watched(frames: int) -> list[int]:
    """Label frames that are held against the video; each has neighbours."""
    return [1 + k for k in evenly(max(frames - 2, 0), WATCHED)]


def video_findings(truth: Truth, name: str) -> Iterator[Finding]:
    """A video of other frames, or of another size or rate, or that shows something else."""
    sights = [look(truth, frame) for frame in watched(len(truth))]
    try:
        info = probe(truth.video)
        wanted = {s.frame + lag for s in sights for lag in LAGS}
        kept, count = {}, 0
        for picture in read_frames(truth.video):
            if count in wanted:
                kept[count] = picture
            count += 1
    except AbsEngineError as error:
        yield Finding(name, "cannot be read", error.problem)
        return
    if count != len(truth):
        yield Finding(name, "has another number of frames than the clip", f"{count}, {len(truth)}")
    if info.size != truth.camera.size:
        yield Finding(name, "has another size than the camera", f"{info.size}")
        return
    if abs(info.rate - truth.rate) > 0.01 * truth.rate:
        yield Finding(name, "has another rate than the clip", f"{info.rate:g} a second")
    yield from time_findings(truth, sights, kept, name)
    for sight in sights:
        if sight.frame in kept:
            yield from _loss_findings(truth, sight.frame, kept[sight.frame], name)


def _loss_findings(
    truth: Truth, frame: int, shown: NDArray[np.uint8], name: str
) -> Iterator[Finding]:
    path = truth.frame_path(frame)
    if path is None:
        return
    try:
        exact = read_picture(path, FRAMES, truth.camera.size)
    except AbsEngineError:  # `files` has said so
        return
    loss = float(np.abs(exact.astype(np.float64) - shown).mean())
    if loss > LOSS:
        yield Finding(name, "differs from the frames before compression", f"{loss:.1f}", frame)


def time_findings(
    truth: Truth, sights: list[Sight], kept: dict[int, NDArray[np.uint8]], name: str
) -> Iterator[Finding]:
    """Labels that fit a neighbouring frame better than their own, or none.

    Frames that show nothing, and those beside them, do not count, unless no frame shows anything.
    """
    measured = [_fit(truth, sight, kept) for sight in sights if len(sight) >= PIXELS]
    fits = [fit for fit in measured if fit is not None]
    if any(fit.shows.any() for fit in fits):
        fits = [fit for fit in fits if fit.shows.all()]
    if not fits:
        return
    left, total = np.sum([f.left for f in fits], axis=0), np.sum([f.total for f in fits], axis=0)
    missed = _share(left, total)
    best, own = int(missed.argmin()), LAGS.index(0)
    better = [_share(f.left, f.total) for f in fits]
    most = sum(share[best] < share[own] for share in better) >= len(fits) / 2
    explained = 1 - missed
    if missed[best] < BETTER * missed[own] and explained[best] >= EXPLAINED and most:
        how = f"labels fit the frame {LAGS[best]:+d} away better, {explained[best]:.1%} against "
        yield Finding(name, "is not in step with the labels", how + f"{explained[own]:.1%}")
    elif explained[own] < EXPLAINED:
        how = f"they explain {explained[own]:.0%} of it"
        yield Finding(name, "does not look like its labels", how)


@dataclass(frozen=True, eq=False)
class _Fit:
    """Labels of a frame against the pictures of the frames at `LAGS` from it.

    Parameters
    ----------
    left, total : (3,) float64
        Sum of squares that is not explained, and of all.
    shows : (3,) bool
        Whether anything is seen in each picture.
    """

    left: FloatArray
    total: FloatArray
    shows: BoolArray


def _fit(truth: Truth, sight: Sight, kept: dict[int, NDArray[np.uint8]]) -> _Fit | None:
    """The fit of a frame's labels, or None where the video lacks a frame."""
    if any(sight.frame + lag not in kept for lag in LAGS):
        return None
    model, near = features(truth, sight)
    levels = np.stack([kept[sight.frame + lag].mean(axis=2)[near] for lag in LAGS])
    left = np.array([unexplained(model, shown) for shown in levels])
    total = ((levels - levels.mean(axis=1, keepdims=True)) ** 2).sum(axis=1)
    return _Fit(left, total, levels.std(axis=1) >= UNIFORM)


def _share(left: FloatArray, total: FloatArray) -> FloatArray:
    """Share of the squares that is left; all of it where there are none."""
    return np.divide(left, total, out=np.ones(len(LAGS)), where=total > 0)


def features(truth: Truth, sight: Sight) -> tuple[FloatArray, BoolArray]:
    """Features that a picture should consist of, (N, K), and the pixels (H, W) concerned."""
    seen = sight.ids > 0
    disc = np.ones((7, 7), np.uint8)
    near = cv2.dilate(seen.astype(np.uint8), disc).astype(np.bool_)
    near &= truth.cover(sight.frame) == 0
    normal = np.zeros((*seen.shape, 3))
    direct = seamless_normals(Head.of(truth, sight.frame).points, truth.faces, truth.weld)
    # The light falls on the head itself, so its own normals count in a mirror too.
    normal[sight.y, sight.x] = sight.blend(truth, direct, None)
    light = np.concatenate([seen[near][:, None], normal[near]], axis=1)
    if truth.has("albedo"):
        parts = [light, light * truth.albedo(sight.frame)[near].mean(axis=1, keepdims=True)]
    else:
        kinds = truth.class_ids(sight.frame)
        parts = [light * (kinds[near] == k)[:, None] for k in np.unique(kinds[seen])]
    return np.concatenate([np.ones((len(light), 1)), *parts], axis=1), near


def unexplained(model: FloatArray, levels: FloatArray) -> float:
    """Sum of squares that a linear fit of features (N, K) to levels (N,) leaves."""
    scale = np.maximum(np.abs(model).max(axis=0), 1e-9)
    weights = np.linalg.lstsq(model / scale, levels, rcond=1e-6)[0]
    return float(((levels - (model / scale) @ weights) ** 2).sum())
