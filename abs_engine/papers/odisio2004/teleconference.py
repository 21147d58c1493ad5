"""Experiment (c): a head-mounted camera, few beads, appearance learned at once (section 5.2)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.camera import Camera
from abs_engine.core.pose import parted
from abs_engine.core.scene import Renderer
from abs_engine.face.appearance.atlas import fitting_size, lay_atlas
from abs_engine.face.appearance.information import choose_informative, information
from abs_engine.face.appearance.local_learning import learn_local
from abs_engine.face.appearance.texture import learn_texture
from abs_engine.face.appearance.visibility import Sighting
from abs_engine.face.articulated import FaceShape
from abs_engine.face.talking import TalkingFace
from abs_engine.io.assets import Speaker
from abs_engine.learn.settings import LEARNING
from abs_engine.papers.odisio2004.sentences_figures import curves_figure
from abs_engine.papers.odisio2004.sentences_filmed import Filmed, cut, film_plan, plan_sentence
from abs_engine.papers.odisio2004.sentences_scores import Curves
from abs_engine.papers.odisio2004.sentences_scores import curves as curves_of
from abs_engine.papers.odisio2004.sentences_work import settings_of
from abs_engine.papers.odisio2004.sequence import Tracked, track
from abs_engine.papers.odisio2004.visemes import Speech
from abs_engine.report.drawing.figure import figure_bytes
from abs_engine.studio.cameras import stand
from abs_engine.studio.french import SENTENCES, Sentence
from abs_engine.studio.plan import ClipPlan, compose, vectors
from abs_engine.studio.scenefile import CameraEntry

FIGURE = "figure10.svg"
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
Tell = Callable[[str], None]


@dataclass(frozen=True, eq=False)
class Teleconference:
    """Tracked sequences.

    Parameters
    ----------
    tracked : dict of str to Tracked
        ``tex_cst``, ``la_lin`` on the sequence that they were learned from, and both on another
        one, ``tex_cst_heldout`` and ``la_lin_heldout``.
    """

    tracked: dict[str, Tracked]
    curves: dict[str, Curves]

    def told(self) -> dict[str, dict[str, float]]:
        """For ``results.json``."""
        return {
            name: {**own.told(), "frames": float(len(own.rms))} for name, own in self.curves.items()
        }


def plan_worn(
    speaker: Speaker, person: str, sentence: Sentence, size: tuple[int, int], seed: int, beads: int
) -> ClipPlan:
    """A sentence before a camera that the person wears; the lamps stay where they are."""
    camera = Camera.ideal(size, FOCAL * size[0])
    plan = plan_sentence(speaker, person, sentence, Camera.ideal(size), seed, beads)
    worn = stand(CameraEntry(mount="head", position=PLACE), camera, speaker, plan.neutral)
    heads = [plan.head(frame) for frame in range(len(plan))]
    rotations, translations = vectors([compose(worn, head.inverse) for head in heads])
    view = replace(plan.views[0], camera=camera, rotations=rotations, translations=translations)
    return replace(plan, views=(view,))


def film_worn(
    speaker: Speaker, person: str, sentence: Sentence, shape: FaceShape, seed: int
) -> tuple[Filmed, NDArray[np.int32]]:
    """The first `FRAMES` frames of a sentence, 320x240, and the vertices of the beads."""
    plan = plan_worn(speaker, person, sentence, (320, 240), seed, BEADS)
    return film_plan(speaker, cut(plan, FRAMES), sentence, shape.vertices), plan.dots


def learn_at_once(
    shape: FaceShape, filmed: Filmed, beads: NDArray[np.integer], renderer: Renderer
) -> TalkingFace:
    """tex_cst from the first image of a sequence, la_lin from all, away from the beads.

    The postures are those of the direct inversion of the true points.

    Parameters
    ----------
    beads : (K,) int
        Vertices at their centres.
    """
    alpha = shape.invert(filmed.points)
    seen = [
        Sighting(picture, shape.scene.vertices(row), pose, row)
        for picture, row, pose in zip(filmed.pictures, alpha, filmed.poses, strict=True)
    ]
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


def run_teleconference(
    speaker: Speaker,
    speech: Speech,
    renderer: Renderer,
    folder: Path | None = None,
    *,
    seed: int = 0,
    frames: int | None = None,
    tell: Tell = lambda _text: None,
    kept: Path | None = None,
) -> Teleconference:
    """Film two sequences with a worn camera, learn from the first, and track both.

    The camera moves with the head, and its pose is known: only the articulation is sought.

    Parameters
    ----------
    speech : Speech
        The corpus that the shape was learned from.
    folder : Path, optional
        Gets figure 10.
    frames : int, optional
        How many of each sequence are tracked, from its start; by default all that were filmed.
        What is learned is learned from all.
    tell : callable
        Called with what is done next.
    kept : Path, optional
        Folder that gets the frames, and has those of an interrupted run.

    Raises
    ------
    StudioError
        If pyrender cannot draw on this machine.
    """
    shape = speech.shape
    tell("filming with the worn camera")
    own, beads = film_worn(speaker, speech.person, TRAINING, shape, seed)
    other, _ = film_worn(speaker, speech.person, HELD_OUT, shape, seed)
    face = learn_at_once(shape, own, beads, renderer)
    tracked, curves = {}, {}
    for suffix, filmed in (("", own), ("_heldout", other)):
        for model in ("tex_cst", "la_lin"):
            tell(f"tracking {filmed.name} with {model}")
            name = model + suffix
            tracked[name] = track(
                face, model, filmed.pictures[:frames], filmed.camera, filmed.poses[0],
                shape.neutral, renderer, replace(settings_of(model), pose_known=True),
                speech.built.alpha, None, None if kept is None else kept / f"{name}.journal",
            )  # fmt: skip
            curves[name] = curves_of(speaker, shape, filmed, tracked[name])
    if folder is not None:
        shown = {name: curves[name] for name in ("tex_cst", "la_lin")}
        (folder / FIGURE).write_bytes(figure_bytes(curves_figure(shape, own, shown), "svg"))
    return Teleconference(tracked, curves)
