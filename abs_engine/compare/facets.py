"""The facet likelihood (Basu et al., eqs. 6-9): how well the drawn classes suit the colours."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from abs_engine.compare.borders import Borders, Groups
from abs_engine.compare.forces import Rule, check_rule, facet_scores
from abs_engine.compare.pull import Pull
from abs_engine.compare.settings import COMPARISON
from abs_engine.compare.sums import outlined, pixel_sums
from abs_engine.core.arrays import BoolArray, FloatArray
from abs_engine.core.buffers import Outlines
from abs_engine.core.camera import Camera, Window
from abs_engine.core.errors import ParameterError
from abs_engine.core.scene import Candidates, ClassMaps, Renderer, Scene

_BEHIND = np.float32(1e9)  # mm: the background's depth


@dataclass(frozen=True, eq=False)
class FacetLikelihood:
    """-log f(O|p) of a frame, from the fused render-and-compare.

    Parameters
    ----------
    renderer : Renderer
    scene : Scene
    camera : Camera
    window : Window
    maps : ClassMaps
        Probability map of each class id at the window's drawn resolution.
    pixels : int
        How many drawn pixels of the window are compared; the score is their mean.
    observations : float
        How many independent observations they hold.
    outside : (H, W) float32, optional
        Probability of each drawn pixel to show nothing of the model, 0 to 1, which counts where no
        facet is drawn. Without it nothing is gained by leaving a pixel free, and a model whose
        outline is seen against a background grows over it.
    rule : {"exact", "sample"}
        How the integral over a facet is found (section 5.4): the exact sum over its visible pixels
        (eq. 7), or the paper's one sample, the value at the centre of what is seen of it times its
        visible area (eq. 8). Only the exact sum is fused into the drawing; for one sample the
        ids of the facets come back.
    compared : (H, W) bool, optional
        Which drawn pixels are compared; by default all. Maps are to be 0 elsewhere, so that the
        exact sum needs it not; one sample must not stand for pixels that are not compared.
    pull : Pull or callable, optional
        What its forces come from, or what makes it once it is asked for; without it it has none.
    seam : tuple
        Classes of the upper and the lower lip, and of what shows where they part: ((1, 2), 3);
        empty where nothing parts.

    Raises
    ------
    ParameterError
        If there is no such rule.

    Notes
    -----
    Eq. 9 is a sum over pixels, where independent pixels would make a product; taken literally its
    logarithm hardly changes with the shape and any prior outweighs it. The mean score over the
    compared pixels is therefore raised to the number of independent observations in it: with a few
    wrongly labelled pixels, -n log(score) is about the number of those that are independent.
    Facets that are hidden or outside of the window add nothing.
    """

    renderer: Renderer
    scene: Scene
    camera: Camera
    window: Window
    maps: ClassMaps
    pixels: int
    observations: float
    outside: NDArray[np.float32] | None = None
    rule: Rule = "exact"
    compared: BoolArray | None = None
    pull: Pull | Callable[[], Pull] | None = None
    seam: tuple[tuple[int, int], int] | tuple[()] = ()

    def __post_init__(self) -> None:
        check_rule(self.rule)

    def negative_log(self, candidates: Candidates) -> FloatArray:
        """-log f(O|p) of each candidate, (B,) float64, up to a constant."""
        if self.observations == 0:
            return np.zeros(len(candidates.weights))
        terms, free = self._terms
        given = self.renderer, self.scene, candidates, self.camera, self.window
        if self.rule == "exact":
            sums = pixel_sums(*given, terms)
            total, pixels = sums.total, sums.pixels.astype(np.float64)
        else:
            total, pixels = self._sampled(outlined(*given), terms)
        total = total if free is None else total - pixels + free
        mean = np.maximum(total / self.pixels, 1e-6)
        return np.asarray(-self.observations * np.log(mean))

    def borders(
        self,
        candidate: Candidates,
        reach: int,
        local: bool,
        floor: float = COMPARISON.least_curvature,
    ) -> tuple[float, Borders]:
        """-log f(O|p) of one candidate, and its borders with what it gains as they move, in nats.

        Up to `reach` drawn pixels to either side of a border are looked at. If `local`, only the
        slope where it is counts, not where it would gain most; `floor` is a border's least
        curvature, of probability per pixel. Raises `ParameterError` if one sample stands for a
        facet: then borders are not what counts.
        """
        if self.rule != "exact":
            raise ParameterError("one sample for a facet has no borders", "choose the exact sum")
        given = self.renderer, self.scene, candidate, self.camera, self.window
        drawn, free = outlined(*given)[0], self._terms[1]
        total = self.groups.total(drawn.class_id)
        if free is not None:
            total += free - drawn.class_id.size
            behind = np.where(drawn.facet_id > 0, drawn.depth, _BEHIND)
            drawn = replace(drawn, depth=behind)  # an outline is that of what is drawn
        found = Borders.of(drawn, self.groups, reach, local, floor)
        mean = max(total / self.pixels, 1e-6)
        return float(-self.observations * np.log(mean)), found.times(
            self.observations / (mean * self.pixels)
        )

    @cached_property
    def groups(self) -> Groups:
        """Facet classes by what they show."""
        return Groups.by(self._terms[0].maps, *self.seam, background=self.outside is not None)

    def forces(self, candidate: Candidates) -> FloatArray:
        """Forces (V, 3) on one candidate's vertices, camera frame: log f(O|p) per mm.

        Raises `ParameterError` if there is nothing that pulls.
        """
        if self._pulling is None:
            raise ParameterError("nothing pulls on the facets", "make the likelihood with a pull")
        given = self.renderer, self.scene, candidate, self.camera, self.window
        return self._gain(candidate) * self._pulling.forces(*given)

    @cached_property
    def _pulling(self) -> Pull | None:
        return self.pull() if callable(self.pull) else self.pull

    def _gain(self, candidate: Candidates) -> float:
        """Derivative of log f(O|p) by the summed score."""
        data, n = float(self.negative_log(candidate)[0]), self.observations
        if n == 0:
            return 0.0
        return float(n / (np.exp(-data / n) * self.pixels))

    def _sampled(self, drawn: list[Outlines], terms: ClassMaps) -> tuple[FloatArray, FloatArray]:
        """The sum of eq. 9 with one sample for each facet, and the drawn pixels, (B,) each."""
        classes, shown = self.scene.facet_class, drawn
        if self.compared is not None:
            shown = [replace(b, facet_id=np.where(self.compared, b.facet_id, 0)) for b in drawn]
        sums = [facet_scores(b, terms.maps, classes, "sample").sum() for b in shown]  # Eq. 8
        pixels = [np.count_nonzero(b.facet_id) for b in shown]
        return np.array(sums, np.float64), np.array(pixels, np.float64)

    @cached_property
    def _terms(self) -> tuple[ClassMaps, float | None]:
        """Maps that are summed, and what all pixels give when none is drawn.

        A drawn pixel gains its class's map and loses `outside`; 1 is added, for maps may not be
        negative, and taken off again by the number of drawn pixels. One that is not drawn has 1.
        """
        if self.outside is None:
            return self.maps, None
        gained = 1 + self.maps.maps - self.outside
        gained[0] = 1
        return ClassMaps(gained), float(self.outside.sum(dtype=np.float64))
