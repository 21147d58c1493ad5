"""Nothing is seen through an open mouth: behind parted lips something of the head is drawn."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from heads import seen_at
from runs import toy_setting

from abs_engine.core.scene import Candidates
from abs_engine.face.head import build_mouth_model
from abs_engine.fit.head_frame import mouth_window
from abs_engine.io.assets import load_speaker

SETTING = toy_setting()
SPEAKER = load_speaker()
TEXTURE = SPEAKER.texture(next(iter(SPEAKER.people)))


def head(size: float):
    """The average head, or one with a mouth as much longer behind the lips."""
    mouth = SPEAKER.vertices[SPEAKER.lip_ring].mean(axis=0)
    longer = (SPEAKER.vertices - mouth) * np.array([1.0, 1.0, size], np.float32) + mouth
    return build_mouth_model(SPEAKER, longer.astype(np.float32), TEXTURE)


@pytest.mark.parametrize("size", [1.0, 1.3])
@pytest.mark.parametrize("turn", [(0, 0, 0), (0, 0.6, 0), (0.15, 0, 0), (-0.3, -0.5, 0)])
def test_an_open_mouth_has_no_hole(size, turn):
    model = head(size)
    pose = seen_at(turn, [0, 20, 500])
    window = mouth_window(model, pose, SETTING.camera)
    scene = model.held(np.zeros(model.n_person))
    candidate = Candidates.one(model.prototypes[4], pose)
    ids = SETTING.renderer.draw(scene, candidate, SETTING.camera, window)[0].class_id
    whole = replace(model.head, mean=_posed(model))
    none = Candidates.one(np.zeros(0), pose)
    seen = SETTING.renderer.draw(whole, none, SETTING.camera, window)[0].class_id
    inside = np.isin(seen, [SPEAKER.class_id(n) for n in ("inner_mouth", "tongue")])
    assert inside.sum() > 20
    np.testing.assert_array_equal(ids[inside], seen[inside])


def _posed(model):
    moved = np.tensordot(model.prototypes[4], model.expression.modes, 1)
    return (model.expression.mean + moved).astype(np.float32)
