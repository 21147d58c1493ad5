"""A picture of a talking face as a problem: epsilon(p) of an appearance model (section 4)."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from abs_engine.compare.descriptor import TextureError, texture_error
from abs_engine.compare.points import LocalError, local_error
from abs_engine.compare.prior import PenaltyPrior
from abs_engine.core.arrays import FloatArray
from abs_engine.core.blocks import POSTURE
from abs_engine.core.camera import Camera, Window
from abs_engine.core.errors import OutOfPictureError, ParameterError
from abs_engine.core.geometry import Pose
from abs_engine.core.objective import Objective
from abs_engine.core.params import ParamSpec
from abs_engine.core.pose import PoseFrame, free_blocks
from abs_engine.core.scene import Renderer, Scene
from abs_engine.face.articulated import FaceShape
from abs_engine.face.base import Face
from abs_engine.face.talking import MODELS, TEXTURES, TalkingFace
from abs_engine.fit.problem import Problem
from abs_engine.fit.settings import TALKING_FIT
from abs_engine.fit.terms import LOCAL, TEXTURE, Bind, TermKind, pixels_per_mm
from abs_engine.fit.view import View
from abs_engine.optimise.base import Solution
from abs_engine.optimise.by_nlopt import Simplex


class Solver(Protocol):
    """Minimiser of a talking face: `optimise.by_nlopt.Simplex` and the others of `optimise`."""

    def minimise(
        self, objective: Objective, start: FloatArray, spec: ParamSpec, step: float = 1.0
    ) -> Solution:
        """Minimise from `start`."""
        ...


def usual_tolerance(problem: Problem) -> float:
    """The stopping rule of a fit from far away, as a share of what a wrong match costs."""
    return (
        TALKING_FIT.tolerance if TEXTURE.name in problem.terms else TALKING_FIT.tolerance_of_points
    )


def surface_window(
    surface: Scene, weights: FloatArray, pose: Pose, camera: Camera, scale: float = 1.0
) -> Window:
    """The part of the picture where a surface is at weights and a pose, and pixels around it.

    With `scale` drawn pixels per image pixel. Raises `OutOfPictureError` if it lies outside of the
    picture.
    """
    place = pose.apply(surface.vertices(weights))
    flat = camera.project(place)
    margin = TALKING_FIT.margin * max(1.0, camera.matrix[0, 0] / float(np.median(place[:, 2])))
    low = np.floor(np.maximum(flat.min(axis=0) - margin, 0))
    high = np.ceil(np.minimum(flat.max(axis=0) + margin, camera.size))
    if not (high - low >= TALKING_FIT.least_window).all():
        raise OutOfPictureError("the face lies outside of the picture", "start where the face is")
    (x, y), (width, height) = low, high - low
    return Window(float(x), float(y), float(width), float(height), scale)


def talking_problem(
    face: TalkingFace,
    name: str,
    picture: NDArray[np.generic],
    camera: Camera,
    pose: Pose,
    alpha: FloatArray,
    renderer: Renderer,
    *,
    pose_known: bool = False,
    window: Window | None = None,
    whiten: bool = False,
    printed: bool = False,
) -> Problem:
    """Objective of a picture (H, W, 3), RGB 0 to 255: epsilon + A(a).

    Parameters
    ----------
    name : str
        Of the appearance model, of `MODELS`.
    pose : Pose
        Head to camera: known, or where the search starts.
    alpha : (P,) float64
        Where the search starts.
    pose_known : bool
        Seek the articulatory parameters only.
    window : Window, optional
        Part of the picture that is compared; by default `surface_window` at the start.
    whiten : bool
        Whether textures, too, are compared beyond epsilon as printed (see `texture_error`), which
        is several times the work; local appearance, where it costs little, is unless `printed`.
    printed : bool
        Compare local appearance, too, by epsilon as printed: descriptors raw, beside all of A(a).

    Notes
    -----
    Local appearance is whitened with `APPEARANCE.alone`, as it was for the published figures, not
    with the face's own share, which `as_face` has: sentences were not measured with that.

    Raises
    ------
    ParameterError
        If there is no such model, or the face is outside of the picture.
    PictureError
        If a pixel is not finite.
    """
    shape = face.shape
    if name not in MODELS:
        raise ParameterError(f"there is no model '{name}'", f"choose one of {', '.join(MODELS)}")
    frame, model = PoseFrame(pose, shape.pivot), getattr(face, name)
    if window is None:
        window = surface_window(shape.surface, alpha, pose, camera)
    error: TextureError | LocalError
    if name in TEXTURES:
        start = frame.candidates(shape.blocks.vector({POSTURE: alpha})[None])
        error = texture_error(
            model, shape.surface, picture, camera, window, start, renderer,
            face.dressed[name], whiten=whiten,
        )  # fmt: skip
        kind, white = TEXTURE.name, whiten
    else:
        error = local_error(
            model, shape.outer, picture, camera, replace(window, scale=face.la_scale),
            renderer, whiten="no" if printed else "all",
        )  # fmt: skip
        kind, white = LOCAL.name, not printed
    prior, free = _penalty(shape, error.unit, white), free_blocks(pose_known)
    return Problem(frame, shape.blocks, {kind: error}, (prior,), free, error.unit)


def _penalty(shape: FaceShape, unit: float, white: bool) -> PenaltyPrior:
    """A(a) beside an error whose wrong match costs `unit`; weaker beside one that is made white."""
    penalty = shape.penalty
    if white:
        penalty = replace(penalty, strength=TALKING_FIT.whitened * penalty.strength)
    return PenaltyPrior(penalty, TALKING_FIT.penalty_share * unit, shape.blocks.places[POSTURE])


@dataclass(frozen=True, eq=False)
class FaceFit:
    """Result of a search in a picture: the parameters (P,), pose and solution."""

    alpha: FloatArray
    pose: Pose
    solution: Solution


def fit(
    problem: Problem, alpha: FloatArray, *, step: float = 1.0, solver: Solver | None = None
) -> FaceFit:
    """Minimise a problem from a posture, at the pose that it was made with.

    `step` is a factor on the first simplex, see `TALKING_FIT.from_neutral`; the solver is by
    default Nelder-Mead with `usual_tolerance`.
    """
    chosen = Simplex(usual_tolerance(problem), TALKING_FIT.limit) if solver is None else solver
    start = problem.chosen(problem.blocks.vector({POSTURE: np.asarray(alpha, np.float64)}))
    found = chosen.minimise(problem, start, problem.spec, step)
    return FaceFit(problem.part(found.x, POSTURE), problem.pose(found.x), found)


def over_face(surface: Scene, per_mm: float = 0.0) -> dict[str, Bind]:
    """Ways in which evidence is bound to the window of a face: see `face.base.Face.own_terms`.

    The surface is skin and lips; its weights are the posture. A texture is drawn `per_mm` pixels
    per mm at most; at 0, as finely as the picture is.
    """

    def wide(face: Face, view: View) -> View:
        weights = face.blocks.part(view.start, POSTURE)
        scale = min(1.0, per_mm / pixels_per_mm(face.pivot, view)) if per_mm else 1.0
        window = surface_window(surface, weights, view.frame.base, view.camera, scale)
        return replace(view, window=window)

    def over(kind: TermKind) -> Bind:
        return lambda face, view: kind.bind(face, wide(face, view))

    return {kind.name: over(kind) for kind in (TEXTURE, LOCAL)}
