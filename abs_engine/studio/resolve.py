"""From a scene file to plans: everything that chance and models decide is decided here."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.arrays import FloatArray
from abs_engine.core.errors import ParameterError
from abs_engine.core.geometry import Pose, compose, pose_vectors
from abs_engine.io.assets import Speaker
from abs_engine.studio.appearance.look import Light
from abs_engine.studio.cameras import check_view, glass, lens, stand
from abs_engine.studio.cast import Cast
from abs_engine.studio.dressing import props_of
from abs_engine.studio.motion import head_poses, ramp
from abs_engine.studio.performance import perform
from abs_engine.studio.plan import ClipPlan, View
from abs_engine.studio.scenefile import (
    CameraEntry,
    ClipEntry,
    EventEntry,
    SceneFile,
    pick,
)

_AMOUNT = {"exposure": 1.8, "blur": 2.5, "leave": 420.0}


def plan_clip(
    scene: SceneFile, number: int, speaker: Speaker, cast: Cast, folder: Path, command: str
) -> ClipPlan:
    """Work out a clip of a scene that `complete` returned.

    Parameters
    ----------
    number : int
        Which of its clips.
    folder : Path
        Where the files that the scene names are looked for.
    command : str
        Kept in the ground truth.

    Raises
    ------
    ParameterError, InputFileError, ModelFormatError
        If something in the scene cannot be filmed.
    """
    entry = scene.clip[number]
    where = f"clip '{entry.name}'"
    person = cast.person(entry.speaker, where)
    seed = scene.seed + number if entry.motion.seed is None else entry.motion.seed
    rng = np.random.default_rng(seed)
    said = perform(entry, speaker, person.neutral, scene.rate, folder, rng)
    times = np.arange(len(said.weights)) / scene.rate
    events = pick("event", scene.event, entry.events, where)
    heads = head_poses(entry.motion, times, rng, said.head, _leaving(events, times))
    rotations, translations = pose_vectors(heads)
    lamps = pick("light", scene.light, entry.lights, where)
    plan = ClipPlan(
        name=entry.name, person=entry.speaker, sentence=said.text,
        command=command, seed=scene.seed, number=number,
        rate=scene.rate,
        weights=said.weights,
        identity_weights=person.identity, neutral=person.neutral,
        texture=person.texture, dots=person.dots,
        rotations=rotations, translations=translations,
        phonemes=said.phonemes, intervals=said.intervals,
        lights=lights_at(lamps, times),
        ambient=scene.ambient,
        roughness=scene.roughness,
        views=_views(scene, entry, speaker, person.neutral, heads, times, events, folder),
        props=props_of(scene, entry, speaker, person, heads),
    )  # fmt: skip
    for view in plan.views:
        check_view(plan, view)
    return plan


def lights_at(lamps: Iterable[Light], times: FloatArray) -> FloatArray:
    """Direction, intensity and RGB of lamps at times (T,), as (T, L, 7).

    Raises
    ------
    ParameterError
        As `Light.check`.
    """
    rows = []
    for lamp in lamps:
        lamp.check(times)
        rows.append(lamp.at(times))
    return np.stack(rows, axis=1) if rows else np.zeros((len(times), 0, 7))


def _leaving(events: tuple[EventEntry, ...], times: FloatArray) -> FloatArray:
    """Shift (T, 3), mm, of a head that leaves the picture and comes back, by all events."""
    out = np.zeros((len(times), 3))
    for event in events:
        if event.kind == "leave":
            way = np.array(event.direction) / np.linalg.norm(event.direction)
            share = ramp(times, event.start, event.end, event.ramp)
            out += _amount(event) * share[:, None] * way
    return out


def _amount(event: EventEntry) -> float:
    return _AMOUNT[event.kind] if event.amount is None else event.amount


def _views(
    scene: SceneFile,
    entry: ClipEntry,
    speaker: Speaker,
    neutral: NDArray[np.float32],
    heads: list[Pose],
    times: FloatArray,
    events: tuple[EventEntry, ...],
    folder: Path,
) -> tuple[View, ...]:
    cameras = pick("camera", scene.camera, entry.cameras, f"clip '{entry.name}'")
    if not cameras:
        raise ParameterError(f"clip '{entry.name}' has no camera", "name one")
    behind = scene.background
    if behind.picture:
        behind = replace(behind, picture=str(folder / behind.picture))
    views = []
    for camera in cameras:
        ideal = lens(camera, scene.size)
        stands = stand(camera, ideal, speaker, neutral)
        poses = [stands]
        if camera.mount == "head":
            poses = [compose(stands, head.inverse) for head in heads]
        rotations, translations = pose_vectors(poses)
        views.append(
            View(
                name=camera.name,
                camera=ideal,
                rotations=rotations,
                translations=translations,
                gain=_gain(camera, events, times),
                blur=_blur(camera, events, times),
                sensor=camera.sensor,
                background=behind,
                crf=camera.crf,
                mirror=None if camera.mirror is None else glass(camera.mirror, camera.name),
            )
        )
    return tuple(views)


def _gain(camera: CameraEntry, events: tuple[EventEntry, ...], times: FloatArray) -> FloatArray:
    out = np.full(len(times), camera.exposure)
    for event in _of(camera, "exposure", events):
        out *= _amount(event) ** ramp(times, event.start, event.end, event.ramp)
    return out


def _blur(camera: CameraEntry, events: tuple[EventEntry, ...], times: FloatArray) -> FloatArray:
    out = np.zeros(len(times))
    for event in _of(camera, "blur", events):
        out = np.hypot(out, _amount(event) * ramp(times, event.start, event.end, event.ramp))
    return out


def _of(camera: CameraEntry, kind: str, events: tuple[EventEntry, ...]) -> list[EventEntry]:
    return [e for e in events if e.kind == kind and (e.cameras is None or camera.name in e.cameras)]
