"""A model that may be a plugin's: it is asked what it refuses, and makes a clip ready."""

from __future__ import annotations

import numpy as np

from abs_engine.core.errors import PluginError
from abs_engine.core.foreign import blamed, own
from abs_engine.core.scene import Renderer
from abs_engine.tracking.model_entry import Model, Prepare
from abs_engine.tracking.options import Clip, ClipTracker, Leaves, Tell, TrackOptions


def check_model(model: Prepare, options: TrackOptions, leaves: Leaves) -> None:
    """Refuse what a model cannot track, before anything is done; no option is left open.

    Raises
    ------
    AbsEngineError
        If something does not go together, or a plugin's check fails.
    """
    if not isinstance(model, Model):  # a preset's own, of which no more is known
        leaves.check("")
        return
    check = model.check
    if check is None:
        leaves.check(options.model or "")
    elif own(check):
        check(options, leaves)
    else:
        with blamed(f"the check of the model '{options.model}'"):
            check(options, leaves)


def made_ready(
    model: Prepare,
    clip: Clip,
    options: TrackOptions,
    leaves: Leaves,
    renderer: Renderer,
    tell: Tell,
) -> ClipTracker:
    """A clip made ready by the model that `options` name.

    Raises
    ------
    PluginError
        If it is a plugin's and fails, or makes no tracker of a head whose vertices are finite.
    """
    if own(model.prepare if isinstance(model, Model) else model):
        return model(clip, options, leaves, renderer, tell)
    name = f"the model '{options.model}'"
    with blamed(name):
        made: object = model(clip, options, leaves, renderer, tell)
    if not isinstance(made, ClipTracker):
        raise PluginError(
            f"{name} returns an object of type {type(made).__name__}",
            "return a ClipTracker, as prepare_head does",
        )
    if not np.isfinite(made.setting.face.body.mean).all():
        raise PluginError(
            f"{name} makes a head whose vertices are not all finite", "correct its plugin"
        )
    return made
