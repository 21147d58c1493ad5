"""Lips of learned physics made ready for a clip: the mouth's own size and shape fitted at first."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from abs_engine.compare.facets import FacetLikelihood
from abs_engine.core.arrays import FloatArray, IntArray
from abs_engine.core.errors import ParameterError
from abs_engine.core.pose import mode_block
from abs_engine.core.scene import Renderer, Scene
from abs_engine.face.appearance.colour import ColourClasses
from abs_engine.face.base import INNER, RINGS, Body, Face
from abs_engine.face.head import colour_classes
from abs_engine.face.rings import lip_rings
from abs_engine.face.shape.lip_model import COLOUR_OF, LipModel, lip_model
from abs_engine.face.shape.lip_shell import COLUMNS, LipShell, cut_lip_shell
from abs_engine.face.shape.modal import LearnedPhysics, load_physics
from abs_engine.face.shape.physics_head import physics_shape
from abs_engine.fit.head_frame import contact_of
from abs_engine.fit.settings import SHELL_FIT
from abs_engine.fit.shell import ShellSetting, shell_colours
from abs_engine.fit.view import View
from abs_engine.io.assets import Speaker, load_speaker, shipped
from abs_engine.learn.training import check_speaker
from abs_engine.tracking.frame.blob_motion import BlobMotion
from abs_engine.tracking.frame.mouth_landmarks import MouthLandmarks
from abs_engine.tracking.frame.shell_frame import ShellBinder
from abs_engine.tracking.models.heads import prepare_head
from abs_engine.tracking.options import BLOBS, Clip, ClipTracker, Leaves, Tell, TrackOptions
from abs_engine.tracking.person.identity_fit import POSE_DEVIATION
from abs_engine.tracking.settings.blobs import BLOB_START

BY_BLOB = np.array(BLOB_START.by_blob)
NO_LIPS = "lips not found"
BUNDLED = "lips/lips.npz"


def prepare_shell(
    clip: Clip, options: TrackOptions, leaves: Leaves, renderer: Renderer, tell: Tell
) -> ClipTracker:
    """Find the mouth, learn its colours and fit its size and shape; then the shell takes over.

    A head is fitted to some frames first; the shell is cut from it at rest. Its physics is that of
    `options.physics`, or of the bundled lips.

    Raises
    ------
    AbsEngineError
        As `heads.prepare_head`; and if the physics cannot be read, or is of another head.
    """
    leaves.check("shell")
    speaker = load_speaker(options.speaker)
    physics = load_physics(_path(options))
    check_speaker(physics, speaker)
    plain = Leaves.of(replace(options, terms=("colour",), driver="simplex"))
    by_blobs = options.start == BLOBS and options.poses is None
    own = replace(options, physics=_path(options) if options.from_landmarks else None)
    base = prepare_head(clip, own, plain, renderer, tell)
    head, marks = base.setting.face, base.setting.landmarks
    classes: ColourClasses = head.learned("colour")
    if by_blobs and not classes.chromatic:
        raise ParameterError(
            f"{clip.video} has no colour, and lips are followed as a blob by theirs",
            "leave out --start blobs and the preset",
        )
    tell("cutting the shell")
    rest = head.body.mean if head.body.rest is None else head.body.rest
    lips = person_lips(speaker, cut_lip_shell(speaker), physics, rest)
    free = None if base.setting.pose_held else BY_BLOB if by_blobs else POSE_DEVIATION
    scene = _with_marks(speaker, lips, rest)
    shell = ShellSetting(lips, scene, classes, clip.camera, renderer, free)
    face = shell_face(speaker, lips, scene, rest, shell, head).looking(colour=classes)
    touching = contact_of(scene, face.rings, np.zeros(lips.n_modes))
    binder = ShellBinder(
        shell, face, leaves.kinds, marks or MouthLandmarks(lips.n_modes), priors=(touching,)
    )
    setting = replace(base.setting, face=face, binder=binder, driver=leaves.driver.minimiser())
    if by_blobs:
        motion = BlobMotion(classes, clip.info.rate, clip.camera, face.pivot, base.setting.motion)
        setting = replace(setting, motion=motion, visibility=None, why_lost=NO_LIPS)
    return replace(base, setting=setting)


def _path(options: TrackOptions) -> Path:
    """The file of the physics."""
    return options.model_file or options.physics or shipped(BUNDLED)


def person_lips(
    speaker: Speaker, shell: LipShell, physics: LearnedPhysics, rest: NDArray[np.float32]
) -> LipModel:
    """Lips of a person whose head at rest is (V, 3) mm, that move as others' were learned to."""
    return lip_model(speaker, shell, replace(physics, rest=shell.nodes(rest)), rest)


def shell_face(
    speaker: Speaker,
    lips: LipModel,
    scene: Scene,
    rest: NDArray[np.float32],
    setting: ShellSetting,
    head: Face,
) -> Face:
    """The face of a shell: what is drawn is the shell, what is written the head about it.

    The head, at rest (V, 3), mm, moves by the face units that come nearest to each mode, see
    `physics_shape`. `head` is what the whole head is tracked as: who was fitted, and the person
    without expression.
    """
    marks = lip_rings(speaker)  # one ring after the other, at the scene's end
    ends = np.cumsum([len(at) for at in marks.values()])
    ends += len(scene.mean) - ends[-1]
    rings = {
        name: np.arange(end - len(at), end)
        for (name, at), end in zip(marks.items(), ends, strict=True)
    }
    moved = physics_shape(speaker, rest, lips.shell, lips.physics)
    contour = np.concatenate([marks[name] for name in RINGS]).astype(np.int32)
    classes = speaker.facet_class.astype(np.int32)
    body = Body(
        moved.mean, moved.modes, speaker.faces, classes, colour_classes(speaker), contour,
        head.body.rest,
    )  # fmt: skip

    def colours(_face: Face, view: View) -> FacetLikelihood:
        return shell_colours(setting, view.image, view.frame.base)

    return Face(
        "shell", scene, mode_block(lips.n_modes, SHELL_FIT.mode_limit),
        setting.border.mean(axis=0), rings,
        setting.border, _starts(lips.n_modes), COLOUR_OF, body, head.identity,
        own_terms={"colour": colours},
    )  # fmt: skip


def _with_marks(speaker: Speaker, lips: LipModel, rest: NDArray[np.float32]) -> Scene:
    """The shell's scene, and after its vertices the head's marks of the lips, which no facet has.

    Each mark is where it is on the head at rest, and moves with the nearest node of its contour.
    """
    scene, marks = lips.scene(), lip_rings(speaker)
    led = np.concatenate([_leading(speaker, lips, at, name) for name, at in marks.items()])
    at_rest = rest[np.concatenate(list(marks.values()))].astype(np.float64)
    own = at_rest + (scene.mean[led] - lips.physics.rest[led])
    return Scene(
        np.vstack([scene.mean, own]).astype(np.float32),
        np.concatenate([scene.modes, scene.modes[:, led]], axis=1), scene.faces,
        np.vstack([scene.uv, np.zeros((len(led), 2), np.float32)]), scene.facet_class,
        scene.texture,
    )  # fmt: skip


def _leading(
    speaker: Speaker, lips: LipModel, vertices: NDArray[np.int32], name: str
) -> NDArray[np.int32]:
    """The node of the shell's inner or outer contour that lies nearest to each vertex (N,)."""
    at_rest = lips.shell.nodes(speaker.vertices)
    inner, outer = np.arange(COLUMNS), np.arange(2 * COLUMNS, 3 * COLUMNS)
    places = speaker.vertices[vertices].astype(np.float64)
    if name == "points":
        first = [_nearest(at_rest, outer, places[:INNER]), _nearest(at_rest, inner, places[INNER:])]
        return np.concatenate(first)
    return _nearest(at_rest, outer if name in ("outer", "corners") else inner, places)


def _nearest(nodes: FloatArray, pool: IntArray, places: FloatArray) -> NDArray[np.int32]:
    away = np.linalg.norm(nodes[pool][None] - places[:, None], axis=2)
    return np.asarray(pool[away.argmin(axis=1)], np.int32)


def _starts(modes: int) -> FloatArray:
    """Postures (K, P) to start from where nothing is known: the mean, and off it in some modes."""
    moves = [
        s * np.eye(modes)[k]
        for k in range(min(BLOB_START.started_modes, modes))
        for s in BLOB_START.starts
    ]
    return np.vstack([np.zeros(modes), *moves])
