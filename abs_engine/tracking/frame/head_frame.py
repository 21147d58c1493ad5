"""A frame of a head as it is fitted: evidence, priors, and what its landmarks say of it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property, partial

import numpy as np

from abs_engine.compare.facets import FacetLikelihood
from abs_engine.compare.mixture_prior import MixturePrior
from abs_engine.compare.prior import ContactPrior, GaussianPrior, Prior
from abs_engine.core.arrays import FloatArray
from abs_engine.core.camera import Camera
from abs_engine.core.geometry import Pose
from abs_engine.core.objective import Evaluation
from abs_engine.core.pose import PoseFrame, at_base, free_blocks, joined
from abs_engine.core.scene import Renderer
from abs_engine.face.base import Face, lip_gap
from abs_engine.face.head import MouthModel
from abs_engine.fit.evidence import Term
from abs_engine.fit.head_frame import contact_prior, mouth_window
from abs_engine.fit.problem import Problem
from abs_engine.fit.seal import Seal
from abs_engine.fit.terms import COLOUR, TermKind, Weighted, bound
from abs_engine.fit.view import View
from abs_engine.io.assets import CLOSED_APERTURE
from abs_engine.tracking.frame.clip_setting import GREY, Work
from abs_engine.tracking.frame.frame_state import HeadFrame, Memory
from abs_engine.tracking.frame.mouth_landmarks import RENDERING, MouthLandmarks
from abs_engine.tracking.frame.mouth_place import mouth_place
from abs_engine.tracking.person.identity_fit import POSE_DEVIATION
from abs_engine.tracking.settings.frames import FRAME_LOOP


@dataclass(frozen=True, eq=False)
class HeadBinder:
    """Binds evidence to a head whose person is known or was fitted.

    Parameters
    ----------
    face : Face
        The model with the person held, and its appearance.
    rate : float, frames per second
    pose_held : bool
        Whether poses are taken as they are, and only the posture is fitted.
    steps : (P,) float64, optional
        How far each parameter of the posture moves in 40 ms, standard deviations; by default as
        anybody's does.
    seen : (K, P) float64, optional
        Postures of this person; by default any that people have may come.
    """

    model: MouthModel
    face: Face
    camera: Camera
    renderer: Renderer
    rate: float
    landmarks: MouthLandmarks
    kinds: Mapping[str, TermKind] = field(default_factory=lambda: {COLOUR.name: COLOUR})
    pose_held: bool = False
    steps: FloatArray | None = None
    seen: FloatArray | None = None

    def work(self, frame: HeadFrame, pose: Pose, memory: Memory) -> Work:
        """Objective of a frame whose head is about a pose, and the start of its search."""
        model, last = self.model, memory.vector
        base, marks = PoseFrame(pose, model.pivot), self.landmarks
        told, terms = marks.told(frame), frame.terms
        priors = self._priors(last, memory.gap, thick=told is not None)
        grey = self._grey(frame)
        if grey:
            terms = {}
        elif terms is None:
            start = next((x for x in (told, last) if x is not None), at_base(model.prototypes[0]))
            terms = self._terms(frame, base, told, start)
        beside: tuple[Prior, ...] = ()
        if frame.face is not None:
            beside = marks.beside(frame, self.face.learned("colour").outdoing)
        problem = self._problem(base, terms, (*priors, *beside))
        known = [x for x in (last, told) if x is not None]
        # Beside both, a usual posture was best in 1 of 430 frames, and led nowhere else
        usual = at_base(model.prototypes[: 0 if len(known) == 2 else None])
        starts = np.vstack([*known, usual])
        said = marks.marked(frame, self._problem(base, {}, priors), GREY if grey else "")
        return Work(problem, starts, partial(explained, terms), said, seal=self._seal)

    def ahead(self, frame: HeadFrame, pose: Pose) -> Mapping[str, Term] | None:
        """The evidence of a frame, started from its landmarks; None if it has, or needs, none."""
        told = self.landmarks.told(frame)
        if told is None or frame.face is None or self._grey(frame):
            return None
        frame.face.fit.evidence(self.landmarks.modes)  # kept there for the fit
        return self._terms(frame, PoseFrame(pose, self.model.pivot), told, told)

    def _grey(self, frame: HeadFrame) -> bool:
        """Whether colours are compared, but say nothing in this frame."""
        return COLOUR.name in self.kinds and self.landmarks.alone(frame)

    def _terms(
        self, frame: HeadFrame, base: PoseFrame, told: FloatArray | None, start: FloatArray
    ) -> Mapping[str, Term]:
        """The evidence near a pose; `told` is the mouth (6 + P,) by landmarks, if there are any."""
        window = mouth_window(self.model, base.base, self.camera, self.face.identity)
        place = None
        if told is not None and self.landmarks.evidence != RENDERING:
            place = mouth_place(self.model, base, self.camera, window, self.face.identity, told)
        view = View(frame.in_usual_light, self.camera, self.renderer, base, window, start, place)
        return bound(self.kinds, self.face, view)

    def _problem(
        self, base: PoseFrame, terms: Mapping[str, Term], priors: tuple[Prior, ...]
    ) -> Problem:
        free, mobility = free_blocks(self.pose_held), mobility_of(self.model.n_expression)
        return Problem(base, self.face.blocks, terms, priors, free, mobility=mobility)

    @cached_property
    def _contact(self) -> tuple[ContactPrior, ContactPrior]:
        """Contact of the lips, and with a thickness that each keeps."""
        loose, thick = (contact_prior(self.model, self.face.identity, t) for t in (False, True))
        return loose, thick

    def _priors(
        self, last: FloatArray | None, gap: float = 1.0, thick: bool = False
    ) -> tuple[Prior, ...]:
        p = self.model.n_expression
        any_of = GaussianPrior(at_base(np.zeros(p)), np.r_[POSE_DEVIATION, np.ones(p)])
        likely = (
            any_of if self.seen is None else MixturePrior(any_of, self.seen, FRAME_LOOP.seen_width)
        )
        contact = self._contact[thick]
        if last is None:
            return likely, contact
        usual = np.full(p, FRAME_LOOP.step_deviation) if self.steps is None else self.steps
        step = usual * np.sqrt(25.0 * gap / self.rate)
        near = GaussianPrior(last, np.r_[POSE_DEVIATION, step])
        return likely, contact, near

    @cached_property
    def _seal(self) -> Seal | None:
        """Frequency with which the lips touch: a known speaker's, or anybody's."""
        scene, points = self.face.scene, self.face.rings["points"]
        mean, modes = (part.astype(np.float64) for part in (scene.mean, scene.modes))
        gap, slope = float(lip_gap(mean[points])), at_base(lip_gap(modes[:, points]))
        if self.seen is None:
            return Seal.usual(gap, slope)
        return Seal.of(gap, slope, self.seen, CLOSED_APERTURE)


def step_deviation(rate: float, gap: float) -> float:
    """Deviation of a posture's parameter over a gap of so many frames, in standard deviations."""
    return float(FRAME_LOOP.step_deviation * np.sqrt(25.0 * gap / rate))


def mobility_of(modes: int) -> FloatArray:
    """Mobility of each parameter (6 + P,) under a force: its prior variance."""
    return np.asarray(joined(POSE_DEVIATION, np.ones(modes)) ** 2)


def explained(terms: Mapping[str, Term], value: Evaluation) -> float:
    """Share of the picture that is explained, 0 to 1: by the first term that can say."""
    for name, term in terms.items():
        if isinstance(term, FacetLikelihood) and term.observations:
            return float(np.exp(-value.terms[name] / term.observations))
        if isinstance(term, Weighted):
            return term.explained(value.terms[name])
    return float("nan")
