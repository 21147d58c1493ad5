"""A corpus of visemes from a session of `bead_session`, by the project's own observing.

Nothing of the truth is used but where a person would point: the dots of the skull in the picture
of the plate, and all dots in the first frame of the visemes, each off by `CARELESS`.
"""

from __future__ import annotations

import json
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from abs_engine.capture.board import Corners
from abs_engine.capture.calibrate import calibrate_camera, calibrate_stereo
from abs_engine.capture.corpus import Corpus
from abs_engine.capture.corpus_file import read_corpus
from abs_engine.capture.dot_annotations import Mark
from abs_engine.capture.dot_tracking import DotFollower
from abs_engine.capture.head import HeadChoice
from abs_engine.capture.head_points import points_of_head
from abs_engine.capture.headframe import HeadMotion, rigid_motion
from abs_engine.capture.observations import Observations, write_observations
from abs_engine.capture.session import follow_videos
from abs_engine.capture.triangulate import triangulate
from abs_engine.capture.view import View
from abs_engine.core.arrays import FloatArray
from abs_engine.core.errors import CalibrationError
from abs_engine.dataset import Truth, load_dataset
from abs_engine.io.naming import made_before
from abs_engine.learn.choice import Points
from abs_engine.learn.corpus_dots import SKULL, corpus_dots
from abs_engine.learn.spoken import SpokenCorpus
from abs_engine.papers.odisio2004.bead_session import (
    BOARDS,
    CAMERAS,
    PLACES,
    SAID,
    BeadSession,
    moments,
    plate_places,
)
from abs_engine.studio.props import BOARD

CARELESS = 0.7
"""Standard deviation of how far beside a dot a person points, px along either axis."""
LOST = 0.15
"""Share of the visemes in which a dot may be missing; it is filled in there. Chosen on clara, whose
face is as good with 0.02 to 0.3."""


@dataclass(frozen=True, eq=False)
class Session:
    """A filmed session, and the dots that are worn in it.

    Parameters
    ----------
    folder : Path
        Of the data set.
    seed : int
        Of how carelessly dots are pointed at.
    """

    folder: Path
    worn: Points
    seed: int = 0

    def observe(self) -> Observations:
        """All dots in all frames of the visemes, mm, in the frame of the upper teeth.

        Raises
        ------
        CalibrationError, DegenerateViewsError, TooFewPointsError
            If cameras or head frame cannot be found from the pictures.
        """
        boards, said = self._views(BOARDS), self._views(SAID)
        pictures = [list(view.pictures()) for view in boards]
        found = [[BOARD.find(image) for image in own] for own in pictures]
        views = _calibrated(found, boards[0].camera.size)
        skull = self.worn.groups[SKULL]
        shown = [
            DotFollower(own[PLACES], at).start.places
            for own, at in zip(pictures, self._pointed(boards, PLACES, skull), strict=True)
        ]
        places = triangulate(views, np.stack(shown)).points
        on_teeth = _plate(views, [own[PLACES] for own in found]).to_head(places[None])[0]
        names = self.worn.names
        marks = [
            Mark(0, view, name, (float(x), float(y)))
            for view, own in enumerate(self._pointed(said, 0, names))
            for name, (x, y) in zip(names, own, strict=True)
        ]
        tracks = follow_videos([view.video for view in said], marks)
        head = HeadChoice(skull, dict(zip(skull, on_teeth, strict=True)))
        return points_of_head(tracks, views, head, source="tracked dots")

    def _views(self, clip: str) -> list[Truth]:
        data = load_dataset(self.folder)
        return [data.view(clip, name) for name in CAMERAS]

    def _pointed(self, views: Sequence[Truth], frame: int, names: Collection[str]) -> FloatArray:
        """Pixels (2, N, 2) at which a person points for dots in a frame."""
        own = [self.worn.names.index(name) for name in names]
        at = np.stack([view.pixels(frame, self.worn.vertices[own]) for view in views])
        return at + np.random.default_rng([self.seed, frame]).normal(0.0, CARELESS, at.shape)


def _calibrated(found: Sequence[Sequence[Corners | None]], size: tuple[int, int]) -> list[View]:
    """Both cameras from the boards that both see; the world is the first one's frame."""
    pairs = [(a, b) for a, b in zip(*found, strict=True) if a is not None and b is not None]
    first, second = (calibrate_camera([pair[k] for pair in pairs], size) for k in range(2))
    return [View(first.camera), View(second.camera, calibrate_stereo(pairs, first, second).pose)]


def _plate(views: Sequence[View], seen: Sequence[Corners | None]) -> HeadMotion:
    """Place of the upper teeth in the world, by the plate that is between them."""
    left, right = seen
    if left is None or right is None:
        raise CalibrationError("the plate between the teeth is not seen", "show its print")
    left, right = left.common(right)
    printed = triangulate(views, np.stack([left.pixels, right.pixels])).points
    return rigid_motion(printed[None], plate_places()[left.ids])


def tracked_corpus(
    spoken: SpokenCorpus, person: str, seed: int, folder: Path, command: str = ""
) -> Corpus:
    """The corpus that a session gives, filmed and observed if need be.

    Errors are those of `BeadSession.film`, `Session.observe` and `read_corpus`.

    Parameters
    ----------
    spoken : SpokenCorpus
        What is said; its points are not looked at.
    folder : Path
        Gets the session and what `articulate` reads: observations and the table of roles.

    Returns
    -------
    Corpus
        Without dots that are lost in more than `LOST` of the visemes; NaN in the others.
    """
    film, visemes = folder / "beads", spoken.corpus.visemes
    worn = corpus_dots(spoken.speaker)
    if not made_before(film):
        BeadSession(spoken, person, seed).film(film, command)
    observed, roles = folder / "observed.npz", folder / "roles.json"
    if not made_before(observed):
        groups = {group: list(names) for group, names in worn.groups.items()}
        spans = dict(zip(visemes, moments(len(visemes)), strict=True))
        text = json.dumps({"groups": groups, "visemes": spans})
        roles.write_text(text, encoding="utf-8")
        write_observations(observed, Session(film, worn, seed).observe())
    corpus = read_corpus(observed, roles)
    lost = np.isnan(corpus.points).any(axis=2).mean(axis=0)
    return corpus.without([corpus.names[k] for k in np.flatnonzero(lost > LOST)])
