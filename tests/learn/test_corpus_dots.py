"""Dots of a corpus: where they may be put, and what they are called."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.distance import pdist

from abs_engine.capture.corpus import Corpus
from abs_engine.core.geometry import vertex_normals
from abs_engine.io.assets import load_speaker
from abs_engine.learn.articulatory import build
from abs_engine.learn.corpus_dots import SKULL, corpus_dots
from abs_engine.studio.corpus import PAPER_VISEMES, viseme_weights
from abs_engine.studio.people import Person, dots

SPEAKER = load_speaker()


@pytest.fixture(scope="module")
def worn():
    return corpus_dots(SPEAKER)


def of(worn, group):
    return worn.vertices[[worn.names.index(name) for name in worn.groups[group]]]


def test_they_are_apart_and_face_the_cameras(worn):
    place = SPEAKER.vertices.astype(np.float64)
    assert pdist(place[worn.vertices]).min() > 2.0
    assert vertex_normals(place, SPEAKER.faces)[worn.vertices, 2].min() > 0.3
    np.testing.assert_array_equal(
        dots(SPEAKER, Person("x", "clara", beads="corpus")).vertices, worn.vertices
    )


def test_speech_moves_all_but_the_skull(worn):
    neutral = SPEAKER.named("clara")
    weights = np.array([viseme_weights(SPEAKER, neutral, v) for v in ("a", "i", "u", "ipi")])
    moved = np.linalg.norm(np.tensordot(weights, SPEAKER.units.astype(float), 1), axis=2).max(0)
    assert moved[of(worn, SKULL)].max() < 0.2
    assert moved[of(worn, "lips")].min() > 1.0


def test_the_papers_predictors_find_their_groups(worn):
    """Without a tooth: the jaw line stands for both."""
    neutral = SPEAKER.named("clara")
    weights = np.array([viseme_weights(SPEAKER, neutral, v) for v in PAPER_VISEMES[:20]])
    units = SPEAKER.units[:, worn.vertices].astype(float)
    points = neutral[worn.vertices] + np.tensordot(weights, units, 1)
    built = build(Corpus(points, worn.names, PAPER_VISEMES[:20], worn.groups))
    assert worn.groups["lower_teeth"] == ()
    assert built.model.parameters[0] == "jaw1"
    assert built.viseme_errors.max() < 0.6
