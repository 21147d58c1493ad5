"""A plugin's evidence is tried on a drawing before anything slow is done."""

from __future__ import annotations

import numpy as np
import pytest
from runs import SIZE, toy_model, write_noise

from abs_engine.compare.residual_rows import Rows
from abs_engine.core.camera import Camera
from abs_engine.core.errors import TermError
from abs_engine.core.registry import TERMS
from abs_engine.face.held_head import held_head
from abs_engine.fit.problem import Problem
from abs_engine.fit.terms import COLOUR, TermKind
from abs_engine.render.cpu import CpuRenderer
from abs_engine.tracking.options import TrackOptions
from abs_engine.tracking.run import prepare
from abs_engine.tracking.start.plugin_trial import Trial

TRIAL = Trial(toy_model(), Camera.ideal(SIZE), CpuRenderer())


class Worth:
    """A term that is worth the same everywhere."""

    value = 0.0

    def __init__(self, face, view) -> None:
        self.seen = view.image

    def negative_log(self, candidates):
        return np.full(len(candidates), self.value)


class Nan(Worth):
    value = np.nan


class Infinite(Worth):
    value = np.inf


class Failing:
    def __init__(self, face, view) -> None:
        raise KeyError("nothing")


class Learning(Worth):
    """It needs what only the clip gives."""

    def __init__(self, face, view) -> None:
        face.learned("colour")


def kind(made, *gives, learned=False):
    return {"mine": TermKind("mine", made, ("values", *gives), learned)}


@pytest.mark.parametrize(
    ("kinds", "said"),
    [
        (kind(Nan), "'mine' is not a finite number"),
        (kind(Infinite), "'mine' is not a finite number"),
        (kind(Failing), "'mine' fails (KeyError: 'nothing')"),
        (kind(Worth, "borders"), "says that it gives borders, but has no 'borders'"),
        (kind(Worth, "forces"), "says that it gives forces, but has no 'forces'"),
        (kind(Worth, "residuals"), "says that it gives residuals, but has no 'rows'"),
    ],
)
def test_evidence_that_cannot_be_used_is_named(kinds, said):
    with pytest.raises(TermError) as caught:
        TRIAL.check({COLOUR.name: COLOUR, **kinds})
    assert said in str(caught.value)


@pytest.mark.parametrize("kinds", [kind(Worth), kind(Learning), kind(Nan, learned=True)])
def test_sound_evidence_passes_and_what_needs_the_clip_is_not_judged(kinds):
    TRIAL.check(kinds)


def test_the_drawing_shows_a_face():
    images = []

    class Looking(Worth):
        def __init__(self, face, view) -> None:
            images.append(view.image)
            assert view.place is not None

    TRIAL.check(kind(Looking))
    assert images[0].shape == (*SIZE[::-1], 3)
    assert images[0].std() > 10


def test_it_is_refused_before_a_face_is_looked_for(tmp_path):
    """A video without a face would be refused for that, if it came to it."""
    TERMS.add("mine", kind(Nan)["mine"])
    stages = []
    try:
        with pytest.raises(TermError, match="'mine' is not a finite number"):
            prepare(
                write_noise(tmp_path / "noise.mp4"), CpuRenderer(),
                TrackOptions(terms=("colour", "mine"), driver="simplex"), stages.append,
            )  # fmt: skip
    finally:
        TERMS._added.pop("mine")
    assert stages == ["reading the video"]


class Bent(Worth):
    """A sum of squares whose rows are not finite."""

    drawn = False

    def rows(self, candidates):
        rows = np.full((len(candidates), 3), np.nan)
        return Rows(rows, np.ones(rows.shape, bool), np.zeros(len(candidates)))


def test_slopes_that_are_not_finite_are_named():
    model = toy_model()
    view = TRIAL._view()
    face = held_head(model, np.zeros(model.n_person))
    problem = Problem(view.frame, face.blocks, {"mine": Bent(face, view)})
    with pytest.raises(TermError, match="residuals of the evidence 'mine' are not finite"):
        problem.newton(view.start, 4)
    with pytest.raises(TermError, match="residuals of the evidence 'mine' are not finite"):
        problem.gauss_newton(view.start, problem.spec.scale, 1.0)
