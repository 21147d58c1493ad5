"""The studio: films people who say something, and writes video and ground truth.

The pictures come from pyrender in processes of their own, so a tracker is never tested on pictures
from its own renderer. All draws of chance take one seed: the same scene gives the same truth and,
before compression, the same pixels, however many processes film it.
"""

from __future__ import annotations

import hashlib
from pathlib import Path

import numpy as np

from abs_engine.core.camera import Camera
from abs_engine.core.geometry import FACING, Pose, pose_vectors
from abs_engine.core.kinds import check_kind, is_of, to_path
from abs_engine.core.provenance import code_digest
from abs_engine.io.assets import Speaker, load_speaker
from abs_engine.studio.appearance.look import Look
from abs_engine.studio.cameras import check_view
from abs_engine.studio.cast import NO_DOTS, Cast
from abs_engine.studio.make import Crew, Filmed, Order, make
from abs_engine.studio.plan import ClipPlan, View
from abs_engine.studio.resolve import lights_at, plan_clip
from abs_engine.studio.scenefile import SceneFile, check_size, complete, scene_text
from abs_engine.studio.sequence import Sequence
from abs_engine.studio.torso import shirt


def film_scene(
    scene: SceneFile,
    folder: Path,
    *,
    beside: Path = Path(),
    command: str = "",
    crew: Crew | None = None,
) -> Filmed:
    """Film a scene and write a data set (see `abs_engine.dataset`).

    An unfinished data set of the same scene beside `folder` is continued.

    Parameters
    ----------
    folder : Path
        Must not exist; it appears when everything is written.
    beside : Path
        Folder of the scene file, where the files that it names are looked for.
    command : str
        Kept in the ground truth.
    crew : Crew, optional
        By default one process for each core, and nothing is kept of what fails.

    Raises
    ------
    ParameterError, InputFileError, ModelFormatError
        If something in the scene cannot be filmed.
    OutputError
        If the folder exists or cannot be written, or an unfinished data set of another scene lies
        beside it; `SameOutputError` if it is this data set, whole.
    StudioError
        If pyrender cannot draw on this machine.
    KeyboardInterrupt
        If interrupted; its text says what was kept.
    """
    check_kind("scene", scene, (is_of(SceneFile), "a SceneFile, as read_scene returns"))
    folder = to_path("folder", folder)
    scene, speaker = complete(scene), load_speaker()
    text = scene_text(scene)
    order = Order(
        command, scene.seed, scene.labels, scene.frames, text, _digest(scene, text, beside, command)
    )
    cast = Cast(speaker, scene.speaker)
    cast.check(scene.clip)
    plans = (
        plan_clip(scene, number, speaker, cast, beside, command)
        for number in range(len(scene.clip))
    )
    return make(plans, len(scene.clip), folder, speaker, order, crew or Crew())


def plan_of(
    speaker: Speaker,
    sequence: Sequence,
    camera: Camera,
    look: Look,
    seed: int = 0,
    command: str = "",
) -> ClipPlan:
    """The plan of a sequence before a camera that stands at the origin of the world.

    Raises
    ------
    ParameterError
        If the camera cannot film it.
    """
    check_size(camera.size)
    neutral = speaker.named(sequence.person)
    stands = Pose(FACING, np.zeros(3))
    heads = [
        Pose(FACING.T @ pose.rotation, FACING.T @ pose.translation)
        for pose in map(sequence.pose, range(len(sequence)))
    ]
    times = np.arange(len(sequence)) / sequence.rate
    rotations, translations = pose_vectors(heads)
    view_rotations, view_translations = pose_vectors([stands])
    plan = ClipPlan(
        name="clip",
        person=sequence.person,
        sentence=sequence.text,
        command=command,
        seed=seed,
        number=0,
        rate=sequence.rate,
        weights=sequence.weights,
        identity_weights=speaker.people[sequence.person],
        neutral=neutral,
        texture=speaker.texture(sequence.person),
        dots=NO_DOTS,
        rotations=rotations,
        translations=translations,
        phonemes=sequence.visemes,
        intervals=sequence.intervals,
        lights=lights_at(look.lights, times),
        ambient=look.ambient,
        roughness=look.roughness,
        views=(
            View(
                "camera", camera, view_rotations, view_translations,
                np.ones(len(times)), np.zeros(len(times)), look.sensor, look.background,
            ),
        ),
        props=() if look.shirt is None else (shirt(speaker, neutral, heads, look.shirt),),
    )  # fmt: skip
    check_view(plan, plan.views[0])
    return plan


def _digest(scene: SceneFile, text: str, beside: Path, command: str) -> str:
    """Digest of all that a data set follows from."""
    named = [clip.textgrid or clip.arkit for clip in scene.clip]
    seen = hashlib.sha256(f"{code_digest()}\n{command}\n{text}".encode())
    for name in [*named, scene.background.picture]:
        path = beside / name if name else None
        if path is not None and path.is_file():
            seen.update(path.read_bytes())
    return seen.hexdigest()
