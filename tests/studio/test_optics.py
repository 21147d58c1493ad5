"""The background that a camera sees."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from abs_engine.core.camera import Camera
from abs_engine.io.files import png
from abs_engine.studio.appearance.optics import Background, backdrop


def test_a_background_picture_is_seen_as_it_is_and_through_a_lens_bent(tmp_path):
    picture = np.random.default_rng(0).integers(0, 256, (72, 96, 3), np.uint8)
    (tmp_path / "wall.png").write_bytes(png(picture))
    wall = Background(picture=str(tmp_path / "wall.png"))
    camera = Camera.ideal((96, 72))
    np.testing.assert_array_equal(backdrop(camera, wall), picture)
    bent = replace(camera, distortion=np.array([-0.2, 0.08, 0.0, 0.0, 0.0]))
    seen = backdrop(bent, wall)
    np.testing.assert_array_equal(seen[36, 48], picture[36, 48])  # at the lens's axis
    assert (seen != picture).mean() > 0.5
