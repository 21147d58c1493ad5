"""The head's outline: where skin ends in the picture is where the head must end.

From brows to chin, cheeks, jaw and ears stand before hair or background. Along the normal of the
drawn outline, each place looks for where the colour of the skin beside it ends, as in Hanek and
Beetz, "The Contracting Curve Density Algorithm", IJCV 59(3), 2004. Hair and beards end it early, so
an outline that would have to shrink is believed less than one that would have to grow.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from abs_engine.core.arrays import FloatArray, Image
from abs_engine.core.buffers import Buffers
from abs_engine.core.camera import Camera
from abs_engine.core.pose import pose_moves
from abs_engine.core.scene import Candidates, Renderer
from abs_engine.core.settings import GENERAL
from abs_engine.tracking.landmark.head_equations import Equations
from abs_engine.tracking.settings.outline import OUTLINE
from abs_engine.tracking.texture.head_texture import (
    HeadBody,
    HeadView,
    between,
    picture_motion,
    pixels_a_mm,
    window_about,
)

_PLACES = np.arange(OUTLINE.beside[0], OUTLINE.ear_reach + OUTLINE.step / 2, OUTLINE.step)
_SPREAD = np.array(OUTLINE.spread)


@dataclass(frozen=True, eq=False)
class Outline:
    """Places of a head's outline in a frame, and how far off the skin ends there.

    Parameters
    ----------
    corners : (N, 3) int
        Vertices of the facet that each lies on.
    weights : (N, 3) float64
        Barycentric.
    normal : (N, 2) float64
        Outward, in the picture.
    begun : (N, 2) float64, px
        Where the places were.
    off : (N,) float64, mm
        How far outward of there the skin ends.
    identity : (K, N, 3) float64, mm per standard deviation
        How the places differ from person to person.
    posture : (M, N, 3) float64, mm per standard deviation
        How they move.
    """

    corners: NDArray[np.integer]
    weights: FloatArray
    normal: FloatArray
    begun: FloatArray
    off: FloatArray
    identity: FloatArray
    posture: FloatArray


def outline(
    body: HeadBody, view: HeadView, image: Image, camera: Camera, renderer: Renderer
) -> Outline | None:
    """The outline of a placed head in a frame (H, W, 3) RGB; None where hardly any of it shows."""
    if "landmark_68" not in body.speaker.points:
        return None
    low, high = _heights(body, view)
    camera = view.camera or camera
    about = view.vertices[(view.vertices[:, 1] > low) & (view.vertices[:, 1] < high)]
    if not len(about):
        return None
    window = window_about(about, view.pose, camera, OUTLINE.side)
    scene = body.scene.at(view.vertices.astype(np.float32))
    drawn = renderer.draw(scene, Candidates.one(np.zeros(0), view.pose), camera, window)[0]
    scale = pixels_a_mm(view.pose, camera)
    at, normal = _rim(drawn, max(1, round(OUTLINE.apart * window.scale * scale)))
    if len(at) < OUTLINE.least:
        return None
    weights = drawn.barycentrics[at[:, 1], at[:, 0]].astype(np.float64)
    corners = body.speaker.faces[drawn.facet_id[at[:, 1], at[:, 0]] - 1]
    points = between(corners, weights, view.vertices)
    seen = camera.project(view.pose.apply(points))
    blur = max(OUTLINE.least_blur, GENERAL.shrunk_blur / window.scale)  # as it is drawn
    soft = cv2.GaussianBlur(image, (0, 0), blur)
    lab = np.asarray(cv2.cvtColor(soft, cv2.COLOR_RGB2LAB), np.float32)
    profile, skin = _profiles(lab, seen, normal, scale), _skin(lab, body, view, camera)
    beside = np.median(profile[:, OUTLINE.beside[1] >= _PLACES], axis=1)
    off, found = _edges(profile, beside)
    found &= _away(beside, *skin) < OUTLINE.bare
    further, ear = _ear_edges(profile, skin)
    # Ears reach to where the jaw line begins
    jaw = view.vertices[body.speaker.points["landmark_68"][[0, 16]], 2]
    ear &= points[:, 2] < float(jaw.mean())
    off, found = np.where(ear, further, off), found | ear
    found &= (points[:, 1] > low) & (points[:, 1] < high)
    if found.sum() < OUTLINE.least:
        return None
    where = corners[found], weights[found]
    return Outline(
        *where, normal[found], seen[found], off[found],
        between(*where, body.identity), between(*where, body.posture),
    )  # fmt: skip


def outline_equations(body: HeadBody, found: Outline, view: HeadView, camera: Camera) -> Equations:
    """Of pose (6), identity (K) and posture (M), where `view` is the head as it is by now.

    A place of an outline may slide along the line of sight and along the outline, so that only how
    far it goes across the outline counts.
    """
    camera = view.camera or camera
    there = view.pose.apply(between(found.corners, found.weights, view.vertices))
    scale = pixels_a_mm(view.pose, camera)
    across = np.einsum("nij,ni->nj", picture_motion(there, camera), found.normal) / scale
    moves = pose_moves(there - view.pose.apply(body.pivot))
    modes = np.concatenate([found.identity, found.posture])
    slope = np.concatenate(
        [_along(across, moves), _along(across @ view.pose.rotation, modes)], axis=1
    ).T
    moved = ((camera.project(there) - found.begun) * found.normal).sum(axis=1) / scale
    residual = found.off - moved
    sigma = np.where(residual > 0, OUTLINE.grows, OUTLINE.shrinks)
    sigma = np.hypot(sigma, OUTLINE.pixels / scale)
    weight = 1 / (OUTLINE.alike * sigma**2 * (1 + (residual / (2 * sigma)) ** 2))
    return Equations((slope * weight) @ slope.T, -(slope * weight) @ residual)


def _along(across: FloatArray, moves: FloatArray) -> FloatArray:
    """Components (N, D) of the motion of points (D, N, 3) along vectors (N, 3)."""
    return np.asarray((across[:, None] @ moves.transpose(1, 2, 0))[:, 0])


def _heights(body: HeadBody, view: HeadView) -> tuple[float, float]:
    """Between which heights of the head, mm, its outline is that of skin."""
    marks = view.vertices[body.speaker.points["landmark_68"]]
    chin, brows = marks[8, 1], marks[17:27, 1].max()
    return float(chin) + OUTLINE.above_chin, float(brows) + OUTLINE.above_brows


def _rim(drawn: Buffers, apart: int) -> tuple[NDArray[np.int_], FloatArray]:
    """Every so many drawn pixels (N, 2) along the outline, and its outward normals (N, 2)."""
    covered = drawn.covered.astype(np.uint8)
    lines, _ = cv2.findContours(covered, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    if not lines:
        return np.zeros((0, 2), np.int_), np.zeros((0, 2))
    at = max(lines, key=len)[::apart, 0].astype(np.int_)
    height, width = covered.shape
    at = at[(at > 0).all(axis=1) & (at[:, 0] < width - 1) & (at[:, 1] < height - 1)]
    soft = cv2.GaussianBlur(covered.astype(np.float32), (0, 0), OUTLINE.rim_blur)
    down, right = np.gradient(soft)
    normal = -np.stack([right, down], axis=-1)[at[:, 1], at[:, 0]].astype(np.float64)
    return at, normal / np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-9)


def _profiles(
    lab: NDArray[np.float32], seen: FloatArray, normal: FloatArray, scale: float
) -> FloatArray:
    """Colours (N, S, 3) along the normals; NaN outside of the picture."""
    at = (seen[:, None] + _PLACES[:, None] * scale * normal[:, None]).astype(np.float32)
    x, y = np.ascontiguousarray(at[..., 0]), np.ascontiguousarray(at[..., 1])
    if not len(at):
        return np.zeros((*x.shape, 3))
    taken = cv2.remap(lab, x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    height, width = lab.shape[:2]
    outside = (x < 0) | (y < 0) | (x > width - 1) | (y > height - 1)
    return np.where(outside[..., None], np.nan, taken.astype(np.float64))


def _skin(
    lab: NDArray[np.float32], body: HeadBody, view: HeadView, camera: Camera
) -> tuple[FloatArray, FloatArray]:
    """Middle and spread (3,) of the colours of nose and cheeks."""
    root = body.speaker.points["landmark_68"][27]
    below = view.vertices[body.skin, 1] < view.vertices[root, 1]
    shown = view.shown(camera)[body.skin[below]]
    x, y = np.rint(shown[shown[:, 2] > 0, :2]).astype(np.int_).T
    height, width = lab.shape[:2]
    inside = (x >= 0) & (y >= 0) & (x < width) & (y < height)
    if not inside.any():
        return np.zeros(3), _SPREAD
    seen = lab[y[inside], x[inside]].astype(np.float64)
    middle = np.median(seen, axis=0)
    return middle, np.maximum(1.48 * np.median(np.abs(seen - middle), axis=0), _SPREAD)


def _away(colours: FloatArray, middle: FloatArray, spread: FloatArray) -> FloatArray:
    """Squared deviations (...) of colours (..., 3) from a middle one."""
    return np.asarray((((colours - middle) / spread) ** 2).sum(axis=-1))


def _for_skin(away: FloatArray) -> FloatArray:
    """By how much samples at squared deviations (N, S) speak for skin rather than anything else."""
    told = np.clip(OUTLINE.other - away, -OUTLINE.other, OUTLINE.other) * OUTLINE.step
    return np.nan_to_num(told)


def _edges(profile: FloatArray, beside: FloatArray) -> tuple[FloatArray, NDArray[np.bool_]]:
    """Ends (N,), mm outward, of skin as it is beside each place (N, 3), and whether it does end.

    The most probable end of a stretch whose colours are as those beside the place, the others being
    any. An edge is blurred, so that skin seems to end about half a pixel early; the places, middles
    of the last drawn pixels, lie as far within the outline, and the two cancel.
    """
    away = _away(profile, beside[:, None], _SPREAD)
    searched = np.abs(_PLACES) <= OUTLINE.reach
    sums = np.cumsum(_for_skin(away[:, searched]), axis=1)
    best = sums.argmax(axis=1)
    drop = sums[np.arange(len(sums)), best] - sums[:, -1]
    off = _PLACES[searched][best]
    found = np.isfinite(away[:, OUTLINE.reach >= _PLACES]).all(axis=1)
    return off, found & (drop > OUTLINE.edge) & (np.abs(off) < OUTLINE.reach - 2 * OUTLINE.step)


def _ear_edges(
    profile: FloatArray, skin: tuple[FloatArray, FloatArray]
) -> tuple[FloatArray, NDArray[np.bool_]]:
    """The same of an ear that hair parts from the cheek: where a stretch of facial skin ends."""
    away = _away(profile, *skin)
    told = _for_skin(away)
    run, runs = np.zeros(len(profile)), np.zeros(told.shape)
    for k, gain in enumerate(told.T):
        run = np.maximum(run, 0.0) + gain
        runs[:, k] = run
    best = runs.argmax(axis=1)
    sums = np.cumsum(told, axis=1)
    at = np.arange(len(profile))
    drop = (sums[at, best] - sums[:, -1]) if len(profile) else np.zeros(0)
    off = _PLACES[best]
    found = np.isfinite(away).all(axis=1) & (runs[at, best] > OUTLINE.ear) & (drop > OUTLINE.edge)
    return off, found & (off > -OUTLINE.reach) & (off < OUTLINE.ear_reach - 2 * OUTLINE.step)
