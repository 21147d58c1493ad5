"""What is said, and whether the lips touch where the labels say so."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

import numpy as np
from numpy.typing import NDArray

from abs_engine.evaluate.check.finding import Finding
from abs_engine.truth import Clip
from abs_engine.truth.codec import CLOSED_BELOW

FloatArray = NDArray[np.float64]
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
        lips = lip_edges(clip, "upper_lip"), lip_edges(clip, "lower_lip")
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
        inside = inside[labels[inside] == said.label]
        if len(inside) and not clip.closed[inside].any():
            how = f"'{said.label}' at {said.start:.2f} s, gap {clip.gap[inside].min():.2f} mm"
            yield Finding(name, "the lips do not meet in a p, b or m", how, int(inside[0]))


def widest_gap(
    vertices: NDArray[np.float32],
    corners: NDArray[np.integer],
    upper: NDArray[np.integer],
    lower: NDArray[np.integer],
) -> float:
    """Widest gap between the lips seen from the front, mm; negative where they overlap.

    In columns 1 mm apart over the middle four fifths of the mouth: the lowest point of the edges
    of the upper lip less the highest point of those of the lower lip.

    Parameters
    ----------
    vertices : (V, 3)
    corners : (2,) int
        Corners of the mouth.
    upper, lower : (E, 2) int
        Edges of the lips' facets.
    """
    right, left = np.sort(vertices[corners, 0].astype(np.float64))
    reach = 0.4 * (left - right)
    columns = (right + left) / 2 + np.arange(-reach, reach, 1.0)
    ceiling = np.nanmin(heights(vertices[upper], columns), axis=1, initial=np.inf)
    floor = np.nanmax(heights(vertices[lower], columns), axis=1, initial=-np.inf)
    return float((ceiling - floor).max())


def heights(edges: NDArray[np.floating], columns: FloatArray) -> FloatArray:
    """Heights (C, E) at which edges (E, 2, 3) cross planes of constant x (C,); NaN if they don't.

    Edges that lie in such a plane have neighbours that cross it at their ends.
    """
    start, run = edges[:, 0].astype(np.float64), (edges[:, 1] - edges[:, 0]).astype(np.float64)
    steep = np.abs(run[:, 0]) > 1e-9
    start, run = start[steep], run[steep]
    share = (columns[:, None] - start[:, 0]) / run[:, 0]
    crosses = (share >= 0) & (share <= 1)
    return np.where(crosses, start[:, 1] + share * run[:, 1], np.nan)


def lip_edges(clip: Clip, label: str) -> NDArray[np.int32]:
    """Edges (E, 2) of the facets of a class, each once."""
    faces = clip.faces[clip.facet_class == clip.class_names.index(label)]
    both = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    return np.unique(np.sort(both, axis=1), axis=0)
