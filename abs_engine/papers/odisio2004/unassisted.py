"""A speaker known by measured points and pictures alone: an experiment of our own.

The paper's experiments here are given the true head, the poses and postures of the training
pictures, sentences filmed as these were, and the first pose. Here the first pose is always
estimated; faces of measured points, or of dots that are tracked, take the place of the true head
and poses (see `unassisted_faces`), and other filming that of the usual.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np

from abs_engine.core.arrays import FloatArray
from abs_engine.core.camera import Camera
from abs_engine.core.errors import FaceNotFoundError, OutOfPictureError
from abs_engine.core.provenance import code_digest
from abs_engine.dataset import Truth, load_truth
from abs_engine.face.talking_file import StoredTalker, load_talking
from abs_engine.io.naming import made_before
from abs_engine.learn.spoken import bite_plane_of
from abs_engine.papers.odisio2004.filmed import SIZE
from abs_engine.papers.odisio2004.gathered import Report
from abs_engine.papers.odisio2004.sentences import in_spread_order
from abs_engine.papers.odisio2004.sentences_filmed import cut, plan_sentence
from abs_engine.papers.odisio2004.sentences_work import settings_of
from abs_engine.papers.odisio2004.sequence import track
from abs_engine.papers.odisio2004.unassisted_faces import KnownFace, faces_of
from abs_engine.papers.odisio2004.visemes import Speech
from abs_engine.studio.appearance.look import Light, Look
from abs_engine.studio.french import Sentence
from abs_engine.studio.make import Crew, Order, make
from abs_engine.tracking.landmark.landmark_correspondence import Correspondence
from abs_engine.tracking.landmark.rendered_landmarks import correspondence_of
from abs_engine.tracking.models.measured_looks import pose_by_landmarks

SAME, OTHER = "as training", "otherwise"
"""Tests: filmed as the training pictures were; with another camera and light, and more motion."""
LIPS = ("upper_lip", "lower_lip")
ASKED = ("tex_lin", "la_lin")
"""Appearance models."""


@dataclass(frozen=True, eq=False)
class Filming:
    """Camera, look and motion of a test's sentences.

    Parameters
    ----------
    camera : Camera
        Its calibration is given to the tracker, as in the paper.
    reach : float
        How far the head moves, as a factor; see `studio.sequence.wander`.
    """

    camera: Camera
    look: Look
    reach: float


FILMINGS: Mapping[str, Filming] = {
    SAME: Filming(Camera.ideal(SIZE), Look(), 1.0),
    OTHER: Filming(
        Camera.ideal((480, 360), 620.0),
        Look(
            lights=(
                Light("window", (-0.7, -0.35, -1.0), 2.4, (0.86, 0.93, 1.0)),
                Light("lamp", (0.8, -0.5, -0.5), 0.9, (1.0, 0.86, 0.7)),
            ),
            ambient=0.2,
        ),
        1.7,
    ),
}


def unassisted(report: Report, bare: Speech, count: int) -> list[dict[str, Any]]:
    """A row for each face, test and model: how far the lips of tracked sentences are off.

    Parameters
    ----------
    report : Report
        The films and what is found go into what it keeps until it is finished.
    bare : Speech
        The corpus, its pictures without beads.

    Returns
    -------
    list of dict
        ``face``, ``test``, ``model``, ``sentences``, ``frames``, and ``found``, sentences that were
        not lost: one is lost as a whole, where its first frame shows no face or the head leaves the
        picture. Of those found, in mm, in the frame of the upper teeth, over the vertices of the
        lips: ``lips_mm``, ``lips_less_constant_mm``, without what all frames of a sentence have in
        common, and ``motion_mm``, by how much they move.
    """
    folder = report.kept / f"unassisted-{code_digest()[:12]}"
    folder.mkdir(parents=True, exist_ok=True)
    faces = faces_of(report, bare, folder)
    sentences, rows = in_spread_order()[:count], []
    places = correspondence_of(report.speaker, report.renderer)
    for test, filming in FILMINGS.items():
        films = [_film(report, folder, test, filming, sentence) for sentence in sentences]
        for name, model in product(faces, ASKED):
            report.tell(f"sentences with less given: {name} head, {model}, filmed {test}")
            tracker = _Tracker(report, faces[name], model, places)
            scores = [tracker.score(film, folder / f"{film.name} {name} {model}") for film in films]
            rows.append({"face": name, "test": test, "model": model, **_pooled(scores)})
    return rows


def _film(report: Report, folder: Path, test: str, filming: Filming, sentence: Sentence) -> Path:
    """The data set of a filmed sentence."""
    path = folder / f"{sentence.name} {test}"
    if not made_before(path):
        report.tell(f"filming {sentence.name}, {test}")
        plan = plan_sentence(
            report.speaker, report.person, sentence, filming.camera, report.seed,
            look=filming.look, reach=filming.reach,
        )  # fmt: skip
        order = Order(report.command, report.seed, (), keep_frames=False)
        make([cut(plan, report.amount.frames)], 1, path, report.speaker, order, Crew())
    return path


@dataclass(frozen=True, eq=False)
class _Score:
    """Frames of a sentence, those found, and sums of squares over these, mm^2."""

    frames: int
    found: int
    squares: FloatArray


@dataclass(frozen=True, eq=False)
class _Tracker:
    """A face, if it could be made, and one of its appearance models."""

    report: Report
    known: KnownFace
    model: str
    places: Correspondence

    def score(self, film: Path, kept: Path) -> _Score:
        """Errors of a filmed sentence; nothing is found where the first frame shows no face."""
        truth = load_truth(film)
        path = self.known.path
        talker = None if path is None else load_talking(path)
        try:
            found = None if talker is None else self._tracked(talker, truth, film, kept)
        except (FaceNotFoundError, OutOfPictureError) as error:
            self.report.tell(f"{film.name}: {error}")
            found = None
        if found is None:
            return _Score(len(truth), 0, np.zeros(3))
        true = _true_lips(self.report, truth)
        away, moved = found - true, true - true.mean(axis=0)
        kinds = away, away - away.mean(axis=0), moved
        squares = np.array([float((one**2).sum(axis=2).mean(axis=1).sum()) for one in kinds])
        return _Score(len(truth), len(truth), squares)

    def _tracked(
        self, talker: StoredTalker, truth: Truth, film: Path, kept: Path
    ) -> FloatArray | None:
        """Vertices of the lips (T, N, 3), in the frame of the upper teeth."""
        if talker.face is None:
            return None
        report, shape, camera = self.report, talker.shape, truth.camera
        first, head = next(iter(truth.pictures())), shape.scene.vertices(shape.neutral)
        pose = pose_by_landmarks(first, head, report.speaker, self.places, camera, film)
        found = track(
            talker.face, self.model, truth.pictures(), camera, pose, shape.neutral,
            report.renderer, settings_of(self.model), self.known.postures, kept=kept,
        )  # fmt: skip
        lips = report.speaker.vertices_of(*LIPS)
        heads = np.stack([shape.scene.vertices(row)[lips] for row in found.alpha])
        return shape.frame.apply(heads.astype(np.float64))


def _true_lips(report: Report, truth: Truth) -> FloatArray:
    """Vertices of the lips as they were filmed, (T, N, 3), in the frame of the upper teeth."""
    speaker, lips = report.speaker, report.speaker.vertices_of(*LIPS)
    frame = bite_plane_of(speaker, speaker.named(report.person))
    heads = np.stack([truth.vertices(t)[lips] for t in range(len(truth))])
    return frame.apply(heads.astype(np.float64))


def _pooled(scores: list[_Score]) -> dict[str, Any]:
    found = sum(one.found for one in scores)
    kept = sum(one.found > 0 for one in scores)
    names = "lips_mm", "lips_less_constant_mm", "motion_mm"
    squares = np.sum([one.squares for one in scores], axis=0)
    values = np.sqrt(squares / found).tolist() if found else [None] * len(names)
    return {
        "sentences": len(scores),
        "frames": sum(one.frames for one in scores),
        "found": kept,
        **dict(zip(names, values, strict=True)),
    }
