"""The check of speech: lips touch where the labels say so."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.geometry import edges_of
from abs_engine.dataset import Clip, Phoneme
from abs_engine.dataset.codec import CLOSED_BELOW
from abs_engine.dataset.lip_gap import widest_gap
from abs_engine.evaluate.check.finding import Finding

GAP = 0.05
"""mm by which `gap` may differ from the mesh."""

BILABIAL = ("p", "b", "m")


def interval_findings(clip: Clip, name: str) -> Iterator[Finding]:
    """Phonemes out of order, or other ones than the frames say."""
    length, end = len(clip) / clip.rate, 0.0
    for said in clip.intervals:
        if not said.start < said.end:
            yield Finding(name, "a phoneme has no length", f"'{said.label}' at {said.start:.3f} s")
        if said.start < end - 1e-6:
            yield Finding(name, "phonemes overlap", f"'{said.label}' at {said.start:.3f} s")
        if said.start < -1e-6 or said.end > length + 1 / clip.rate:
            how = f"'{said.label}' at {said.start:.3f} to {said.end:.3f} s of {length:.3f} s"
            yield Finding(name, "a phoneme lies outside of the clip", how)
        end = max(end, said.end)
    yield from frame_findings(clip, name)


def frame_findings(clip: Clip, name: str) -> Iterator[Finding]:
    """Frames that are labelled with no phoneme of their time, give or take half a frame."""
    labels = [said.label for said in clip.intervals]
    starts, ends = [said.start for said in clip.intervals], [said.end for said in clip.intervals]
    times, half = np.arange(len(clip)) / clip.rate, 0.5 / clip.rate
    first = np.searchsorted(ends, times - half, side="left")
    last = np.searchsorted(starts, times + half, side="right")
    for frame, label in enumerate(clip.phonemes):
        near = labels[first[frame] : last[frame]]
        if near and label not in near:
            how = f"'{label}', not {' or '.join(sorted(set(near)))}"
            yield Finding(name, "a frame has another phoneme than its time", how, frame)


def contact_findings(clip: Clip, frames: Iterable[int], name: str) -> Iterator[Finding]:
    """`gap` and `closed` that are not so on the mesh, and p, b, m without contact."""
    for frame in np.flatnonzero(clip.closed != (clip.gap < CLOSED_BELOW)).tolist():
        how = f"closed is {bool(clip.closed[frame])}, gap {clip.gap[frame]:.2f} mm"
        yield Finding(name, "closed does not follow from gap", how, frame)
    if {"upper_lip", "lower_lip"} <= set(clip.class_names):
        kinds = [clip.class_names.index(label) for label in ("upper_lip", "lower_lip")]
        lips = [edges_of(clip.faces[clip.facet_class == kind])[0] for kind in kinds]
        for frame in frames:
            gap = widest_gap(clip.vertices(frame), clip.landmarks["mouth_corners"], *lips)
            if not abs(gap - clip.gap[frame]) <= GAP:
                how = f"{clip.gap[frame]:.2f} mm, on the mesh {gap:.2f}"
                yield Finding(name, "gap is not that of the mesh", how, frame)
    labels = np.array(clip.phonemes)
    for said in clip.intervals:
        if said.label not in BILABIAL:
            continue
        first, last = np.ceil(said.start * clip.rate), np.ceil(said.end * clip.rate)
        inside = np.arange(max(int(first), 0), min(int(last), len(clip)))
        inside = inside[labels[inside] == said.label] if first < last else _beside(clip, said)
        if len(inside) and not clip.closed[inside].any():
            how = f"'{said.label}' at {said.start:.2f} s, gap {clip.gap[inside].min():.2f} mm"
            yield Finding(name, "the lips do not meet in a p, b or m", how, int(inside[0]))


def _beside(clip: Clip, said: Phoneme) -> NDArray[np.int64]:
    """The frames before and after a phoneme that has none.

    None, if not even the nearest lies within half a frame of it. The closure may be in the farther
    one: the nearest may belong to an f or v.
    """
    after = int(np.ceil(said.start * clip.rate))
    frames = np.array([f for f in (after - 1, after) if 0 <= f < len(clip)], np.int64)
    away = np.maximum(said.start * clip.rate - frames, frames - said.end * clip.rate)
    return frames if (away <= 0.5).any() else frames[:0]
