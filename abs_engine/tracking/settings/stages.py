"""Settings of all stages of tracking, gathered: the numbers that steer results.

Each stage keeps its own in a frozen value beside its code, and reads them from there. They are
values of the engine, not options of a user: none is changed while it runs. What was measured of
each stands in its docstring; what was not, says so.
"""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

from abs_engine.compare.settings import COMPARISON
from abs_engine.core.settings import GENERAL
from abs_engine.face.settings.appearance import APPEARANCE, SHADING
from abs_engine.face.settings.colour import COLOURS
from abs_engine.face.settings.shape import SHAPE
from abs_engine.face.settings.tint import TINT
from abs_engine.fit.settings import BELIEF, HEAD_FIT, SHELL_FIT, TALKING_FIT
from abs_engine.optimise.settings import SOLVING
from abs_engine.tracking.settings.blobs import BLOB_START
from abs_engine.tracking.settings.detection import DETECTION
from abs_engine.tracking.settings.doubts import DOUBTS
from abs_engine.tracking.settings.frames import FRAME_LOOP
from abs_engine.tracking.settings.head import HEAD_POSE
from abs_engine.tracking.settings.landmarks import LANDMARK_EVIDENCE
from abs_engine.tracking.settings.outline import OUTLINE
from abs_engine.tracking.settings.preparation import PREPARATION
from abs_engine.tracking.settings.registration import REGISTRATION
from abs_engine.tracking.settings.worn import CLOSE_UP

STAGES: dict[str, Any] = {
    "general": GENERAL,
    "detection": DETECTION,
    "landmarks": LANDMARK_EVIDENCE,
    "head": HEAD_POSE,
    "outline": OUTLINE,
    "registration": REGISTRATION,
    "blobs": BLOB_START,
    "preparation": PREPARATION,
    "shape": SHAPE,
    "colours": COLOURS,
    "tint": TINT,
    "appearance": APPEARANCE,
    "shading": SHADING,
    "comparison": COMPARISON,
    "head_fit": HEAD_FIT,
    "shell_fit": SHELL_FIT,
    "talking_fit": TALKING_FIT,
    "solvers": SOLVING,
    "frames": FRAME_LOOP,
    "doubts": DOUBTS,
    "belief": BELIEF,
    "worn": CLOSE_UP,
}
"""The settings of each stage; what they are for, their own docstrings say."""


def stage_values() -> dict[str, dict[str, Any]]:
    """The values by stage and name, as JSON writes them."""
    return {stage: asdict(own) for stage, own in STAGES.items()}
