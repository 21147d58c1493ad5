"""The head's own texture: what one frame shows of it must lie where other frames show it.

Points of the skin are carried from one frame to another by the fitted head, and what is left
between there and where optical flow finds them says how poses, upper face and shape must change.
No light is modelled: what changes slowly over the skin is subtracted, and corners of the texture
are compared.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import cv2
import numpy as np
from numpy.typing import NDArray

from abs_engine.core.arrays import BoolArray, FloatArray
from abs_engine.core.camera import Camera, Window
from abs_engine.core.geometry import Pose, vertex_normals
from abs_engine.core.scene import Candidates, Renderer, Scene
from abs_engine.core.settings import GENERAL
from abs_engine.io.assets import Speaker
from abs_engine.tracking.settings.head import HEAD_POSE
from abs_engine.tracking.settings.registration import REGISTRATION
from abs_engine.tracking.texture.interpolation import at_pixels
from abs_engine.tracking.texture.rigid_motion import corners_of, flow

Gray = NDArray[np.uint8]

_TINY = np.zeros((4, 4, 3), np.uint8)
_LEAST = 8.0  # px, of a window


@dataclass(frozen=True, eq=False)
class HeadBody:
    """All of a head: how it may differ, and how it moves.

    Parameters
    ----------
    mean : (V, 3) float64, mm
    identity : (K, V, 3) float64, mm per standard deviation
    posture : (M, V, 3) float64, mm per standard deviation
    pivot : (3,) float64, mm
    skull : (F,) bool
        Facets of skin that the mouth hardly moves, whose texture is compared.
    upper : int
        How many of the modes of `posture`, the last ones, move the upper face.
    """

    speaker: Speaker
    mean: FloatArray
    identity: FloatArray
    posture: FloatArray
    pivot: FloatArray
    skull: BoolArray
    upper: int

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
        above = middle[:, 1] > lips[:, 1].mean() + HEAD_POSE.above
        skull = skin & (moved < HEAD_POSE.still) & above & (middle[:, 2] > HEAD_POSE.front)
        posture = np.concatenate([mouth, upper]).astype(np.float64)
        pivot = lips.astype(np.float64).mean(axis=0)
        people = identity.astype(np.float64)
        return cls(speaker, whole, people, posture, pivot, skull, len(upper))

    @cached_property
    def scene(self) -> Scene:
        """The head as it is drawn, without modes."""
        none, one = np.zeros((0, *self.mean.shape), np.float32), self.speaker
        classes = one.facet_class.astype(np.int32)
        return Scene(self.mean.astype(np.float32), none, one.faces, one.uv, classes, _TINY)

    @cached_property
    def skin(self) -> NDArray[np.integer]:
        """Vertices of the skin whose texture is compared, see `skull`."""
        return np.unique(self.speaker.faces[self.skull])

    def without_scalp(self) -> HeadBody:
        """The head, no texture of which is compared above its forehead.

        Scalps are seen at a grazing angle.
        """
        one = self.speaker
        height = one.vertices[one.faces].astype(np.float64)[..., 1].mean(axis=1)
        lips = float(one.vertices[one.lip_ring].astype(np.float64)[:, 1].mean())
        return replace(self, skull=self.skull & (height < lips + HEAD_POSE.scalp))

    def vertices(self, identity: FloatArray, posture: FloatArray) -> FloatArray:
        """A person (K,) in a posture (M,): (V, 3), mm."""
        return np.asarray(self.of_person(identity, posture[None])[0])

    def of_person(self, identity: FloatArray, postures: FloatArray) -> FloatArray:
        """A person (K,) in postures (N, M): (N, V, 3), mm."""
        own = self.mean + np.tensordot(identity, self.identity, 1)
        return np.asarray(own + np.tensordot(postures, self.posture, 1))


@dataclass(frozen=True, eq=False)
class HeadView:
    """A frame whose head is placed.

    Parameters
    ----------
    gray : (H, W) uint8
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

    def shown(self, camera: Camera) -> FloatArray:
        """Place of each vertex, px, and the cosine of surface and line of sight, (V, 3).

        Computed once for the camera of a clip.
        """
        if camera not in self._shown:
            at = self.pose.apply(self.vertices)
            sight = at / np.linalg.norm(at, axis=1, keepdims=True)
            facing = -(self.normals @ self.pose.rotation.T * sight).sum(axis=1)
            self._shown[camera] = np.column_stack([camera.project(at), facing])
        return self._shown[camera]

    @cached_property
    def _shown(self) -> dict[Camera, FloatArray]:
        return {}


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
    identity : (K, N, 3) float64, mm per standard deviation
        How they differ from person to person.
    posture : (M, N, 3) float64, mm per standard deviation
        How they move.
    """

    corners: NDArray[np.integer]
    weights: FloatArray
    first: FloatArray
    second: FloatArray
    sigma: float
    identity: FloatArray
    posture: FloatArray

    def of(self, values: FloatArray) -> FloatArray:
        """Values (..., V, 3) at the points, (..., N, 3)."""
        return between(self.corners, self.weights, values)


def between(corners: NDArray[np.integer], weights: FloatArray, values: FloatArray) -> FloatArray:
    """Values (..., V, 3) between the corners (N, 3) of facets, (..., N, 3)."""
    return np.asarray(np.einsum("nk,...nkd->...nd", weights, values[..., corners, :]))


def gray_of(image: NDArray[np.uint8]) -> Gray:
    """A picture (H, W, 3) as it is compared."""
    return np.asarray(cv2.cvtColor(image, cv2.COLOR_RGB2GRAY), np.uint8)


def match(
    body: HeadBody, first: HeadView, second: HeadView, camera: Camera, renderer: Renderer
) -> Matches | None:
    """Points of the skin in both frames; None where there are too few."""
    if not body.skull.any():
        return None
    window = window_about(second.vertices[body.skin], second.pose, camera, HEAD_POSE.side)
    one, scene = body.speaker, body.scene.at(second.vertices.astype(np.float32))
    drawn = renderer.draw(scene, Candidates.one(np.zeros(0), second.pose), camera, window)[0]
    # Facets are so small that what is straight in space is straight in the picture, too
    own = first.camera or camera
    carried_to = at_pixels(drawn.facet_id, drawn.barycentrics, one.faces, first.shown(own))
    there, shown = carried_to[..., :2], drawn.covered & (carried_to[..., 2] > HEAD_POSE.facing)
    pixels = np.meshgrid(*(along.astype(np.float32) for along in window.places))
    seen = _sampled(second.gray, np.stack(pixels, axis=-1), window.scale)
    finer = pixels_a_mm(second.pose, camera) / pixels_a_mm(first.pose, own)
    coarse = window.scale * (1.0 if first.camera is None else finer)
    carried = np.where(shown, _sampled(first.gray, there, coarse), seen).astype(np.uint8)
    still = shown & body.skull[np.maximum(drawn.facet_id - 1, 0)]
    corners, found = _matched(_evenly_lit(carried), _evenly_lit(seen), still)
    if len(corners) < HEAD_POSE.least_points:
        return None
    column, row = corners.T
    facet, weights = drawn.facet_id[row, column] - 1, drawn.barycentrics[row, column]
    where = one.faces[facet], weights.astype(np.float64)
    return Matches(
        *where, there[row, column], window.to_image(found), HEAD_POSE.match_noise / window.scale,
        between(*where, body.identity), between(*where, body.posture),
    )  # fmt: skip


def pixels_a_mm(pose: Pose, camera: Camera) -> float:
    """Size at which a camera shows a head."""
    return float(camera.matrix[0, 0] / pose.translation[2])


def window_about(vertices: FloatArray, pose: Pose, camera: Camera, side: int) -> Window:
    """About vertices (N, 3), mm, head frame; its longer side is `side` drawn pixels at most."""
    pixels = camera.project(pose.apply(vertices))
    low, high = pixels.min(axis=0) - HEAD_POSE.margin, pixels.max(axis=0) + HEAD_POSE.margin
    size = np.clip(high - low, _LEAST, 4.0 * max(camera.size))
    scale = min(1.0, side / float(size.max()))
    return Window(float(low[0]), float(low[1]), float(size[0]), float(size[1]), scale)


def _sampled(gray: Gray, pixels: NDArray[np.floating], scale: float) -> Gray:
    """The picture at pixels (H, W, 2), blurred as coarsely as it is drawn."""
    soft = cv2.GaussianBlur(gray, (0, 0), GENERAL.shrunk_blur / scale) if scale < 1 else gray
    x, y = np.moveaxis(pixels.astype(np.float32), -1, 0)
    edge = cv2.BORDER_REPLICATE
    return np.asarray(cv2.remap(soft, x, y, cv2.INTER_LINEAR, borderMode=edge), np.uint8)


def _evenly_lit(gray: Gray) -> Gray:
    """The picture less its own blur, about a middle grey: shading does not move with the skin."""
    side = 2 * HEAD_POSE.shading + 1
    slow = cv2.stackBlur(gray, (side, side))
    return np.asarray(cv2.addWeighted(gray, 1.0, slow, -1.0, 128.0), np.uint8)


def _matched(before: Gray, after: Gray, where: BoolArray) -> tuple[NDArray[np.int_], FloatArray]:
    """Whole pixels (N, 2) of corners in one picture, and where they are in another (N, 2)."""
    mask = cv2.erode(where.astype(np.uint8), np.ones((5, 5), np.uint8))
    apart = max(HEAD_POSE.least_apart, min(before.shape) / REGISTRATION.corners_across)
    start = corners_of(before, HEAD_POSE.most_points, REGISTRATION.corner_quality, apart, mask)
    if not len(start):
        return np.zeros((0, 2), np.int_), np.zeros((0, 2))
    there, ok = flow(before, after, start, start, HEAD_POSE.levels)
    back, ok_back = flow(after, before, there, there, HEAD_POSE.levels)
    good = ok & ok_back & (np.linalg.norm(back - start, axis=1) < HEAD_POSE.returns)
    good &= np.linalg.norm(there - start, axis=1) < HEAD_POSE.flow_reach
    whole = np.rint(start[good]).astype(np.int_)
    return whole, np.asarray(there[good] - start[good] + whole, np.float64)


def picture_motion(points: FloatArray, camera: Camera) -> FloatArray:
    """Motion in the picture, px, of points (N, 3) for a mm along each axis, (N, 2, 3).

    All are in the camera's frame; its distortion is left out.
    """
    seen = np.zeros((len(points), 2, 3))
    seen[:, 0, 0], seen[:, 1, 1] = np.diag(camera.matrix)[:2, None] / points[:, 2]
    across = points[:, :2] / points[:, 2:]
    seen[:, 0, 2], seen[:, 1, 2] = -seen[:, 0, 0] * across[:, 0], -seen[:, 1, 1] * across[:, 1]
    return seen
