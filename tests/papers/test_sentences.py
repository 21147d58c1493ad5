"""French sentences, trees of phonemes, closures, and the search of a frame of a sequence."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace
from types import SimpleNamespace

import appearances
import numpy as np
import pytest
import shapes

from abs_engine.compare.descriptor import texture_error
from abs_engine.compare.points import local_error
from abs_engine.compare.prior import PenaltyPrior
from abs_engine.core.blocks import POSTURE
from abs_engine.core.errors import ParameterError
from abs_engine.core.geometry import Pose
from abs_engine.core.pose import PoseFrame, at_base, mode_block, pose_and
from abs_engine.core.scene import Candidates
from abs_engine.face.appearance.atlas import fitting_size, lay_atlas
from abs_engine.face.appearance.local_learning import learn_local
from abs_engine.face.appearance.point_selection import choose_points
from abs_engine.face.appearance.texture import learn_texture
from abs_engine.face.penalty import ImprobablePenalty
from abs_engine.fit.problem import Problem
from abs_engine.fit.settings import TALKING_FIT
from abs_engine.optimise.anchored import Held
from abs_engine.optimise.axes import AxesSimplex
from abs_engine.papers.odisio2004.sentences_scores import Closures, closures
from abs_engine.papers.odisio2004.sequence import PAPER, Settings
from abs_engine.papers.odisio2004.trees import (
    CONSONANTS,
    VOWELS,
    faces_at_centres,
    hausdorff,
    phoneme_tree,
    trees_figure,
)
from abs_engine.render.cpu import CpuRenderer
from abs_engine.studio.french import PHONEMES, PRACTICE, QUICK, SENTENCES
from abs_engine.studio.speech import parse_phonemes

RENDERER = CpuRenderer()
N = appearances.N_MODES


def test_77_sentences_have_every_french_phoneme_and_many_closures():
    said = Counter(p for s in SENTENCES for p in s.phonemes if p != "_")
    assert len(SENTENCES) == len({s.name for s in SENTENCES}) == 77
    assert set(said) == set(PHONEMES)
    assert sum(said[p] for p in "pbm") > 300
    assert 7_300 < 25 * sum(s.utterance.seconds for s in SENTENCES) < 7_800
    assert all(len(s.utterance.segments) == len(s.phonemes) + 2 for s in SENTENCES)
    assert QUICK[0].name == "massue"
    assert PRACTICE.sounds not in {s.sounds for s in SENTENCES}


def test_a_nasal_vowel_is_one_sound():
    assert SENTENCES[1].phonemes[:8] == ("p", "a", "p", "a", "a", "p", "o", "z")
    labels = [s.phoneme.label for s in SENTENCES[1].utterance.segments]
    assert labels[10] == "œ̃"


def test_the_median_modified_hausdorff_distance_by_hand():
    """A = {0, 1, 10}, B = {0, 2}: nearest 0, 1, 8 and 0, 1; their medians 1 and 0.5."""
    one, other = np.array([0.0, 1, 10]), np.array([0.0, 2])
    away = np.abs(one[:, None] - other)
    assert hausdorff(away) == 1.0
    assert hausdorff(away.T) == 1.0
    assert hausdorff(away[:2]) == 0.5  # {0, 1}: nearest 0, 1 and 0, 1


def faces(*values):
    """Faces of two points, both moved along x by each value."""
    moved = np.zeros((len(values), 2, 3))
    moved[..., 0] = np.array(values)[:, None]
    return moved


def test_phonemes_are_joined_from_the_nearest_on():
    tree = phoneme_tree({"p": faces(0, 0.2), "a": faces(9, 9.5), "b": faces(0.1, 0.4)})
    assert tree.links[0, :2].tolist() == [0, 2]
    # nearest to 0, 0.2: 0.1, 0.1; nearest to 0.1, 0.4: 0.1, 0.2
    assert tree.links[0, 2] == pytest.approx(0.15)
    # nearest to 9, 9.5 among 0, 0.2, 0.1, 0.4: 8.6, 9.1; the other way round 9, 8.8, 8.9, 8.6
    assert tree.links[1, 2] == pytest.approx(8.85)
    assert tree.groups(2) == (("p", "b"), ("a",))
    with pytest.raises(ParameterError, match="of 1 phonemes"):
        phoneme_tree({"p": faces(0)})


def test_no_join_is_drawn_below_one_inside_of_it():
    rng = np.random.default_rng(0)
    tree = phoneme_tree({chr(97 + k): rng.normal(0, 1, (3, 4, 3)) for k in range(9)})
    assert (np.diff(tree.links[:, 2]) >= 0).all() or all(
        row[2] >= tree.links[int(k) - 9, 2] for row in tree.links for k in row[:2] if k >= 9
    )
    assert tree.links[-1, 3] == 9


def test_vowels_and_consonants_apart_at_their_middles():
    utterance = parse_phonemes("_(0.2) p(0.08) a(0.12) _(0.2) p(0.08) i(0.12)")
    points = np.zeros((20, 1, 3))
    points[:, 0, 0] = np.arange(20)
    found = faces_at_centres([(utterance.segments, 25.0, points)])
    assert set(found[VOWELS]) == {"a", "i"}
    assert found[CONSONANTS]["p"][:, 0, 0].tolist() == [6, 16]
    trees = {VOWELS: phoneme_tree(found[VOWELS])}
    assert len(trees_figure(trees).axes) == 1


def test_closures_are_counted():
    utterance = parse_phonemes("_(0.2) a(0.2) p(0.12) a(0.2) m(0.12) a(0.2) _(0.2)")
    frames = np.arange(int(utterance.seconds * 25))
    times = frames / 25
    closed = ((times >= 0.42) & (times < 0.5)) | ((times >= 0.74) & (times < 0.82))
    filmed = SimpleNamespace(utterance=utterance, closed=closed)
    right = closures(filmed, np.where(closed, 0.0, 5.0), 1.0)
    assert right == Closures(2, 2, 2, 2)
    gap = np.where(closed & (times < 0.6), 0.0, 5.0)
    gap[(times > 0.58) & (times < 0.62)] = 0.0  # in the second a
    wrong = closures(filmed, gap, 1.0)
    assert (wrong.recall, wrong.precision) == (0.5, 0.5)
    rest = np.where(times < 0.1, 0.0, 5.0)  # silent lips are no closure
    assert closures(filmed, rest, 1.0).found == 0
    assert np.isnan(Closures(0, 0, 0, 0).recall)
    assert right + wrong == Closures(4, 3, 4, 3)


@pytest.fixture(scope="module")
def ball():
    scene = appearances.varying_ball()
    camera = shapes.view(appearances.PIXELS)[0]
    frames = appearances.sightings(scene, camera, 25)
    return scene, camera, frames, appearances.sightings(scene, camera, 1, seed=77)[0]


def ball_problem(ball, kind):
    scene, camera, frames, other = ball
    frame = PoseFrame(other.pose, np.zeros(3))
    penalty = ImprobablePenalty(np.zeros(N), np.eye(N), strength=1e-4)  # hardly any pull
    if kind == "tex":
        size = fitting_size(scene, camera, Pose.facing(shapes.DISTANCE))
        model = learn_texture(frames, scene, lay_atlas(scene, size, RENDERER), camera, RENDERER)
        start = Candidates.one(other.parameters, other.pose)
        error = texture_error(model, scene, other.image, camera, camera.whole, start, RENDERER)
    else:
        front = np.flatnonzero(scene.mean[:, 2] > 0.5 * shapes.RADIUS)
        every = learn_local(frames, scene, front, camera, RENDERER)
        model = every.only(choose_points(every, 40, scene.mean[front], 8.0))
        error = local_error(model, scene, other.image, camera, camera.whole, RENDERER, whiten="all")
    blocks = pose_and(mode_block(N, 3.5))
    prior = PenaltyPrior(penalty, TALKING_FIT.penalty_share * error.unit, blocks.places[POSTURE])
    return Problem(frame, blocks, {kind: error}, (prior,), unit=error.unit)


@pytest.mark.parametrize("kind", ["tex", "la"])
def test_epsilon_taken_apart_is_epsilon(ball, kind):
    problem = ball_problem(ball, kind)
    rows = np.random.default_rng(3).normal(0, 1.0, (4, 6 + N)) * problem.spec.scale
    rows[:, 6:] *= 4  # outside of the penalty's range
    error, many = problem.terms[kind], problem.candidates(rows)
    apart, walls = error.rows(many), (problem.roots(rows) ** 2).sum(axis=1)
    assert walls.any()
    np.testing.assert_allclose(apart.value, error.epsilon(many), rtol=1e-4)
    np.testing.assert_allclose(apart.value + walls, problem.values(rows), rtol=1e-4)
    if kind == "la":
        assert apart.there.any()


@pytest.mark.parametrize("kind", ["tex", "la"])
def test_a_search_comes_home(ball, kind):
    problem, other = ball_problem(ball, kind), ball[3]
    start, spec = at_base(other.parameters), problem.spec
    off = start + 0.8 * spec.scale * np.r_[0.3, -0.3, 0.3, 1, -1, 0.5, 1, -1, 1]
    held, solver = Held(problem, spec, off), AxesSimplex(220, 1e-6, 1e-6)
    found = solver.descend(problem, off, spec, 120)
    better = solver.polish(problem, found, spec, off, 100)
    assert better.value <= found.value < float(held.values(off[None])[0])
    assert np.abs(better.x[6:] - other.parameters).max() < 0.2
    assert found.n_evaluations <= 120
    assert better.n_evaluations <= 220
    pulled = replace(solver, inertia=10.0)
    assert np.abs(pulled.descend(problem, off, spec, 120).x - off).max() < 0.1
    free = pulled.descend(problem, off, spec, 120, free=True)
    np.testing.assert_array_equal(free.x, found.x)


def test_settings_are_checked():
    assert (PAPER.method, PAPER.predict) == ("simplex", False)
    with pytest.raises(ParameterError, match="no search 'annealing'"):
        replace(Settings(), method="annealing")
