"""A plugin's model that makes no tracker is named."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from runs import write_noise

from abs_engine.core.errors import MeshError, PluginError
from abs_engine.core.registry import MODELS
from abs_engine.io.assets import load_speaker
from abs_engine.render.cpu import CpuRenderer
from abs_engine.tracking.models.heads import prepare_head
from abs_engine.tracking.options import TrackOptions
from abs_engine.tracking.run import prepare


@pytest.fixture
def prepared(tmp_path, request):
    """Prepares a clip with a function for its model."""

    def by(make):
        MODELS.add("mine", make)
        request.addfinalizer(lambda: MODELS._added.pop("mine", None))
        video = write_noise(tmp_path / "noise.mp4")
        return prepare(video, CpuRenderer(), TrackOptions(model="mine"))

    return by


@pytest.mark.parametrize(
    ("make", "said"),
    [
        (
            lambda *_: None,
            "the model 'mine' returns an object of type NoneType; return a ClipTracker",
        ),
        (lambda *_: 1 / 0, "'mine' fails (ZeroDivisionError: division by zero) in test_plugin_m"),
        (lambda clip: None, "the model 'mine' fails (TypeError: "),
    ],
)
def test_a_model_that_makes_no_tracker_is_named(make, said, prepared):
    with pytest.raises(PluginError) as caught:
        prepared(make)
    assert said in str(caught.value)


@pytest.mark.parametrize("names", [["skin"], ["upper_lip", "lower_lip"]])
def test_a_head_without_skin_or_lips_is_refused(names, prepared):
    head = load_speaker()
    kept = ~head.facets_of(*names)
    broken = replace(head, faces=head.faces[kept], facet_class=head.facet_class[kept])
    with pytest.raises(MeshError, match=f"the head has no facets of {', '.join(names)}; correct"):
        prepared(lambda *given: prepare_head(*given, broken))


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda vertices: vertices * np.nan, "vertices that are not all finite; correct the model"),
        (
            lambda vertices: vertices[:100],
            r"100 vertices, but its facets need \d+; correct the model",
        ),
        (lambda vertices: vertices * 10, r"the outer corners of its eyes \d+ mm apart; correct"),
    ],
)
def test_a_head_that_is_none_is_refused(change, said, prepared):
    head = load_speaker()
    broken = replace(head, vertices=change(head.vertices))
    with pytest.raises(MeshError, match=f"the head has {said}"):
        prepared(lambda *given: prepare_head(*given, broken))
