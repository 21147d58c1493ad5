"""The paper's system on a clip of a talking face's speaker: see `PRESET`."""

from __future__ import annotations

from dataclasses import asdict, replace

from abs_engine.core.errors import FaceNotFoundError, ParameterError
from abs_engine.core.geometry import Pose
from abs_engine.core.scene import Renderer
from abs_engine.papers.odisio2004.sequence import AS_PRINTED, Settings, clip_setting
from abs_engine.tracking.frames import Memory
from abs_engine.tracking.loop import at_rest
from abs_engine.tracking.options import BLOBS, Clip, ClipTracker, Leaves, Tell, TrackOptions
from abs_engine.tracking.presets import Preset
from abs_engine.tracking.talkers import found_talker
from abs_engine.video import read_frames

APPEARANCE = {"texture": "tex_lin", "local": "la_lin"}
SEARCHES = {"simplex": AS_PRINTED, "axes": Settings()}
"""The paper's search and comparison, and those that the sentences are tracked with."""


def prepare(
    clip: Clip, options: TrackOptions, leaves: Leaves, renderer: Renderer, tell: Tell
) -> ClipTracker:
    """Find the face in the first frame; from there each frame is started from the one before.

    Raises
    ------
    ParameterError
        If more than one appearance model, or another driver, is asked for.
    FaceNotFoundError
        If the first frame shows no face.
    AbsEngineError
        As `tracking.talkers.found_talker`.
    """
    name = next(iter(leaves.kinds))
    if len(leaves.kinds) > 1 or name not in APPEARANCE:
        raise ParameterError(
            "the preset compares one appearance model", "--terms texture or --terms local"
        )
    if leaves.name not in SEARCHES:
        raise ParameterError(
            f"the preset does not search by '{leaves.name}'", "--driver simplex or --driver axes"
        )
    if options.poses is not None:
        raise ParameterError("the preset finds the head itself", "leave out --poses")
    talker = found_talker(clip, options, leaves, renderer, tell)
    base, face = talker.base, talker.talking
    pose = _first_pose(base)
    setting = clip_setting(
        face, APPEARANCE[name], clip.camera, pose, renderer, SEARCHES[leaves.name],
        rate=clip.info.rate,
    )  # fmt: skip
    setting = replace(setting, times=clip.info.times, face=talker.face)
    how = SEARCHES[leaves.name]
    driver = {"name": leaves.name, **asdict(how)}
    return replace(
        base, setting=setting, memory=at_rest(pose, face.shape.neutral),
        facts={**base.facts, "driver": driver},
    )  # fmt: skip


def _first_pose(base: ClipTracker) -> Pose:
    """The head in the first frame."""
    image = next(iter(read_frames(base.video)))
    pose = base.setting.motion.follower().step(image, Memory()).pose
    if pose is None:
        raise FaceNotFoundError(
            f"no face was found in the first frame of {base.video}",
            "cut the video so that it begins with one",
        )
    return pose


PRESET = Preset(
    "Shape and appearance models of talking faces: seven articulatory parameters and pose, "
    "epsilon(p) of one appearance model and A(a), Nelder-Mead from the frame before",
    model="talking",
    terms=("texture",),
    driver="simplex",
    start=BLOBS,
    prepare=prepare,
)
"""Odisio and Bailly, section 4; with ``--terms local`` its local appearance."""
