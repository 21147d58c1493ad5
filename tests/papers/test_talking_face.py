"""The talking face: shape, the four models, epsilon over 7 and 13 parameters, and the search."""

from __future__ import annotations

import numpy as np
import pytest

from abs_engine.core.camera import Camera
from abs_engine.core.errors import ParameterError
from abs_engine.core.scene import Candidates
from abs_engine.face.talking import MODELS
from abs_engine.fit.talking import fit, talking_problem
from abs_engine.io.assets import load_speaker
from abs_engine.learn.articulated import face_shape
from abs_engine.learn.articulatory import build
from abs_engine.papers.odisio2004.filmed import VisemePictures
from abs_engine.papers.odisio2004.goals import GOALS, goal_rows
from abs_engine.papers.odisio2004.page import reproduction_page
from abs_engine.papers.odisio2004.search import SOLVERS, Watched, compare_solvers
from abs_engine.papers.odisio2004.sequence_measure import variants
from abs_engine.papers.odisio2004.viseme_figures import residual_figure
from abs_engine.papers.odisio2004.visemes import (
    ASKED,
    NEUTRAL,
    Speech,
    VisemeError,
    find_visemes,
    splits,
    summary,
)
from abs_engine.render.cpu import CpuRenderer
from abs_engine.studio.corpus import speak_corpus
from abs_engine.studio.sequence import portrait

RENDERER = CpuRenderer()
CAMERA = Camera.ideal((160, 120))


@pytest.fixture(scope="module")
def speech() -> Speech:
    """Visemes drawn by the CPU rasteriser before a plain wall, with noise."""
    speaker = load_speaker()
    neutral = speaker.named("clara")
    spoken = speak_corpus(speaker, neutral)
    built = build(spoken.corpus)
    shape = face_shape(speaker, spoken, built, "clara")
    pose = portrait(CAMERA, speaker, neutral)
    rng = np.random.default_rng(0)
    pictures = []
    for row in built.alpha:
        drawn = RENDERER.draw(shape.scene, Candidates.one(row, pose), CAMERA, CAMERA.whole)[0]
        wall = np.where(drawn.covered[..., None], drawn.rgb, 90)
        pictures.append(np.clip(wall + rng.normal(0, 1.5, wall.shape), 0, 255).astype(np.uint8))
    heads = np.stack([shape.scene.vertices(row) for row in built.alpha]).astype(np.float32)
    names = spoken.corpus.visemes
    seen = VisemePictures(names, np.stack(pictures), heads, (pose,) * len(names), CAMERA)
    return Speech("clara", spoken, built, shape, seen, 0)


@pytest.fixture(scope="module")
def face(speech):
    return speech.learn(range(0, 68, 2), RENDERER)


def test_the_shape_is_the_models(speech):
    shape, alpha = speech.shape, speech.built.alpha[5]
    np.testing.assert_allclose(
        shape.frame.apply(shape.points(alpha)), shape.model.points(alpha), atol=0.6
    )
    assert len(shape.vertices) == 275
    assert speech.distances(shape.neutral, 0).mean() < 0.5  # the first viseme is rest


def test_local_appearance_is_sought_where_the_head_is_drawn(speech):
    """A mark beside it, where it is chosen, stops the whole face from being learned."""
    assert np.isin(speech.shape.marks, speech.shape.kept).all()
    assert len(speech.shape.marks) > 400


def test_the_compared_surface_has_no_holes_around_the_lips(speech):
    speaker = load_speaker()
    rim = speaker.landmarks["outer_lip"]
    around = np.isin(speaker.faces, rim).any(axis=1)
    corners = np.unique(speaker.faces[around], axis=0)
    place = {tuple(v) for v in speech.shape.surface.mean.round(3)}
    mean = speech.shape.scene.mean.round(3)
    assert all(tuple(mean[v]) in place for v in np.unique(corners))


@pytest.mark.parametrize("name", MODELS)
@pytest.mark.parametrize("known", [True, False])
def test_epsilon_is_its_rows_squared(name, known, speech, face):
    seen, start = speech.pictures, speech.shape.neutral
    asked = talking_problem(
        face, name, seen.pictures[3], CAMERA, seen.poses[3], start, RENDERER, pose_known=known
    )
    x = start if known else np.concatenate([np.zeros(6), start])
    assert len(asked.spec) == len(x)
    one, (term,) = asked.candidates(x[None]), asked.terms.values()
    apart = term.rows(one)
    squares = float((apart.mixed(apart.rows)[0] ** 2).sum())
    hidden = (
        float((term.wrong * ~term.differences(one)[1][0]).mean()) if name.startswith("la") else 0.0
    )
    assert squares + hidden == pytest.approx(float(apart.value[0]), rel=1e-4)
    whole = float(apart.value[0]) + float((asked.roots(x[None]) ** 2).sum())
    assert whole == pytest.approx(asked(x).value, rel=1e-4)
    np.testing.assert_array_equal(asked.part(x, "posture"), start)


@pytest.mark.parametrize("name", ["tex_lin", "la_lin"])
def test_a_fit_comes_nearer(name, speech, face):
    which = speech.pictures.visemes.index("a")
    asked = speech.problem(face, name, which, RENDERER)
    found = fit(asked, speech.shape.neutral, step=3.0)
    before = speech.distances(speech.shape.neutral, which).mean()
    assert speech.distances(found.alpha, which).mean() < 0.35 * before


def test_what_cannot_be_asked_for(speech, face):
    seen = speech.pictures
    with pytest.raises(ParameterError, match="choose one of tex_lin"):
        talking_problem(
            face, "aam", seen.pictures[0], CAMERA, seen.poses[0], speech.shape.neutral, RENDERER
        )
    with pytest.raises(ParameterError, match="no pictures"):
        speech.learn([], RENDERER)


def test_variants_change_one_thing_each(speech, face):
    found = variants(speech, face, RENDERER)
    papers, apart, free = found.values()
    assert len(papers.la_lin) == len(face.la_lin)
    assert not np.array_equal(np.sort(papers.la_lin.vertices), np.sort(face.la_lin.vertices))
    alone = apart.la_lin.whitener
    np.testing.assert_allclose(alone, alone[0, 0] * np.eye(len(alone)), atol=1e-9)
    far = speech.shape.neutral + 3
    assert free.shape.penalty(far) < 0.01 * face.shape.penalty(far)


def test_splits_test_each_viseme_once():
    ((trained, tests),) = splits(68, 4, 1)
    assert len(trained) == 54
    assert not set(trained) & set(tests)
    found = splits(68, 4, 5)
    assert sorted(np.concatenate([t for _, t in found])) == list(range(68))
    assert all(not set(a) & set(b) for a, b in found)


def test_every_solver_can_be_compared(speech, face):
    rows = compare_solvers(speech, face, [1], RENDERER, budgets=(30,))
    assert {row["solver"] for row in rows} == set(SOLVERS)
    assert all(0 < row["evaluations"] <= 30 for row in rows)


def test_tables(speech, face):
    errors = find_visemes(speech, face, [1], RENDERER, ("tex_lin",))
    told = summary(errors)
    assert set(told) == {"tex_lin", "neutral"}
    rows = compare_solvers(
        speech, face, [1], RENDERER, budgets=(20, 40), solvers=("nelder_mead", "bobyqa")
    )
    assert [r["evaluations"] for r in rows] == [20, 40, 20, 40]
    watched = Watched(speech.problem(face, "tex_lin", 1, RENDERER))
    first = watched(speech.shape.neutral).value
    watched(speech.shape.neutral + 5)
    assert watched.after(2)[0] is watched.best[0]
    assert first < 1
    page = reproduction_page({"visemes": told}, [("a.png", "A figure")])
    assert "not measured" in page
    assert len(goal_rows({})) == len(GOALS)


def test_names_of_the_worst_visemes_lie_beside_the_boxes_and_inside_the_frame():
    """Far from another, near another, and the highest of all."""
    errors = [
        VisemeError("preph", model, np.zeros(0), rms, rms, 0)
        for model in (*ASKED, NEUTRAL)
        for k, rms in enumerate([0.2, 0.4, 0.5, 0.52, 9.0 if model == NEUTRAL else 0.55])
    ]
    figure = residual_figure({"bare face": errors, "with beads": errors})
    figure.canvas.draw()
    for axes in figure.axes:
        frame = axes.get_window_extent()
        names = [text.get_window_extent() for text in axes.texts]
        boxes = [line.get_window_extent() for line in axes.lines if len(line.get_xdata()) > 2]
        assert len(names) == 3 * (len(ASKED) + 1)
        assert all(frame.y0 < n.y0 and n.y1 < frame.y1 and n.x1 < frame.x1 for n in names)
        assert not any(n.overlaps(box) for n in names for box in boxes)
