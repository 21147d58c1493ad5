"""Files that tracking is given, read before a renderer is opened."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from abs_engine.tracking.options import TrackOptions


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
