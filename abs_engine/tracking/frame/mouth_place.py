"""The mouth's place in a window, as far as landmarks show it."""

from __future__ import annotations

import cv2
import numpy as np

from abs_engine.core.arrays import FloatArray, Image
from abs_engine.core.camera import Camera, Window
from abs_engine.core.pose import PoseFrame, parted
from abs_engine.face.appearance.chroma import CHROMA_REACH
from abs_engine.face.appearance.mouth_area import MouthPlace
from abs_engine.face.head import MouthModel
from abs_engine.fit.settings import HEAD_FIT
from abs_engine.tracking.settings.preparation import PREPARATION


def mouth_place(
    model: MouthModel,
    base: PoseFrame,
    camera: Camera,
    window: Window,
    person: FloatArray,
    vector: FloatArray,
) -> MouthPlace:
    """Place in a window of the mouth of a person (Q,) with this pose and posture (6 + P,)."""
    vertices, pose = model.held(person).vertices(parted(vector)[1]), base.pose(parted(vector)[0])
    line = camera.project(pose.apply(_where_lips_meet(model, vertices)))
    outline = window.to_drawn(camera.project(pose.apply(vertices[model.rings["outer"]])))
    away = _outside(window, outline)
    depth = float(pose.apply(model.pivot)[2])
    mm = float(camera.matrix[0, 0]) / depth * window.scale
    inside, beyond = (
        sure
        / _inverse_probability(
            (PREPARATION.place_margin - side * away / mm) / PREPARATION.place_softness
        )
        for side, sure in ((-1.0, PREPARATION.sure_within), (1.0, PREPARATION.sure_beyond))
    )
    mixing = max(1.0, CHROMA_REACH * window.scale)
    return MouthPlace(_upper_share(window, line), inside, beyond, mixing)


def _inverse_probability(nats: FloatArray) -> FloatArray:
    """One over a probability, by the logarithm of the odds against it, up to 30 nats."""
    return np.asarray(1 + np.exp(np.clip(nats, -30.0, 30.0)))


def within(window: Window, outline: FloatArray) -> Image:
    """Mask (H, W), 0 and 1, of the drawn pixels within an outline (K, 2), drawn pixels."""
    width, height = window.drawn
    mask = np.zeros((height, width), np.uint8)
    cv2.fillPoly(mask, [np.rint(outline).astype(np.int32)], 1)
    return mask


def _outside(window: Window, outline: FloatArray) -> FloatArray:
    """Distance (H, W) of each drawn pixel from an outline (K, 2); less than 0 within it."""
    mask = within(window, outline)
    outer, inner = (
        cv2.distanceTransform(np.asarray(m, np.uint8), cv2.DIST_L2, 3) for m in (1 - mask, mask)
    )
    return np.asarray(outer, np.float64) - np.asarray(inner, np.float64)


def _where_lips_meet(model: MouthModel, vertices: FloatArray) -> FloatArray:
    """Half-way between the inner lips, from corner to corner, (15, 3) mm, head frame."""
    upper, lower = (vertices[model.rings[name]] for name in ("upper", "lower"))
    upper, lower = upper[np.argsort(upper[:, 0])], lower[np.argsort(lower[:, 0])]
    x = np.linspace(max(upper[0, 0], lower[0, 0]), min(upper[-1, 0], lower[-1, 0]), 15)
    line = [
        0.5 * (np.interp(x, upper[:, 0], upper[:, d]) + np.interp(x, lower[:, 0], lower[:, d]))
        for d in (1, 2)
    ]
    return np.column_stack([x, *line])


def _upper_share(window: Window, line: FloatArray) -> FloatArray:
    """Probability that a lip seen at each drawn pixel (H, W) is the upper one.

    A `line` (K, 2), px, from one corner to the other is where the lips would meet: half-way between
    their inner edges.
    """
    drawn = window.to_drawn(line)
    ends = drawn[-1] - drawn[0]
    along = ends / max(float(np.linalg.norm(ends)), 1e-9)
    down = np.array([-along[1], along[0]])
    order = np.argsort(drawn @ along)
    width, height = window.drawn
    grid = np.stack(np.meshgrid(np.arange(width), np.arange(height)), axis=-1).astype(np.float64)
    level = np.interp(grid @ along, (drawn @ along)[order], (drawn @ down)[order])
    below = (grid @ down - level) / (PREPARATION.between_lips * HEAD_FIT.drawn_mouth)
    return np.asarray(1 / _inverse_probability(below))
