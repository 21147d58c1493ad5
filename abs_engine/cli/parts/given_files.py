"""Options of tracking as they were typed, and their files, read before a renderer is opened."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from abs_engine.cli.parts.command import Chosen

if TYPE_CHECKING:
    from abs_engine.tracking.options import TrackOptions


def track_options(chosen: Chosen) -> TrackOptions:
    """Options of the command line, as the tracker takes them.

    Raises
    ------
    InputFileError, ModelFormatError
        If the camera's file cannot be read.
    """
    from abs_engine.dataset import load_camera
    from abs_engine.tracking.options import TrackOptions

    names = TrackOptions.__dataclass_fields__.keys() & vars(chosen).keys()
    options = TrackOptions(**{name: getattr(chosen, name) for name in names - {"camera"}})
    return options if chosen.camera is None else replace(options, camera=load_camera(chosen.camera))


def check_files(options: TrackOptions) -> None:
    """Read what was given, so that what is wrong is refused before a renderer is opened."""
    from abs_engine.face.appearance.colour import ColourClasses
    from abs_engine.face.shape.modal import load_physics
    from abs_engine.io.assets import load_speaker
    from abs_engine.tracking.presets import resolved
    from abs_engine.tracking.runs.poses_file import read_poses

    options, _ = resolved(options)  # a model's file may be the head
    if options.person is not None or options.speaker is not None:
        speaker = load_speaker(options.speaker)
        speaker.named(options.person or next(iter(speaker.people)))
    colours, physics = (options.colours, ColourClasses.load), (options.physics, load_physics)
    for path, read in (colours, physics, (options.poses, read_poses)):
        if path is not None:
            read(path)
