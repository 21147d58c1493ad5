"""A face: what can move, and what it looks like, held as one value for a whole clip."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.arrays import FloatArray
from abs_engine.core.blocks import Blocks
from abs_engine.core.errors import ParameterError
from abs_engine.core.params import ParamSpec
from abs_engine.core.pose import pose_and
from abs_engine.core.scene import Scene

IntArray = NDArray[np.integer]
INNER = 12  # the inner contour's first among the 20 points of the lips
RINGS = ("outer", "upper", "lower")


def lip_gap(points: FloatArray) -> FloatArray:
    """Height (...,) between the inner lips' middles of the 20 points of the lips (..., 20, 3).

    Less than 0 where lips overlap; linear, so that of modes it is the slope.
    """
    return np.asarray(points[..., INNER + 2, 1] - points[..., INNER + 6, 1], np.float64)


def lip_front(points: FloatArray) -> FloatArray:
    """Mean z (...,) of the outer lips' middles, points 51 and 57 of the usual 68; linear, too."""
    return np.asarray(0.5 * (points[..., 3, 2] + points[..., 9, 2]), np.float64)


_TOUCHING = 1e-6
"""Gap of lips that touch, mm: rounding leaves some."""


def lip_aperture(points: FloatArray) -> float:
    """Height, mm, between the inner lips' middles of the 20 points of the lips (20, 3), or 0."""
    gap = float(lip_gap(points))
    return gap if gap > _TOUCHING else 0.0


@dataclass(frozen=True, eq=False)
class Body:
    """Everything that moves with a face, as it is written and shown.

    Parameters
    ----------
    mean : (V, 3) float32, mm, head frame
        Posture 0: of most models the average of speech, with parted lips.
    modes : (P, V, 3) float32, mm per unit of a posture's parameters
    faces : (F, 3) int32
    facet_class : (F,) int32
    regions : tuple of (str or None)
        What colour class the facets of each class show.
    lips : (N,) int32
        The vertices at the lips' contours: outer, upper inner, lower inner.
    rest : (V, 3) float32, mm, head frame, optional
        The person without expression; see `face.neutral`.
    """

    mean: NDArray[np.float32]
    modes: NDArray[np.float32]
    faces: NDArray[np.int32]
    facet_class: NDArray[np.int32]
    regions: tuple[str | None, ...]
    lips: NDArray[np.int32]
    rest: NDArray[np.float32] | None = None


@dataclass(frozen=True, eq=False)
class Face:
    """Shape and appearance of a face: the parts that can move, and their look.

    Parameters
    ----------
    name : str
        Of its kind, as the registry of models has it.
    scene : Scene
        What is drawn in a fit; its weights are the posture.
    posture : ParamSpec
        Names, units, first steps and bounds of the posture's parameters.
    pivot : (3,) float64, mm, head frame
        Point near the mouth that poses turn about.
    rings : mapping of str to int arrays
        Indices into the scene's vertices: `outer`, `upper`, `lower` (inner contours), `points` (12
        outer and 8 inner), `corners`; `jaw`, points that move as the jaw does, where there are any.
    border : (R, 3) float64, mm, head frame
        The lips' outer contour at rest.
    starts : (K, P) float64
        Postures that a fit may start from.
    regions : tuple of (str or None)
        What colour class the facets of each class show; None is not compared.
    body : Body
    identity : (Q,) float64
        What was fitted of the person; none for a person's own face.
    appearance : mapping of str to Any
        What was learned, by the name of the evidence that needs it: "colour" colour classes,
        "texture" a texture model, "local" local appearance.
    own_terms : mapping of str to callable
        How evidence is bound to this face, where not in the usual way: see `fit.terms.TermKind`.
    """

    name: str
    scene: Scene
    posture: ParamSpec
    pivot: FloatArray
    rings: Mapping[str, IntArray]
    border: FloatArray
    starts: FloatArray
    regions: tuple[str | None, ...]
    body: Body
    identity: FloatArray = field(default_factory=lambda: np.zeros(0))
    appearance: Mapping[str, Any] = field(default_factory=dict)
    own_terms: Mapping[str, Callable[..., Any]] = field(default_factory=dict)

    @cached_property
    def blocks(self) -> Blocks:
        """The pose, then the posture."""
        return pose_and(self.posture)

    @property
    def ring_sizes(self) -> tuple[int, int, int]:
        """Number of points of the outer, upper inner and lower inner contour."""
        outer, upper, lower = (len(self.rings[name]) for name in RINGS)
        return outer, upper, lower

    def looking(self, **learned: Any) -> Face:
        """The same face with what was learned of its appearance."""
        return replace(self, appearance={**self.appearance, **learned})

    def learned(self, name: str) -> Any:
        """Learned appearance for a kind of evidence.

        Raises
        ------
        ParameterError
            If nothing was.
        """
        if name not in self.appearance:
            known = ", ".join(self.appearance) or "none"
            raise ParameterError(
                f"the model '{self.name}' has no {name} to compare",
                f"evidence that it has: {known}",
            )
        return self.appearance[name]

    def aperture(self, vertices: FloatArray) -> float:
        """Height, mm, between the inner lips' middles of the scene's vertices (V, 3), or 0."""
        return lip_aperture(vertices[self.rings["points"]])

    def protrusion(self, posture: FloatArray) -> float:
        """Distance of the middle of the outer lips in front of the head frame's origin, mm.

        Of a posture (P,).
        """
        return float(lip_front(self.scene.vertices(posture)[self.rings["points"]]))

    def measures(self, posture: FloatArray) -> tuple[FloatArray, float, float]:
        """Lip contours (N, 3) in mm, head frame; mouth width and aperture in mm, of a posture (P,).

        The aperture is the height between the middles of the upper and lower inner lip, 0 when they
        touch; the width is the distance between the corners.
        """
        vertices = self.scene.vertices(posture)
        lips = np.concatenate([vertices[self.rings[name]] for name in RINGS])
        corners = vertices[self.rings["corners"]]
        width = float(np.linalg.norm(corners[1] - corners[0]))
        return lips, width, self.aperture(vertices)
