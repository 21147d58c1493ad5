"""Experiment (a): visemes that appearance was not learned from, found from neutral (figure 6)."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from abs_engine.core.arrays import FloatArray, IntArray
from abs_engine.core.scene import Renderer
from abs_engine.face.appearance.visibility import Sighting
from abs_engine.face.articulated import FaceShape
from abs_engine.face.talking import MODELS, TalkingFace
from abs_engine.fit.problem import Problem
from abs_engine.fit.settings import TALKING_FIT
from abs_engine.fit.talking import fit, talking_problem, usual_tolerance
from abs_engine.io.assets import Speaker
from abs_engine.io.naming import made_before
from abs_engine.learn.articulated import face_shape
from abs_engine.learn.articulatory import Build, build
from abs_engine.learn.spoken import SpokenCorpus
from abs_engine.learn.talking import learn_face
from abs_engine.optimise.restarted import RestartedSimplex
from abs_engine.papers.odisio2004.filmed import (
    VisemePictures,
    film_visemes,
    read_visemes,
    sightings,
)
from abs_engine.studio.corpus import NOISE, PAPER_VISEMES, speak_corpus

NEUTRAL = "neutral"
PRINTED = {"tex_lin_printed": "tex_lin", "tex_cst_printed": "tex_cst"}
"""Textures compared by epsilon as printed, beside the whitened comparison of `talking_problem`."""
ASKED = (*MODELS, *PRINTED)
LIMIT, RESTARTS = 800, 2


@dataclass(frozen=True, eq=False)
class Speech:
    """A speaker's corpus, the shape learned from it, and a picture of each of its visemes.

    Parameters
    ----------
    beads : int
        How many are on the face in the pictures.
    """

    person: str
    spoken: SpokenCorpus
    built: Build
    shape: FaceShape
    pictures: VisemePictures
    beads: int

    def sightings(self, which: Iterable[int]) -> list[Sighting]:
        """Some of the pictures, with the model's geometry of them."""
        seen = self.pictures
        every = sightings(self.shape, seen.pictures, seen.poses, self.built.alpha)
        return [every[k] for k in which]

    def learn(self, which: Iterable[int], renderer: Renderer) -> TalkingFace:
        """The appearance models of some of the pictures."""
        return learn_face(self.shape, self.sightings(which), self.pictures.camera, renderer)

    def problem(
        self, face: TalkingFace, name: str, which: int, renderer: Renderer, whiten: bool = False
    ) -> Problem:
        """A picture's epsilon from neutral, its pose known; `whiten` as of `talking_problem`."""
        seen = self.pictures
        return talking_problem(
            face, name, seen.pictures[which], seen.camera, seen.poses[which],
            self.shape.neutral, renderer, pose_known=True, whiten=whiten,
        )  # fmt: skip

    def missed(self, alpha: FloatArray, which: int) -> tuple[float, float]:
        """Root mean square of `distances`, mm, over all points, and over those of the lips."""
        away = self.distances(alpha, which)
        return _rms(away), _rms(away[self.shape.lips])

    def distances(self, alpha: FloatArray, which: int) -> FloatArray:
        """Distance of each of the model's points (N,) from its filmed place, mm."""
        true = self.pictures.vertices[which][self.shape.vertices]
        return np.asarray(np.linalg.norm(self.shape.points(alpha) - true, axis=1), np.float64)


def film_speech(
    speaker: Speaker, person: str, folder: Path, *, beads: int, size: tuple[int, int], seed: int
) -> Speech:
    """Speak a corpus, build its model, and film its visemes; errors as these do.

    Parameters
    ----------
    folder : Path
        Gets the data set of the pictures; where it exists, that is taken for this corpus.
    beads : int
        On the face; 0 films it bare.
    seed : int
        Of the corpus' noise, the head's motion and the sensor.
    """
    spoken = speak_corpus(speaker, speaker.named(person), PAPER_VISEMES, noise=NOISE, seed=seed)
    built = build(spoken.corpus)
    if made_before(folder):
        pictures = read_visemes(folder, spoken.corpus.visemes)
    else:
        pictures = film_visemes(speaker, spoken, person, folder, size=size, beads=beads, seed=seed)
    shape = face_shape(speaker, spoken, built, person)
    return Speech(person, spoken, built, shape, pictures, beads)


@dataclass(frozen=True, eq=False)
class VisemeError:
    """Errors of a viseme.

    Parameters
    ----------
    viseme, model : str
        `NEUTRAL` is where the search starts.
    distances : (N,) float64, mm
        Of the points from the truth, head coordinates.
    rms, lips : float, mm
        Root mean square over all points, and over those of the lips and around them.
    """

    viseme: str
    model: str
    distances: FloatArray
    rms: float
    lips: float
    evaluations: int


def find_visemes(
    speech: Speech,
    face: TalkingFace,
    tests: Iterable[int],
    renderer: Renderer,
    models: Sequence[str] = ASKED,
) -> list[VisemeError]:
    """Find visemes from neutral, their pose known, by every model; and what neutral misses.

    The face is learned from other visemes.
    """
    out = []
    for which in tests:
        out.append(_error(speech, NEUTRAL, which, speech.shape.neutral, 0))
        for name in models:
            printed = name in PRINTED
            asked = speech.problem(face, PRINTED.get(name, name), which, renderer, not printed)
            solver = RestartedSimplex(usual_tolerance(asked), LIMIT, RESTARTS)
            found = fit(asked, speech.shape.neutral, step=TALKING_FIT.from_neutral, solver=solver)
            count = found.solution.n_evaluations
            out.append(_error(speech, name, which, found.alpha, count))
    return out


def _error(speech: Speech, model: str, which: int, alpha: FloatArray, count: int) -> VisemeError:
    away = speech.distances(alpha, which)
    viseme = speech.pictures.visemes[which]
    return VisemeError(viseme, model, away, *speech.missed(alpha, which), count)


def _rms(distances: FloatArray) -> float:
    return float(np.sqrt((distances**2).mean()))


def splits(count: int, seed: int, rounds: int) -> list[tuple[IntArray, IntArray]]:
    """Random shares of four fifths to learn from, and the rest to test on.

    Of five rounds each viseme is tested once: the shuffled visemes are cut into five parts; fewer
    rounds test on the first of them, a single round on the last fifth.
    """
    order = np.random.default_rng([seed, 2]).permutation(count)
    parts = [order[round(0.8 * count) :]] if rounds == 1 else np.array_split(order, 5)[:rounds]
    return [(np.setdiff1d(np.arange(count), part), np.sort(part)) for part in parts]


def summary(errors: Sequence[VisemeError]) -> dict[str, dict[str, float]]:
    """By model: medians and worst over the visemes, mm, and evaluations for each."""
    out = {}
    for name in (*ASKED, NEUTRAL):
        own = [e for e in errors if e.model == name]
        if own:
            out[name] = {
                "median_mm": float(np.median([e.rms for e in own])),
                "worst_mm": float(max(e.rms for e in own)),
                "lips_median_mm": float(np.median([e.lips for e in own])),
                "below_half_mm": float(np.mean([e.rms <= 0.5 for e in own])),
                "evaluations": float(np.mean([e.evaluations for e in own])),
                "visemes": len(own),
            }
    return out
