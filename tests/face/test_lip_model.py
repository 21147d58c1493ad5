"""What is drawn of the lips besides the shell: how they bulge, and where they end in the mouth."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from itertools import pairwise

import numpy as np
import pytest

from abs_engine.core.errors import MeshError, ModelFormatError
from abs_engine.face.shape.lip_edge import lip_edge
from abs_engine.face.shape.lip_model import INSIDE, LIPS, LipModel, followed, lip_model
from abs_engine.face.shape.lip_shell import COLUMNS, cut_lip_shell, lips_besides
from abs_engine.face.shape.modal import learn
from abs_engine.io.assets import load_speaker
from abs_engine.papers.basu1998.motion import authored_motion

SPEAKER = load_speaker()
SHELL = cut_lip_shell(SPEAKER)
BETWEEN = 3
BESIDES = lips_besides(SPEAKER, BETWEEN, INSIDE)


@cache
def model_of(person: str) -> tuple[LipModel, np.ndarray]:
    """A person's lips whose modes are those of the whole surface, and the heads they are of."""
    heads = authored_motion(SPEAKER, person, frames=60).vertices(SPEAKER)
    rest = SHELL.nodes(SPEAKER.named(person))
    return lip_model(
        SPEAKER, SHELL, learn(rest, SHELL.nodes(heads) - rest), SPEAKER.named(person)
    ), heads


def surface(model: LipModel, nodes: np.ndarray) -> np.ndarray:
    """The bulge's points as drawn, of nodes that have moved."""
    count = len(model.shell) + len(model.skirt)
    moved = model.surrounded(nodes - model.physics.rest)
    return model.bulge + moved[..., count : count + len(model.bulge), :]


def rms(away: np.ndarray) -> float:
    """Root mean square distance, mm, of differences (..., 3)."""
    return float(np.sqrt((away**2).sum(axis=-1).mean()))


@pytest.mark.parametrize("lip", ["upper_lip", "lower_lip"])
def test_a_lip_ends_behind_its_inner_contour(lip):
    edge, marks = (
        lip_edge(SPEAKER, lip),
        SPEAKER.vertices[SPEAKER.landmarks[f"inner_lip_{lip[:5]}"]],
    )
    facets = SPEAKER.faces[SPEAKER.facet_class == SPEAKER.class_id(lip)]
    own = SPEAKER.vertices[np.unique(facets)]
    assert np.linalg.norm(edge[:, None] - own, axis=2).min(axis=1).max() < 1e-3
    assert edge[0, 0] < -20 < 20 < edge[-1, 0]
    middle = np.abs(edge[:, 0]) < 12
    behind = np.interp(edge[middle, 0], marks[:, 0], marks[:, 2]) - edge[middle, 2]
    assert behind.min() > -0.7
    assert behind.mean() > 0.5
    assert np.linalg.norm(np.diff(edge, axis=0), axis=1).max() < 5  # one line, without leaps


def test_a_lip_that_ends_nowhere_is_named():
    """All of a head's facets lips: they end at no skin, and in closed rings if at all."""
    lower = SPEAKER.class_id("lower_lip")
    only = SPEAKER.facet_class == lower
    none = replace(SPEAKER, facet_class=np.where(only, SPEAKER.class_id("skin"), 0))
    ring = replace(SPEAKER, facet_class=np.full_like(SPEAKER.facet_class, lower))
    for speaker in (none, ring):
        with pytest.raises(MeshError, match="lower_lip end in no line"):
            lip_edge(speaker, "lower_lip")


@pytest.mark.parametrize(("person", "cut"), [("kofi", 1.0), ("clara", 0.35)])
def test_the_drawn_lips_stand_out_of_the_chords_as_the_heads_do(person, cut):
    model, heads = model_of(person)
    truth = BESIDES.at(heads)[:, INSIDE * COLUMNS :]
    nodes = SHELL.nodes(heads)
    drawn = surface(model, nodes)[:, INSIDE * COLUMNS :]
    chords = nodes[:, :COLUMNS], nodes[:, COLUMNS : 2 * COLUMNS], nodes[:, 2 * COLUMNS :]
    between = np.concatenate(
        [(1 - k / 4) * a + k / 4 * b[:, :COLUMNS] for a, b in pairwise(chords) for k in (1, 2, 3)],
        axis=1,
    )
    assert rms(between - truth) > cut
    assert rms(drawn - truth) < 0.15


@pytest.mark.parametrize("person", ["kofi", "clara"])
def test_where_the_lips_end_follows_as_it_does_on_the_head(person):
    """Kept at its distance from the inner ring, that edge is drawn half a millimetre off."""
    model, heads = model_of(person)
    truth, nodes = BESIDES.at(heads)[:, :COLUMNS], SHELL.nodes(heads)
    edge = model.bulge[:COLUMNS]
    kept = edge + (nodes - model.physics.rest)[:, :COLUMNS]
    drawn = surface(model, nodes)[:, :COLUMNS]
    assert rms(drawn - truth) < 0.8 * rms(kept - truth)
    upper, lower = slice(1, COLUMNS // 2), slice(COLUMNS // 2 + 1, None)

    def too_open(points: np.ndarray) -> float:
        off = (points - truth)[..., 1]
        return float((off[:, upper] - off[:, lower]).mean())

    assert too_open(kept) > 0.4
    assert abs(too_open(drawn)) < 0.5 * too_open(kept)


def test_rings_that_nothing_is_known_of_keep_to_the_facets():
    still = replace(SPEAKER, units=np.zeros_like(SPEAKER.units))
    chords = np.random.default_rng(0).dirichlet(np.ones(4), len(BESIDES) // COLUMNS)
    np.testing.assert_array_equal(followed(still, SHELL, BESIDES, chords), chords)


def test_lips_that_move_as_a_whole_take_all_rings_along():
    model, _ = model_of("clara")
    moved = model.surrounded(np.tile([1.0, -2, 0.5], (len(SHELL), 1)))
    np.testing.assert_allclose(moved, np.tile([1.0, -2, 0.5], (len(moved), 1)), atol=1e-12)


def test_shares_of_other_rings_are_refused():
    model, _ = model_of("clara")
    with pytest.raises(ModelFormatError, match=r"\(7, 4\) are not of 8 rings"):
        replace(model, follow=model.follow[:7])


def test_lips_are_drawn_from_where_they_end_to_the_outer_contour():
    model, _ = model_of("clara")
    scene = model.scene()
    of = np.unique(scene.faces[scene.facet_class == LIPS])
    first = len(SHELL) + len(model.skirt)
    assert set(of) == {*range(3 * COLUMNS), *range(first, first + len(model.bulge))}
    opening = np.unique(scene.faces[-COLUMNS:])
    assert set(opening) == {*range(first, first + COLUMNS), len(scene.mean) - 1}
