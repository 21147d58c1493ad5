"""Fills a scene file's defaults in, and checks what its parts say of each other."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import TypeVar

import numpy as np

from abs_engine.core.errors import ParameterError
from abs_engine.dataset import SUMS, codec
from abs_engine.studio.appearance.look import FILL, KEY, Light
from abs_engine.studio.scenefile.reader import nearest
from abs_engine.studio.scenefile.scene import ClipEntry, SceneFile
from abs_engine.studio.scenefile.values import CameraEntry, EventEntry, OccluderEntry

Named = TypeVar("Named", CameraEntry, Light, OccluderEntry, EventEntry, ClipEntry)
_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9_.-]*")
_TAKEN = {
    "clip": {codec.DATASET, codec.SCENE, codec.README, SUMS},
    "camera": {codec.TRUTH, codec.VERTICES},
}
"""Names that a dataset's own files, or those of a clip's folder, have."""
SMALLEST, LARGEST = 16, 8192
"""Sides of pictures that can be filmed, pixels."""
FASTEST = 1000
"""Frames per second that can be filmed."""


def check_size(size: tuple[int, int]) -> None:
    """Raise `ParameterError` for pictures that cannot be filmed."""
    if size[0] % 2 or size[1] % 2:
        raise ParameterError(f"H.264 has no pictures of {size[0]}x{size[1]}", "give even sizes")
    if not all(SMALLEST <= side <= LARGEST for side in size):
        raise ParameterError(
            f"pictures of {size[0]}x{size[1]} cannot be filmed",
            f"give sides of {SMALLEST} to {LARGEST} pixels",
        )


def complete(scene: SceneFile) -> SceneFile:
    """A scene with its defaults filled in: cameras, lights, clips and all names.

    Raises
    ------
    ParameterError
        If a name is given twice, is one of the dataset's own, makes no file name, or means
        nothing; the nearest is named. If the rate, a size, a time or another number is impossible.
    """
    if not 0 < scene.rate <= FASTEST:
        raise ParameterError(
            f"a rate of {scene.rate:g} frames per second",
            f"give a rate above 0, of {FASTEST} at most",
        )
    check_size(scene.size)
    if scene.shirt is True:
        raise ParameterError("shirt = true names no colour", "give [r, g, b] or false")
    clips = scene.clip or (ClipEntry(),)
    scene = replace(
        scene,
        camera=scene.camera or (CameraEntry(),),
        light=scene.light or (KEY, FILL),
        occluder=tuple(replace(o, name=o.name or o.kind) for o in scene.occluder),
        event=tuple(replace(e, name=e.name or e.kind) for e in scene.event),
        clip=tuple(replace(c, name=c.name or f"clip-{n}") for n, c in enumerate(clips, start=1)),
    )
    for kind in ("speaker", "camera", "light", "occluder", "event", "clip"):
        _check_names(kind, [entry.name for entry in getattr(scene, kind)])
    for event in scene.event:
        _check_event(event)
        pick("camera", scene.camera, event.cameras, f"event '{event.name}'")
    for what, values, most in _ranges(scene):
        if not all(0 <= value <= most for value in values):
            given = ", ".join(f"{value:g}" for value in values)
            wanted = "0 or more" if most == np.inf else f"0 to {most:g}"
            raise ParameterError(f"{what} is {given}", f"give {wanted}")
    return scene


def _ranges(scene: SceneFile) -> Iterator[tuple[str, Sequence[float], float]]:
    """Numbers that may not be below zero: of what, they themselves, and the most that they may be.

    The parts of a scene that check themselves, such as lights, are not among them.
    """
    yield "the seed", [scene.seed], np.inf
    yield "ambient", [scene.ambient], np.inf
    yield "roughness", [scene.roughness], 1
    yield "the colour of the shirt", scene.shirt if isinstance(scene.shirt, tuple) else (), 1
    for camera in scene.camera:
        yield f"the exposure of camera '{camera.name}'", [camera.exposure], np.inf
        yield f"the crf of camera '{camera.name}'", [camera.crf], 51
    for speaker in scene.speaker:
        yield f"the seed of speaker '{speaker.name}'", [speaker.seed or 0], np.inf
    for occluder in scene.occluder:
        yield f"the seed of occluder '{occluder.name}'", [occluder.seed], np.inf
        yield f"the colour of occluder '{occluder.name}'", occluder.colour or (), 255
    for clip in scene.clip:
        yield f"the motion's seed of clip '{clip.name}'", [clip.motion.seed or 0], np.inf
        yield f"the motion's amount of clip '{clip.name}'", [clip.motion.amount], np.inf


def _check_names(kind: str, names: Sequence[str]) -> None:
    for name in names:
        if not _NAME.fullmatch(name):
            raise ParameterError(
                f"[[{kind}]] has the name '{name}'", "use letters, digits, '_', '-' and '.'"
            )
        if name.lower() in {taken.lower() for taken in _TAKEN.get(kind, ())}:
            raise ParameterError(
                f"[[{kind}]] has the name '{name}', which a file of the dataset has", "rename it"
            )
        if names.count(name) > 1:
            raise ParameterError(
                f"there are {names.count(name)} [[{kind}]] named '{name}'", "rename one"
            )


def _check_event(event: EventEntry) -> None:
    if not 0 <= event.start < event.end or event.ramp < 0:
        raise ParameterError(
            f"event '{event.name}' lasts from {event.start:g} to {event.end:g} s",
            "let it start at 0 or later and end after that, with a ramp of 0 or more",
        )
    if (event.amount is not None and event.amount < 0) or not np.any(event.direction):
        raise ParameterError(
            f"event '{event.name}' has a negative amount or no direction",
            "give an amount of 0 or more, and a direction that is not 0, 0, 0",
        )


def pick(
    kind: str, entries: tuple[Named, ...], names: tuple[str, ...] | None, where: str
) -> tuple[Named, ...]:
    """Entries of those names, by default all.

    Raises
    ------
    ParameterError
        If there is no such entry; the nearest is named.
    """
    if names is None:
        return entries
    known = {entry.name: entry for entry in entries}
    for name in names:
        if name not in known:
            raise ParameterError(
                f"{where} names the {kind} '{name}', which does not exist{nearest(name, known)}",
                f"known: {', '.join(known) or 'none'}",
            )
    return tuple(known[name] for name in names)
