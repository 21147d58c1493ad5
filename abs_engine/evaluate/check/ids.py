"""Facet ids against the vertices: each pixel on its facet, and nothing in front of it.

An id is right if the centre of its pixel lies in the projection of its facet. The engine's own CPU
rasteriser, which had no part in the pictures, says what else lies on that line of sight.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.arrays import BoolArray, FloatArray
from abs_engine.core.geometry import Pose
from abs_engine.core.scene import Candidates, Scene
from abs_engine.dataset import Truth, codec
from abs_engine.evaluate.check.finding import Finding
from abs_engine.evaluate.check.visibility import Head, Reflection, Sight, in_mirror
from abs_engine.render.cpu import CpuRenderer

EDGE = 0.05
"""Rounding of a rasteriser's vertices: a pixel may be outside of its facet by this, px."""

STRAY = 0.01
"""Share of the pixels that may be farther out; OpenGL leaves ties at edges open."""

IN_FRONT = 1.0
"""A facet is hidden by what is nearer by more than this, mm."""

HOLES = 0.005
"""Share of the head's pixels that may have no id where nothing is known to hide the head."""


def id_findings(truth: Truth, sight: Sight, name: str) -> Iterator[Finding]:
    """Ids that name no facet, or one that is not under the pixel."""
    if sight.ids.max() > len(truth.faces):
        yield Finding(name, "ids name facets that do not exist", f"{sight.ids.max()}", sight.frame)
    if not len(sight):
        return
    outside = sight.outside.max(axis=1)
    stray = outside > EDGE
    if stray.mean() > STRAY:
        x, y = shift(sight.edges, sight.outside)
        how = f"{stray.mean():.1%} of {len(stray)} pixels, half of them by more than "
        how += (
            f"{np.median(outside[stray]):.2f} px; a shift of ({x:.2f}, {y:.2f}) px explains it best"
        )
        yield Finding(name, "ids do not lie on their facets", how, sight.frame)


def shift(edges: FloatArray, outside: FloatArray) -> tuple[float, float]:
    """The displacement, px, that brings the pixels best onto their facets.

    Minimises the sum of squared distances outside of the edges, which is convex, by Newton's
    method: only edges that a pixel is outside of count.

    Parameters
    ----------
    edges : (N, 3, 2) float64
        Outward unit normals.
    outside : (N, 3) float64
        Distances outside of the edges, px.
    """
    normals, away = edges.reshape(-1, 2), outside.ravel()
    usual = away < 1e3
    normals, away = normals[usual], away[usual]
    step = np.zeros(2)
    for _ in range(20):
        now = away + normals @ step
        active = now > 0
        if active.sum() < 3:
            break
        chosen = normals[active]
        step -= np.linalg.lstsq(chosen.T @ chosen, chosen.T @ now[active], rcond=1e-9)[0]
    return float(step[0]), float(step[1])


def cover_findings(
    truth: Truth, sight: Sight, name: str, renderer: CpuRenderer
) -> Iterator[Finding]:
    """Facets that something hides, and parts of the head that should be seen and have no id."""
    height, width = sight.ids.shape
    mirrored = np.zeros((height, width), np.bool_)
    every_y, every_x = np.mgrid[:height, :width].reshape(2, -1)
    looks = in_mirror(truth, every_x, every_y).reshape(height, width)
    mirrored[sight.y, sight.x] = sight.mirrored
    labelled = np.zeros((height, width))
    labelled[sight.y, sight.x] = sight.depth
    facet, nearest = front(truth, sight.frame, renderer)
    hidden = (labelled > 0) & ~mirrored & (nearest > 0) & (labelled > nearest + IN_FRONT)
    if sight.reflection is not None:
        _, image = front(truth, sight.frame, renderer, sight.reflection)
        hidden |= mirrored & (image > 0) & (labelled > image + IN_FRONT)
    if len(sight) and hidden.sum() > STRAY * len(sight):
        how = f"{hidden.sum() / len(sight):.1%} of the pixels"
        yield Finding(name, "ids name facets that others hide", how, sight.frame)
    free = bare(truth, sight.frame, facet) & ~looks
    holes = (sight.ids == 0) & free
    if holes.sum() > max(HOLES * free.sum(), 2):
        how = f"{holes.sum() / free.sum():.1%} of {free.sum()} pixels"
        yield Finding(name, "ids lack a part of the head", how, sight.frame)


def front(
    truth: Truth, frame: int, renderer: CpuRenderer, mirror: Reflection | None = None
) -> tuple[NDArray[np.int32], NDArray[np.float32]]:
    """Facet id + 1 and depth (H, W) of what of the head is in front, or of its mirror image."""
    faces = truth.faces if mirror is None else truth.faces[:, [0, 2, 1]]
    scene = Scene(
        mean=Head.of(truth, frame, mirror).points.astype(np.float32),
        modes=np.zeros((0, len(truth.neutral), 3), np.float32),
        faces=faces,
        uv=np.zeros((len(truth.neutral), 2), np.float32),
        facet_class=np.ones(len(faces), np.int32),
        texture=np.zeros((1, 1, 3), np.uint8),
    )
    still = Candidates.one(np.zeros(0), Pose(np.eye(3), np.zeros(3)))
    (drawn,) = renderer.draw(scene, still, truth.camera, truth.camera.whole)
    return drawn.facet_id, drawn.depth


def bare(truth: Truth, frame: int, facet: NDArray[np.int32]) -> BoolArray:
    """Pixels (H, W) where the head is in front and nothing is known that may hide it.

    Without a picture of what covers the head, clothes may hide what is below the nose.
    """
    if truth.has(codec.COVER):
        return np.asarray((facet > 0) & (truth.cover(frame) == 0))
    nose = truth.neutral[truth.landmarks["landmark_68"][33], 1]
    above = truth.neutral[truth.faces, 1].min(axis=1) > nose
    return np.concatenate([[False], above])[facet]
