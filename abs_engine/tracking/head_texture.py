"""The head's own texture: what one frame shows of it must lie where other frames show it.

Points of the skin are carried from one frame to another by the fitted head, and what is left
between there and where optical flow finds them says how poses and shape must change. No light is
modelled: corners of the texture are compared, not its brightness.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import cast

import cv2
import numpy as np
from numpy.typing import NDArray

from abs_engine.core.camera import Camera, Window
from abs_engine.core.geometry import Pose, vertex_normals
from abs_engine.core.pose import pose_moves
from abs_engine.core.scene import Candidates, Renderer, Scene
from abs_engine.io.assets import Speaker
from abs_engine.tracking.interpolation import at_pixels
from abs_engine.tracking.rigid_motion import flow

FloatArray = NDArray[np.float64]
Gray = NDArray[np.uint8]

_SIDE = 220  # pixels, most of the longer side of what is compared
_MOST, _LEAST = 120, 8  # points
_FACING = 0.25  # least cosine between the surface and the line of sight
_LEVELS = 2  # of the pyramid that flow is sought in
_RETURNS, _REACH = 0.7, 12.0  # drawn pixels: flow there and back, and farthest that it leads
_STILL_MM, _ABOVE_MM, _FRONT_MM = 1.0, 12.0, 20.0  # of skin that moves with the skull
_SLIDE_MM, _GRAZING = 8.0, -0.15
_PIXEL, _ALIKE = 0.7, 4.0
"""Standard deviation of a match, drawn pixels; matches that err together: so many count as one."""
_TINY = np.zeros((4, 4, 3), np.uint8)


@dataclass(frozen=True, eq=False)
class HeadBody:
    """All of a head: how it may differ, and how it moves.

    Parameters
    ----------
    speaker : Speaker
    mean : (V, 3) float64, mm
    identity : (K, V, 3) float64, mm per standard deviation
    posture : (M, V, 3) float64, mm per standard deviation
    pivot : (3,) float64, mm
    skull : (F,) bool
        Facets whose skin moves with the skull.
    """

    speaker: Speaker
    mean: FloatArray
    identity: FloatArray
    posture: FloatArray
    pivot: FloatArray
    skull: NDArray[np.bool_]

    @classmethod
    def of(
        cls,
        speaker: Speaker,
        mean: NDArray[np.floating],
        identity: NDArray[np.floating],
        mouth: NDArray[np.floating],
        upper: NDArray[np.floating],
    ) -> HeadBody:
        """A head (V, 3) with modes of who it is, of the mouth and of the upper face."""
        whole, lips = mean.astype(np.float64), speaker.vertices[speaker.lip_ring]
        moved = np.sqrt((mouth.astype(np.float64) ** 2).sum(axis=(0, 2)))[speaker.faces].mean(1)
        middle = speaker.vertices[speaker.faces].astype(np.float64).mean(axis=1)
        names = speaker.class_names
        skin = speaker.facet_class == (names.index("skin") if "skin" in names else -1)
        above = middle[:, 1] > lips[:, 1].mean() + _ABOVE_MM
        skull = skin & (moved < _STILL_MM) & above & (middle[:, 2] > _FRONT_MM)
        posture = np.concatenate([mouth, upper]).astype(np.float64)
        pivot = lips.astype(np.float64).mean(axis=0)
        return cls(speaker, whole, identity.astype(np.float64), posture, pivot, skull)

    @cached_property
    def scene(self) -> Scene:
        """The head as it is drawn, without modes."""
        none, one = np.zeros((0, *self.mean.shape), np.float32), self.speaker
        classes = one.facet_class.astype(np.int32)
        return Scene(self.mean.astype(np.float32), none, one.faces, one.uv, classes, _TINY)

    @cached_property
    def skin(self) -> NDArray[np.integer]:
        """Vertices of the skin that moves with the skull."""
        return np.unique(self.speaker.faces[self.skull])

    def vertices(self, identity: FloatArray, posture: FloatArray) -> FloatArray:
        """A person (K,) in a posture (M,): (V, 3), mm."""
        moved = np.tensordot(identity, self.identity, 1) + np.tensordot(posture, self.posture, 1)
        return np.asarray(self.mean + moved)


@dataclass(frozen=True, eq=False)
class HeadView:
    """A frame whose head is placed.

    Parameters
    ----------
    gray : (H, W) uint8
    pose : Pose
    vertices : (V, 3) float64, mm
    normals : (V, 3) float64
    camera : Camera or None
        That of the frame, where it is not the clip's.
    """

    gray: Gray
    pose: Pose
    vertices: FloatArray
    normals: FloatArray
    camera: Camera | None = None

    @classmethod
    def of(cls, gray: Gray, pose: Pose, vertices: FloatArray, faces: NDArray[np.int32]) -> HeadView:
        """The view of a head (V, 3) in a posture."""
        return cls(gray, pose, vertices, vertex_normals(vertices, faces))


@dataclass(frozen=True, eq=False)
class Matches:
    """Points of the skin that two frames show.

    Parameters
    ----------
    corners : (N, 3) int
        Vertices of the facet that each lies on.
    weights : (N, 3) float64
        Barycentric.
    first, second : (N, 2) float64, px
        Where the frames show them.
    sigma : float, px
        How far a match is off.
    """

    corners: NDArray[np.integer]
    weights: FloatArray
    first: FloatArray
    second: FloatArray
    sigma: float

    def of(self, values: FloatArray) -> FloatArray:
        """Values (..., V, 3) at the points, (..., N, 3)."""
        return np.asarray(np.einsum("nk,...nkd->...nd", self.weights, values[..., self.corners, :]))


def gray_of(image: NDArray[np.uint8]) -> Gray:
    """A picture (H, W, 3) as it is compared."""
    return np.asarray(cv2.cvtColor(image, cv2.COLOR_RGB2GRAY), np.uint8)


def match(
    body: HeadBody, first: HeadView, second: HeadView, camera: Camera, renderer: Renderer
) -> Matches | None:
    """Points of the skin in both frames; None where there are too few."""
    if not body.skull.any():
        return None
    window = _window(body, second, camera)
    one, scene = body.speaker, body.scene.at(second.vertices.astype(np.float32))
    drawn = renderer.draw(scene, Candidates.one(np.zeros(0), second.pose), camera, window)[0]
    facet, weights = np.maximum(drawn.facet_id - 1, 0), drawn.barycentrics.astype(np.float64)
    corners = one.faces[facet]
    # Facets are so small that what is straight in space is straight in the picture, too
    at = first.pose.apply(first.vertices)
    sight = at / np.linalg.norm(at, axis=1, keepdims=True)
    facing = -(first.normals @ first.pose.rotation.T * sight).sum(axis=1)
    own = first.camera or camera
    known = np.column_stack([own.project(at), facing])
    carried_to = at_pixels(drawn.facet_id, weights, one.faces, known)
    there, shown = carried_to[..., :2], drawn.covered & (carried_to[..., 2] > _FACING)
    height, width = facet.shape
    grid = np.stack(np.meshgrid(np.arange(width), np.arange(height)), axis=-1).astype(np.float64)
    seen = _sampled(second.gray, window.to_image(grid), window.scale)
    finer = _pixels_a_mm(second.pose, camera) / _pixels_a_mm(first.pose, own)
    coarse = window.scale * (1.0 if first.camera is None else finer)
    carried = np.where(shown, _sampled(first.gray, there, coarse), seen).astype(np.uint8)
    pixels, found = _matched(carried, seen, shown & body.skull[facet])
    if len(pixels) < _LEAST:
        return None
    column, row = pixels.T
    return Matches(
        corners[row, column], weights[row, column], there[row, column], window.to_image(found),
        _PIXEL / window.scale,
    )  # fmt: skip


def _pixels_a_mm(pose: Pose, camera: Camera) -> float:
    """Size at which a camera shows a head."""
    return float(camera.matrix[0, 0] / pose.translation[2])


def _window(body: HeadBody, view: HeadView, camera: Camera) -> Window:
    """About the skin that moves with the skull."""
    pixels = camera.project(view.pose.apply(view.vertices[body.skin]))
    low, high = pixels.min(axis=0) - 4, pixels.max(axis=0) + 4
    size = np.clip(high - low, 8.0, 4.0 * max(camera.size))
    scale = min(1.0, _SIDE / float(size.max()))
    return Window(float(low[0]), float(low[1]), float(size[0]), float(size[1]), scale)


def _sampled(gray: Gray, pixels: FloatArray, scale: float) -> Gray:
    """The picture at pixels (H, W, 2), blurred as coarsely as it is drawn."""
    soft = cv2.GaussianBlur(gray, (0, 0), 0.4 / scale) if scale < 1 else gray
    x, y = np.moveaxis(pixels.astype(np.float32), -1, 0)
    edge = cv2.BORDER_REPLICATE
    return np.asarray(cv2.remap(soft, x, y, cv2.INTER_LINEAR, borderMode=edge), np.uint8)


def _matched(
    before: Gray, after: Gray, where: NDArray[np.bool_]
) -> tuple[NDArray[np.int_], FloatArray]:
    """Whole pixels (N, 2) of corners in one picture, and where they are in another (N, 2)."""
    mask = cv2.erode(where.astype(np.uint8), np.ones((5, 5), np.uint8))
    apart = max(3.0, min(before.shape) / 40)
    # None where there is no corner, which OpenCV's types do not say
    found = cast(
        "NDArray[np.float32] | None",
        cv2.goodFeaturesToTrack(before, _MOST, 0.005, apart, mask=mask),
    )
    if found is None:
        return np.zeros((0, 2), np.int_), np.zeros((0, 2))
    start = found.reshape(-1, 2)
    there, ok = flow(before, after, start, start, _LEVELS)
    back, ok_back = flow(after, before, there, there, _LEVELS)
    good = ok & ok_back & (np.linalg.norm(back - start, axis=1) < _RETURNS)
    good &= np.linalg.norm(there - start, axis=1) < _REACH
    whole = np.rint(start[good]).astype(np.int_)
    return whole, np.asarray(there[good] - start[good] + whole, np.float64)


@dataclass(frozen=True, eq=False)
class MatchEquations:
    """Matches, linearised.

    Parameters
    ----------
    residual : (N, 2) float64, px
        Where the second frame shows the points, less where the head puts them.
    first : (6, N, 2) float64
        By how much the head puts them elsewhere for a step of the first frame's pose; empty where
        the identity is not asked for.
    second : (6 + M, N, 2) float64
        The same of the second frame's pose and posture.
    identity : (K, N, 2) float64
    weight : (N,) float64
        Inverse variances, robust.
    """

    residual: FloatArray
    first: FloatArray
    second: FloatArray
    identity: FloatArray
    weight: FloatArray


def linearised(
    body: HeadBody, found: Matches, first: HeadView, second: HeadView, camera: Camera,
    who: bool = True,
) -> MatchEquations:  # fmt: skip
    """The matches' equations; of the first frame and the identity only if `who` is asked for.

    A point stays on its ray in the first frame: where shape or pose change, it slides along the
    surface.
    """
    here, normal = found.of(first.vertices), found.of(first.normals)
    eye = -first.pose.rotation.T @ first.pose.translation
    ray = _rays(found.first, first.camera or camera) @ first.pose.rotation
    steep = np.minimum((ray * normal).sum(axis=1, keepdims=True), _GRAZING)
    slide = eye + ray * ((here - eye) * normal).sum(axis=1, keepdims=True) / steep - here
    far = np.maximum(np.linalg.norm(slide, axis=1, keepdims=True), 1e-9)
    slide *= np.minimum(1.0, _SLIDE_MM / far)

    def sunk(moves: FloatArray) -> FloatArray:
        """Distance along the ray (..., N, 3) by which a move of the surface takes its points."""
        return np.asarray(ray * (moves * normal).sum(axis=-1, keepdims=True) / steep)

    point = found.of(second.vertices) + slide
    posture = found.of(body.posture)
    moves = [_moves(second.pose, point, body.pivot), posture @ second.pose.rotation.T]
    if who:
        back = _moves(first.pose, here + slide, body.pivot) @ first.pose.rotation
        parts = [sunk(back) - back, sunk(found.of(body.identity))]
        moves = [*(part @ second.pose.rotation.T for part in parts), *moves]
    there = second.pose.apply(point)
    slope = np.concatenate(moves)
    focal, depth = np.diag(camera.matrix)[:2], there[:, 2:]
    across = focal * (slope[..., :2] - there[:, :2] / depth * slope[..., 2:]) / depth
    residual = found.second - camera.project(there)
    away = (residual**2).sum(axis=1) / (2 * found.sigma) ** 2
    weight = 1 / (_ALIKE * found.sigma**2 * (1 + away))
    n = len(across) - 6 - len(posture)
    return MatchEquations(residual, across[:n][:6], across[n:], across[6:n], weight)


def _rays(pixels: FloatArray, camera: Camera) -> FloatArray:
    """Unit vectors (N, 3) to pixels (N, 2), camera frame."""
    flat = cv2.undistortPoints(pixels[:, None], camera.matrix, camera.distortion)[:, 0]
    rays = np.column_stack([flat, np.ones(len(flat))])
    return np.asarray(rays / np.linalg.norm(rays, axis=1, keepdims=True))


def _moves(pose: Pose, points: FloatArray, pivot: FloatArray) -> FloatArray:
    """Motion of points (N, 3) of the head, camera frame, for a step of the pose, (6, N, 3)."""
    return pose_moves(pose.apply(points) - pose.apply(pivot))
