"""Fitting the person's own mouth once, over a few frames, and learning the clip's colours."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from abs_engine.compare.facets import FacetLikelihood
from abs_engine.compare.prior import GaussianPrior, Prior
from abs_engine.core.arrays import FloatArray, evenly
from abs_engine.core.blocks import IDENTITY, POSE, Blocks
from abs_engine.core.geometry import Pose
from abs_engine.core.pose import PoseFrame, at_base, no_correction, pose_and
from abs_engine.face.appearance.colour import ColourClasses
from abs_engine.face.head import MouthModel
from abs_engine.fit.evidence import Term
from abs_engine.fit.head_frame import COLOUR, best_start, contact_prior, head_problem
from abs_engine.fit.problem import Problem
from abs_engine.fit.search import Minimiser
from abs_engine.fit.shared import SharedProblem, shared_blocks
from abs_engine.optimise.base import Solution
from abs_engine.optimise.by_nlopt import Simplex
from abs_engine.optimise.newton import Newton
from abs_engine.tracking.person.calibration_views import Stand, place_mouth
from abs_engine.tracking.settings.preparation import PREPARATION

TOLD_DEVIATION = np.array(PREPARATION.given_deviation)
POSE_DEVIATION = np.array(PREPARATION.pose_deviation)
_POSTURE = Newton()


@dataclass(frozen=True, eq=False)
class Calibration:
    """Calibration that is held for the rest of the clip.

    Parameters
    ----------
    person : (Q,) float64
        Weights of the person modes.
    shift : (6,) float64
        Constant correction of the poses, radians and mm.
    expressions : (K, 6 + P) float64
        Fits of the calibration frames.
    """

    person: FloatArray
    shift: FloatArray
    classes: ColourClasses
    expressions: FloatArray


def shift_deviation(stand: Stand, seen: bool) -> FloatArray:
    """Standard deviations (6,) of the constant correction of the poses, radians and mm."""
    if stand.model.known:
        return np.array(PREPARATION.aligned_deviation)
    each = PREPARATION.seen_deviation if seen else PREPARATION.given_deviation
    return np.asarray(each * np.r_[np.ones(5), stand.depth])


def calibrate(
    stand: Stand, known: ColourClasses | None, seen: bool, tell: Callable[[str], None]
) -> Calibration:
    """Fit the person's mouth and the clip's colours by turns, from the person of a stand.

    Each round learns the colours from where the model now stands, fits every frame's posture, then
    one person and one pose correction to all of the frames together. In the first, an unknown mouth
    is looked for by colours that anybody's lips have beside such skin.

    With `known` colours only the mouth is fitted. `seen` is whether the poses are those of faces
    that were found in several frames. `tell` is called as each round begins.

    Raises
    ------
    FaceNotFoundError, TooFewPixelsError
        If the frames do not show enough of skin and lips to learn from.
    """
    model, poses = stand.model, [frame.pose for frame in stand.frames]
    vectors = np.tile(at_base(model.prototypes[2]), (len(poses), 1))
    deviation = shift_deviation(stand, seen)
    rounds = len(PREPARATION.view_rounds)
    for turn in range(rounds):
        tell(f"round {turn + 1} of {rounds}")
        if turn == 0 and not model.known:
            wide = replace(stand, more=PREPARATION.searched_more)
            classes = known or wide.learned(vectors, 0)
            stand = replace(stand, shift=place_mouth(stand, classes, deviation))
        classes = known or stand.learned(vectors, turn)
        terms = stand.terms(classes)
        if turn < len(PREPARATION.depths) and not model.known:
            shift = _best_depth(stand, terms, vectors, deviation, PREPARATION.depths[turn])
            stand = replace(stand, shift=shift)
        fits = zip(terms, stand.bases, vectors, strict=True)
        vectors = np.stack([fit_posture(model, t, b, stand.person, v).x for t, b, v in fits])
        each, begun = [{COLOUR: t} for t in terms], (stand.shift, stand.person)
        solver = Simplex(PREPARATION.joint_tolerance, PREPARATION.joint_limit)
        shift, person = fit_shared(model, poses, each, vectors, deviation, begun, solver)
        stand = replace(stand, shift=shift, person=person)
    return Calibration(stand.person, stand.shift, classes, vectors)


def _best_depth(
    stand: Stand,
    terms: Sequence[FacetLikelihood],
    vectors: FloatArray,
    deviation: FloatArray,
    steps: Sequence[float],
) -> FloatArray:
    """Correction of the poses by which a few frames are explained best, their postures fitted.

    Depth and posture trade against each other, so fitting them by turns creeps; trying depths
    and fitting the postures at each does not.
    """
    prior = GaussianPrior(no_correction(), deviation)
    some = evenly(len(stand.frames), PREPARATION.depth_frames)

    def cost(candidate: FloatArray) -> float:
        total, there = prior.negative_log(candidate), replace(stand, shift=candidate)
        for k in some:
            given = terms[k], there.bases[k], stand.person, vectors[k]
            total += fit_posture(stand.model, *given).value
        return total

    tries = [stand.shift + np.array([0, 0, 0, 0, 0, share * stand.depth]) for share in steps]
    return np.asarray(tries[int(np.argmin([cost(t) for t in tries]))], np.float64)


def fit_posture(
    model: MouthModel,
    term: FacetLikelihood,
    frame: PoseFrame,
    person: FloatArray,
    last: FloatArray,
    solver: Newton = _POSTURE,
    more: tuple[Prior, ...] = (),
) -> Solution:
    """Pose and posture (6 + P,) of one frame with the person held.

    Started from `last` or a usual posture, whichever explains the frame better; `more` priors over
    (6 + P) add to the usual ones. With them, `last` is theirs, and an outline keeps its lips'
    thickness.
    """
    p = model.n_expression
    held = replace(term, scene=model.held(person))
    deviation = np.r_[POSE_DEVIATION, np.ones(p)]
    prior = GaussianPrior(at_base(np.zeros(p)), deviation)
    contact = contact_prior(model, person, thick=bool(more))
    problem = head_problem(held, frame, (prior, contact, *more), model.posture)
    start = last if more else best_start(problem, np.vstack([at_base(model.prototypes), last]))
    return solver.minimise(problem, start, problem.spec)


def fit_shared(
    model: MouthModel,
    poses: Sequence[Pose],
    terms: Sequence[Mapping[str, Term]],
    vectors: FloatArray,
    deviation: FloatArray,
    begun: tuple[FloatArray, FloatArray],
    solver: Minimiser,
    threads: int = 1,
) -> tuple[FloatArray, FloatArray]:
    """A correction (6,) of K frames' poses and the person (Q,), the frames' postures held.

    The solver begins with the two in `begun`. `terms` are the evidence of each frame, over the
    model's scene; `vectors` (K, 6 + P) are where each stands; `deviation` (6,), radians and mm, is
    how far off the poses may be. So many `threads` draw at once.
    """
    blocks = shared_blocks(deviation, model.person_deviation)
    own = Blocks({**pose_and(model.posture).specs, IDENTITY: blocks.specs[IDENTITY]})
    problems = [
        Problem(PoseFrame(pose, model.pivot), own, seen, free=tuple(own.specs))
        for pose, seen in zip(poses, terms, strict=True)
    ]
    held = np.hstack([vectors, np.zeros((len(vectors), model.n_person))])
    prior = GaussianPrior(np.zeros(len(blocks)), np.r_[deviation, model.person_deviation])
    joint = SharedProblem(problems, held, blocks, prior, threads)
    start = blocks.vector(dict(zip((POSE, IDENTITY), begun, strict=True)))
    found = solver.minimise(joint, start, joint.spec).x
    return blocks.part(found, POSE), blocks.part(found, IDENTITY)
