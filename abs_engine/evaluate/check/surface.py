"""Depth, normals, flow and albedo against the vertices under each pixel."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.arrays import FloatArray, IntArray
from abs_engine.core.geometry import seamless_normals
from abs_engine.dataset import DEPTH_STEP, Truth
from abs_engine.evaluate.check.finding import Finding
from abs_engine.evaluate.check.visibility import Head, Sight

STRAY = 0.02
"""Share of the pixels whose label may be off; facets that are seen edge-on are never exact."""

DEPTH_BIAS = 0.6 * DEPTH_STEP
NORMAL_MEDIAN, NORMAL_FAR = 1.0, 5.0
"""Degrees between a normal and that of the mesh: the median, and for all but `STRAY`."""

FLOW_MEDIAN, FLOW_FAR = 0.03, 0.25
"""Pixels between a flow vector and the truth: the median, and for all but `STRAY`."""

UNSTEADY = 12.0
"""Grey levels by which the mean colour of a facet may differ from frame to frame (median)."""


def where_findings(sight: Sight, values: NDArray[np.generic], name: str) -> Iterator[Finding]:
    """Label pixels beside the head, and pixels of the head without a label."""
    there = values.any(axis=2) if values.ndim == 3 else values != 0
    beside = int((there & (sight.ids == 0)).sum())
    if beside:
        yield Finding(name, "labels lie beside the ids", f"{beside} pixels", sight.frame)
    lacking = int((~there & (sight.ids > 0)).sum())
    if lacking > STRAY * max(len(sight), 1):
        yield Finding(name, "ids have no label here", f"{lacking} pixels", sight.frame)


def depth_findings(truth: Truth, sight: Sight, name: str) -> Iterator[Finding]:
    """Depth that is not where the line of sight meets the facet."""
    depth = truth.depth(sight.frame)
    yield from where_findings(sight, depth, name)
    if not len(sight):
        return
    error = depth[sight.y, sight.x] - sight.depth
    far = np.abs(error) > DEPTH_STEP + 0.05 * sight.slope
    flat = sight.slope < np.median(sight.slope)
    bias = float(np.median(error[flat])) if flat.any() else 0.0
    if far.mean() > STRAY or abs(bias) > DEPTH_BIAS:
        ratio = float(np.median(depth[sight.y, sight.x] / sight.depth))
        how = f"{far.mean():.1%} of the pixels, median {bias:+.3f} mm, ratio {ratio:.4f}"
        yield Finding(name, "depth does not agree with the vertices", how, sight.frame)


def normal_findings(truth: Truth, sight: Sight, name: str) -> Iterator[Finding]:
    """Normals that are not those of the mesh."""
    found = truth.normals(sight.frame)
    yield from where_findings(sight, found, name)
    if not len(sight):
        return
    direct = seamless_normals(Head.of(truth, sight.frame).points, truth.faces, truth.weld)
    mirrored = None if sight.reflection is None else sight.reflection.directions(direct)
    wanted = sight.blend(truth, direct, mirrored)
    wanted /= np.maximum(np.linalg.norm(wanted, axis=1, keepdims=True), 1e-12)
    cosine = np.einsum("nc,nc->n", wanted, found[sight.y, sight.x])
    angle = np.degrees(np.arccos(np.clip(cosine, -1, 1)))
    if np.median(angle) > NORMAL_MEDIAN or (angle > NORMAL_FAR).mean() > STRAY:
        how = f"{np.median(angle):.1f} degrees off in the middle, "
        how += f"{(angle > NORMAL_FAR).mean():.1%} of the pixels by more than {NORMAL_FAR:g}"
        yield Finding(name, "normals do not agree with the vertices", how, sight.frame)


def flow_findings(truth: Truth, sight: Sight, name: str) -> Iterator[Finding]:
    """Flow that does not lead to where the point is in the next frame."""
    flow, valid = truth.flow(sight.frame)
    beside = int((valid & (sight.ids == 0)).sum())
    if beside:
        yield Finding(name, "labels lie beside the ids", f"{beside} pixels", sight.frame)
    if sight.frame == len(truth) - 1:
        if valid.any():
            yield Finding(name, "flow of the last frame leads nowhere", "", sight.frame)
        return
    if not len(sight):
        return
    wanted = next_place(truth, sight) - np.column_stack([sight.x, sight.y])
    told = valid[sight.y, sight.x]
    lacking = ~told & (np.abs(wanted) < 500).all(axis=1)
    if lacking.mean() > STRAY:
        yield Finding(name, "ids have no label here", f"{lacking.mean():.1%}", sight.frame)
    if not told.any():
        return
    away = np.linalg.norm(flow[sight.y, sight.x] - wanted, axis=1)[told]
    if np.median(away) > FLOW_MEDIAN or (away > FLOW_FAR).mean() > STRAY:
        moved = np.median(np.linalg.norm(wanted[told], axis=1))
        how = f"{np.median(away):.2f} px off in the middle, where points move {moved:.2f} px"
        yield Finding(name, "flow does not agree with the vertices", how, sight.frame)


def next_place(truth: Truth, sight: Sight) -> FloatArray:
    """Pixels (N, 2) at which the points that are seen now are in the next frame."""
    drawn = Head.of(truth, sight.frame + 1).drawn
    mirror = sight.reflection
    image = None if mirror is None else Head.of(truth, sight.frame + 1, mirror).drawn
    place = sight.blend(truth, drawn, image) @ truth.camera.matrix.T
    return np.asarray(place[:, :2] / place[:, 2:])


def albedo_findings(
    truth: Truth, sight: Sight, name: str, colours: dict[int, FloatArray]
) -> Iterator[Finding]:
    """Albedo that is empty or not the same from frame to frame.

    Parameters
    ----------
    colours : dict
        Mean colour of every facet in the first frame that was looked at; filled at first.
    """
    albedo = truth.albedo(sight.frame)
    yield from where_findings(sight, albedo, name)
    if len(sight) < 50:
        return
    seen = albedo[sight.y, sight.x].astype(np.float64)
    if seen.mean() < 5 or seen.std() < 1:
        yield Finding(name, "albedo is empty", f"mean {seen.mean():.1f}", sight.frame)
        return
    means = _facet_means(seen, sight.facet, len(truth.faces))
    first = colours.setdefault(0, means)
    both = np.isfinite(first).all(axis=1) & np.isfinite(means).all(axis=1)
    if both.sum() < 20:
        return
    change = float(np.median(np.abs(first[both] - means[both])))
    if change > UNSTEADY:
        how = f"facets differ by {change:.0f} grey levels"
        yield Finding(name, "albedo changes from frame to frame", how, sight.frame)


def _facet_means(values: FloatArray, facet: IntArray, facets: int) -> FloatArray:
    """Mean colour (F, 3) of the facets that two or more pixels show; NaN for the others."""
    count = np.bincount(facet, minlength=facets)
    sums = np.stack([np.bincount(facet, values[:, k], facets) for k in range(3)], axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.asarray(np.where((count >= 2)[:, None], sums / count[:, None], np.nan))
