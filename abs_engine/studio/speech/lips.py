"""Lips and front teeth of a person as linear functions of the face units, and their distances."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.arrays import FloatArray, IntArray
from abs_engine.core.geometry import edges_of
from abs_engine.core.nearest import barycentric, nearest_on_facets
from abs_engine.io.assets import Speaker

INCISORS = 5.0
"""Half the width (mm) of the upper front teeth's edge that the lower lip is measured against."""


@dataclass(frozen=True, eq=False)
class Lips:
    """The points of a person's lips, and how the face units move them.

    Parameters
    ----------
    neutral : (L, 3) float64, mm, head frame
    units : (52, L, 3) float64, mm at weight 1
    upper, lower : (E, 2) int64
        Edges of the upper and the lower lip, indices into `neutral`.
    corners : (2,) int64
        Corners of the mouth.
    lower_faces : (F, 3) int64
        Facets of the lower lip.
    incisors : (D, 3) float64, mm, head frame
        Points along the lower edge of the upper front teeth, which no unit moves.
    """

    neutral: FloatArray
    units: FloatArray
    upper: IntArray
    lower: IntArray
    corners: IntArray
    lower_faces: IntArray
    incisors: FloatArray

    @classmethod
    def of(cls, speaker: Speaker, neutral: NDArray[np.floating]) -> Lips:
        """Lips of a person with `neutral` vertices (V, 3), mm."""
        kinds = "upper_lip", "lower_lip", "upper_teeth"
        faces = {n: speaker.faces[speaker.facets_of(n)] for n in kinds}
        corners = speaker.landmarks["mouth_corners"]
        used = np.union1d(speaker.vertices_of("upper_lip", "lower_lip"), corners)
        place = np.full(len(neutral), -1)
        place[used] = np.arange(len(used))
        return cls(
            neutral[used].astype(np.float64),
            speaker.units[:, used].astype(np.float64),
            place[edges_of(faces["upper_lip"])[0]],
            place[edges_of(faces["lower_lip"])[0]],
            place[corners],
            place[faces["lower_lip"]],
            _incisors(neutral.astype(np.float64), edges_of(faces["upper_teeth"])[0]),
        )

    def points(self, weights: FloatArray) -> FloatArray:
        """Points (L, 3), mm, at face-unit weights (52,)."""
        used = np.flatnonzero(weights)
        return self.neutral + np.tensordot(weights[used], self.units[used], 1)

    def gaps(self, weights: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Gap between the lips in columns across the mouth, and how the units change it.

        The widest is `abs_engine.studio.people.lip_contact.widest_gap`.

        Returns
        -------
        gaps : (C,) float64, mm
            Negative where the lips overlap.
        slopes : (C, 52) float64, mm per weight
            With the columns and the edges that they cross held fast.
        """
        points = self.points(weights)
        right, left = np.sort(points[self.corners, 0])
        columns = (right + left) / 2 + np.arange(-0.4 * (left - right), 0.4 * (left - right), 1.0)
        bottom, bottom_slopes = self._extreme(points, self.upper, columns, -1.0)
        top, top_slopes = self._extreme(points, self.lower, columns, 1.0)
        return bottom - top, bottom_slopes - top_slopes

    def _extreme(
        self, points: FloatArray, edges: IntArray, columns: FloatArray, sign: float
    ) -> tuple[FloatArray, FloatArray]:
        """Highest (sign 1) or lowest (sign -1) y of edges in each column, and its slopes."""
        x, y = points[edges, 0], points[edges, 1]
        run = x[:, 1] - x[:, 0]
        rise = (y[:, 1] - y[:, 0]) / np.where(np.abs(run) < 1e-6, 1e-6, run)
        height = sign * ((y[:, 0] - rise * x[:, 0]) + rise * columns[:, None])
        crossed = (x.min(axis=1) <= columns[:, None]) & (columns[:, None] <= x.max(axis=1))
        best = np.where(crossed, height, -np.inf).argmax(axis=1)
        first, last = edges[best, 0], edges[best, 1]
        run = np.where(np.abs(run[best]) < 1e-6, 1e-6, run[best])
        part = (columns - points[first, 0]) / run
        slopes = (1 - part) * self.units[:, first, 1] + part * self.units[:, last, 1]
        return sign * height[np.arange(len(columns)), best], slopes.T

    def tooth_gaps(self, weights: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Distance of the lower lip from the upper front teeth, and how the units change it.

        Returns
        -------
        gaps : (D,) float64, mm
            From each point of `incisors` to the nearest of the lower lip's red.
        slopes : (D, 52) float64, mm per weight
            Along the direction of that distance, with the nearest point held fast to its facet.
        """
        corner = self.points(weights)[self.lower_faces]
        best, nearest = nearest_on_facets(corner, self.incisors)
        away = self.incisors - nearest
        distance = np.linalg.norm(away, axis=1)
        unit = away / np.maximum(distance, 1e-9)[:, None]
        share = barycentric(corner[best], nearest)
        moved = np.einsum("df,udfx->udx", share, self.units[:, self.lower_faces[best]])
        return distance, -np.einsum("udx,dx->du", moved, unit)


def _incisors(vertices: FloatArray, edges: IntArray) -> FloatArray:
    """Lowest point of the upper teeth in columns 1 mm apart, (D, 3)."""
    start, end = vertices[edges[:, 0]], vertices[edges[:, 1]]
    found = []
    for x in np.arange(-INCISORS, INCISORS + 0.5, 1.0):
        run = end[:, 0] - start[:, 0]
        share = (x - start[:, 0]) / np.where(np.abs(run) < 1e-6, 1e-6, run)
        cut = (start + share[:, None] * (end - start))[(share >= 0) & (share <= 1)]
        found.append(cut[cut[:, 1].argmin()])
    return np.array(found)
