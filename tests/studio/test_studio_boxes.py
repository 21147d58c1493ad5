"""Boxes of what a camera sees of the head itself."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np

from abs_engine.studio.chunk import _row


def test_the_box_of_a_head_leaves_its_mirror_image_out():
    ids, glass = np.zeros((2, 8, 12), np.uint16)
    ids[2:5, 1:4] = 7
    ids[3:6, 8:11] = 9  # in the mirror
    glass[:, 6:] = 1
    shot = SimpleNamespace(
        ids=ids, glass=glass.astype(bool), pixels=np.zeros((68, 2)), seen=np.ones(68, bool),
        mirror_pixels=None, mirror_seen=None,
    )  # fmt: skip
    row = _row(shot)
    assert row["boxes"] == [1, 2, 3, 3]
    assert row["areas"] == 9
