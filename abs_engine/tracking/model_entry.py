"""Models that can be tracked, also those of plugins: what each refuses, and how it is prepared."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

import numpy as np

from abs_engine.core.errors import ParameterError, PluginError
from abs_engine.core.foreign import blamed, own
from abs_engine.core.registry import MODELS
from abs_engine.core.scene import Renderer
from abs_engine.tracking.options import STARTS, Clip, ClipTracker, Leaves, Tell, TrackOptions


class Prepare(Protocol):
    """Makes a clip ready for one kind of face."""

    def __call__(
        self, clip: Clip, options: TrackOptions, leaves: Leaves, renderer: Renderer, stage: Tell, /
    ) -> ClipTracker:
        """Find the face, and learn what is to be learned of it."""
        ...


Check = Callable[[TrackOptions, Leaves], None]
"""Refuses what does not go together, before anything is done."""


@dataclass(frozen=True)
class Model:
    """Model that can be tracked: an entry of `core.registry.MODELS`.

    Parameters
    ----------
    prepare : Prepare
        How a clip is made ready.
    starts : tuple of str
        How its head may be found, of `STARTS`.
    without : tuple of str
        Options that do nothing for it.
    check : callable, optional
        Raises `ParameterError` for what does not go together with it or its file, before a renderer
        is opened; by default `Leaves.check` alone is asked.
    """

    prepare: Prepare
    starts: tuple[str, ...] = STARTS
    without: tuple[str, ...] = ()
    check: Check | None = None

    def __call__(
        self, clip: Clip, options: TrackOptions, leaves: Leaves, renderer: Renderer, stage: Tell, /
    ) -> ClipTracker:
        """Make a clip ready."""
        return self.prepare(clip, options, leaves, renderer, stage)


def own_file(options: TrackOptions, face: str, example: str) -> Path:
    """File of a face that is a person's own.

    Raises
    ------
    ParameterError
        If none is given; `face` says which face has one, `example` is the name of such a file.
    """
    if options.model_file is None:
        raise ParameterError(face, f"give its file: --model {example}")
    return options.model_file


def model_named(name: str) -> Model:
    """The model of a name; one that is a function alone takes every start and option.

    Raises
    ------
    ParameterError
        If there is none.
    PluginError
        If it cannot be imported.
    """
    entry = MODELS.get(name)
    return entry if isinstance(entry, Model) else Model(entry)


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
