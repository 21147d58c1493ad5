"""Scene files: what is filmed, written down in one readable TOML file."""

from abs_engine.studio.scenefile.complete import check_size, complete, pick
from abs_engine.studio.scenefile.reader import nearest, parse_scene, read_scene
from abs_engine.studio.scenefile.scene import (
    ClipEntry,
    HeadKey,
    Label,
    MotionEntry,
    SceneFile,
)
from abs_engine.studio.scenefile.sentence import sentence_scene
from abs_engine.studio.scenefile.text import scene_text
from abs_engine.studio.scenefile.values import (
    CameraEntry,
    EventEntry,
    MirrorEntry,
    OccluderEntry,
    SpeakerEntry,
)

__all__ = [
    "CameraEntry", "ClipEntry", "EventEntry", "HeadKey", "Label", "MirrorEntry",
    "MotionEntry", "OccluderEntry", "SceneFile", "SpeakerEntry", "check_size", "complete",
    "nearest", "parse_scene", "pick", "read_scene", "scene_text", "sentence_scene",
]  # fmt: skip
