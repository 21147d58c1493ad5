"""A frame as a problem: what is minimised over the named blocks of a face's parameters.

Value = sum of terms, each the negative logarithm of a likelihood, + priors. A solver asks for what
it needs: one value, many at once, a Gauss-Newton matrix, or a direction.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import cast

import numpy as np

from abs_engine.compare.prior import Prior
from abs_engine.compare.settings import COMPARISON
from abs_engine.core.arrays import FloatArray, IntArray
from abs_engine.core.blocks import POSE, POSTURE, Blocks
from abs_engine.core.errors import ParameterError
from abs_engine.core.geometry import Pose
from abs_engine.core.objective import Evaluation
from abs_engine.core.params import ParamSpec
from abs_engine.core.pose import PoseFrame
from abs_engine.core.scene import Candidates
from abs_engine.fit.evidence import Bordered, Squared, Term, finite, valued
from abs_engine.fit.forces import Forces
from abs_engine.fit.settings import HEAD_FIT
from abs_engine.fit.surface_jacobian import summed_along


@dataclass(frozen=True, eq=False)
class Problem:
    """Objective of a frame, over the parameters (N,) of its free blocks.

    Parameters
    ----------
    frame : PoseFrame
        What the six numbers of the pose mean.
    blocks : Blocks
        Pose first, then the weights of the scene.
    terms : mapping of str to Term
        By the names under which their values are reported.
    priors : tuple of Prior
        Over all blocks; their sum counts.
    free : tuple of str
        Names of the blocks that are fitted; the others stay where they are held.
    unit : float
        The scale of tolerances, in units of the value: 1 where it is in nats.
    mobility : (6 + P,) float64, optional
        How far each parameter gives way to a unit force on it; by default the square of its scale.
    held : (6 + P,) float64, optional
        Values of the parameters that are not free; by default zero.
    """

    frame: PoseFrame
    blocks: Blocks
    terms: Mapping[str, Term]
    priors: tuple[Prior, ...] = ()
    free: tuple[str, ...] = (POSE, POSTURE)
    unit: float = 1.0
    mobility: FloatArray | None = None
    held: FloatArray | None = None

    @cached_property
    def spec(self) -> ParamSpec:
        """Names, units, scales and bounds of the free parameters."""
        return self.blocks.only(self.free).spec

    @cached_property
    def _places(self) -> IntArray:
        return self.blocks.indices(self.free)

    def whole(self, vectors: FloatArray) -> FloatArray:
        """All parameters (..., 6 + P) of the free ones (..., N)."""
        if len(self._places) == len(self.blocks):
            return vectors
        out = np.zeros((*vectors.shape[:-1], len(self.blocks)))
        out[...] = 0.0 if self.held is None else self.held
        out[..., self._places] = vectors
        return out

    def chosen(self, vectors: FloatArray) -> FloatArray:
        """The free parameters (..., N) of all (..., 6 + P)."""
        return np.asarray(vectors[..., self._places])

    def candidates(self, vectors: FloatArray) -> Candidates:
        """Candidates of free parameters (B, N)."""
        return self.frame.candidates(self.whole(vectors))

    def pose(self, x: FloatArray) -> Pose:
        """Head to camera at free parameters (N,)."""
        return self.frame.pose(self.whole(x))

    def part(self, x: FloatArray, name: str) -> FloatArray:
        """The numbers of a block at free parameters (..., N)."""
        return self.blocks.part(self.whole(x), name)

    def __call__(self, x: FloatArray) -> Evaluation:
        """Value and terms at free parameters (N,)."""
        one, full = self.candidates(x[None]), self.whole(x)
        values = {name: float(valued(name, term, one)[0]) for name, term in self.terms.items()}
        prior = sum(p.negative_log(full) for p in self.priors)
        return Evaluation(sum(values.values()) + prior, {**values, "prior": prior})

    def values(self, vectors: FloatArray) -> FloatArray:
        """Values (B,) at free parameters (B, N), drawn in one call for each term."""
        many, full = self.candidates(vectors), self.whole(vectors)
        data = sum((valued(name, term, many) for name, term in self.terms.items()), 0.0)
        prior = sum((p.negative_logs(full) for p in self.priors), np.zeros(len(full)))
        return np.asarray(data + prior, np.float64)

    def roots(self, vectors: FloatArray) -> FloatArray:
        """The priors at free parameters (B, N), taken apart, (B, M)."""
        full = self.whole(vectors)
        none = np.zeros((len(full), 0))
        return np.concatenate([none, *(p.roots(full) for p in self.priors)], axis=1)

    def _squared(self) -> dict[str, Squared]:
        other = [name for name, term in self.terms.items() if not isinstance(term, Squared)]
        if other:
            raise ParameterError(
                f"the evidence '{other[0]}' is not a sum of squares",
                "choose a driver that needs values alone, such as simplex",
            )
        return {name: term for name, term in self.terms.items() if isinstance(term, Squared)}

    def gauss_newton(
        self, x: FloatArray, scale: FloatArray, difference: float
    ) -> tuple[float, FloatArray, FloatArray]:
        """Value, Gauss-Newton matrix (N, N) and half the gradient (N,) at `x`, per `scale` (N,).

        Slopes are differences over `difference` scales, of what is compared in both drawings.

        Raises
        ------
        ParameterError
            If a term or a prior is no sum of squares.
        """
        several = np.vstack([x, x + np.diag(difference * scale)])
        walls = self.roots(several)
        slopes, here = (walls[1:] - walls[0]) / difference, walls[0]
        value, matrix, gradient = float((here**2).sum()), slopes @ slopes.T, slopes @ here
        for name, term in self._squared().items():
            cost, curve, fall = self._linearised(term, several, difference)
            finite(name, "residuals", cost, curve, fall)
            value, matrix, gradient = value + cost, matrix + curve, gradient + fall
        return value, matrix, gradient

    def _linearised(
        self, term: Squared, several: FloatArray, difference: float
    ) -> tuple[float, FloatArray, FloatArray]:
        """Value, Gauss-Newton matrix (N, N) and half the gradient (N,) of a sum of squares.

        At the first of some vectors (1 + N, N); in each of the others one parameter has moved by
        `difference`.
        """
        one, many = self.candidates(several[:1]), self.candidates(several[1:])
        first, beside = term.rows(one), term.rows(many)
        both = first.there & beside.there
        moved = first.mixed(np.where(both, beside.rows - first.rows, 0) / difference)
        fall = moved @ first.mixed(first.rows)[0]
        return float(first.value[0]), np.asarray(moved @ moved.T), np.asarray(fall)

    def newton(
        self, x: FloatArray, reach: int, local: bool = False
    ) -> tuple[float, FloatArray, FloatArray]:
        """Value, gradient (N,) and second derivative (N, N) at `x` (N,), for a Newton step.

        Terms give what they gain as the borders between drawn classes move, looked for `reach`
        drawn pixels to either side; `local`, the slopes where they are. Those without borders that
        are sums of squares give Gauss-Newton's.

        Raises
        ------
        ParameterError
            If a term has neither, or a prior no curvature.
        """
        full = self.whole(x)
        value = sum(p.negative_log(full) for p in self.priors)
        slope = sum((p.slope(full) for p in self.priors), np.zeros(len(self.blocks)))
        others = [p.curvature(full) for p in self.priors if not p.bends_alike]
        curve = self._bent_alike + self._summed(others) if others else self._bent_alike
        slope = self.chosen(slope)
        for cost, fall, bend in self._curved(x, reach, local, COMPARISON.least_curvature):
            value, slope, curve = value + cost, slope + fall, curve + bend
        return value, slope, curve

    @cached_property
    def _bent_alike(self) -> FloatArray:
        """Curvature (N, N) of the priors that have the same one everywhere."""
        nowhere = np.zeros(len(self.blocks))
        return self._summed(p.curvature(nowhere) for p in self.priors if p.bends_alike)

    def information(self, x: FloatArray) -> FloatArray | None:
        """Information of the evidence and the priors about the parameters at `x` (N,), (N, N).

        The value's second derivative, without what keeps a step short. None where a term or a prior
        has none, or the value is not in nats.
        """
        if self.unit != 1.0:
            return None
        try:
            parts = [
                bend for _, _, bend in self._curved(x, HEAD_FIT.border_reach, local=True, floor=0.0)
            ]
            told = self._summed(p.bend(self.whole(x)) for p in self.priors)
            return np.asarray(sum(parts, told), np.float64)
        except ParameterError:
            return None

    def _summed(self, each: Iterable[FloatArray]) -> FloatArray:
        """The sum of matrices over all parameters, of the free ones (N, N)."""
        size = len(self.blocks)
        return self._of_free(sum(each, np.zeros((size, size))))

    def _of_free(self, matrix: FloatArray) -> FloatArray:
        """The part (N, N) of the free parameters of a matrix over all."""
        if len(self._places) == len(self.blocks):
            return matrix
        return np.asarray(matrix[np.ix_(self._places, self._places)])

    def _curved(
        self, x: FloatArray, reach: int, local: bool, floor: float
    ) -> list[tuple[float, FloatArray, FloatArray]]:
        """Value, gradient (N,) and second derivative (N, N) of each term."""
        found = []
        for name, term in self.terms.items():
            if hasattr(term, "borders"):  # far quicker than isinstance of a protocol
                found.append(self._bordered(cast("Bordered", term), x, reach, local, floor))
                cost, fall, bend = found[-1]
                finite(name, "borders", cost, fall, np.diagonal(bend))
            elif not hasattr(term, "rows"):
                raise ParameterError(
                    f"the evidence '{name}' has no borders",
                    "choose another driver, such as simplex",
                )
            else:
                found.append(self._bent(cast("Squared", term), x))
                finite(name, "residuals", *found[-1])
        return found

    def _bordered(
        self, term: Bordered, x: FloatArray, reach: int, local: bool, floor: float
    ) -> tuple[float, FloatArray, FloatArray]:
        """Value, gradient (N,) and second derivative (N, N) of a term by its borders."""
        candidate = self.candidates(x[None])
        cost, found = term.borders(candidate, reach, local, floor)
        drawn = term.scene, term.camera, term.window
        fall, bend = summed_along(*drawn, candidate, self.frame, found, term.observations)
        return cost, -self.chosen(fall), self._of_free(bend)

    def _bent(self, term: Squared, x: FloatArray) -> tuple[float, FloatArray, FloatArray]:
        """The same of a sum of squares, by its slopes or differences of first steps."""
        if hasattr(term, "slopes"):
            rows, along = term.slopes(self.candidates(x[None]), self.frame.pivot)
            free = along if len(self._places) == len(along) else along[self._places]
            return float(rows @ rows), 2 * free @ rows, 2 * free @ free.T
        scale = self.spec.scale
        several = np.vstack([x, x + np.diag(scale)])
        cost, curve, fall = self._linearised(term, several, 1.0)
        return cost, 2 * fall / scale, 2 * curve / np.outer(scale, scale)

    def push(self, x: FloatArray) -> FloatArray:
        """Step under the forces at `x` (N,) (Basu et al., eq. 13), and the pose's work.

        Each parameter gives way by its `mobility` times the work of the forces on the nodes, less
        the priors' slope. The weights' part is scaled so that the node which moves most moves by
        `HEAD_FIT.first_stride`; the pose's is shortened to that.

        Raises
        ------
        ParameterError
            If no term has forces, or a prior has no slope.
        """
        candidate = self.candidates(x[None])
        step = self._given_way(x, candidate)
        return self.chosen(self._forces.strides(step, candidate))

    def give_way(self, x: FloatArray) -> FloatArray:
        """The same before it is scaled: `mobility` times force, (N,); errors as `push`."""
        return self.chosen(self._given_way(x, self.candidates(x[None])))

    def _given_way(self, x: FloatArray, candidate: Candidates) -> FloatArray:
        """`give_way` over all parameters (6 + P,)."""
        full = self.whole(x)
        slope = sum((p.slope(full) for p in self.priors), np.zeros(len(full)))
        mobility = self.blocks.spec.scale**2 if self.mobility is None else self.mobility
        return np.asarray(mobility * (self._forces.generalised(candidate) - slope))

    @cached_property
    def _forces(self) -> Forces:
        return Forces(self.frame, self.blocks, self.terms)
