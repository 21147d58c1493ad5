"""The paper's system on a clip of a talking face's speaker: see `PRESET`."""

from __future__ import annotations

from dataclasses import asdict, replace

from abs_engine.core.errors import ParameterError
from abs_engine.core.scene import Renderer
from abs_engine.papers.odisio2004.frame_before import FrameBefore
from abs_engine.papers.odisio2004.sequence import AS_PRINTED, Settings, clip_setting
from abs_engine.tracking.model_entry import Model
from abs_engine.tracking.models.talking_faces import check_talker, found_talker
from abs_engine.tracking.options import BLOBS, Clip, ClipTracker, Leaves, Tell, TrackOptions
from abs_engine.tracking.presets import Preset
from abs_engine.tracking.settings.frames import FRAME_LOOP

APPEARANCE = {"texture": "tex_lin", "local": "la_lin"}
SEARCHES = {"simplex": AS_PRINTED, "axes": Settings()}
"""The paper's search and comparison, and those that the sentences are tracked with."""


def check(options: TrackOptions, leaves: Leaves) -> None:
    """Refuse what the preset does not do; errors as `prepare`, before anything is done."""
    _chosen(leaves)
    check_talker(options, leaves)


def _chosen(leaves: Leaves) -> tuple[str, Settings]:
    """The appearance model and the search that are asked for; `ParameterError` for others."""
    name = next(iter(leaves.kinds))
    if len(leaves.kinds) > 1 or name not in APPEARANCE:
        raise ParameterError(
            "the preset compares one appearance model", "use --terms texture or --terms local"
        )
    if leaves.name not in SEARCHES:
        raise ParameterError(
            f"the preset does not search by '{leaves.name}'",
            "use --driver simplex or --driver axes",
        )
    return APPEARANCE[name], SEARCHES[leaves.name]


def prepare(
    clip: Clip, options: TrackOptions, leaves: Leaves, renderer: Renderer, tell: Tell
) -> ClipTracker:
    """Find the face; from there on each frame is started from the one before.

    Raises
    ------
    ParameterError
        If more than one appearance model, or another driver, is asked for.
    AbsEngineError
        As `tracking.models.talking_faces.found_talker`.
    """
    appearance, search = _chosen(leaves)
    talker = found_talker(clip, options, leaves, renderer, tell)
    head = talker.base.setting
    how = replace(search, pose_known=head.pose_held, least=FRAME_LOOP.least_explained)
    setting = clip_setting(
        talker.learned, appearance, clip.camera, renderer, how, rate=clip.info.rate
    )
    setting = replace(
        setting, times=head.times, face=talker.face, visibility=head.visibility,
        motion=head.motion if head.pose_held else FrameBefore(head.motion),
        why_lost=head.why_lost, pose_held=head.pose_held,
    )  # fmt: skip
    driver = {"name": leaves.name, **asdict(how)}
    return replace(talker.base, setting=setting, facts={**talker.base.facts, "driver": driver})


PRESET = Preset(
    "Shape and appearance models of talking faces: seven articulatory parameters and pose, "
    "epsilon(p) of one appearance model and A(a), Nelder-Mead from the frame before",
    model="talking",
    terms=("local",),
    driver="simplex",
    start=BLOBS,
    prepare=Model(prepare, check=check),
)
"""Odisio and Bailly, section 4: local appearance, which is off least there, too, or the texture."""
