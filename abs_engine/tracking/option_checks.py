"""Options of tracking that do not go together, or not with the video, are refused."""

from __future__ import annotations

import numpy as np

from abs_engine.core.camera import Camera
from abs_engine.core.errors import ParameterError
from abs_engine.core.registry import nearest
from abs_engine.io.video import VideoInfo
from abs_engine.tracking.frame.mouth_landmarks import EVIDENCE
from abs_engine.tracking.frame.mouth_landmarks import LANDMARKS as ALONE
from abs_engine.tracking.model_entry import Model, check_model, model_named
from abs_engine.tracking.options import BLOBS, LANDMARKS, STARTS, Leaves, TrackOptions
from abs_engine.tracking.person.scale import pupil_scale
from abs_engine.tracking.presets import resolved
from abs_engine.tracking.results.smoothing import Smoothing

DEFAULTS = TrackOptions()


def check_options(options: TrackOptions, info: VideoInfo) -> None:
    """Raise `ParameterError` for a mouth outside of the picture or another picture's camera.

    And for a mouth beside poses, which say where it is, and a filter that the frames do not allow.
    """
    check_camera(options.camera, info.size)
    check_choices(options)
    if options.smooth is not None:
        Smoothing.named(options.smooth).check(info.rate, np.asarray(info.times))
    if options.mouth is None:
        return
    if options.poses is not None:
        raise ParameterError("head poses say where the mouth is", "leave out --mouth, or --poses")
    x, y, width, height = options.mouth
    right, bottom = info.size
    if not (
        width > 0 and height > 0 and 0 <= x < x + width <= right and 0 <= y < y + height <= bottom
    ):
        raise ParameterError(
            f"the mouth {x:g} {y:g} {width:g} {height:g} is not in the picture",
            f"give left, top, width and height within {right}x{bottom} pixels",
        )


def check_camera(camera: Camera | None, size: tuple[int, int]) -> None:
    """Raise `ParameterError` if a camera that is given is of another picture than the video's."""
    if camera is not None and camera.size != size:
        raise ParameterError(
            "the camera has {}x{} pixels, the video {}x{}".format(*camera.size, *size),
            "give the camera.json of this video, as it is shown: upright, with square pixels",
        )


def check_choices(options: TrackOptions) -> None:
    """Refuse what does not go together, whatever the video.

    So what only a start by landmarks can do, beside another start, and evidence that the model has
    nothing for. Of a model's file, no more is read than that takes.

    Raises
    ------
    InputFileError, ModelFormatError
        If the model's file cannot be read.
    ParameterError
        If something does not go together.
    PluginError
        If what is chosen cannot be imported.
    """
    pupil_scale(options.pupil_distance)
    if options.smooth is not None:
        Smoothing.named(options.smooth)
    for name, value, known in (
        ("start", options.start or STARTS[0], STARTS),
        ("evidence", options.evidence, EVIDENCE),
    ):
        if value not in known:
            raise ParameterError(f"there is no {name} '{value}'", nearest(value, known))
    if options.face is not None and options.face < 1:
        raise ParameterError(f"there is no face {options.face}", "faces are counted from 1")
    chosen, prepare = resolved(options)
    leaves = Leaves.of(chosen)
    model = model_named(chosen.model or "")
    _check_taken(model, options, chosen.model or "")
    _check_placed(model, options, chosen)
    check_model(prepare, chosen, leaves)


def _check_placed(model: Model, options: TrackOptions, chosen: TrackOptions) -> None:
    """Raise `ParameterError` for what does nothing for how the face is found, or says it twice.

    `chosen` are the options with nothing left open.
    """
    by = "--start blobs" if options.start == BLOBS else f"--preset {options.preset}"
    placed = {
        "--person": options.person is not None,
        "--model": options.model is not None and LANDMARKS not in model.starts,
        by: chosen.start == BLOBS,
    }
    other = next((name for name, given in placed.items() if given), None)
    asked = {
        "--face": options.face is not None,
        "--pupil-distance": options.pupil_distance is not None,
        "--evidence": options.evidence != DEFAULTS.evidence,
    }
    for name, given in asked.items():
        if given and other is not None:
            raise ParameterError(
                f"{name} has no effect with {other}", f"leave out {name}, or {other}"
            )
    if options.driver is not None and options.evidence == ALONE:
        raise ParameterError(
            f"--driver has no effect with --evidence {ALONE}", "leave out --driver, or --evidence"
        )
    if options.face is not None and options.poses is not None:
        raise ParameterError("head poses say which face is meant", "leave out --face, or --poses")
    if options.face is not None and options.mouth is not None:
        raise ParameterError("--mouth says which face is meant", "leave out --face, or --mouth")


def _check_taken(model: Model, options: TrackOptions, name: str) -> None:
    """Raise `ParameterError` for an option that does nothing for a model."""
    if options.start is not None and options.start not in model.starts:
        raise ParameterError(
            f"the model '{name}' does not start from {options.start}", "leave out --start"
        )
    for option in model.without:
        if getattr(options, option) != getattr(DEFAULTS, option):
            raise ParameterError(
                f"--{option.replace('_', '-')} does nothing for the model '{name}'",
                f"leave out --{option.replace('_', '-')}",
            )
