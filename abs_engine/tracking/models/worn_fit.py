"""A close-up's mouth found by the landmark network, and a person's head fitted to it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import cv2
import numpy as np

from abs_engine.compare.facets import FacetLikelihood
from abs_engine.core.arrays import FloatArray, Image
from abs_engine.core.camera import Camera
from abs_engine.core.geometry import FACING, Pose, rotations
from abs_engine.core.pose import PoseFrame, at_base, no_correction, parted
from abs_engine.core.scene import Renderer
from abs_engine.face.appearance.opening import MouthSpot
from abs_engine.face.head import MouthModel
from abs_engine.fit.head_frame import mouth_window
from abs_engine.fit.opening import NAME, Opening
from abs_engine.optimise.newton import Newton
from abs_engine.tracking.detection.initial_pose import with_mouth_at
from abs_engine.tracking.detection.landmarks import landmarks_at
from abs_engine.tracking.detection.mouth_search import shifted
from abs_engine.tracking.person.identity_fit import TOLD_DEVIATION, fit_posture, fit_shared
from abs_engine.tracking.settings.worn import CLOSE_UP

INNER = np.array([61, 291, 81, 178, 13, 14, 311, 402])
"""Landmarks of the corners and of the inner lips, in the order of `learn.opening.POINTS`."""


def mouth_points(image: Image, spot: MouthSpot | None = None) -> FloatArray:
    """Points (8, 2), px, of a mouth of whose face little more is in the picture (H, W, 3) RGB.

    NaN where the network sees none; see `_seen`.
    """
    return _seen(image, spot)[0]


def _seen(image: Image, spot: MouthSpot | None = None) -> tuple[FloatArray, float]:
    """The points (8, 2), px, and how probably a face was looked at, 0 to 1.

    The picture's border is repeated around it. Where it is not known where the mouth lies, it is
    looked for about the picture's middle, and each look begins where the one before ended.
    """
    height, width = image.shape[:2]
    margin = max(height, width)
    wide = cv2.copyMakeBorder(image, margin, margin, margin, margin, cv2.BORDER_REPLICATE)
    if spot is None:
        spot = MouthSpot((width - 1) / 2, (height - 1) / 2, CLOSE_UP.first_width * width)
    points, presence = np.full((len(INNER), 2), np.nan), 0.0
    for _ in range(CLOSE_UP.looks):
        size = CLOSE_UP.face * spot.width
        centre = np.array([spot.x, spot.y - CLOSE_UP.below * size]) + margin
        seen = landmarks_at(np.asarray(wide, np.uint8), centre, size)
        if seen is None:
            break
        points, presence = seen.pixels[INNER] - margin, seen.presence
        spot = MouthSpot.between(points[0], points[1])
    return points, presence


def upside_down(images: Sequence[Image]) -> bool:
    """Whether the network sees a face more surely where the pictures are turned by 180 degrees.

    It sees a mouth in either, but is surer of a face whose nose, if any, is above.
    """
    upright, turned = (
        float(np.median([_seen(image[::way, ::way])[1] for image in images])) for way in (1, -1)
    )
    return turned > max(upright, CLOSE_UP.turned)


def unsettled(images: Sequence[Image]) -> float:
    """Standard deviation of the logarithm of a mouth's width by where it is first looked for.

    The network sees a mouth in anything. Where there is one, each look ends at it, wherever it
    began; elsewhere they end here and there. That of the median frame; infinite where it sees none.
    """
    return float(np.median([_spread_of_widths(image) for image in images]))


def _spread_of_widths(image: Image) -> float:
    height, width = image.shape[:2]
    widths = []
    for right, down, factor in CLOSE_UP.starts:
        x, y = (0.5 + right) * (width - 1), (0.5 + down) * (height - 1)
        points = mouth_points(image, MouthSpot(x, y, factor * CLOSE_UP.first_width * width))
        widths.append(float(np.linalg.norm(points[1] - points[0])))
    sound = np.isfinite(widths).all() and min(widths) > 0
    return float(np.std(np.log(widths))) if sound else float("inf")


def find_mouth(images: Sequence[Image]) -> MouthSpot:
    """Place of the mouth in several frames of a clip."""
    points = np.stack([mouth_points(image) for image in images])
    return MouthSpot.between(*np.median(points[:, :2], axis=0))


@dataclass(frozen=True, eq=False)
class WornHead:
    """The head that a close-up shows a part of.

    Parameters
    ----------
    model : MouthModel
        As `fit.opening.sided` makes it.
    regions : tuple of (str or None)
        What its facet classes show.
    """

    model: MouthModel
    regions: tuple[str | None, ...]
    camera: Camera
    renderer: Renderer

    def fitted(self, images: Sequence[Image], opening: Opening) -> tuple[Pose, FloatArray, Opening]:
        """Fit pose, person and postures by turns to some frames of a clip.

        The pose is that of the head, which is still in the picture; with it come weights (Q,) of
        the person modes, and the mouth where it was found.
        """
        model = self.model
        pose = self._ahead(opening.spot)
        person = np.zeros(model.n_person)
        vectors = np.tile(at_base(model.prototypes[0]), (len(images), 1))
        for turn in range(CLOSE_UP.rounds):
            if turn == CLOSE_UP.rounds // 2:  # the mouth is now known to lie where it is drawn
                opening = replace(opening, spot=self.spot(pose, person, vectors))
            terms = self._terms(
                images, opening, pose, person, CLOSE_UP.wider if turn == 0 else (0.0, 0.0)
            )
            base = PoseFrame(pose, model.pivot)
            pairs = zip(terms, vectors, strict=True)
            vectors = np.stack([fit_posture(model, t, base, person, v).x for t, v in pairs])
            pose, person = self._shared(terms, pose, person, vectors)
        return pose, person, opening

    def _ahead(self, spot: MouthSpot) -> Pose:
        """The head facing the camera, its mouth at a spot."""
        model, camera = self.model, self.camera
        corners = model.scene.mean[model.rings["corners"]].astype(np.float64)
        depth = camera.matrix[0, 0] * float(np.ptp(corners[:, 0])) / spot.width
        turned = rotations(np.array([[0.0, 0.0, spot.roll]]))[0] @ FACING
        pose = Pose(turned, np.array([0.0, 0.0, depth]) - turned @ model.pivot)
        return with_mouth_at(pose, np.array([spot.x, spot.y]), camera, corners.mean(axis=0))

    def _terms(
        self,
        images: Sequence[Image],
        opening: Opening,
        pose: Pose,
        person: FloatArray,
        more: tuple[float, float],
    ) -> list[FacetLikelihood]:
        window = mouth_window(self.model, pose, self.camera, person, more)
        given = self.renderer, self.model.scene, self.camera, window
        return [
            opening.likelihood(*given, opening.maps(self.regions, window, i), self.regions)
            for i in images
        ]

    def _shared(
        self, terms: Sequence[FacetLikelihood], pose: Pose, person: FloatArray, vectors: FloatArray
    ) -> tuple[Pose, FloatArray]:
        """One pose and one person for all frames, their postures held."""
        model = self.model
        deviation = TOLD_DEVIATION * np.r_[np.ones(5), pose.translation[2]]
        poses, each = [pose] * len(terms), [{NAME: t} for t in terms]
        begun, solver = (no_correction(), person), Newton(limit=CLOSE_UP.joint_limit)
        shift, person = fit_shared(model, poses, each, vectors, deviation, begun, solver)
        return shifted(pose, shift, model.pivot), person

    def spot(self, pose: Pose, person: FloatArray, vectors: FloatArray) -> MouthSpot:
        """Place of the mouth as drawn, the median of some fits (K, 6 + P)."""
        model, seen = self.model, []
        scene, base = model.held(person), PoseFrame(pose, model.pivot)
        for vector in vectors:
            moved, posture = parted(vector)
            corners = scene.vertices(posture)[model.rings["corners"]]
            seen.append(self.camera.project(base.pose(moved).apply(corners)))
        pair = np.median(seen, axis=0)
        return MouthSpot.between(*pair[np.argsort(pair[:, 0])])
