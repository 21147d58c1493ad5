"""The landmark network's points on an imported head, by drawing and looking."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.errors import FaceNotFoundError
from abs_engine.core.scene import Renderer
from abs_engine.face.head import mouth_facets
from abs_engine.face.rings import rings_of
from abs_engine.io.assets import LIPS_OF_68, Speaker
from abs_engine.tracking.heads import correspondence_of
from abs_engine.tracking.landmark_correspondence import Correspondence

OF_68 = np.array([
    162, 234, 93, 58, 172, 136, 149, 148, 152, 377, 378, 365, 397, 288, 323, 454, 389, 71, 63, 105,
    66, 107, 336, 296, 334, 293, 301, 168, 197, 5, 4, 75, 97, 2, 326, 305, 33, 160, 158, 133, 153,
    144, 362, 385, 387, 263, 373, 380, 61, 39, 37, 0, 267, 269, 291, 405, 314, 17, 84, 181, 78, 82,
    13, 312, 308, 317, 14, 87,
])  # fmt: skip
"""The network's points that lie where the usual 68 do."""


def with_network(head: Speaker, renderer: Renderer) -> Speaker:
    """The head with the network's points, and with all 68 landmarks where they were not given.

    Raises
    ------
    ModelFormatError
        If its landmarks are not on its mouth, as `build_mouth_model` asks.
    FaceNotFoundError
        If the network sees no face in drawings of it.
    """
    rings_of(head, np.unique(head.faces[mouth_facets(head, head.vertices)]))
    try:
        found = correspondence_of(head, renderer)
    except FaceNotFoundError as error:
        raise FaceNotFoundError(
            error.problem,
            "check that its faces point outwards and its landmarks lie where they should, or give "
            "it a texture",
        ) from error
    points = {"landmark_68": _landmark_68(head, found), **head.points}
    return replace(head, points=points, network=found.arrays())


def _landmark_68(head: Speaker, found: Correspondence) -> NDArray[np.int32]:
    """The vertices nearest to the network's points; those of the lips are known better."""
    own = np.asarray(found.corners[OF_68, found.weights[OF_68].argmax(axis=1)], np.int32)
    marks = head.landmarks
    own[LIPS_OF_68] = np.r_[marks["outer_lip_20"], marks["inner_lip_8"]]
    own[30], own[8] = marks["nose_tip"][0], marks["chin"][0]
    own[[36, 39, 42, 45]] = marks["eye_corners"]
    return own
