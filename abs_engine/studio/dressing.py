"""Dressing of a scene: a shirt, and what comes before the mouth."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.arrays import BoolArray
from abs_engine.core.errors import ParameterError
from abs_engine.core.geometry import Pose, compose, pose_vectors
from abs_engine.dataset.codec import BOARD, HAND, MICROPHONE
from abs_engine.io.assets import Speaker
from abs_engine.studio.cast import Actor
from abs_engine.studio.plan import Prop
from abs_engine.studio.prop_mesh import Prop as Mesh
from abs_engine.studio.props import Occluder, clear_of, mouth_of
from abs_engine.studio.scenefile import ClipEntry, OccluderEntry, SceneFile, pick
from abs_engine.studio.torso import shirt

_CODE = {"hand": HAND, "microphone": MICROPHONE, "board": BOARD}
_STILL = np.zeros(3)


def props_of(
    scene: SceneFile, entry: ClipEntry, speaker: Speaker, person: Actor, heads: list[Pose]
) -> tuple[Prop, ...]:
    """The shirt and what comes before the mouth; a hand has the skin of the face."""
    props, skin = [], skin_of(speaker, person.texture)
    if not isinstance(scene.shirt, bool):
        props.append(shirt(speaker, person.neutral, heads, scene.shirt))
    for occluder in pick("occluder", scene.occluder, entry.occluders, f"clip '{entry.name}'"):
        if occluder.kind == "hand" and occluder.colour is None:
            occluder = replace(occluder, colour=skin)
        props.append(_occluder(occluder, speaker, person.neutral, heads, scene.rate))
    return tuple(props)


def skin_of(speaker: Speaker, texture: NDArray[np.uint8]) -> tuple[int, int, int]:
    """The median colour of a face, sRGB."""
    place = speaker.uv[speaker.points["face"]] * texture.shape[0]
    column, row = np.clip(place.astype(int), 0, texture.shape[0] - 1).T
    red, green, blue = (int(v) for v in np.median(texture[row, column], axis=0))
    return red, green, blue


def _occluder(
    entry: OccluderEntry,
    speaker: Speaker,
    neutral: NDArray[np.float32],
    heads: list[Pose],
    rate: float,
) -> Prop:
    try:
        occluder = Occluder(entry)
    except ParameterError as error:
        raise ParameterError(f"occluder '{entry.name}': {error.problem}", error.remedy) from error
    occluder = clear_of(occluder, speaker, neutral)
    mouth, mesh = mouth_of(speaker, neutral), occluder.prop()
    first = heads[min(max(round(entry.start * rate), 0), len(heads) - 1)]
    poses, present = [], []
    for frame, head in enumerate(heads):
        own = occluder.pose_at(frame / rate, mouth)
        present.append(own is not None)
        base = head if entry.follows else first
        poses.append(compose(base, own) if own is not None else Pose(np.eye(3), _STILL))
    return prop_of(_CODE[entry.kind], mesh, poses, np.array(present))


def prop_of(code: int, mesh: Mesh, poses: list[Pose], present: BoolArray) -> Prop:
    """A mesh in its pose in each frame, (T,), its own frame to world."""
    rotations, translations = pose_vectors(poses)
    colour = np.asarray((mesh.colours / 255) ** 2.2, np.float32)  # sRGB, nearly
    return Prop(
        code, mesh.vertices, mesh.faces, mesh.normals, colour, rotations, translations, present
    )
