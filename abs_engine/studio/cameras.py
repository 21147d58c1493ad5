"""Cameras of a scene: their lenses, where they stand, and where they must not."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import ConvexHull

from abs_engine.core.arrays import FloatArray
from abs_engine.core.camera import Camera
from abs_engine.core.errors import ParameterError
from abs_engine.core.geometry import Pose, compose
from abs_engine.dataset.codec import DEPTH_STEP, OTHER
from abs_engine.io.assets import Speaker
from abs_engine.studio.mirror import Mirror
from abs_engine.studio.plan import ClipPlan, View
from abs_engine.studio.scenefile import CameraEntry, MirrorEntry, check_size
from abs_engine.studio.sequence import portrait

FARTHEST = 65_535 * DEPTH_STEP
"""No depth label says more, mm."""

_REACH = 250.0
"""No point of a head is farther from its origin, mm."""

_OFF = 0.5
"""The ray of a corner of a picture leads back to it within this, px."""

_AIR = 15.0
"""A camera keeps this far away from the head and the shirt, mm."""


def lens(entry: CameraEntry, size: tuple[int, int]) -> Camera:
    """Intrinsics and distortion of a camera; `size` where it has none of its own.

    Raises
    ------
    ParameterError
        If the size cannot be filmed, the focal length is given twice, or a value makes no sense.
    """
    size = entry.size or size
    check_size(size)
    given = [entry.focal, entry.focal_mm, entry.field_of_view_degrees]
    if sum(value is not None for value in given) > 1:
        raise ParameterError(
            f"camera '{entry.name}' has its focal length twice",
            "give one of focal, focal_mm, field_of_view_degrees",
        )
    focal = entry.focal
    if entry.focal_mm is not None:
        focal = entry.focal_mm * size[0] / entry.sensor_width_mm if entry.sensor_width_mm else 0.0
    if entry.field_of_view_degrees is not None:
        if not 1 <= entry.field_of_view_degrees <= 150:
            raise ParameterError(
                f"camera '{entry.name}' sees {entry.field_of_view_degrees:g} degrees",
                "give 1 to 150",
            )
        focal = size[0] / 2 / np.tan(np.radians(entry.field_of_view_degrees) / 2)
    if focal is not None and focal <= 0:
        raise ParameterError(
            f"the focal length of camera '{entry.name}' is {focal:g} px", "give lengths above 0"
        )
    matrix = Camera.ideal(size, focal).matrix.copy()
    if entry.centre is not None:
        matrix[:2, 2] = entry.centre
    if len(entry.distortion) > 8:
        raise ParameterError(
            f"camera '{entry.name}' has {len(entry.distortion)} distortion coefficients",
            "give k1, k2, p1, p2, k3, k4, k5, k6 or fewer",
        )
    camera = Camera(matrix, size, np.array(entry.distortion, np.float64))
    _check_lens(entry.name, camera)
    return camera


def _check_lens(name: str, camera: Camera) -> None:
    """Raise `ParameterError` where the picture is folded, or a corner of it has no ray."""
    if not camera.distorted:
        return
    right, bottom = np.array(camera.size) - 0.5  # pixel centres are whole numbers
    corners = np.array([[-0.5, -0.5], [right, -0.5], [-0.5, bottom], [right, bottom]])
    rays = np.column_stack([camera.undistort(corners), np.ones(4)])
    off = np.abs(camera.project(rays) - corners).max()
    inside = (rays[:, :2] ** 2).sum(axis=1).max() <= camera.radius_limit
    along = np.linspace(0, 1, 200)[:, None, None] * rays
    along[..., 2] = 1.0
    radii = np.linalg.norm(camera.distort(along)[..., :2], axis=-1)
    if not (off < _OFF and inside and np.all(np.diff(radii, axis=0) > 0)):
        raise ParameterError(
            f"the distortion of camera '{name}' folds the picture over itself, or leaves its "
            "corners without rays",
            "give smaller coefficients or a narrower field of view",
        )


def stand(
    entry: CameraEntry, camera: Camera, speaker: Speaker, neutral: NDArray[np.float32]
) -> Pose:
    """Pose of a camera: world (or, if it is worn, head) frame to camera frame.

    Raises
    ------
    ParameterError
        If it looks at the place where it stands.
    """
    if entry.position is None:
        pose = portrait(camera, speaker, neutral)
        if entry.target is None and not entry.roll_degrees:
            return pose
        place = pose.inverse.translation
    else:
        place = np.array(entry.position)
    mouth = neutral[speaker.lip_ring].mean(axis=0)
    target = np.array(mouth if entry.target is None else entry.target, np.float64)
    forward = target - place
    if np.linalg.norm(forward) < 1e-6:
        raise ParameterError(
            f"camera '{entry.name}' looks at the place where it stands", "move its target"
        )
    forward = forward / np.linalg.norm(forward)
    up = np.array([0.0, 1, 0]) if abs(forward[1]) < 0.999 else np.array([0.0, 0, 1])
    right = np.cross(forward, up)
    right /= np.linalg.norm(right)
    upright = np.stack([right, np.cross(forward, right), forward])
    roll = Pose.from_vectors([0, 0, np.radians(entry.roll_degrees)], np.zeros(3)).rotation
    rotation = roll @ upright
    return Pose(rotation, -rotation @ place)


def glass(entry: MirrorEntry, name: str) -> FloatArray:
    """Corners (4, 3), mm, camera frame, of the mirror of camera `name`.

    Raises
    ------
    ParameterError
        If they make no mirror.
    """
    if (entry.corners is None) == (entry.centre is None):
        raise ParameterError(
            f"the mirror of camera '{name}' has both corners and a centre, or neither",
            "give corners or centre",
        )
    try:
        if entry.corners is not None:
            return Mirror(np.array(entry.corners)).corners
        return Mirror.standing(
            entry.centre or (0, 0, 0), np.radians(entry.yaw_degrees), entry.size
        ).corners
    except ParameterError as error:
        raise ParameterError(f"camera '{name}': {error.problem}", error.remedy) from error


def check_view(plan: ClipPlan, view: View) -> None:
    """Raise `ParameterError` if a camera cannot film a clip.

    It is inside the head or the shirt at some time, too far for the depth labels, or the head
    reaches behind its mirror.
    """
    poses = [plan.pose(view, frame) for frame in range(len(plan))]
    _check_free(plan, view, plan.neutral, poses, "head")
    for prop in plan.props:
        if prop.code == OTHER:
            own = map(Pose.from_vectors, prop.rotations, prop.translations)
            placed = [compose(view.pose(frame), pose) for frame, pose in enumerate(own)]
            _check_free(plan, view, prop.vertices, placed, "shirt")
    farthest = max(float(pose.translation[2]) for pose in poses) + _REACH
    mirrored = 0.0
    if view.mirror is not None:
        mirror = Mirror(view.mirror)
        outermost = plan.neutral[ConvexHull(plan.neutral).vertices].astype(np.float64)
        for pose in poses:
            points = pose.apply(outermost)
            if (height := float(mirror.height(points).min())) <= 0:
                raise ParameterError(
                    f"the head, for camera '{view.name}', reaches {-height:.0f} mm behind the "
                    "mirror's plane",
                    "move the mirror or the head",
                )
            mirrored = max(mirrored, float(mirror.reflect(points)[:, 2].max()))
    if max(farthest, mirrored) > FARTHEST:
        raise ParameterError(
            f"the head is {max(farthest, mirrored) - _REACH:.0f} mm from camera '{view.name}', "
            "farther than depth labels go",
            f"place it within {FARTHEST - _REACH:.0f} mm",
        )


def _check_free(
    plan: ClipPlan, view: View, vertices: NDArray[np.float32], placed: list[Pose], name: str
) -> None:
    """Raise `ParameterError` if a camera is within the hull of a thing, or nearly, at some time."""
    hull = ConvexHull(vertices).equations
    centres = np.array([pose.inverse.translation for pose in placed])
    away = (centres @ hull[:, :3].T + hull[:, 3]).max(axis=1)
    if away.min() < _AIR:
        at = int(away.argmin()) / plan.rate
        raise ParameterError(
            f"camera '{view.name}' is inside the {name}, or touches it, at {at:.2f} s",
            f"place it at least {_AIR:.0f} mm away from the {name}",
        )
