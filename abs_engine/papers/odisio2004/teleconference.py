"""Experiment (c): a head-mounted camera, few beads, appearance learned at once (section 5.2)."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.camera import Camera
from abs_engine.core.geometry import compose, pose_vectors
from abs_engine.core.pose import parted
from abs_engine.core.scene import Renderer
from abs_engine.face.appearance.atlas import fitting_size, lay_atlas
from abs_engine.face.appearance.information import choose_informative, information
from abs_engine.face.appearance.local_learning import learn_local
from abs_engine.face.appearance.texture import learn_texture
from abs_engine.face.articulated import FaceShape
from abs_engine.face.talking import TalkingFace
from abs_engine.io.assets import Speaker
from abs_engine.learn.settings import LEARNING
from abs_engine.papers.odisio2004.filmed import SIZE, sightings
from abs_engine.papers.odisio2004.gathered import Report
from abs_engine.papers.odisio2004.sentences_figures import curves_figure
from abs_engine.papers.odisio2004.sentences_filmed import Filmed, cut, film_plan, plan_sentence
from abs_engine.papers.odisio2004.sentences_scores import curves as curves_of
from abs_engine.papers.odisio2004.sentences_work import settings_of
from abs_engine.papers.odisio2004.sequence import track
from abs_engine.papers.odisio2004.visemes import Speech
from abs_engine.report.drawing.figure import figure_bytes
from abs_engine.studio.cameras import stand
from abs_engine.studio.french import SENTENCES, Sentence
from abs_engine.studio.scenefile import CameraEntry

BEADS = 12
"""'Only a few beads, sufficient to compute reliably a direct inversion'; none are on the lips."""
POINTS, FRAMES = 51, 75
"""The paper's number of points of local appearance, and of images that it is learned from."""
FREE_OF_BEADS = 6.0
"""mm around a bead in which no point is chosen."""
PLACE = (0.0, -35.0, 260.0)
"""Where the worn camera is, head frame, mm; it looks at the mouth from a little below."""
FOCAL = 1.1
"""In widths of the picture."""
TRAINING, HELD_OUT = SENTENCES[3], SENTENCES[27]


def film_worn(
    speaker: Speaker, person: str, sentence: Sentence, shape: FaceShape, seed: int
) -> tuple[Filmed, NDArray[np.int32]]:
    """The first `FRAMES` frames of a sentence, and the vertices of the beads.

    The person wears the camera; the lamps stay where they are.
    """
    camera = Camera.ideal(SIZE, FOCAL * SIZE[0])
    plan = plan_sentence(speaker, person, sentence, Camera.ideal(SIZE), seed, BEADS)
    worn = stand(CameraEntry(mount="head", position=PLACE), camera, speaker, plan.neutral)
    heads = [plan.head(frame) for frame in range(len(plan))]
    rotations, translations = pose_vectors([compose(worn, head.inverse) for head in heads])
    view = replace(plan.views[0], camera=camera, rotations=rotations, translations=translations)
    plan = replace(plan, views=(view,))
    return film_plan(speaker, cut(plan, FRAMES), sentence, shape.vertices), plan.dots


def learn_at_once(
    shape: FaceShape, filmed: Filmed, beads: NDArray[np.integer], renderer: Renderer
) -> TalkingFace:
    """tex_cst from the first image of a sequence, la_lin from all, away from the beads.

    The postures are those of the direct inversion of the true points. Beads (K,) are the vertices
    at their centres.
    """
    alpha = shape.invert(filmed.points)
    seen = sightings(shape, filmed.pictures, filmed.poses, alpha)
    scene, camera = shape.scene, filmed.camera
    atlas = lay_atlas(scene, fitting_size(scene, camera, filmed.poses[0]), renderer)
    first = replace(seen[0], parameters=np.zeros(0))
    texture = learn_texture([first], scene, atlas, camera, renderer)
    places = scene.mean[shape.marks].astype(np.float64)
    away = np.linalg.norm(places[:, None] - scene.mean[beads], axis=2).min(axis=1)
    marks = shape.marks[away > FREE_OF_BEADS]
    every = learn_local(seen, scene, marks, camera, renderer)
    own = slice(len(shape.blocks) - len(shape.spec), None)  # the pose is known
    told = information(every, seen, scene, camera, renderer, shape.moved)[:, own, own]
    chosen = choose_informative(
        every, told, parted(shape.about)[1], POINTS, places[away > FREE_OF_BEADS], LEARNING.spacing
    )
    local = every.only(chosen).within(shape.kept)
    return TalkingFace(shape, texture, texture, local, local.constant())


def run_teleconference(report: Report, speech: Speech) -> None:
    """Figure 10 and errors with a worn camera; appearance is learned from one of two sequences.

    The camera moves with the head, and its pose is known: only the articulation is sought. What is
    learned is learned from all frames that were filmed, also where fewer are tracked.
    """
    shape, frames = speech.shape, report.amount.worn
    report.tell("filming with the worn camera")
    own, beads = film_worn(report.speaker, speech.person, TRAINING, shape, report.seed)
    other, _ = film_worn(report.speaker, speech.person, HELD_OUT, shape, report.seed)
    face = learn_at_once(shape, own, beads, report.renderer)
    curves = {}
    for suffix, filmed in (("", own), ("_heldout", other)):
        for model in ("tex_cst", "la_lin"):
            report.tell(f"tracking {filmed.name} with {model}")
            name = model + suffix
            tracked = track(
                face, model, filmed.pictures[:frames], filmed.camera, filmed.poses[0],
                shape.neutral, report.renderer, replace(settings_of(model), pose_known=True),
                speech.built.alpha, report.kept / "worn" / f"{name}.journal",
            )  # fmt: skip
            curves[name] = curves_of(report.speaker, shape, filmed, tracked)
    report.results["teleconference"] = {
        name: {**one.told(), "frames": float(len(one.rms))} for name, one in curves.items()
    }
    shown = {name: curves[name] for name in ("tex_cst", "la_lin")}
    figure = figure_bytes(curves_figure(shape, own, shown), "svg")
    report.figure("figure10.svg", figure, "Figure 10: a sequence that a worn camera filmed.")
