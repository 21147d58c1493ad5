"""A talking face that is learned from a few drawings of a ball."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import shapes

from abs_engine.core.camera import Camera
from abs_engine.core.geometry import Pose
from abs_engine.core.params import ParamSpec
from abs_engine.core.scene import Candidates, Scene
from abs_engine.face.appearance.region import part
from abs_engine.face.appearance.visibility import Sighting
from abs_engine.face.articulated import FaceShape, middle
from abs_engine.face.penalty import ImprobablePenalty
from abs_engine.face.shape.articulatory_model import ArticulatoryModel
from abs_engine.face.shape.predictors import PAPER_PREDICTORS
from abs_engine.face.talking import TalkingFace
from abs_engine.learn.talking import learn_face
from abs_engine.render.cpu import CpuRenderer

RENDERER = CpuRenderer()
CAMERA = Camera.ideal((64, 64))
POSE = Pose.facing(shapes.DISTANCE)
PARAMETERS = 2
RINGS = ("outer", "upper", "lower", "points", "corners")


def _scene() -> Scene:
    """A ball that two parameters move, the upper third of another class."""
    ball = shapes.ball(shapes.LARGE, PARAMETERS)
    high = ball.mean[ball.faces][:, :, 1].mean(axis=1) > ball.mean[:, 1].max() / 3
    return replace(ball, facet_class=np.where(high, 2, 1).astype(np.int32))


def _shape() -> FaceShape:
    """Half of the ball is compared, and a little more is drawn."""
    scene = _scene()
    depth = scene.mean[scene.faces][:, :, 2].mean(axis=1)
    outer, kept = part(scene, depth > -2)
    front = kept[np.argsort(-scene.mean[kept, 2])]
    rng = np.random.default_rng(0)
    alpha = rng.normal(size=(12, PARAMETERS))
    vertices = front[:20]
    predictors, names = PAPER_PREDICTORS[:PARAMETERS], tuple(f"p{k}" for k in range(20))
    model = ArticulatoryModel(
        names, predictors, scene.mean[vertices].astype(float),
        scene.modes[:, vertices].astype(float), np.array([0.6, 0.3]), {"lips": names[:8]}, "a ball",
    )  # fmt: skip
    rings = dict(zip(RINGS, np.split(front[:46].astype(np.int32), [12, 18, 24, 44]), strict=True))
    spec = ParamSpec(
        model.parameters, ("sd",) * PARAMETERS, np.full(PARAMETERS, 0.5), alpha.min(0), alpha.max(0)
    )
    return FaceShape(
        scene, part(scene, depth > 0)[0], outer, kept, np.sort(front[:120]), spec,
        middle(scene, vertices[:8]), model, Pose.from_vectors([0.1, 0.2, 0.3], [1, 2, 3]),
        vertices, np.arange(8), ImprobablePenalty.of_corpus(alpha), alpha[0], rings,
        (None, "skin", "lips"),
    )  # fmt: skip


def learned_face() -> TalkingFace:
    """Learned from a few noisy drawings."""
    shape, rng = _shape(), np.random.default_rng(1)
    seen = []
    for row in rng.uniform(-1, 1, (8, PARAMETERS)):
        one = Candidates.one(row, POSE)
        rgb = RENDERER.draw(shape.scene, one, CAMERA, CAMERA.whole)[0].rgb
        image = np.clip(rgb + rng.normal(0, 2, rgb.shape), 0, 255).astype(np.uint8)
        seen.append(Sighting(image, shape.scene.vertices(row), POSE, row))
    return learn_face(shape, seen, CAMERA, RENDERER, count=9)
