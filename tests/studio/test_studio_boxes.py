"""Boxes of what a camera sees of the head itself."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np

from abs_engine.studio.chunk import _Gatherer


def test_the_box_of_a_head_leaves_its_mirror_image_out():
    ids, glass = np.zeros((2, 8, 12), np.uint16)
    ids[2:5, 1:4] = 7
    ids[3:6, 8:11] = 9  # in the mirror
    glass[:, 6:] = 1
    shot = SimpleNamespace(
        ids=ids, glass=glass.astype(bool), pixels=np.zeros((68, 2)), seen=np.ones(68, bool),
        mirror_pixels=None, mirror_seen=None,
    )  # fmt: skip
    gather = _Gatherer(None, None, whole=False)
    gather.add(None, shot)
    assert gather.arrays()["boxes"].tolist() == [[1, 2, 3, 3]]
    assert gather.arrays()["areas"].tolist() == [9]
