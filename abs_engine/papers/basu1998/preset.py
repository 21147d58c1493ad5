"""The paper's system on anybody's clip: see `PRESET`."""

from __future__ import annotations

from abs_engine.tracking.options import BLOBS
from abs_engine.tracking.presets import Preset

PRESET = Preset(
    "3D Modeling and Tracking of Human Lip Motions: a shell of learned physics, lips found as "
    "blobs and followed by a Kalman filter, moved by forces on its nodes",
    model="shell",
    terms=("colour",),
    driver="forces",
    start=BLOBS,
)
"""Basu, Oliver and Pentland (1998), sections 5.2 to 5.5. Where the paper leaves something open:
colours are learned and the mouth's own size and shape fitted on a few frames of the clip, rotation
and depth are those of its first frame, and forces are followed as `optimise.ascent.Forces` does."""
